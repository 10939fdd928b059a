"""Registers the mpcgear workbench."""

import FreeCADGui as Gui


class MpcgearWorkbench(Gui.Workbench):
    """Toolbar and menu with the commands."""

    MenuText = "mpcgear"
    ToolTip = "Gear mechanisms designed by mpcgear: open, build on, drive, check"

    def __init__(self):
        import os

        import mpcgear

        here = os.path.dirname(os.path.dirname(mpcgear.__file__))
        self.__class__.Icon = os.path.join(here, "resources", "mpcgear.svg")

    def Initialize(self):
        from mpcgear import check, commands

        check.watch()
        names = commands.register()
        self.appendToolbar("mpcgear", names)
        self.appendMenu("mpcgear", names)

    def GetClassName(self):
        return "Gui::PythonWorkbench"


Gui.addWorkbench(MpcgearWorkbench())
