"""Registers the workbench; FreeCAD imports this at its start when it has a window."""

import os

import FreeCAD as App
import FreeCADGui as Gui

RESOURCES = os.path.join(os.path.dirname(__file__), "resources")
translate = App.Qt.translate

Gui.addLanguagePath(os.path.join(RESOURCES, "translations"))
Gui.updateLocale()


class MpcgearWorkbench(Gui.Workbench):
    """Toolbar and menu with the commands."""

    MenuText = "mpcgear"
    ToolTip = translate("mpcgear", "Gear mechanisms designed by mpcgear: design, build on, drive, check")
    Icon = os.path.join(RESOURCES, "mpcgear.svg")

    def Initialize(self):
        """FreeCAD calls it when the workbench is chosen for the first time."""
        from . import check, commands

        check.watch()
        names = commands.register()
        self.appendToolbar("mpcgear", names)
        self.appendMenu("mpcgear", names)

    def GetClassName(self):
        """What FreeCAD wants to hear of a workbench in Python."""
        return "Gui::PythonWorkbench"


Gui.addWorkbench(MpcgearWorkbench())
