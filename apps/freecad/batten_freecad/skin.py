# SPDX-License-Identifier: MPL-2.0
"""The feature Skin: surfaces between edges of other objects, updated when one of them changes."""
import FreeCAD
import Part

from batten_freecad import given, scene
from batten_freecad.stateless import Stateless


def edges_of(links):
    """{name: edge} of links [(object, (sub-element, …)), …]; an object without sub-elements stands for all its edges."""
    edges = {}
    for obj, subs in links:
        subs = [sub for sub in ([subs] if isinstance(subs, str) else subs) if sub]
        subs = subs or [f"Edge{i + 1}" for i in range(len(obj.Shape.Edges))]
        for sub in subs:
            if sub.startswith("Edge"):
                edges[f"{obj.Name}_{sub}"] = obj.Shape.getElement(sub)
    return edges


class Skin(Stateless):
    """Properties in addition to the shape:

    Curves           edges, in any order and direction; closed loops of them bound faces
    Creases, Smooth  edges of Curves whose faces meet with a crease (G0) or smoothly (G1), instead of automatically
    Neighbours       faces that the surfaces continue at common edges, which keep their shape
    Continuity       with these faces
    Pressure         along the normals; dimensionless, for surfaces scaled to size 1
    LoadPoints, LoadForces  points, and the force at each, with dimensionless length
    EdgeLength       target edge length of the elements; 0: 1/20 of the size
    GapTolerance     largest gap between curves that is closed; 0: determined from the gaps
    Messages         warnings and failed checks of the program
    """

    def __init__(self, obj):
        obj.Proxy = self
        add = obj.addProperty
        add("App::PropertyLinkSubList", "Curves", "Batten", "Edges that bound the surfaces")
        add("App::PropertyLinkSubList", "Creases", "Batten", "Edges with a crease (G0)")
        add("App::PropertyLinkSubList", "Smooth", "Batten", "Edges with tangent continuity (G1)")
        add("App::PropertyLinkSubList", "Neighbours", "Batten", "Faces that the surfaces continue")
        given.add_continuity(obj)
        add("App::PropertyFloat", "Pressure", "Batten", "Pressure along the normals (dimensionless)")
        add("App::PropertyVectorList", "LoadPoints", "Batten", "Points of the point loads")
        add("App::PropertyVectorList", "LoadForces", "Batten", "Forces of the point loads (dimensionless)")
        add("App::PropertyLength", "EdgeLength", "Batten", "Target edge length of the elements (0: automatic)")
        add("App::PropertyLength", "GapTolerance", "Batten", "Largest gap between curves that is closed (0: automatic)")
        add("App::PropertyStringList", "Messages", "Result", "Warnings and failed checks")
        obj.setEditorMode("Messages", 1)

    def execute(self, obj):
        edges = edges_of(obj.Curves)
        if not edges:
            raise scene.BattenError("found no edges, expected edges that form a closed loop")
        if len(obj.LoadPoints) != len(obj.LoadForces):
            raise scene.BattenError(f"found {len(obj.LoadPoints)} load points and {len(obj.LoadForces)} forces, "
                                    "expected one force for each point")
        # Documents of earlier releases have no such property.
        faces = [o.Shape.getElement(s) for o, s in given.sub_elements(getattr(obj, "Neighbours", [])) if s]
        files = [("neighbours.brep", Part.Compound(faces))] if faces else []
        toml = scene.scene_of(edges, [n for n in edges_of(obj.Creases) if n in edges],
                              [n for n in edges_of(obj.Smooth) if n in edges], obj.Pressure,
                              list(zip(obj.LoadPoints, obj.LoadForces)), obj.EdgeLength.Value, obj.GapTolerance.Value,
                              neighbours=files[0][0] if files else "", continuity=getattr(obj, "Continuity", "Automatic"))
        shape, report = scene.run(toml, files)
        obj.Shape = shape
        obj.Messages = scene.messages_of(report)
        for message in obj.Messages:
            FreeCAD.Console.PrintWarning(f"{obj.Label}: {message}\n")


def make(document, curves, name="Skin"):
    """Adds a Skin between edges, [(object, (sub-element, …)), …], and computes it. It continues the faces beside them."""
    obj = document.addObject("Part::FeaturePython", name)
    Skin(obj)
    obj.Curves = curves
    obj.Neighbours = given.faces_beside(curves)
    if FreeCAD.GuiUp:
        from batten_freecad import view

        view.SkinView(obj.ViewObject)
    document.recompute()
    return obj
