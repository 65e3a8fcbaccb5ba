# SPDX-License-Identifier: MPL-2.0
"""View providers: the icons of the features, and the panel that a double click on a Skin opens."""
import FreeCADGui

from batten_freecad import icons
from batten_freecad.stateless import Stateless


class SkinView(Stateless):
    def __init__(self, view):
        view.Proxy = self

    def attach(self, view):
        self.Object = view.Object

    def getIcon(self):
        return icons.path("skin")

    def setEdit(self, view, mode=0):
        from batten_freecad import panel

        FreeCADGui.Control.showDialog(panel.SkinPanel(view.Object))
        return True

    def unsetEdit(self, view, mode=0):
        FreeCADGui.Control.closeDialog()
        return True

    def doubleClicked(self, view):
        return self.setEdit(view)


class GivenView(Stateless):
    """Of a Fill or a Blend."""

    def __init__(self, view):
        view.Proxy = self

    def attach(self, view):
        self.icon = type(view.Object.Proxy).__name__.lower()

    def getIcon(self):
        return icons.path(self.icon)
