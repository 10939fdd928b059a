# --- Progress with a way out, for everything that takes longer than two seconds -------------------

import FreeCAD as App


class Cancelled(Exception):
    """The user has pressed Cancel; what was begun has to be taken back."""


class Progress:
    """A bar with a Cancel button where there is a window, nothing else without. Use it as a context."""

    def __init__(self, words, steps):
        self.words, self.steps, self.done, self.bar = words, steps, 0, None

    def __enter__(self):
        if App.GuiUp:
            import FreeCADGui as Gui
            from PySide import QtCore, QtGui

            self.bar = QtGui.QProgressDialog(self.words, "Cancel", 0, self.steps, Gui.getMainWindow())
            self.bar.setWindowTitle("mpcgear")
            self.bar.setWindowModality(QtCore.Qt.WindowModal)
            self.bar.setMinimumDuration(1000)
        return self

    def step(self, words=None, steps=1):
        """Some more steps are about to be done; raises Cancelled where the user has had enough."""
        if self.bar is not None:
            from PySide import QtGui

            self.bar.setLabelText(words or self.words)
            self.bar.setValue(self.done)
            QtGui.QApplication.processEvents()
            if self.bar.wasCanceled():
                raise Cancelled(self.words)
        self.done += steps

    def __exit__(self, kind, error, trace):
        if self.bar is not None:
            self.bar.close()
            self.bar.deleteLater()
        return False
