# SPDX-License-Identifier: MPL-2.0
"""Gaps and angles between faces along the edges that they share."""
import math

import FreeCAD

SAMPLES = 15  # points along an edge


def normal_at(face, point):
    """The oriented normal of a face at its point nearest to a given point, and that point."""
    u, v = face.Surface.parameter(point)
    return face.normalAt(u, v), face.Surface.value(u, v)


def rows_of(shape):
    """For every edge that two faces share: (name, largest gap between the faces in mm, largest angle between their
    normals in degrees). Free edges are omitted."""
    rows = []
    for number, edge in enumerate(shape.Edges, 1):
        faces = [f for f in shape.Faces if any(e.isSame(edge) for e in f.Edges)]
        if len(faces) != 2:
            continue
        gap = angle = 0.0
        first, last = edge.ParameterRange
        for i in range(SAMPLES):
            p = edge.valueAt(first + (last - first) * (i + 0.5) / SAMPLES)
            (n1, p1), (n2, p2) = (normal_at(face, p) for face in faces)
            gap = max(gap, (p1 - p2).Length)
            angle = max(angle, math.degrees(n1.getAngle(n2)))
        rows.append((f"Edge{number}", gap, angle))
    return rows


def print_rows(obj):
    """Prints the rows of an object's shape, in descending order of the angle, and returns them."""
    rows = sorted(rows_of(obj.Shape), key=lambda row: -row[2])
    FreeCAD.Console.PrintMessage(f"{obj.Label}: {len(rows)} edges shared by two faces\n")
    for name, gap, angle in rows:
        FreeCAD.Console.PrintMessage(f"  {name}: gap {gap:.3g} mm, angle between normals {angle:.3g}°\n")
    return rows
