"""The task panel that drives the gear."""

import math
import os

import FreeCADGui as Gui
from PySide import QtCore, QtGui

from .mechanism import Mechanism

STEPS = 720  # of the slider, per turn
FRAME_MS = 40
ICON = os.path.join(os.path.dirname(__file__), "resources", "drive.svg")


class DrivePanel:
    """Slider and play button; shows φ and Q."""

    def __init__(self, document):
        self.mechanism = Mechanism(document)
        self.form = QtGui.QWidget()
        self.form.setWindowTitle("Drive the gear")
        self.form.setWindowIcon(QtGui.QIcon(ICON))
        self.slider = QtGui.QSlider(QtCore.Qt.Horizontal)
        self.slider.setRange(0, STEPS)
        self.slider.valueChanged.connect(self.turn)
        self.play = QtGui.QPushButton("Play")
        self.play.setCheckable(True)
        self.play.toggled.connect(self.toggle)
        self.words = QtGui.QLabel()
        self.warning = QtGui.QLabel(
            "Q above 0: the driver holds the follower in every free direction here.")
        self.warning.setWordWrap(True)
        layout = QtGui.QVBoxLayout(self.form)
        for widget in (self.slider, self.play, self.words, self.warning):
            layout.addWidget(widget)
        self.timer = QtCore.QTimer()
        self.timer.timeout.connect(self.step)
        self.slider.setValue(round(self.mechanism.phi / (2 * math.pi) * STEPS))
        self.turn(self.slider.value())

    def turn(self, value):
        """The slider has moved."""
        phi = 2 * math.pi * value / STEPS
        q = self.mechanism.move(phi)
        self.words.setText("φ = %.1f°      Q = %.3f" % (math.degrees(phi), q))
        Gui.updateGui()

    def step(self):
        """One frame of the animation."""
        self.slider.setValue((self.slider.value() + 2) % STEPS)

    def toggle(self, playing):
        """The play button has been pressed."""
        self.play.setText("Pause" if playing else "Play")
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
