"""The commands of the workbench."""
import FreeCAD
import FreeCADGui

from batten_freecad import continuity, fair, icons, scene, skin


def chosen_lines():
    """What is chosen, as links to lines: edges, or whole objects that have edges and no faces."""
    links = []
    for one in FreeCADGui.Selection.getSelectionEx():
        edges = tuple(s for s in one.SubElementNames if s.startswith("Edge"))
        if edges:
            links.append((one.Object, edges))
        elif hasattr(one.Object, "Shape") and one.Object.Shape.Edges and not one.Object.Shape.Faces:
            links.append((one.Object, ("",)))
    return links


def with_words(what, act):
    """Does something as one step to undo; what is refused is told in the report view."""
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
    def __init__(self, icon, words, tip, act, active):
        self.resources = {"Pixmap": icons.path(icon), "MenuText": words, "ToolTip": tip}
        self.act, self.active = act, active

    def GetResources(self):
        return self.resources

    def IsActive(self):
        return FreeCAD.ActiveDocument is not None and self.active()

    def Activated(self):
        self.act()


def make_skin():
    links = chosen_lines()
    obj = with_words("Skin", lambda document: skin.make(document, links))
    if obj:
        FreeCADGui.ActiveDocument.setEdit(obj.Name)


def make_fair():
    for obj, edges in chosen_lines():
        with_words("Fair curve", lambda document, o=obj, e=edges: fair.make(document, (o, (e[0],))))


def check():
    for one in FreeCADGui.Selection.getSelection():
        continuity.tell(one)


def has_faces():
    return any(hasattr(o, "Shape") and len(o.Shape.Faces) > 1 for o in FreeCADGui.Selection.getSelection())


COMMANDS = {
    "Batten_Skin": Command("skin", "Skin", "Surfaces between the chosen edges or sketches", make_skin,
                           lambda: bool(chosen_lines())),
    "Batten_Fair": Command("fair", "Fair curve", "The fair curve that the chosen edge means", make_fair,
                           lambda: bool(chosen_lines())),
    "Batten_Check": Command("check", "Check continuity", "Gaps and angles along the edges that faces share", check, has_faces),
}


def register():
    """Adds the commands to FreeCAD; returns their names."""
    for name, command in COMMANDS.items():
        FreeCADGui.addCommand(name, command)
    return list(COMMANDS)
