#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes a plate with a hole as Gmsh meshes of several formats, or prints the physical groups of a file.

usage: gmsh_meshes.py write FOLDER
       gmsh_meshes.py groups FILE
"""
import sys

import gmsh


def write(folder):
    occ, mesh = gmsh.model.occ, gmsh.model.mesh
    plate = occ.cut([(2, occ.addRectangle(0, 0, 0, 100, 50))], [(2, occ.addDisk(30, 25, 0, 10, 10))])[0]
    occ.fragment(plate, [(2, occ.addRectangle(100, 0, 0, 50, 50))])
    occ.synchronize()
    surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
    circle = [tag for _, tag in gmsh.model.getEntities(1)
              if gmsh.model.getBoundingBox(1, tag)[0] > 15 and gmsh.model.getBoundingBox(1, tag)[3] < 45]
    for dimension, tags, name in ((2, surfaces, "sheet"), (2, surfaces[:1], "left"), (1, circle, "hole")):
        group = gmsh.model.addPhysicalGroup(dimension, tags)
        gmsh.model.setPhysicalName(dimension, group, name)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 12)
    mesh.generate(2)
    for order in (1, 2):
        mesh.setOrder(order)
        for version, binary in ((4.1, 0), (4.1, 1), (4.0, 0), (2.2, 0), (2.2, 1), (1, 0)):
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            gmsh.write(f"{folder}/order{order}-version{int(10 * version)}-{binary}.msh")
        gmsh.option.setNumber("Mesh.Binary", 0)
        gmsh.write(f"{folder}/order{order}.unv")


def groups(path):
    gmsh.open(path)
    for dimension, tag in gmsh.model.getPhysicalGroups():
        nodes = gmsh.model.mesh.getNodesForPhysicalGroup(dimension, tag)[0]
        print(gmsh.model.getPhysicalName(dimension, tag) or tag, dimension, *sorted(set(nodes)))


gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
{"write": write, "groups": groups}[sys.argv[1]](sys.argv[2])
gmsh.finalize()
