#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Prints the nodes of a mesh file as another program reads them: lines "number x y z".

usage: mesh_positions.py gmsh|vtk FILE
"""
import os
import sys


def with_gmsh(path):
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    for tag, place in zip(tags, coordinates.reshape(-1, 3)):
        yield tag, place
    gmsh.finalize()


def with_vtk(path):
    import vtk
    extension = os.path.splitext(path)[1]
    reader = {".obj": vtk.vtkOBJReader, ".ply": vtk.vtkPLYReader, ".stl": vtk.vtkSTLReader,
              ".vtp": vtk.vtkXMLPolyDataReader,
              ".vtu": vtk.vtkXMLUnstructuredGridReader}[extension]()
    if extension == ".stl":
        reader.MergingOff()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    for i in range(data.GetNumberOfPoints()):
        yield i, data.GetPoint(i)


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] not in ("gmsh", "vtk"):
        sys.exit(__doc__)
    for number, place in (with_gmsh if sys.argv[1] == "gmsh" else with_vtk)(sys.argv[2]):
        print(number, *(repr(float(x)) for x in place))
