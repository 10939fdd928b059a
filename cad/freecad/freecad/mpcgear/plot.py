"""The course of a motion, drawn before anything is designed."""

import FreeCAD as App
from PySide import QtCore, QtGui

translate = App.Qt.translate
CURVES = (  # column, words; each has a strip of its own
    ("tilt_deg", translate("mpcgear", "tilt of the axis, °")),
    ("lead_deg", translate("mpcgear", "lead of the turn, °")),
    ("slide_mm", translate("mpcgear", "slide, mm")),
    ("turn_speed", translate("mpcgear", "turning speed")),
    ("sharpness_mm_rad2", translate("mpcgear", "sharpness, mm/rad²")),
)
STRIP, LEFT, RIGHT, WORDS = 62, 46, 8, 16  # px: height of a strip, margins, height of its heading
FLAT = 1e-3  # a curve that stays within this is a straight line


class MotionPlot(QtGui.QWidget):
    """Strips of curves over the driver angle, one below the other; empty until `show_course`."""

    def __init__(self):
        super().__init__()
        self.course = {}
        self.setFixedHeight(0)

    def show_course(self, course):
        """Shows {column: values} of `mpcgear motion show --csv`; nothing when it is empty."""
        self.course = dict(course)
        if course:  # a gear turns by -φ, so only what differs from it can be seen
            self.course["lead_deg"] = [turn + phi for turn, phi in zip(course["turn_deg"], course["phi_deg"])]
        self.setFixedHeight(STRIP * len(CURVES) + WORDS if course else 0)
        self.update()

    def paintEvent(self, _event):
        """Qt calls it when the widget is to be drawn."""
        if not self.course:
            return
        painter = QtGui.QPainter(self)
        painter.setRenderHint(QtGui.QPainter.Antialiasing)
        font = painter.font()
        font.setPointSizeF(7.5)
        painter.setFont(font)
        phis = self.course["phi_deg"]
        width = self.width() - LEFT - RIGHT
        for row, (column, words) in enumerate(CURVES):
            area = QtCore.QRectF(LEFT, row * STRIP + WORDS, width, STRIP - WORDS - 4)
            painter.setPen(self.palette().color(QtGui.QPalette.WindowText))
            painter.drawText(QtCore.QRectF(LEFT, row * STRIP, width, WORDS), QtCore.Qt.AlignBottom, words)
            self.draw(painter, area, phis, self.course[column])
        painter.setPen(self.palette().color(QtGui.QPalette.WindowText))
        for share in (0.0, 0.5, 1.0):
            phi = phis[0] + share * (phis[-1] - phis[0])
            place = QtCore.QRectF(LEFT + share * width - 30, STRIP * len(CURVES) - 2, 60, WORDS)
            place.moveLeft(min(max(place.left(), LEFT), LEFT + width - 60))
            align = (QtCore.Qt.AlignLeft, QtCore.Qt.AlignHCenter, QtCore.Qt.AlignRight)[int(2 * share)]
            painter.drawText(place, align, "φ = %.0f°" % phi)
        painter.end()

    def draw(self, painter, area, phis, values):
        """One curve in its strip, with its least and largest value at the left."""
        low, high = min(values), max(values)
        ends = (low, high)
        if high - low < FLAT:
            low, high = low - 1, high + 1
        painter.setPen(QtGui.QPen(QtGui.QColor(150, 150, 150), 1))
        painter.drawRect(area)
        if low < 0 < high:
            zero = area.bottom() - area.height() * (0 - low) / (high - low)
            painter.setPen(QtGui.QPen(QtGui.QColor(190, 190, 190), 1, QtCore.Qt.DotLine))
            painter.drawLine(QtCore.QPointF(area.left(), zero), QtCore.QPointF(area.right(), zero))
        span = phis[-1] - phis[0]
        points = [QtCore.QPointF(area.left() + area.width() * (phi - phis[0]) / span,
                                 area.bottom() - area.height() * (value - low) / (high - low))
                  for phi, value in zip(phis, values)]
        painter.setPen(QtGui.QPen(QtGui.QColor(64, 115, 179), 1.5))
        painter.drawPolyline(QtGui.QPolygonF(points))
        painter.setPen(self.palette().color(QtGui.QPalette.WindowText))
        labels = [(ends[1], area.top() - 5), (ends[0], area.bottom() - 9)]
        for value, top in labels if ends[1] - ends[0] >= FLAT else [(ends[0], area.center().y() - 7)]:
            painter.drawText(QtCore.QRectF(0, top, LEFT - 4, 14), QtCore.Qt.AlignRight, "%.3g" % (value + 0.0))
