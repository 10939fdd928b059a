"""The commands of the workbench."""

import math
import os

import FreeCAD as App
import FreeCADGui as Gui
from PySide import QtGui

from . import clearance, datums, files, new_gear, redesign, teeth
from .drive import DrivePanel
from .mechanism import Mechanism, NoMechanism
from .open_design import DesignError, open_design
from .progress import Cancelled

translate = App.Qt.translate
RESOURCES = os.path.join(os.path.dirname(__file__), "resources")


def tell(title, words):
    """A message box, and the same words in the report view."""
    App.Console.PrintMessage("mpcgear: %s\n" % words)
    QtGui.QMessageBox.information(Gui.getMainWindow(), title, words)


class Command:
    """What the commands have in common: they turn expected failures into words."""

    title = ""
    tip = ""
    icon = ""

    def GetResources(self):
        picture = os.path.join(RESOURCES, self.icon)
        return {"MenuText": self.title, "ToolTip": self.tip, "Pixmap": picture}

    def IsActive(self):
        return App.ActiveDocument is not None

    def Activated(self):
        try:
            self.run()
        except (DesignError, NoMechanism, datums.NotAHub, redesign.NotRedesigned) as error:
            tell(self.title, str(error))
        except Cancelled:
            App.Console.PrintMessage("mpcgear: cancelled\n")


class NewGear(Command):
    """New gear…"""

    title = translate("mpcgear", "New gear…")
    tip = translate("mpcgear", "Designs a gear for a motion: example, formulas, CSV, path or recorded poses")
    icon = "new.svg"

    def IsActive(self):
        return True

    def run(self):
        Gui.Control.showDialog(new_gear.NewGearPanel())


class Redesign(Command):
    """Redesign…"""

    title = translate("mpcgear", "Redesign…")
    tip = translate("mpcgear", "Designs this gear again with changes; what you have built on it stays")
    icon = "redesign.svg"

    def run(self):
        Gui.Control.showDialog(new_gear.NewGearPanel(App.ActiveDocument))


class OpenDesign(Command):
    """Open mpcgear design…"""

    title = translate("mpcgear", "Open mpcgear design…")
    tip = translate("mpcgear", "Builds the mechanism of a design.json in a new document")
    icon = "open.svg"

    def IsActive(self):
        return True

    def run(self):
        path, _ = QtGui.QFileDialog.getOpenFileName(
            Gui.getMainWindow(), self.title, "", "mpcgear designs (*.json)")
        if path:
            files.show(open_design(path))


class RebuildTeeth(Command):
    """Rebuild teeth"""

    title = translate("mpcgear", "Rebuild teeth")
    tip = translate("mpcgear", "Builds the teeth anew after a change of the sheet ToothParams")
    icon = "teeth.svg"

    def run(self):
        with_undo(self.title, Mechanism(App.ActiveDocument).document, teeth.rebuild)


class PutUnderTeeth(Command):
    """Put under the teeth"""

    title = translate("mpcgear", "Put under the teeth")
    tip = translate("mpcgear", "The selected feature, built on a hub, takes the place of that hub under the teeth")
    icon = "hub.svg"

    def run(self):
        selected = Gui.Selection.getSelection()
        if len(selected) != 1:
            raise datums.NotAHub(translate(
                "mpcgear", "Select the last feature of what you have built on the hub."))
        with_undo(self.title, App.ActiveDocument, lambda document: datums.adopt(document, selected[0]))


def with_undo(title, document, change):
    """Changes the document in one step that can be undone, or not at all."""
    document.openTransaction(title)
    try:
        change(document)
        document.recompute()
    except BaseException:
        document.abortTransaction()
        raise
    document.commitTransaction()


class Drive(Command):
    """Drive the gear"""

    title = translate("mpcgear", "Drive the gear")
    tip = translate("mpcgear", "Turns the driver and moves the follower; shows the driver angle and Q")
    icon = "drive.svg"

    def run(self):
        Gui.Control.showDialog(DrivePanel(App.ActiveDocument))


class CheckClearance(Command):
    """Check clearance here"""

    title = translate("mpcgear", "Check clearance here")
    tip = translate("mpcgear", "Overlaps and gaps of the solids at the present driver angle")
    icon = "clearance.svg"

    def run(self):
        mechanism = Mechanism(App.ActiveDocument)
        words = translate("mpcgear", "At φ = %.1f°: ") % math.degrees(mechanism.phi)
        tell(self.title, words + told(clearance.here(mechanism), False))


class SweepClearance(Command):
    """Clearance over a turn"""

    title = translate("mpcgear", "Clearance over a turn")
    tip = translate("mpcgear", "Overlaps and least gaps of the solids, with what you have added, all round")
    icon = "sweep.svg"

    def run(self):
        mechanism = Mechanism(App.ActiveDocument)
        words = translate("mpcgear", "At %d driver angles: ") % clearance.ANGLES
        tell(self.title, words + told(clearance.sweep(mechanism), True))


def told(contacts, with_angle):
    """Contacts in words, the worst dozen of them."""
    overlaps = [c for c in contacts if c.overlap > clearance.TOUCH]
    words = translate("mpcgear", "%d overlaps.") % len(overlaps) if overlaps else \
        translate("mpcgear", "nothing overlaps.")
    at = [" (φ = %.0f°)" % math.degrees(c.phi) if with_angle else "" for c in contacts]
    return "\n".join([words] + ["%s%s" % pair for pair in zip(contacts[:12], at)])


def register():
    """Registers the commands and returns their names."""
    commands = {"Mpcgear_New": NewGear, "Mpcgear_Redesign": Redesign,
                "Mpcgear_Open": OpenDesign, "Mpcgear_Teeth": RebuildTeeth,
                "Mpcgear_Hub": PutUnderTeeth, "Mpcgear_Drive": Drive,
                "Mpcgear_Clearance": CheckClearance, "Mpcgear_Sweep": SweepClearance}
    for name, command in commands.items():
        Gui.addCommand(name, command())
    return list(commands)
