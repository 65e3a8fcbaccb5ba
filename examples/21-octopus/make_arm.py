#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes arm.obj, the arm of an octopus. It is 300 mm long, with a radius of 18 mm at its open root and 6 mm at its round tip.
Along its underside it has fourteen suckers: rings with a hollow.

    python3 make_arm.py > arm.obj
"""

import math

LENGTH, ROOT, TIP = 300.0, 18.0, 6.0
BELOW, ABOVE = 24, 14  # number of quads around the underside and around the back
HALF = math.radians(62)  # the underside extends by this angle to both sides of straight down
SUCKERS, FIRST, STEP, SIZE = 14, 20.0, 1.6, 0.43  # count, first position (mm), spacing and size / radius of the arm
ACROSS, BETWEEN = 10, 4  # rings of quads per sucker, and between two suckers


def radius(x):
    return ROOT + (TIP - ROOT) * x / LENGTH


def suckers():
    """Positions of the suckers along the arm, and their radii."""
    found, x = [], FIRST
    for _ in range(SUCKERS):
        found.append((x, SIZE * radius(x)))
        x += STEP * radius(x)
    return found


def smooth(t):
    t = min(1.0, max(0.0, t))
    return t * t * (3 - 2 * t)


def height(s):
    """Height of a sucker of radius 1 at the distance s from its centre: a ring around a hollow."""
    if s >= 1:
        return 0.0
    return 0.36 * math.sin(math.pi / 2 * min(1.0, (1 - s) / 0.4)) - 0.34 * smooth((0.6 - s) / 0.5)


def stations(cups):
    """Positions of the rings of vertices along the arm."""
    places = [0.0, FIRST / 4, FIRST / 2 - 1]
    for k, (x, size) in enumerate(cups):
        half = 1.08 * size
        places += [x + half * (2 * j / ACROSS - 1) for j in range(ACROSS + 1)]
        to = cups[k + 1][0] - 1.08 * cups[k + 1][1] if k + 1 < len(cups) else LENGTH
        steps = BETWEEN if k + 1 < len(cups) else round((to - x - half) / 1.8)
        places += [x + half + (to - x - half) * j / steps for j in range(1, steps)]
    return places + [LENGTH]


def main():
    cups = suckers()
    around = [-HALF + 2 * HALF * k / BELOW for k in range(BELOW)]
    around += [HALF + 2 * (math.pi - HALF) * k / ABOVE for k in range(ABOVE)]
    n = len(around)
    points, faces = [], []
    for x in stations(cups):
        r = radius(x)
        for a in around:
            out = r
            if abs(a) <= HALF:
                for centre, size in cups:
                    out += size * height(math.hypot(x - centre, r * math.sin(a)) / size)
            points.append((x, out * math.sin(a), -out * math.cos(a)))
    for step in range(1, 8):
        t = math.pi / 2 * step / 8
        for a in around:
            r = TIP * math.cos(t)
            points.append((LENGTH + TIP * math.sin(t), r * math.sin(a), -r * math.cos(a)))
    for k in range(len(points) // n - 1):
        for j in range(n):
            a, b = k * n + j, k * n + (j + 1) % n
            faces.append((a, a + n, b + n, b))
    last = len(points) - n
    points.append((LENGTH + TIP, 0.0, 0.0))
    for j in range(n):
        faces.append((last + j, len(points) - 1, last + (j + 1) % n))
    print("# The arm of an octopus, millimetres (make_arm.py).")
    for p in points:
        print("v " + " ".join(f"{c + 0.0:.2f}" for c in p))
    for f in faces:
        print("f", *(v + 1 for v in f))


main()
