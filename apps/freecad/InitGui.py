# SPDX-License-Identifier: MPL-2.0
"""The workbench Batten: FreeCAD reads this file when its window starts."""
import FreeCADGui


class BattenWorkbench(FreeCADGui.Workbench):
    MenuText = "Batten"
    ToolTip = "Smooth surfaces through curves: fit, load, check continuity"

    def __init__(self):
        from batten_freecad import icons

        self.__class__.Icon = icons.path("skin")

    def Initialize(self):
        from batten_freecad import commands

        names = commands.register()
        self.appendToolbar("Batten", names)
        self.appendMenu("Batten", names)

    def GetClassName(self):
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(BattenWorkbench())
