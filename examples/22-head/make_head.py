#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes head.obj, a head of 240 mm as a closed mesh of quads. The mesh is a cube inflated to an egg, finer in front. Smooth
bumps along its normals form nose, eyes, mouth, brows and ears. The head faces -y.

    python3 make_head.py > head.obj
"""

import math

CELLS = 36  # quads per edge of the cube


def normalised(v):
    l = math.sqrt(sum(c * c for c in v))
    return tuple(c / l for c in v)


def direction(face, i, j):
    """The direction of a grid point on the unit sphere. Face 0 of the cube faces -y."""
    a = math.tan(math.pi / 4 * (2 * i / CELLS - 1))
    b = math.tan(math.pi / 4 * (2 * j / CELLS - 1))
    v = [(a, -1, b), (1, a, b), (-a, 1, b), (-1, -a, b), (a, b, 1), (a, -b, -1)][face]
    x, y, z = normalised(v)
    # Concentrates the vertices at the face: reduces the angle from -y.
    angle = math.acos(max(-1.0, min(1.0, -y)))
    less = angle - 0.46 * math.sin(angle)
    across = math.hypot(x, z)
    if across < 1e-12:
        return (0.0, math.copysign(1.0, y), 0.0)
    s = math.sin(less) / across
    return (x * s, -math.cos(less), z * s)


def bell(*t):
    return math.exp(-sum(c * c for c in t))


def cap(s):
    """A round bump, nonzero for |s| < 1."""
    return (1 - s * s) ** 1.5 if s < 1 else 0.0


def surface(d):
    x, y, z = d
    # The egg: 160 x 190 x 240 mm, narrower at the chin.
    narrow = 1 - 0.16 * max(0.0, -z) ** 1.5
    p = (80 * x * narrow, 95 * y * (1 - 0.06 * max(0.0, -z)), 120 * z)
    n = normalised((p[0] / 80**2, p[1] / 95**2, p[2] / 120**2))
    px, pz, front = p[0], p[2], y < 0
    h = 0.0
    if front:
        # The nose: a ridge that becomes higher downwards, with a round end and nostrils.
        t = (18 - pz) / 46  # 0 at its root, 1 at its tip
        if -0.5 < t < 1.6:
            grow = 5 + 17 * max(0.0, min(1.0, t)) ** 1.3
            end = bell((t - 1) / 0.16) if t > 1 else (bell((t / 0.35)) if t < 0 else 1.0)
            h += grow * end * bell(px / (6.5 + 4.5 * max(0.0, min(1.0, t))))
        for side in (-1, 1):
            h += 6 * bell((px - 12 * side) / 5, (pz + 25) / 6)
            # An eye: a ball in a hollow.
            r = math.hypot((px - 36 * side) / 21, (pz - 18) / 14)
            h += -7 * bell(r / 1.1) + 13 * cap(math.hypot((px - 36 * side) / 17, (pz - 18) / 13))
            # A brow.
            h += 4 * bell((px - 36 * side) / 19, (pz - 41 + 0.006 * (px - 36 * side) ** 2) / 7)
        # The mouth: two lips and the groove between them.
        curve = pz + 58 - 0.004 * px * px
        wide = bell((px / 27) ** 2)
        h += wide * (6 * bell((curve - 7) / 6) + 7 * bell((curve + 8) / 6.5) - 3 * bell(curve / 5))
        h += 6 * bell(px / 20, (pz + 92) / 14)  # the chin
        for side in (-1, 1):
            h += 4 * bell((px - 42 * side) / 18, (pz + 16) / 18)  # cheeks
    q = [p[k] + h * n[k] for k in range(3)]
    # The ears stand out sideways: a rim around a hollow.
    e = math.hypot((p[1] - 8) / 27, (pz - 2) / 38)
    if e < 1 and abs(x) > 0.5:
        ear = 24 * (1 - e**2.5) ** 2 - 17 * bell(e / 0.38)
        q[0] += math.copysign(ear, x)
        q[1] += 0.35 * max(0.0, ear)
    return tuple(q)


def main():
    numbers, points, faces = {}, [], []

    def vertex(face, i, j):
        d = direction(face, i, j)
        key = tuple(round(c, 6) + 0.0 for c in d)
        if key not in numbers:
            numbers[key] = len(points) + 1
            points.append(surface(d))
        return numbers[key]

    for face in range(6):
        for j in range(CELLS):
            for i in range(CELLS):
                faces.append([vertex(face, *c) for c in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))])
    print("# A head, millimetres (make_head.py).")
    for p in points:
        print("v " + " ".join(f"{c + 0.0:.2f}" for c in p))
    for f in faces:
        print("f", *f)


main()
