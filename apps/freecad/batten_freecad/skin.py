"""The feature Skin: surfaces between edges of other objects, made again when one of them changes."""
import FreeCAD

from batten_freecad import scene
from batten_freecad.stateless import Stateless


def edges_of(links):
    """{name: edge} of a list of links [(object, (sub-element, …)), …]; an object without sub-elements means all its edges."""
    edges = {}
    for obj, subs in links:
        subs = [sub for sub in ([subs] if isinstance(subs, str) else subs) if sub]
        subs = subs or [f"Edge{i + 1}" for i in range(len(obj.Shape.Edges))]
        for sub in subs:
            if sub.startswith("Edge"):
                edges[f"{obj.Name}_{sub}"] = obj.Shape.getElement(sub)
    return edges


class Skin(Stateless):
    """Properties beside the shape:

    Lines       edges, in any order and direction; those that close loops get surfaces
    Creases, Smooth   edges of Lines where surfaces meet so, whatever they would do by themselves
    Pressure    along the normals; a pure number on surfaces scaled to size 1
    PushAt, PushBy    places, and for each a force; its length is a pure number
    EdgeLength  of elements; 0: a twentieth of the size
    Tolerance   distance within which lines meet; 0: found from their gaps
    Words       what the program warned of and what it missed
    """

    def __init__(self, obj):
        obj.Proxy = self
        add = obj.addProperty
        add("App::PropertyLinkSubList", "Lines", "Batten", "Edges between which there are surfaces")
        add("App::PropertyLinkSubList", "Creases", "Batten", "Edges where surfaces meet at an angle")
        add("App::PropertyLinkSubList", "Smooth", "Batten", "Edges where surfaces meet smoothly")
        add("App::PropertyFloat", "Pressure", "Batten", "Pressure along the normals, a pure number")
        add("App::PropertyVectorList", "PushAt", "Batten", "Places of point loads")
        add("App::PropertyVectorList", "PushBy", "Batten", "Their forces, pure numbers")
        add("App::PropertyLength", "EdgeLength", "Batten", "Length of elements; 0: found")
        add("App::PropertyLength", "Tolerance", "Batten", "Distance within which lines meet; 0: found")
        add("App::PropertyStringList", "Words", "Result", "What was warned of and missed")
        obj.setEditorMode("Words", 1)

    def execute(self, obj):
        edges = edges_of(obj.Lines)
        if not edges:
            raise scene.BattenError("no edges: choose lines that close a loop")
        if len(obj.PushAt) != len(obj.PushBy):
            raise scene.BattenError(f"found {len(obj.PushAt)} places and {len(obj.PushBy)} forces, expected as many")
        words = scene.scene_of(edges, [n for n in edges_of(obj.Creases) if n in edges],
                               [n for n in edges_of(obj.Smooth) if n in edges], obj.Pressure,
                               list(zip(obj.PushAt, obj.PushBy)), obj.EdgeLength.Value, obj.Tolerance.Value)
        shape, report = scene.run(words)
        obj.Shape = shape
        obj.Words = scene.words_of(report)
        for line in obj.Words:
            FreeCAD.Console.PrintWarning(f"{obj.Label}: {line}\n")


def make(document, lines, name="Skin"):
    """Adds a Skin over edges, [(object, (sub-element, …)), …], and makes it."""
    obj = document.addObject("Part::FeaturePython", name)
    Skin(obj)
    obj.Lines = lines
    if FreeCAD.GuiUp:
        from batten_freecad import view

        view.SkinView(obj.ViewObject)
    document.recompute()
    return obj
