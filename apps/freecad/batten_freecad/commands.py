# SPDX-License-Identifier: MPL-2.0
"""The commands of the workbench."""
import FreeCAD
import FreeCADGui

from batten_freecad import continuity, fair, given, icons, scene, skin


def selected_curves():
    """The selection as links to curves: edges, or whole objects that have edges and no faces."""
    links = []
    for one in FreeCADGui.Selection.getSelectionEx():
        edges = tuple(s for s in one.SubElementNames if s.startswith("Edge"))
        if edges:
            links.append((one.Object, edges))
        elif hasattr(one.Object, "Shape") and one.Object.Shape.Edges and not one.Object.Shape.Faces:
            links.append((one.Object, ("",)))
    return links


def as_transaction(what, act):
    """Performs an action as one undo step; errors are printed to the report view."""
    document = FreeCAD.ActiveDocument
    document.openTransaction(what)
    try:
        result = act(document)
        document.commitTransaction()
        return result
    except scene.BattenError as error:
        document.abortTransaction()
        FreeCAD.Console.PrintError(f"{what}: {error}\n")
        return None


class Command:
    def __init__(self, icon, label, tip, act, active):
        self.resources = {"Pixmap": icons.path(icon), "MenuText": label, "ToolTip": tip}
        self.act, self.active = act, active

    def GetResources(self):
        return self.resources

    def IsActive(self):
        return FreeCAD.ActiveDocument is not None and self.active()

    def Activated(self):
        self.act()


def make_skin():
    links = selected_curves()
    obj = as_transaction("Skin", lambda document: skin.make(document, links))
    if obj:
        FreeCADGui.ActiveDocument.setEdit(obj.Name)


def selected(kinds):
    """The selection as links to sub-elements whose names start with one of `kinds`; ("",) for objects without such ones."""
    links = []
    for one in FreeCADGui.Selection.getSelectionEx():
        if hasattr(one.Object, "Shape") and one.Object.Shape.Faces:
            links.append((one.Object, tuple(s for s in one.SubElementNames if s.startswith(kinds)) or ("",)))
    return links


def make_fill():
    links = selected(("Edge", "Face"))
    as_transaction("Fill", lambda document: given.fill(document, links))


def make_blend():
    links = selected(("Edge", "Face"))
    as_transaction("Blend", lambda document: given.blend(document, links))


def make_fair():
    for obj, edges in selected_curves():
        as_transaction("Fair curve", lambda document, o=obj, e=edges: fair.make(document, (o, (e[0],))))


def check():
    for one in FreeCADGui.Selection.getSelection():
        continuity.print_rows(one)


def has_faces():
    return any(hasattr(o, "Shape") and len(o.Shape.Faces) > 1 for o in FreeCADGui.Selection.getSelection())


COMMANDS = {
    "Batten_Skin": Command("skin", "Skin", "Fit smooth surfaces between the selected edges or sketches", make_skin,
                           lambda: bool(selected_curves())),
    "Batten_Fill": Command("fill", "Fill", "Fill the openings at the selected edges, replace the selected faces, or close the "
                           "selected object, tangent to the faces beside them", make_fill,
                           lambda: bool(selected(("Edge", "Face")))),
    "Batten_Blend": Command("blend", "Blend", "Connect the selected edges of faces by a face that continues both", make_blend,
                            lambda: sum(s != "" for _, subs in selected(("Edge",)) for s in subs) > 1),
    "Batten_Fair": Command("fair", "Fair curve", "Create a fair (smooth) curve from the selected edge", make_fair,
                           lambda: bool(selected_curves())),
    "Batten_Check": Command("check", "Check continuity", "Print the gap and the angle between the faces at each shared edge",
                            check, has_faces),
}


def register():
    """Adds the commands to FreeCAD; returns their names."""
    for name, command in COMMANDS.items():
        FreeCADGui.addCommand(name, command)
    return list(COMMANDS)
