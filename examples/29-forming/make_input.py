#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes plate.obj and plate.pc2: a plate of 240 by 160 mm with three round holes is pressed into a hat section, in 21 frames as
in the output of a forming simulation. The plate does not stretch, so the flanges are drawn in. The output folder is the first
argument; default: the current folder.

    python3 make_input.py
"""

import math
import pathlib
import struct
import sys

FRAMES = 20
BLOCK, CELLS, RINGS = 40.0, 6, 3  # the plate consists of blocks of 40 mm; cells per block side; rings around a hole
HOLES = {(0, 2): 9.0, (1, 1): 8.0, (3, 2): 12.0}  # block: radius in mm; in a flange, in a wall, in the top
ANGLE, SHARP = 62.0, 16.0  # wall angle, degrees; length of a bend, mm


def plate():
    numbers, points, faces = {}, [], []

    def node(x, y):
        key = (round(x, 4), round(y, 4))
        if key not in numbers:
            numbers[key] = len(points)
            points.append(key)
        return numbers[key]

    step = BLOCK / CELLS
    for bx in range(6):
        for by in range(4):
            x0, y0 = BLOCK * bx, BLOCK * by
            radius = HOLES.get((bx, by), 0)
            if not radius:
                for j in range(CELLS):
                    for i in range(CELLS):
                        corners = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                        faces.append([node(x0 + step * a, y0 + step * b) for a, b in corners])
                continue
            # Rings of nodes from the border of the block to the circle.
            border = [(step * i, 0.0) for i in range(CELLS)] + [(BLOCK, step * i) for i in range(CELLS)]
            border += [(BLOCK - step * i, BLOCK) for i in range(CELLS)] + [(0.0, BLOCK - step * i) for i in range(CELLS)]

            def place(k, ring):
                x, y = (c - BLOCK / 2 for c in border[k % len(border)])
                angle = 2 * math.pi * k / len(border) - 0.75 * math.pi
                w = (1 - ring / RINGS) ** 1.2
                cx, cy = radius * math.cos(angle), radius * math.sin(angle)
                return node(x0 + BLOCK / 2 + cx + w * (x - cx), y0 + BLOCK / 2 + cy + w * (y - cy))

            for ring in range(RINGS):
                for k in range(len(border)):
                    faces.append([place(k, ring), place(k + 1, ring), place(k + 1, ring + 1), place(k, ring + 1)])
    return points, faces


def ramp(t):
    t = min(1.0, max(0.0, t))
    return t * t * (3 - 2 * t)


def profile(press):
    """Maps the distance of a point from the middle of the flat plate to its position in the cross-section: (across, up).
    `press`: stroke of the punch, 0 to 1. The bends are at 32 and 78 mm."""
    angle = math.radians(ANGLE) * press
    steps, table = 1200, [(0.0, 0.0)]
    for k in range(steps):
        s = 120.0 * (k + 0.5) / steps
        slope = angle * (ramp((s - 32 + SHARP / 2) / SHARP) - ramp((s - 78 + SHARP / 2) / SHARP))
        x, z = table[-1]
        table.append((x + 120.0 / steps * math.cos(slope), z - 120.0 / steps * math.sin(slope)))
    low = table[-1][1]  # the flanges keep their height, and the middle moves up
    return lambda s: (table[round(s / 120.0 * steps)][0], table[round(s / 120.0 * steps)][1] - low)


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    points, faces = plate()
    frames = []
    for k in range(FRAMES + 1):
        hat = profile(ramp(k / FRAMES))
        frame = []
        for x, y in points:
            across, height = hat(abs(x - 120))
            frame.append((120 + math.copysign(across, x - 120), y, height))
        frames.append(frame)
    with open(folder / "plate.obj", "w") as out:
        for x, y in points:
            out.write(f"v {x + 0.0:g} {y + 0.0:g} 0\n")
        for f in faces:
            out.write("f " + " ".join(str(v + 1) for v in f) + "\n")
    with open(folder / "plate.pc2", "wb") as out:
        out.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(points), 0, 1, len(frames)))
        for frame in frames:
            for p in frame:
                out.write(struct.pack("<3f", *(round(c, 4) + 0.0 for c in p)))


main()
