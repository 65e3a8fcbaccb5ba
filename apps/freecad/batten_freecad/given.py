# SPDX-License-Identifier: MPL-2.0
"""The features Fill and Blend: faces that continue the faces of other objects."""
import json
import tempfile
from pathlib import Path

import FreeCAD
import Part

from batten_freecad import scene
from batten_freecad.stateless import Stateless

CONTINUITIES = ["Automatic", "G0", "G1", "G2"]


def add_continuity(obj):
    obj.addProperty("App::PropertyEnumeration", "Continuity", "Batten",
                    "Common edges (G0), tangent planes (G1) or curvature (G2)")
    obj.Continuity = CONTINUITIES


def sub_elements(links):
    """[(object, sub-element), …] of links [(object, (sub-element, …)), …]; the sub-element "" stands for the object."""
    pairs = []
    for obj, subs in links:
        subs = [subs] if isinstance(subs, str) else list(subs)
        pairs += [(obj, sub) for sub in subs or [""]]
    return pairs


def faces_at(obj, sub):
    """Names of the faces of an object that share an edge."""
    edge = obj.Shape.getElement(sub)
    return [f"Face{i + 1}" for i, face in enumerate(obj.Shape.Faces) if any(e.isSame(edge) for e in face.Edges)]


def faces_beside(links):
    """The faces that a surface between the edges continues, as links: at each edge, the only face of the object, or the one of
    two whose edges are not all among them."""
    chosen = {}
    for obj, sub in sub_elements(links):
        if sub.startswith("Edge") and obj.Shape.Faces:
            chosen.setdefault(obj, []).append(sub)
    beside = []
    for obj, subs in chosen.items():
        edges = [obj.Shape.getElement(sub) for sub in subs]
        names = []
        for sub in subs:
            faces = faces_at(obj, sub)
            if len(faces) > 1:  # the face that the edges bound is the one that is replaced
                faces = [name for name in faces
                         if not all(any(e.isSame(one) for one in edges) for e in obj.Shape.getElement(name).Edges)]
            if len(faces) == 1 and faces[0] not in names:
                names.append(faces[0])
        if names:
            beside.append((obj, tuple(names)))
    return beside


def part_of(links):
    """The shape of all linked objects, and the names of the program for the faces and edges that are linked."""
    objects = list(dict.fromkeys(obj for obj, _ in sub_elements(links)))
    faces, edges = [], []
    first_face = first_edge = 0
    for obj in objects:
        # The program does not count degenerate edges, such as the pole of a sphere.
        real = [f"Edge{i + 1}" for i, edge in enumerate(obj.Shape.Edges) if not edge.Degenerated]
        for other, sub in sub_elements(links):
            if other is not obj:
                continue
            if sub.startswith("Face"):
                faces.append(f"face {first_face + int(sub[4:])}")
            elif sub.startswith("Edge"):
                edges.append(f"edge{first_edge + real.index(sub) + 1}")
        first_face += len(obj.Shape.Faces)
        first_edge += len(real)
    shapes = [obj.Shape for obj in objects]
    return shapes[0] if len(shapes) == 1 else Part.Compound(shapes), faces, edges


def run(shape, arguments):
    """Runs `batten fill` or `batten blend` on a shape: (shape, report)."""
    with tempfile.TemporaryDirectory(prefix="batten-freecad-") as name:
        folder = Path(name)
        shape.exportBrep(str(folder / "part.brep"))
        scene.call([arguments[0], "part.brep", "--out", "out", "--quiet", *arguments[1:]], folder)
        report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
        steps = list((folder / "out").glob("*.step"))
        if not steps:
            raise scene.BattenError("; ".join(scene.messages_of(report)) or "the openings have no surface")
        return Part.read(str(steps[0])), report


class GivenFaces(Stateless):
    """Properties in addition to the shape:

    Source        the objects that are continued, with faces and edges that say where
    Continuity    with the faces beside the new ones
    NewFacesOnly  whether the shape is only the new faces, and not joined to those of Source
    EdgeLength    target edge length of the elements; 0: 1/20 of the size
    Messages      warnings and failed checks of the program
    """

    def __init__(self, obj, only_new):
        obj.Proxy = self
        add = obj.addProperty
        add("App::PropertyLinkSubList", "Source", "Batten", "Objects that are continued, with the faces and edges that say where")
        add_continuity(obj)
        add("App::PropertyBool", "NewFacesOnly", "Batten", "Without the faces of Source")
        add("App::PropertyLength", "EdgeLength", "Batten", "Target edge length of the elements (0: automatic)")
        add("App::PropertyStringList", "Messages", "Result", "Warnings and failed checks")
        obj.NewFacesOnly = only_new
        obj.setEditorMode("Messages", 1)

    def compute(self, obj, arguments, shape):
        if obj.Continuity != "Automatic":
            arguments += ["--continuity", obj.Continuity]
        if obj.EdgeLength.Value > 0:
            arguments += ["--edge-length", repr(obj.EdgeLength.Value)]
        if obj.NewFacesOnly:
            arguments += ["--new-faces-only"]
        obj.Shape, report = run(shape, arguments)
        obj.Messages = scene.messages_of(report)
        for message in obj.Messages:
            FreeCAD.Console.PrintWarning(f"{obj.Label}: {message}\n")


class Fill(GivenFaces):
    """Faces in the openings of Source: those at the linked edges, those that the linked faces leave when they are removed, or
    all."""

    def __init__(self, obj):
        super().__init__(obj, only_new=False)

    def execute(self, obj):
        if not obj.Source:
            raise scene.BattenError("found no object, expected one with an opening, or a face that is replaced")
        shape, faces, edges = part_of(obj.Source)
        arguments = ["fill"]
        for face in faces:
            arguments += ["--replace", face]
        for edge in edges:
            arguments += ["--edge", edge]
        self.compute(obj, arguments, shape)


class Blend(GivenFaces):
    """A face between free edges of Source. Tension: pull at its sides, 1 by default; between closed edges it has no effect."""

    def __init__(self, obj):
        super().__init__(obj, only_new=True)
        obj.addProperty("App::PropertyFloatConstraint", "Tension", "Batten", "Pull at the sides: 0.5 is flat, 2 bulges")
        obj.Tension = (1.0, 0.05, 10.0, 0.1)

    def execute(self, obj):
        shape, faces, edges = part_of(obj.Source)
        if len(edges) < 2:
            raise scene.BattenError(f"found {len(edges)} edges, expected those of two ends")
        arguments = ["blend"]
        for face in faces:
            arguments += ["--face", face]
        for edge in edges:
            arguments += ["--edge", edge]
        if obj.Tension != 1:
            arguments += ["--tension", repr(obj.Tension)]
        self.compute(obj, arguments, shape)


def make(document, kind, source, name):
    """Adds a feature of the class `kind` for objects and sub-elements [(object, (sub-element, …)), …], and computes it."""
    obj = document.addObject("Part::FeaturePython", name)
    kind(obj)
    obj.Source = source
    if FreeCAD.GuiUp:
        from batten_freecad import view

        view.GivenView(obj.ViewObject)
    document.recompute()
    return obj


def fill(document, source):
    """Adds a Fill: `source` is [(object, (sub-element, …)), …] with faces to replace or edges of openings; ("",): all openings."""
    return make(document, Fill, source, "Fill")


def blend(document, source):
    """Adds a Blend between the edges `source`, [(object, (sub-element, …)), …]."""
    return make(document, Blend, source, "Blend")
