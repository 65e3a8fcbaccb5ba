#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes banner.obj and banner.pc2: a cloth of 1.6 by 0.9 m that hangs from its two upper corners in a light wind, in 25
frames. The figure that carries it is in ../24-stairs/walker.pc2. The output folder is the first argument; default: the
current folder.

    python3 make_input.py
"""

import math
import pathlib
import struct
import sys

FRAMES, ALONG, DOWN = 24, 33, 19
WIDE, HIGH = 1.6, 0.9


def place(i, j, k):
    u, v = i / (ALONG - 1), j / (DOWN - 1)  # v: 0 at the upper edge, 1 at the lower edge
    t = 2 * math.pi * k / FRAMES
    sag = 4 * u * (1 - u)  # sag of the upper edge between the corners
    loose = 1 - (1 - v) ** 2 * (1 - sag)  # freedom to move: 0 at the fixed corners
    wind = 0.07 * loose * math.sin(2 * math.pi * (1.2 * u + 0.5 * v) - t) + 0.05 * v * math.cos(t)
    belly = 0.10 * loose * sag * (1 - v)
    return wind * min(1.0, 1.6 * (v + 0.35 * sag)) + belly, WIDE * (u - 0.5), -HIGH * v - 0.06 * sag * (1 - 0.4 * v)


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    frames = [[place(i, j, k % FRAMES) for j in range(DOWN) for i in range(ALONG)] for k in range(FRAMES + 1)]
    with open(folder / "banner.obj", "w") as out:
        for p in frames[0]:
            out.write("v " + " ".join(f"{c + 0.0:.5f}" for c in p) + "\n")
        for j in range(DOWN - 1):
            for i in range(ALONG - 1):
                a = j * ALONG + i + 1
                out.write(f"f {a} {a + ALONG} {a + ALONG + 1} {a + 1}\n")
    with open(folder / "banner.pc2", "wb") as out:
        out.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(frames[0]), 0, 1, len(frames)))
        for frame in frames:
            for p in frame:
                out.write(struct.pack("<3f", *(round(c, 5) + 0.0 for c in p)))


main()
