"""The feature FairCurve: the fair curve that an edge or drawn points mean."""
import tempfile
from pathlib import Path

import FreeCAD
import Part

from batten_freecad import scene
from batten_freecad.stateless import Stateless


def fair_edge(vectors, deviation=0.0, closed=False):
    """The fair curve near points: an edge. deviation: not farther than this from any point, mm; 0: found by itself."""
    with tempfile.TemporaryDirectory(prefix="batten-freecad-") as name:
        folder = Path(name)
        rows = "\n".join(",".join(repr(float(x)) for x in v) for v in vectors)
        (folder / "line.csv").write_text("x,y,z\n" + rows + "\n", encoding="utf-8")
        words = ["fair", "line.csv", "--out", "fair.step", "--unit", "mm", "--quiet", "--closed" if closed else "--open"]
        scene.call(words + (["--deviation", repr(float(deviation))] if deviation > 0 else []), folder)
        edges = Part.read(str(folder / "fair.step")).Edges
        if not edges:
            raise scene.BattenError("the file of the fair curve has no edge")
        return edges[0] if len(edges) == 1 else Part.Wire(Part.__sortEdges__(edges))


class FairCurve(Stateless):
    """Properties beside the shape: Line (an edge, taken at Points places along it), Deviation (0: found), Points."""

    def __init__(self, obj):
        obj.Proxy = self
        obj.addProperty("App::PropertyLinkSub", "Line", "Batten", "The edge that is made fair")
        obj.addProperty("App::PropertyLength", "Deviation", "Batten", "Largest distance from it; 0: found")
        obj.addProperty("App::PropertyInteger", "Points", "Batten", "Points that are taken of the edge").Points = 200

    def execute(self, obj):
        if not obj.Line or not obj.Line[0]:
            raise scene.BattenError("no edge: choose the line to make fair")
        source, subs = obj.Line
        edge = source.Shape.getElement(subs[0]) if subs and subs[0] else source.Shape.Edges[0]
        closed = edge.isClosed()
        count = max(8, obj.Points) + (1 if closed else 0)
        obj.Shape = fair_edge(edge.discretize(count), obj.Deviation.Value, closed)


def make(document, line, name="FairCurve"):
    """Adds a FairCurve of an edge, (object, ("Edge1",)), and makes it."""
    obj = document.addObject("Part::FeaturePython", name)
    FairCurve(obj)
    obj.Line = line
    if FreeCAD.GuiUp:
        obj.ViewObject.Proxy = 0
    document.recompute()
    return obj
