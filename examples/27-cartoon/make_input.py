#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes jumper.obj and jumper.pc2: the figure of example 24 jumps, in 36 frames. The output folder is the first argument;
default: the current folder.

    python3 make_input.py
"""

import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "24-stairs"))
from figure import ANKLE, figure, posed, ramp, write_cache, write_obj  # noqa: E402

FRAMES = 36
OFF, DOWN = 14, 22  # frames of take-off and landing
LOW, STRAIGHT, STANDING, JUMP = 0.58, 0.82, 0.80, 0.35  # hip heights (crouch, straight legs, standing), jump height, m


def keyed(k, keys):
    for (a, x), (b, y) in zip(keys, keys[1:]):
        if k <= b:
            return x + (y - x) * ramp((k - a) / (b - a))
    return keys[-1][1]


def hips(k):
    """Height of the hips: crouch, accelerate, fly, land, stand up again."""
    if k <= 11:
        return keyed(k, [(3, STANDING), (11, LOW)])
    if k <= OFF:
        return LOW + (STRAIGHT - LOW) * ((k - 11) / (OFF - 11)) ** 2
    if k <= DOWN:
        return STRAIGHT + air(k)
    if k <= DOWN + 3:
        return LOW + (STRAIGHT - LOW) * ((DOWN + 3 - k) / 3) ** 2
    return keyed(k, [(DOWN + 3, LOW), (33, STANDING)])


def air(k):
    s = (k - OFF) / (DOWN - OFF)
    return 4 * JUMP * s * (1 - s) if 0 < s < 1 else 0


def pose(k):
    lean = keyed(k, [(3, 0), (11, 26), (15, -4), (21, 0), (26, 24), (33, 0)])
    arm = keyed(k, [(3, 0), (10, -45), (16, 80), (20, 60), (27, -15), (33, 0)])
    elbow = keyed(k, [(3, 8), (10, 15), (16, 30), (24, 35), (33, 8)])
    # The hips move back when the trunk leans forward.
    figure_now = {"hip": (-0.005 * lean, hips(k)), "lean": lean, "nod": -0.7 * lean}
    for side in ("left", "right"):
        figure_now[side] = {"ankle": (0, ANKLE + air(k)), "foot": -30 * min(1.0, 5 * air(k)), "arm": arm, "elbow": elbow}
    return figure_now


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    points, faces = figure()
    frames = [posed(points, pose(k)) for k in range(FRAMES)]
    write_obj(folder / "jumper.obj", frames[0], faces)
    write_cache(folder / "jumper.pc2", frames)


main()
