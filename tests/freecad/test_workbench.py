# SPDX-License-Identifier: MPL-2.0
"""Tests of FreeCAD's workbench, run by freecadcmd; the exit code is their result."""
import json
import os
import sys
import traceback
import unittest
from pathlib import Path

import FreeCAD
import Part

sys.path.insert(0, os.environ["BATTEN_WORKBENCH"])  # the folder of InitGui.py
from batten_freecad import continuity, fair, given, scene, skin  # noqa: E402

V = FreeCAD.Vector
SKETCHES = Path(os.environ.get("BATTEN_SKETCH_FOLDER", ""))


def arch(a, b, up):
    """An edge from a to b with its middle raised."""
    curve = Part.BSplineCurve()
    curve.interpolate([a, (a + b) * 0.5 + up, b])
    return curve.toShape()


def four_arches(document, height=20):
    """Four splines around a rectangle, one object each."""
    corners = [V(0, 0, 0), V(200, 0, 0), V(200, 120, 0), V(0, 120, 0)]
    lines = []
    for i in range(4):
        line = document.addObject("Part::Feature", f"Line{i + 1}")
        line.Shape = arch(corners[i], corners[(i + 1) % 4], V(0, 0, height))
        lines.append((line, ("Edge1",)))
    return lines


class Workbench(unittest.TestCase):
    def setUp(self):
        self.document = FreeCAD.newDocument()

    def tearDown(self):
        FreeCAD.closeDocument(self.document.Name)

    def test_splines_are_skinned_and_followed(self):
        lines = four_arches(self.document)
        obj = skin.make(self.document, lines)
        self.assertTrue(obj.Shape.isValid())
        self.assertEqual(len(obj.Shape.Faces), 1)
        for line, _ in lines:
            for p in line.Shape.Edges[0].discretize(20):
                self.assertLess(obj.Shape.distToShape(Part.Vertex(p))[0], 0.03)
        area = obj.Shape.Area
        # A curve changes: the surface is computed again.
        lines[0][0].Shape = arch(V(0, 0, 0), V(200, 0, 0), V(0, 0, 60))
        self.document.recompute()
        self.assertGreater(obj.Shape.Area, area * 1.02)
        self.assertLess(obj.Shape.distToShape(Part.Vertex(V(100, 0, 60)))[0], 0.03)
        # Pressure and point loads move it, and its curves do not change.
        def height():
            upright = Part.LineSegment(V(100, 70, -500), V(100, 70, 500)).toShape()
            return obj.Shape.distToShape(upright)[1][0][0].z

        rest = height()
        obj.Pressure = 100
        self.document.recompute()
        self.assertGreater(abs(height() - rest), 1)
        obj.Pressure = 0
        obj.LoadPoints = [V(100, 70, rest)]
        obj.LoadForces = [V(0, 0, 20)]
        self.document.recompute()
        self.assertGreater(height(), rest + 1)
        self.assertLess(obj.Shape.distToShape(Part.Vertex(V(100, 0, 60)))[0], 0.03)

    def test_edges_are_creases_or_smooth(self):
        # Two halves of a vault; their sides continue across the ridge.
        def side(x, y, way):
            curve = Part.BezierCurve()
            curve.setPoles([V(x, y, 0), V(x, y + (20 + x / 5) * way, 30), V(x, 80 - 40 * way, 40), V(x, 80, 40)])
            return curve.toShape()

        def straight(a, b):
            return Part.LineSegment(a, b).toShape()

        shapes = {"front": Part.Arc(V(0, 0, 0), V(50, -10, 10), V(100, 0, 0)).toShape(), "back": straight(V(0, 160, 0), V(100, 160, 0)),
                  "ridge": straight(V(0, 80, 40), V(100, 80, 40)), "a": side(0, 0, 1), "b": side(100, 0, 1),
                  "c": side(0, 160, -1), "d": side(100, 160, -1)}
        lines = {}
        for name, shape in shapes.items():
            lines[name] = self.document.addObject("Part::Feature", name)
            lines[name].Shape = shape
        obj = skin.make(self.document, [(line, ("Edge1",)) for line in lines.values()])
        self.assertEqual(len(obj.Shape.Faces), 2)
        (_, gap, smooth), = continuity.rows_of(obj.Shape)
        self.assertLess(gap, 0.01)
        self.assertLess(smooth, 0.1)
        obj.Creases = [(lines["ridge"], ("Edge1",))]
        self.document.recompute()
        (_, gap, crease), = continuity.rows_of(obj.Shape)
        self.assertLess(gap, 0.01)
        self.assertGreater(crease, 10 * smooth)

    def test_a_circle_and_a_line_are_lines(self):
        line = self.document.addObject("Part::Feature", "Rim")
        line.Shape = Part.Circle(V(0, 0, 10), V(0.3, 0, 1), 50).toShape()
        obj = skin.make(self.document, [(line, ("",))])
        self.assertAlmostEqual(obj.Shape.Area, 3.14159265 * 2500, delta=3)

    def test_a_fair_curve_follows_its_edge(self):
        wave = [V(x, 30 * (x / 100) * (1 - x / 100) + 0.2 * (-1) ** x, 0) for x in range(101)]
        line = self.document.addObject("Part::Feature", "Drawn")
        line.Shape = Part.makePolygon(wave)
        direct = fair.fair_edge(wave)
        self.assertLess(max(abs(p.y - 30 * (p.x / 100) * (1 - p.x / 100)) for p in direct.discretize(50)), 0.25)
        spline = self.document.addObject("Part::Feature", "Spline")
        spline.Shape = arch(V(0, 0, 0), V(100, 0, 0), V(0, 10, 0))
        obj = fair.make(self.document, (spline, ("Edge1",)))
        self.assertLess(obj.Shape.distToShape(Part.Vertex(V(50, 10, 0)))[0], 0.2)

    def test_what_is_wrong_is_said(self):
        line = self.document.addObject("Part::Feature", "Alone")
        line.Shape = Part.LineSegment(V(0, 0, 0), V(10, 0, 0)).toShape()
        obj = skin.make(self.document, [(line, ("Edge1",))])
        self.assertIn("Invalid", obj.State)
        with self.assertRaises(scene.BattenError) as refused:
            scene.run(scene.scene_of({"alone": line.Shape.Edges[0]}))
        self.assertIn("loop", str(refused.exception))
        empty = self.document.addObject("Part::FeaturePython", "Empty")
        skin.Skin(empty)
        with self.assertRaises(scene.BattenError):
            empty.Proxy.execute(empty)
        before = os.environ.get("BATTEN_PROGRAM", "")
        os.environ["BATTEN_PROGRAM"] = "/nowhere/batten"
        try:
            with self.assertRaises(scene.BattenError):
                scene.program()
        finally:
            os.environ["BATTEN_PROGRAM"] = before

    def part(self, shape, name="Part"):
        obj = self.document.addObject("Part::Feature", name)
        obj.Shape = shape
        return obj

    def test_openings_are_filled_to_a_solid(self):
        # A cylinder with a hemisphere's zone on top, without the cap: an edge number after the degenerate one of a pole.
        sphere = Part.makeSphere(20, V(0, 0, 0), V(0, 0, 1), -90, 50, 360)
        cap = next(f"Face{i + 1}" for i, face in enumerate(sphere.Faces) if isinstance(face.Surface, Part.Plane))
        obj = given.fill(self.document, [(self.part(sphere), (cap,))])
        self.assertEqual(list(obj.Messages), [])
        self.assertTrue(obj.Shape.isValid())
        self.assertEqual(len(obj.Shape.Solids), 1)
        self.assertAlmostEqual(obj.Shape.Volume, 4 / 3 * 3.14159265 * 8000, delta=0.002 * 33510)
        # The same opening, of the shell without the cap, by its edge; the other is closed, too, if nothing is selected.
        tube = self.part(Part.makeCylinder(10, 30).Faces[0], "Tube")
        ring = next(f"Edge{i + 1}" for i, edge in enumerate(tube.Shape.Edges) if edge.Length > 40 and edge.CenterOfMass.z > 1)
        one = given.fill(self.document, [(tube, (ring,))])
        self.assertEqual(len(one.Shape.Faces), 2)
        self.assertGreater(one.Shape.Faces[1].CenterOfMass.z, 15)
        both = given.fill(self.document, [(tube, ("",))])
        self.assertAlmostEqual(both.Shape.Volume, 3.14159265 * 100 * 30, delta=10)
        # It follows the part.
        tube.Shape = Part.makeCylinder(12, 30).Faces[0]
        self.document.recompute()
        self.assertAlmostEqual(both.Shape.Volume, 3.14159265 * 144 * 30, delta=15)
        both.NewFacesOnly = True
        self.document.recompute()
        self.assertEqual(len(both.Shape.Faces), 2)

    def test_edges_of_two_parts_are_blended(self):
        def sheet(*corners):
            return Part.Face(Part.makePolygon([*corners, corners[0]]))

        def edge_at(obj, middle):
            return next(f"Edge{i + 1}" for i, e in enumerate(obj.Shape.Edges) if (e.CenterOfMass - middle).Length < 1e-6)

        flat = self.part(sheet(V(0, 0, 0), V(40, 0, 0), V(40, 30, 0), V(0, 30, 0)), "Flat")
        wall = self.part(sheet(V(70, 0, 30), V(70, 30, 30), V(70, 30, 60), V(70, 0, 60)), "Wall")
        source = [(flat, (edge_at(flat, V(40, 15, 0)),)), (wall, (edge_at(wall, V(70, 15, 30)),))]
        obj = given.blend(self.document, source)
        self.assertEqual(len(obj.Shape.Faces), 1)
        area = obj.Shape.Area
        obj.NewFacesOnly = False
        self.document.recompute()
        rows = continuity.rows_of(obj.Shape)
        self.assertEqual(len(rows), 4)  # a curve across the blend divides both of its edges
        self.assertLess(max(angle for _, _, angle in rows), 0.1)
        obj.NewFacesOnly = True
        obj.Tension = 2
        self.document.recompute()
        self.assertGreater(obj.Shape.Area, 1.05 * area)
        with self.assertRaises(scene.BattenError):
            obj.Source = source[:1]
            obj.Proxy.execute(obj)

    def test_a_skin_continues_the_faces_beside_its_edges(self):
        tube = self.part(Part.makeCylinder(10, 30).Faces[0], "Tube")
        ring = next(f"Edge{i + 1}" for i, edge in enumerate(tube.Shape.Edges) if edge.Length > 40 and edge.CenterOfMass.z > 1)
        obj = skin.make(self.document, [(tube, (ring,))])
        self.assertEqual([(o.Name, tuple(s)) for o, s in obj.Neighbours], [("Tube", ("Face1",))])
        self.assertLess(obj.Shape.BoundBox.ZMax, 30.01)  # a flat lid: G0 at a right angle
        obj.Continuity = "G1"
        self.document.recompute()
        self.assertGreater(obj.Shape.BoundBox.ZMax, 34)
        obj.Neighbours = []
        self.document.recompute()
        self.assertLess(obj.Shape.BoundBox.ZMax, 30.01)
        # The edges of one face of a solid: the faces around it.
        box = self.part(Part.makeBox(10, 20, 30), "Box")
        edges = tuple(f"Edge{i + 1}" for i, edge in enumerate(box.Shape.Edges) if edge.CenterOfMass.z > 29.9)
        (_, names), = given.faces_beside([(box, edges)])
        self.assertEqual(len(names), 4)

    def test_a_document_is_saved_and_opened(self):
        obj = skin.make(self.document, four_arches(self.document))
        area = obj.Shape.Area
        name = obj.Name
        file = Path(os.environ["BATTEN_SCRATCH"]) / "four.FCStd"
        self.document.saveAs(str(file))
        FreeCAD.closeDocument(self.document.Name)
        self.document = FreeCAD.openDocument(str(file))
        same = self.document.getObject(name)
        self.assertAlmostEqual(same.Shape.Area, area, delta=1e-9 * area)
        self.document.getObject("Line1").Shape = arch(V(0, 0, 0), V(200, 0, 0), V(0, 0, 50))
        self.document.recompute()
        self.assertGreater(same.Shape.Area, area * 1.01)

    @unittest.skipUnless((SKETCHES / "hat.json").exists(), "the published sketches are not there")
    def test_sketches_are_documents_with_valid_shapes(self):
        names = os.environ.get("BATTEN_SKETCHES", "hat,02-1-2").split(",")
        for name in names:
            graph = json.loads((SKETCHES / f"{name}.json").read_text())
            segments = {s["id"]: s for s in graph["segments"]}
            lines = []
            for number, stroke in enumerate(graph["strokes"]):
                edges = []
                for one in stroke["segments"]:
                    for poles in segments[one]["ctrl_pts"]:
                        curve = Part.BezierCurve()
                        curve.setPoles([V(*p) * 1000 for p in poles])
                        edges.append(curve.toShape())
                if not edges:
                    continue
                line = self.document.addObject("Part::Feature", f"Stroke{number}")
                line.Shape = Part.Wire(edges) if len(edges) > 1 else edges[0]
                lines.append((line, ("",)))
            obj = skin.make(self.document, lines, "Skin_" + name.replace("-", "_"))
            print(f"{name}: {len(lines)} strokes, {len(obj.Shape.Faces)} faces, valid {obj.Shape.isValid()}, "
                  f"{len(obj.Messages)} messages", flush=True)
            self.assertGreater(len(obj.Shape.Faces), 3)
            self.assertTrue(all(face.isValid() for face in obj.Shape.Faces))


def main():
    try:
        suite = unittest.defaultTestLoader.loadTestsFromTestCase(Workbench)
        result = unittest.TextTestRunner(stream=sys.stderr, verbosity=2).run(suite)
        code = 0 if result.wasSuccessful() else 1
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # otherwise FreeCAD would wait for commands


main()
