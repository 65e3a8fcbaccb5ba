#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Opens a STEP file in Gmsh, meshes its faces, prints faces, nodes and triangles.

usage: gmsh_opens_step.py FILE [ELEMENTS_PER_SIZE]
ELEMENTS_PER_SIZE: model diagonal divided by the mesh size (default 20).
Exit code 1 if the file cannot be opened, a face has no triangles, or the mesh is not connected
across the faces' edges.
"""
import math
import sys

import gmsh


def main(path, elements_per_size):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        gmsh.model.occ.importShapes(path)
        gmsh.model.occ.synchronize()
        box = gmsh.model.getBoundingBox(-1, -1)
        size = math.dist(box[:3], box[3:])
        gmsh.option.setNumber("Mesh.MeshSizeMax", size / elements_per_size)
        gmsh.model.mesh.generate(2)
        faces = gmsh.model.getEntities(2)
        nodes = len(gmsh.model.mesh.getNodes()[0])
        triangles, empty, borders = 0, 0, {}
        for dim, tag in faces:
            _, tags, connectivity = gmsh.model.mesh.getElements(dim, tag)
            found = sum(len(t) for t in tags)
            triangles += found
            empty += found == 0
            corners = connectivity[0].reshape(-1, 3) if found else []
            for a, b, c in corners:
                for side in ((a, b), (b, c), (c, a)):
                    side = tuple(sorted(side))
                    borders[side] = borders.get(side, 0) + 1
        # Only on the boundary of the shell does a mesh edge have a single triangle.
        rims = [curve for curve in gmsh.model.getEntities(1)
                if len(gmsh.model.getAdjacencies(*curve)[0]) == 1]
        rim = sum(len(t) for curve in rims for t in gmsh.model.mesh.getElements(*curve)[1])
        single = sum(count == 1 for count in borders.values())
        print(f"faces {len(faces)}  nodes {nodes}  triangles {triangles}  size {size:.6g}  "
              f"rim {rim}  edges with one triangle {single}")
        if not faces or empty or single != rim or any(n > 2 for n in borders.values()):
            print(f"failed: {empty} faces without triangles, {single} open edges, {rim} on the rim")
            return 1
        return 0
    except Exception as error:  # Gmsh throws plain exceptions
        print(f"failed: {error}")
        return 1
    finally:
        gmsh.finalize()


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) == 3 else 20))
