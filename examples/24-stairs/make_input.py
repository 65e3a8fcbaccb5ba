#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes walker.obj and walker.pc2, a figure that walks on the spot (one cycle in 25 frames, the last equals the first), and
stairs.obj with eight steps. The output folder is the first argument; default: the current folder.

    python3 make_input.py
"""

import math
import pathlib
import sys

from figure import ANKLE, HIP, figure, posed, ramp, write_cache, write_obj

FRAMES = 24  # per cycle
STRIDE = 0.8  # m per cycle of two steps
STANDS = 0.6  # fraction of the cycle in which each foot is planted


def ankle(phase):
    """Position and rotation of an ankle. The foot touches the ground at phase 0."""
    phase %= 1
    length = STRIDE * STANDS
    if phase < STANDS:  # backwards at constant speed
        return (length / 2 - STRIDE * phase, ANKLE), 0
    t = (phase - STANDS) / (1 - STANDS)
    # The ground moves backwards. Relative to it, the foot starts and ends at rest.
    x = length / 2 - STRIDE * phase + STRIDE * ramp(t)
    return (x, ANKLE + 0.19 * math.sin(math.pi * t) ** 1.5), 12 * math.sin(2 * math.pi * t)


def pose(k):
    at = k / FRAMES + 0.05  # in frame 1 both feet are planted
    walk = {"hip": (0, HIP - 0.05 - 0.012 * math.cos(4 * math.pi * (at - 0.05))), "lean": 3, "nod": -3}
    for side, ahead in (("left", 0), ("right", 0.5)):
        place, foot = ankle(at + ahead)
        swing = math.cos(2 * math.pi * (at + ahead - 0.05))
        walk[side] = {"ankle": place, "foot": foot, "arm": -24 * swing, "elbow": 24 - 8 * swing}
    return walk


def stairs():
    """Level ground, eight steps of 0.4 m by 0.1 m, level ground. The risers lean a little, so that every height is unique."""
    profile = [(-0.6, 0.0)]
    for k in range(8):
        edge = 0.86 + 0.4 * k
        profile += [(edge - 0.005, 0.1 * k), (edge, 0.1 * (k + 1))]
    profile.append((4.8, 0.8))
    points = [(x, y, z) for x, z in profile for y in (-0.6, 0.6)]
    return points, [[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(len(profile) - 1)]


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    points, faces = figure()
    frames = [posed(points, pose(k)) for k in range(FRAMES)]
    frames.append(frames[0])
    write_obj(folder / "walker.obj", frames[0], faces)
    write_cache(folder / "walker.pc2", frames)
    write_obj(folder / "stairs.obj", *stairs())


main()
