# SPDX-License-Identifier: MPL-2.0
"""Files, other packages, pictures, reports."""

import importlib
import os
import subprocess
import sys
import types
import unittest
import unittest.mock

from properties import PropertyTests, batten, example, grid, np, saddle


# Writes a model and a mesh with the VTK module and reads them again. Argument: a folder.
READ_BACK = """
import os, sys, numpy as np, batten
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter
from test_exchange import two_faces

def read_back(data):
    file = os.path.join(sys.argv[1], "data.vtp")
    writer, reader = vtkXMLPolyDataWriter(), vtkXMLPolyDataReader()
    writer.SetFileName(file), writer.SetInputData(data), writer.Write()
    reader.SetFileName(file), reader.Update()
    return reader.GetOutput()

def array(of, name):
    return vtk_to_numpy(of.GetArray(name))

model = two_faces()
session = batten.Session(model)
for shown, model in ((model, model), (session, session.model())):
    data = read_back(shown.to_vtk())
    np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), model.points)
    np.testing.assert_array_equal(vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3), model.triangles)
    np.testing.assert_array_equal(vtk_to_numpy(data.GetPointData().GetNormals()), model.normals)
    np.testing.assert_array_equal(array(data.GetPointData(), "Gauss_curvature"), model.curvatures.prod(axis=1))
    np.testing.assert_array_equal(array(data.GetCellData(), "Face"), model.triangle_faces)
    names = data.GetFieldData().GetAbstractArray("Face_names")
    assert [names.GetValue(i) for i in range(names.GetNumberOfValues())] == model.faces
mesh = batten.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0.5, 0]], [[0, 1, 2, 3], [1, 4, 2]])
data = read_back(mesh.to_vtk())
assert vtk_to_numpy(data.GetPolys().GetOffsetsArray()).tolist() == [0, 4, 7]
welded = model.mesh()
data = read_back(welded.to_vtk())
for name, members in welded.sets.items():
    of, numbers = (data.GetCellData(), members["faces"]) if len(members["faces"]) else (data.GetPointData(), members["nodes"])
    assert set(np.flatnonzero(array(of, name))) == set(numbers), name
stress = batten.stress(model, material="steel", thickness=0.02, supports=["left"], loads=[{"pressure": 1}])
data = read_back(stress.to_vtk())
np.testing.assert_array_equal(array(data.GetPointData(), "Von_mises_top"), stress.von_mises(side="top"))
assert model.save(os.path.join(sys.argv[1], "x.step")) == []
"""


