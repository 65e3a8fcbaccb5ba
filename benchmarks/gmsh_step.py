#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Gmsh reads a STEP file, writes it again, and meshes it.

usage: gmsh_step.py IN.step OUT.step
Prints processor seconds to read and to write, faces, triangles, and the number of Gmsh's warnings.
"""
import math
import sys
import time

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("General.NumThreads", 1)
gmsh.logger.start()
start = time.process_time()
gmsh.model.occ.importShapes(sys.argv[1])
gmsh.model.occ.synchronize()
read = time.process_time()
gmsh.write(sys.argv[2])
written = time.process_time()
box = gmsh.model.getBoundingBox(-1, -1)
gmsh.option.setNumber("Mesh.MeshSizeMax", math.dist(box[:3], box[3:]) / 20)
gmsh.model.mesh.generate(2)
triangles = sum(len(t) for t in gmsh.model.mesh.getElements(2)[1])
bad = [m for m in gmsh.logger.get() if m.startswith(("Warning", "Error"))]
for message in bad:
    print(message, file=sys.stderr)
print(read - start, written - read, len(gmsh.model.getEntities(2)), triangles, len(bad))
gmsh.finalize()
