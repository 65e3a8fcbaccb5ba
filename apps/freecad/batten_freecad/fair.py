# SPDX-License-Identifier: MPL-2.0
"""The feature FairCurve: a fair curve from an edge or from drawn points."""
import tempfile
from pathlib import Path

import FreeCAD
import Part

from batten_freecad import scene
from batten_freecad.stateless import Stateless


def fair_edge(vectors, deviation=0.0, closed=False):
    """Fairs points; returns an edge. deviation: maximum distance from any point in mm; 0: determined automatically."""
    with tempfile.TemporaryDirectory(prefix="batten-freecad-") as name:
        folder = Path(name)
        rows = "\n".join(",".join(repr(float(x)) for x in v) for v in vectors)
        (folder / "curve.csv").write_text("x,y,z\n" + rows + "\n", encoding="utf-8")
        arguments = ["fair", "curve.csv", "--out", "fair.step", "--unit", "mm", "--quiet", "--closed" if closed else "--open"]
        scene.call(arguments + (["--deviation", repr(float(deviation))] if deviation > 0 else []), folder)
        edges = Part.read(str(folder / "fair.step")).Edges
        if not edges:
            raise scene.BattenError("found no curve in the output of 'batten fair', expected one")
        return edges[0] if len(edges) == 1 else Part.Wire(Part.__sortEdges__(edges))


class FairCurve(Stateless):
    """Properties in addition to the shape: Curve (an edge), Points (number of sample points along it), Deviation (mm;
    0: automatic)."""

    def __init__(self, obj):
        obj.Proxy = self
        obj.addProperty("App::PropertyLinkSub", "Curve", "Batten", "Edge to fair")
        obj.addProperty("App::PropertyLength", "Deviation", "Batten", "Maximum distance from the edge (0: automatic)")
        obj.addProperty("App::PropertyInteger", "Points", "Batten", "Number of sample points along the edge").Points = 200

    def execute(self, obj):
        if not obj.Curve or not obj.Curve[0]:
            raise scene.BattenError("found no edge, expected one: select the edge to fair")
        source, subs = obj.Curve
        edge = source.Shape.getElement(subs[0]) if subs and subs[0] else source.Shape.Edges[0]
        closed = edge.isClosed()
        count = max(8, obj.Points) + (1 if closed else 0)
        obj.Shape = fair_edge(edge.discretize(count), obj.Deviation.Value, closed)


def make(document, curve, name="FairCurve"):
    """Adds a FairCurve of an edge, (object, ("Edge1",)), and computes it."""
    obj = document.addObject("Part::FeaturePython", name)
    FairCurve(obj)
    obj.Curve = curve
    if FreeCAD.GuiUp:
        obj.ViewObject.Proxy = 0
    document.recompute()
    return obj
