"""The task panel that drives the gear."""

import math
import os

import FreeCAD as App
import FreeCADGui as Gui
from PySide import QtCore, QtGui

from .mechanism import Mechanism

translate = App.Qt.translate
STEPS = 720  # of the slider, per turn
FRAME_MS = 40
ICON = os.path.join(os.path.dirname(__file__), "resources", "drive.svg")


class DrivePanel:
    """Slider and play button; shows φ and Q."""

    def __init__(self, document):
        self.mechanism = Mechanism(document)
        self.before = self.mechanism.phi
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translate("mpcgear", "Drive the gear"))
        self.form.setWindowIcon(QtGui.QIcon(ICON))
        self.slider = QtGui.QSlider(QtCore.Qt.Horizontal)
        self.slider.setRange(0, STEPS)
        self.slider.valueChanged.connect(self.turn)
        self.play = QtGui.QPushButton(translate("mpcgear", "Play"))
        self.play.setCheckable(True)
        self.play.toggled.connect(self.toggle)
        self.back = QtGui.QPushButton(translate("mpcgear", "Reset"))
        self.back.setToolTip(translate("mpcgear", "Back to where the gear stood when this panel was opened"))
        self.back.clicked.connect(self.reset)
        self.words = QtGui.QLabel()
        self.warning = QtGui.QLabel(
            translate("mpcgear", "Q above 0: the driver holds the follower in every free direction here."))
        self.warning.setWordWrap(True)
        layout = QtGui.QVBoxLayout(self.form)
        for widget in (self.slider, self.play, self.back, self.words, self.warning):
            layout.addWidget(widget)
        self.timer = QtCore.QTimer()
        self.timer.timeout.connect(self.step)
        self.reset()

    def turn(self, value):
        """The slider has moved."""
        self.show(2 * math.pi * value / STEPS)

    def reset(self):
        """Back to where the gear stood, as if nobody had driven it."""
        self.play.setChecked(False)
        self.slider.blockSignals(True)
        self.slider.setValue(round(self.before / (2 * math.pi) * STEPS))
        self.slider.blockSignals(False)
        self.show(self.before)

    def show(self, phi):
        """Moves the gear to φ, rad."""
        q = self.mechanism.move(phi)
        self.words.setText("φ = %.1f°      Q = %.3f" % (math.degrees(phi), q))
        Gui.updateGui()

    def step(self):
        """One frame of the animation."""
        self.slider.setValue((self.slider.value() + 2) % STEPS)

    def toggle(self, playing):
        """The play button has been pressed."""
        self.play.setText(translate("mpcgear", "Pause") if playing else translate("mpcgear", "Play"))
        if playing:
            self.timer.start(FRAME_MS)
        else:
            self.timer.stop()

    def getStandardButtons(self):
        """A Close button only; an int in 0.20, taken as such by 1.x too."""
        return int(QtGui.QDialogButtonBox.Close.value
                   if hasattr(QtGui.QDialogButtonBox.Close, "value")
                   else QtGui.QDialogButtonBox.Close)

    def reject(self):
        """The panel is closed; the gear stays where it is."""
        self.timer.stop()
        Gui.Control.closeDialog()
        return True
