"""Files, other packages, pictures, reports."""

import os
import subprocess
import sys
import types
import unittest
import unittest.mock

from properties import PropertyTests, batten, example, grid, np, saddle


class Exchange(PropertyTests):
    def test_a_model_is_written_by_its_ending(self):
        model = batten.load(example("05-door", "scene.toml"))
        for ending in ("step", "iges", "brep", "stl", "obj", "ply", "vtp", "vtu", "glb", "3mf", "inp"):
            file = self.file("door." + ending)
            self.assertEqual(model.save(file), [], ending)
            self.assertGreater(os.path.getsize(file), 1000, ending)
        self.assertEqual(model.failed_checks, [])
        self.assertEqual(model.report["name"], "door")
        with self.assertRaisesRegex(batten.InputError, "stress"):
            batten.skin(saddle()).save(self.file("saddle.inp"))
        again = batten.load(self.file("door.step"))
        self.assertGreater(len(again.faces), 0)

    def test_runs_of_scenes(self):
        report = batten.run(example("02-hood", "scene.toml"), self.folder)
        self.assertTrue(all(os.path.exists(self.file(name)) for name in report["files"]))
        self.assertEqual(batten.convert(example("30-refit", "scan.obj"), self.file("scan.stl")), [])

    def test_a_file_of_lines(self):
        lines = batten.read_curves(example("30-refit", "rims.csv"))
        self.assertTrue(all(points.shape[1] == 3 for points in lines.values()))

    def test_meshio(self):
        try:
            import meshio
        except ImportError:
            self.skipTest("python3-meshio is not there")
        for shown in (batten.skin(saddle()), batten.Session(batten.skin(saddle())), batten.Mesh(*grid(4))):
            mesh = shown.to_meshio()
            np.testing.assert_array_equal(mesh.points, shown.points)
            np.testing.assert_array_equal(mesh.cells_dict["triangle"], shown.triangles)
        mesh.write(self.file("grid.off"))
        self.assertEqual(len(batten.read_mesh(self.file("grid.off")).points), 25)
        self.assertEqual(meshio.Mesh, type(mesh))

    def test_vtk(self):
        # In a separate process, to check which VTK modules it loads.
        code = """
import batten, sys
try:
    import vtkmodules.vtkCommonDataModel
except ImportError:
    sys.exit(77)
sys.path.insert(0, %r)
from properties import saddle
model = batten.skin(saddle())
data = model.to_vtk()
assert data.GetNumberOfPoints() == len(model.points) and data.GetNumberOfCells() == len(model.triangles)
assert data.GetPointData().GetNormals().GetNumberOfTuples() == len(model.points)
assert model.save(sys.argv[1]) == []
""" % os.path.dirname(__file__)
        done = subprocess.run([sys.executable, "-c", code, self.file("x.step")])
        if done.returncode == 77:
            self.skipTest("python3-vtk9 is not there")
        self.assertEqual(done.returncode, 0)

    def test_pyvista_gets_points_facets_and_normals(self):
        # Debian has no PyVista: a mock that stores its arguments replaces it.
        class PolyData:
            def __init__(self, points, faces):
                self.points, self.faces, self.point_data = points, faces, {}

        stand_in = types.ModuleType("pyvista")
        stand_in.PolyData = PolyData
        model = batten.skin(saddle())
        with unittest.mock.patch.dict(sys.modules, {"pyvista": stand_in}):
            surface = model.to_pyvista()
        np.testing.assert_array_equal(surface.points, model.points)
        facets = surface.faces.reshape(-1, 4)
        self.assertTrue((facets[:, 0] == 3).all())
        np.testing.assert_array_equal(facets[:, 1:], model.triangles)
        np.testing.assert_array_equal(surface.point_data["Normals"], model.normals)

    def test_a_model_shows_itself(self):
        model = batten.skin(saddle())
        png = model._repr_png_()
        if not os.environ.get("DISPLAY"):
            self.assertIsNone(png)
            with self.assertRaisesRegex(batten.InputError, "display"):
                model.picture(self.file("x.png"))
        else:
            self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertIn("1 face,", repr(model))

    def test_the_import_is_lean(self):
        code = "import sys, batten; print([m for m in ('meshio', 'vtkmodules', 'pyvista', 'json') if m in sys.modules])"
        done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=True)
        self.assertNotIn("meshio", done.stdout)
        self.assertNotIn("vtkmodules", done.stdout)


if __name__ == "__main__":
    unittest.main()
