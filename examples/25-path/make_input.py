#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes hills.obj, gently uneven ground of 8 by 6 m, for the figure in ../24-stairs/walker.pc2. The output folder is the first
argument; default: the current folder.

    python3 make_input.py
"""

import math
import pathlib
import sys


def height(x, y):
    level = min(1.0, max(0.0, (x - 0.2) / 1.2))  # the walk starts on level ground
    return level * level * (3 - 2 * level) * (0.12 * math.sin(1.3 * x - 0.4) + 0.07 * math.sin(1.2 * y + 0.6))


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    across, along = 25, 33
    with open(folder / "hills.obj", "w") as out:
        for j in range(across):
            for i in range(along):
                x, y = -1 + 0.25 * i, -1.5 + 0.25 * j
                out.write(f"v {x:.3f} {y:.3f} {height(x, y) + 0.0:.4f}\n")
        for j in range(across - 1):
            for i in range(along - 1):
                a = j * along + i + 1
                out.write(f"f {a} {a + 1} {a + along + 1} {a + along}\n")


main()
