# SPDX-License-Identifier: MPL-2.0
"""Converts models, sessions, meshes and stresses to objects of other packages, which are imported on demand.

The arrays have the names of the VTK files of Batten (docs/python.md).
"""

import importlib
from types import SimpleNamespace

from ._batten import Mesh, Session


def to_meshio(self):
    """The faces as a meshio.Mesh: triangles, quads, polygons; points n×3 in model units.

    A model or session has the point data Normals, K1, K2, Mean_curvature and Gauss_curvature, the cell data
    Face (index into `faces`), and a cell set for each face. A mesh has its sets as point sets and cell sets.
    Raises ImportError without meshio.

    >>> model.to_meshio().cells_dict["triangle"].shape == model.triangles.shape
    True
    """
    return _meshio(_content(self))


def to_vtk(self):
    """The faces as a vtkPolyData, with the point data and cell data of to_meshio().

    The names of the faces are the field data Face_names. The sets of a mesh are point and cell arrays of
    0 and 1. Raises ImportError without VTK.

    >>> model.to_vtk().GetNumberOfCells() == len(model.triangles)
    True
    """
    return _vtk(_content(self))


def to_pyvista(self):
    """The faces as a pyvista.PolyData, with the arrays of to_vtk(). Raises ImportError without PyVista.

    >>> model.to_pyvista().plot(scalars="Mean_curvature")  # doctest: +SKIP
    """
    return _pyvista(_content(self))


def stress_to_meshio(self, *, case=""):
    """The model as a meshio.Mesh, with the results of a load case; default: the governing one.

    In addition to the arrays of Model.to_meshio(): Displacement (n×3), Von_mises_top, Von_mises_middle,
    Von_mises_bottom and Thickness. Raises InputError for an unknown case, ImportError without meshio.

    >>> stress.to_meshio().point_data["Displacement"].shape == model.points.shape
    True
    """
    return _meshio(_stress_content(self, case))


def stress_to_vtk(self, *, case=""):
    """The model as a vtkPolyData, with the arrays of to_meshio(). Raises InputError, ImportError.

    >>> stress.to_vtk().GetPointData().HasArray("Von_mises_top")
    1
    """
    return _vtk(_stress_content(self, case))


def stress_to_pyvista(self, *, case=""):
    """The model as a pyvista.PolyData, with the arrays of to_meshio(). Raises InputError, ImportError.

    >>> stress.to_pyvista().warp_by_vector("Displacement", factor=100).plot()  # doctest: +SKIP
    """
    return _pyvista(_stress_content(self, case))


def add_to(classes):
    """Adds the conversions to the classes of the package."""
    for name, of_shape, of_stress in (("to_meshio", to_meshio, stress_to_meshio), ("to_vtk", to_vtk, stress_to_vtk),
                                      ("to_pyvista", to_pyvista, stress_to_pyvista)):
        of_stress.__name__ = of_stress.__qualname__ = name
        for one in classes:
            setattr(one, name, of_stress if one.__name__ == "Stress" else of_shape)


def _content(shown):
    return _mesh_content(shown) if isinstance(shown, Mesh) else _model_content(shown)


def _model_content(model):
    import numpy

    if isinstance(model, Session):
        model = model.model()
    k1, k2 = model.curvatures.T
    return SimpleNamespace(
        points=model.points, sizes=numpy.full(len(model.triangles), 3), nodes=model.triangles.ravel(),
        point_data={"Normals": model.normals, "K1": k1, "K2": k2, "Mean_curvature": (k1 + k2) / 2,
                    "Gauss_curvature": k1 * k2},
        cell_data={"Face": model.triangle_faces}, names={"Face_names": model.faces}, point_sets={},
        cell_sets={name: numpy.flatnonzero(model.triangle_faces == i) for i, name in enumerate(model.faces)})


def _stress_content(stress, case):
    content = _model_content(stress.model)
    content.point_data["Displacement"] = stress.displacement(case=case)
    for side in ("top", "middle", "bottom"):
        content.point_data["Von_mises_" + side] = stress.von_mises(case=case, side=side)
    content.point_data["Thickness"] = stress.thickness
    return content


def _mesh_content(mesh):
    import numpy

    def as_array(members, count):
        array = numpy.zeros(count, numpy.int8)
        array[members] = 1
        return array

    faces = mesh.faces
    content = SimpleNamespace(
        points=mesh.points, sizes=numpy.array([len(face) for face in faces]), nodes=numpy.concatenate(faces),
        names={}, point_sets={name: s["nodes"] for name, s in mesh.sets.items() if len(s["nodes"])},
        cell_sets={name: s["faces"] for name, s in mesh.sets.items() if len(s["faces"])})
    content.point_data = {name: as_array(nodes, len(mesh.points)) for name, nodes in content.point_sets.items()}
    content.cell_data = {name: as_array(cells, len(faces)) for name, cells in content.cell_sets.items()}
    return content


def _meshio(content):
    import numpy

    meshio = _imported("meshio", "python3-meshio")
    first = numpy.concatenate([[0], numpy.cumsum(content.sizes)[:-1]])
    cells, numbers = [], []
    for size in numpy.unique(content.sizes):
        of_size = numpy.flatnonzero(content.sizes == size)
        numbers.append(of_size)
        cells.append(({3: "triangle", 4: "quad"}.get(size, "polygon"),
                      content.nodes[first[of_size][:, None] + numpy.arange(size)]))
    sets = {name: [numpy.flatnonzero(numpy.isin(block, members)) for block in numbers]
            for name, members in content.cell_sets.items()}
    return meshio.Mesh(
        content.points, cells, point_sets=content.point_sets, cell_sets=sets,
        point_data={name: values for name, values in content.point_data.items() if name not in content.point_sets},
        cell_data={name: [values[block] for block in numbers] for name, values in content.cell_data.items()
                   if name not in sets})


def _vtk(content):
    import numpy

    support = _imported("vtkmodules.util.numpy_support", "python3-vtk9")
    core = _imported("vtkmodules.vtkCommonCore", "python3-vtk9")
    model = _imported("vtkmodules.vtkCommonDataModel", "python3-vtk9")

    def array(values, name=None):
        made = support.numpy_to_vtk(numpy.ascontiguousarray(values), deep=True)
        made.SetName(name)
        return made

    points = core.vtkPoints()
    points.SetData(array(content.points))
    offsets = numpy.concatenate([[0], numpy.cumsum(content.sizes)])
    cells = model.vtkCellArray()
    cells.SetData(support.numpy_to_vtkIdTypeArray(offsets.astype(numpy.int64), deep=True),
                  support.numpy_to_vtkIdTypeArray(content.nodes.astype(numpy.int64), deep=True))
    data = model.vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    for name, values in content.point_data.items():
        data.GetPointData().AddArray(array(values, name))
    data.GetPointData().SetActiveNormals("Normals")
    for name, values in content.cell_data.items():
        data.GetCellData().AddArray(array(values, name))
    for name, texts in content.names.items():
        words = core.vtkStringArray()
        words.SetName(name)
        for text in texts:
            words.InsertNextValue(text)
        data.GetFieldData().AddArray(words)
    return data


def _pyvista(content):
    return _imported("pyvista", None).wrap(_vtk(content))


def _imported(module, debian_package):
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        package = {"vtkmodules": "vtk"}.get(module.split(".")[0], module)
        ways = [f"apt install {debian_package}"] if debian_package else []
        raise ImportError(f"found no Python package '{package}', expected it to be installed: "
                          + " or ".join([*ways, f"pip install {package}"])) from error
