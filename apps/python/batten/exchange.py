"""Converts models, meshes and sessions to objects of other packages, which are imported on demand."""

import os


def to_meshio(self):
    """The triangles as a meshio.Mesh; points n×3 in model units."""
    import meshio

    return meshio.Mesh(self.points, [("triangle", self.triangles)], point_data=_point_data(self))


def to_vtk(self):
    """The triangles as a vtkPolyData, with normals if they are known."""
    import numpy
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    points = vtkPoints()
    points.SetData(numpy_to_vtk(numpy.ascontiguousarray(self.points), deep=True))
    triangles = self.triangles
    corners = numpy.column_stack([numpy.full(len(triangles), 3), triangles]).astype(numpy.int64)
    cells = vtkCellArray()
    cells.SetCells(len(triangles), numpy_to_vtkIdTypeArray(corners.ravel(), deep=True))
    data = vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    for name, values in _point_data(self).items():
        array = numpy_to_vtk(numpy.ascontiguousarray(values), deep=True)
        array.SetName(name)
        data.GetPointData().SetNormals(array)
    return data


def to_pyvista(self):
    """The triangles as a pyvista.PolyData."""
    import numpy
    import pyvista

    triangles = self.triangles
    faces = numpy.column_stack([numpy.full(len(triangles), 3), triangles]).ravel()
    surface = pyvista.PolyData(numpy.ascontiguousarray(self.points), faces)
    for name, values in _point_data(self).items():
        surface.point_data[name] = numpy.ascontiguousarray(values)
    return surface


def _point_data(shown):
    return {"Normals": shown.normals} if hasattr(shown, "normals") else {}


def model_png(self):
    """The bytes of a PNG picture, which Jupyter displays; None without an X server."""
    if not os.environ.get("DISPLAY"):
        return None
    import tempfile

    with tempfile.TemporaryDirectory(prefix="batten_") as folder:
        file = os.path.join(folder, "model.png")
        self.picture(file, width=800, height=500, contours=12)
        with open(file, "rb") as picture:
            return picture.read()


def session_png(self):
    """The bytes of a PNG picture of the current shape."""
    return self.model()._repr_png_()
