#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes a crawling worm and a fish that swims on the spot, 25 frames each: worm.obj and worm.pc2 (rings of 16 quads), fish.obj
and fish.pc2 (an inflated cube). The heads face x. The output folder is the first argument; default: the current folder.

    python3 make_input.py
"""

import math
import pathlib
import struct
import sys

FRAMES = 24  # per period


def ramp(t):
    t = min(1.0, max(0.0, t))
    return t * t * (3 - 2 * t)


def worm_half(u):
    """Half width and half height of the worm at u, from 0 (head) to 1 (tail). The worm tapers towards the tail."""
    end = math.sqrt(max(0.0, 1 - (2 * u - 1) ** 8))
    thick = (0.085 - 0.035 * u) * end
    return thick, thick


def fish_half(u):
    """Half width and half height of the fish at u: a high body, a thin root of the tail, a fin."""
    end = math.sqrt(max(0.0, 1 - (2 * u - 1) ** 6))
    body = math.sin(math.pi * min(1.0, u / 0.86) ** 0.75) if u < 0.86 else 0.0
    fin = ramp((u - 0.78) / 0.16)
    width = (0.018 + 0.062 * body) * end
    height = (0.035 + 0.125 * body + 0.115 * fin) * end
    return width, height


def worm_line(u, t):
    return 0.07 * ramp(u * 3 + 0.4) * math.sin(2 * math.pi * (1.1 * u - t)), 0.0


def fish_line(u, t):
    return (0.012 + 0.10 * u * u) * math.sin(2 * math.pi * (0.7 * u - t)), 0.0


def placed(u, angle, half, line, t):
    """The surface point at u along the centre line and at `angle` around it. The cross-section rotates with the line."""
    width, height = half(u)
    y, _ = line(u, t)
    ahead, behind = line(max(0.0, u - 0.01), t)[0], line(min(1.0, u + 0.01), t)[0]
    slope = (ahead - behind) / 0.02
    length = math.hypot(1, slope)
    across = width * math.sin(angle)
    return 0.5 - u - across * slope / length, y + across / length, height * math.cos(angle)


def rings():
    """(u, angle) of all nodes of a tube with two closed ends, and its faces."""
    count, around = 25, 16
    nodes = [(0.0, 0.0)]
    for k in range(count):
        u = (1 - math.cos(math.pi * (k + 1) / (count + 1))) / 2
        u = 0.35 * u + 0.65 * (k + 1) / (count + 1)  # denser rings at the ends
        nodes += [(u, 2 * math.pi * i / around) for i in range(around)]
    nodes.append((1.0, 0.0))
    ring = lambda k, i: 1 + k * around + i % around  # noqa: E731
    faces = [[0, ring(0, i + 1), ring(0, i)] for i in range(around)]
    for k in range(count - 1):
        faces += [[ring(k, i), ring(k, i + 1), ring(k + 1, i + 1), ring(k + 1, i)] for i in range(around)]
    faces += [[len(nodes) - 1, ring(count - 1, i), ring(count - 1, i + 1)] for i in range(around)]
    return nodes, faces


def cube(cells=10):
    """(u, angle) of all nodes of a cube inflated to a ball and stretched, and its faces."""
    numbers, nodes, faces = {}, [], []

    def node(face, i, j):
        a, b = (math.tan(math.pi / 4 * (2 * c / cells - 1)) for c in (i, j))
        v = [(1, a, b), (-a, 1, b), (-1, -a, b), (a, -1, b), (-b, a, 1), (b, a, -1)][face]
        size = math.sqrt(sum(c * c for c in v))
        x, y, z = (c / size for c in v)
        key = (round(x, 6) + 0.0, round(y, 6) + 0.0, round(z, 6) + 0.0)
        if key not in numbers:
            numbers[key] = len(nodes)
            polar = math.acos(max(-1.0, min(1.0, x)))
            nodes.append(((1 - math.cos(polar)) / 2 * 0.3 + 0.7 * polar / math.pi, math.atan2(y, z)))
        return numbers[key]

    for face in range(6):
        for j in range(cells):
            for i in range(cells):
                faces.append([node(face, *c) for c in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))])
    return nodes, faces


def write(folder, name, nodes, faces, half, line):
    frames = [[placed(u, a, half, line, (k % FRAMES) / FRAMES) for u, a in nodes] for k in range(FRAMES + 1)]
    with open(folder / f"{name}.obj", "w") as out:
        for p in frames[0]:
            out.write("v " + " ".join(f"{c + 0.0:.5f}" for c in p) + "\n")
        for f in faces:
            out.write("f " + " ".join(str(v + 1) for v in f) + "\n")
    with open(folder / f"{name}.pc2", "wb") as out:
        out.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(nodes), 0, 1, len(frames)))
        for frame in frames:
            for p in frame:
                out.write(struct.pack("<3f", *(round(c, 5) + 0.0 for c in p)))


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    write(folder, "worm", *rings(), worm_half, worm_line)
    write(folder, "fish", *cube(), fish_half, fish_line)


main()