def two_faces():
    """A saddle that a curve from side to side divides in two."""
    curves = saddle()
    curves["middle"] = [[0, 0.5, 0.1], [0.5, 0.5, 0.4], [1, 0.5, 0.15]]
    return batten.skin(curves, smooth=["middle"])


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

    def needs(self, module):
        try:
            return importlib.import_module(module)
        except ImportError:
            self.skipTest(f"{module} is not there")

    def test_meshio(self):
        meshio = self.needs("meshio")
        model = two_faces()
        session = batten.Session(model)
        for shown, model in ((model, model), (session, session.model())):
            mesh = shown.to_meshio()
            np.testing.assert_array_equal(mesh.points, model.points)
            np.testing.assert_array_equal(mesh.cells_dict["triangle"], model.triangles)
            for i, name in enumerate(model.faces):
                np.testing.assert_array_equal(mesh.cell_sets[name][0], np.flatnonzero(model.triangle_faces == i))
            np.testing.assert_array_equal(mesh.point_data["K1"], model.curvatures[:, 0])
        model.to_meshio().write(self.file("model.vtu"))
        read = meshio.read(self.file("model.vtu"))
        np.testing.assert_array_equal(read.points, model.points)
        np.testing.assert_array_equal(read.cell_data["Face"][0], model.triangle_faces)
        np.testing.assert_array_equal(read.point_data["Normals"], model.normals)
        flat = batten.Mesh(*grid(4))
        flat.to_meshio().write(self.file("grid.off"))
        self.assertEqual(len(batten.read_mesh(self.file("grid.off")).points), 25)

    def test_meshio_gets_quads_polygons_and_sets(self):
        self.needs("meshio")
        points = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [0, 1, 0], [1.5, 2, 0], [3, 0.5, 0]]
        faces = [[0, 1, 4, 5], [4, 3, 6], [1, 2, 3, 4], [2, 7, 3]]
        mesh = batten.Mesh(points, faces)
        given = mesh.to_meshio()
        self.assertEqual([block.type for block in given.cells], ["triangle", "quad"])
        np.testing.assert_array_equal(given.cells_dict["quad"], [faces[0], faces[2]])
        again = batten.Mesh(given)
        self.assertEqual(sorted(again.faces), sorted(mesh.faces))
        pentagon = batten.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 2, 0], [0, 1, 0]], [[0, 1, 2, 3, 4]])
        self.assertEqual(pentagon.to_meshio().cells[0].type, "polygon")
        # The mesh of a model has a set of triangles for each face, and one of nodes for each curve.
        model = two_faces()
        welded, sets = model.mesh().to_meshio(), model.mesh().sets
        for name in model.faces:
            np.testing.assert_array_equal(welded.cell_sets[name][0], sets[name]["faces"])
        self.assertIn("middle", welded.point_sets)
        for name in welded.point_sets:
            np.testing.assert_array_equal(welded.point_sets[name], sets[name]["nodes"])

    def test_vtk(self):
        # In a separate process, to check which VTK modules it loads.
        self.needs("vtkmodules.vtkCommonDataModel")
        done = subprocess.run([sys.executable, "-c", READ_BACK, self.folder], cwd=os.path.dirname(__file__))
        self.assertEqual(done.returncode, 0)

    def test_stress(self):
        self.needs("meshio")
        model = batten.skin(saddle(), edge_length=0.2)
        stress = batten.stress(model, material="steel", thickness=0.02, supports=["left"],
                               settings='thicknesses = [{ near = "front", radius = 0.3, thickness = 0.05 }]',
                               loads=[{"pressure": 1}, {"case": "push", "force": [0, 0, 1], "point": [1, 1, 0.3]}])
        for case in ("loads", "push"):
            data = stress.to_meshio(case=case).point_data
            np.testing.assert_array_equal(data["Displacement"], stress.displacement(case=case))
            larger = np.maximum(data["Von_mises_top"], data["Von_mises_bottom"])
            np.testing.assert_array_equal(larger, stress.von_mises(case=case))
            middle = stress.at(model.points[7], case=case).von_mises_middle
            self.assertAlmostEqual(data["Von_mises_middle"][7], middle, delta=1e-4 * larger.max())
        self.assertGreater(data["Thickness"].max(), 0.045)
        self.assertAlmostEqual(data["Thickness"].min(), 0.02, places=12)
        with self.assertRaisesRegex(batten.InputError, "did you mean 'push'"):
            stress.to_meshio(case="psh")
        with self.assertRaisesRegex(batten.InputError, "side: found 'topp'.*did you mean 'top'"):
            stress.von_mises(side="topp")

    def test_messages_contain_no_control_characters(self):
        with self.assertRaisesRegex(batten.InputError, r"x\\x1B\[31m\\ny\.toml: found no such file"):
            batten.load("x\x1b[31m\ny.toml")
        model = two_faces()
        with self.assertRaisesRegex(batten.InputError, r"push\\x1B\\nforged"):
            batten.Session(model)["push\x1b\nforged"] = 1

    def test_pyvista_wraps_the_vtk_object(self):
        # Debian 12 has no PyVista: a mock that stores its argument replaces it.
        self.needs("vtkmodules.vtkCommonDataModel")
        mock = types.ModuleType("pyvista")
        mock.wrap = lambda data: ("wrapped", data)
        model = batten.skin(saddle())
        with unittest.mock.patch.dict(sys.modules, {"pyvista": mock}):
            words, data = model.to_pyvista()
        self.assertEqual((words, data.GetNumberOfCells()), ("wrapped", len(model.triangles)))

    def test_missing_packages_are_named(self):
        for package, call in {"meshio": "to_meshio", "vtk": "to_vtk", "pyvista": "to_pyvista"}.items():
            missing = {name: None for name in ("meshio", "pyvista", "vtkmodules", "vtkmodules.util.numpy_support")}
            if package == "pyvista":
                missing = {"pyvista": None}
            with unittest.mock.patch.dict(sys.modules, missing):
                with self.assertRaisesRegex(ImportError, f"pip install {package}"):
                    getattr(batten.skin(saddle()), call)()

    def test_pyvista(self):
        pyvista = self.needs("pyvista")
        stress = batten.stress(batten.skin(saddle()), material="steel", thickness=0.02, supports=["left"])
        self.assertIsInstance(stress.to_pyvista(), pyvista.PolyData)

    def test_the_import_is_lean(self):
        code = "import sys, batten; print([m for m in ('meshio', 'vtkmodules', 'pyvista', 'json') if m in sys.modules])"
        done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=True)
        self.assertNotIn("meshio", done.stdout)
        self.assertNotIn("vtkmodules", done.stdout)


if __name__ == "__main__":
    unittest.main()
