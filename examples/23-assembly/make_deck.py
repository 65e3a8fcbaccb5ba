#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes assembly.bdf: a plate of 240 x 120 mm with a stiffener, a bolted angle, a block underneath, a motor and a sensor.

    python3 make_deck.py > assembly.bdf
"""

import math

PITCH = 10
grids, cards, numbers = [], [], {}
element = 0


def node(part, x, y, z):
    key = (part, round(x), round(y), round(z))
    if key not in numbers:
        numbers[key] = len(grids) + 1
        grids.append([x, y, z])
    return numbers[key]


def write(name, *fields):
    """Writes a card in fields of eight columns, with a continuation line after every eight fields."""
    text = [f"{f:<8}" for f in map(str, fields)]
    lines = [text[k : k + 8] for k in range(0, len(text), 8)]
    for k, line in enumerate(lines):
        cards.append((f"{name:<8}" if k == 0 else "+       ") + "".join(line).rstrip())


def add(name, *fields):
    global element
    element += 1
    write(name, element, *fields)
    return element


def shells(part, corner, across, up, columns, rows, prop, holes=()):
    """Adds a grid of quads that starts at `corner`. Around each hole, eight nodes are moved onto a circle of radius 7."""

    def at(i, j):
        return node(part, *(corner[k] + PITCH * (i * across[k] + j * up[k]) for k in range(3)))

    for j in range(rows):
        for i in range(columns):
            if all(not (h[0] - 1 <= i <= h[0] and h[1] - 1 <= j <= h[1]) for h in holes):
                add("CQUAD4", prop, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))
    rings = []
    for hi, hj in holes:
        middle = [corner[k] + PITCH * (hi * across[k] + hj * up[k]) for k in range(3)]
        ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
        ids = [at(hi + i, hj + j) for i, j in ring]
        for number, (i, j) in zip(ids, ring):
            for k in range(3):
                grids[number - 1][k] = middle[k] + 7 / math.hypot(i, j) * (i * across[k] + j * up[k])
        rings.append((middle, ids))
    return rings


def spider(place, ring):
    centre = node("centre", *place)
    add("RBE2", centre, 123456, *ring)
    return centre


def main():
    east, north, up = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    plate = shells("plate", (0, 0, 0), east, north, 24, 12, 1, holes=[(6, 3), (10, 3), (18, 3)])
    shells("plate", (0, 60, 0), east, up, 24, 3, 2)  # the stiffener shares the plate's nodes
    angle = shells("angle", (40, 10, 5), east, north, 8, 4, 3, holes=[(2, 2), (6, 2)])
    shells("angle", (120, 10, 5), (-1, 0, 0), up, 8, 4, 3)
    for below, above in zip(plate, angle):  # bolts
        add("CBAR", 5, spider(below[0], below[1]), spider(above[0], above[1]), "0.", "1.", "0.")
    add("CBUSH", 6, node("plate", 80, 40, 0), node("angle", 80, 40, 5), "1.", "0.", "0.")
    for k in range(3):  # the block
        for j in range(4):
            for i in range(6):
                x, y, z = 150 + PITCH * i, 70 + PITCH * j, -30 + PITCH * k
                corners = []
                for h in (0, PITCH):
                    for a, b in ((0, 0), (PITCH, 0), (PITCH, PITCH), (0, PITCH)):
                        corners.append(node("plate" if z + h == 0 else "block", x + a, y + b, z + h))
                add("CHEXA", 4, *corners)
    (x, y, z), ring = plate[2]
    motor = spider((x, y, z + 25), ring)
    add("CONM2", motor, 0, "0.35")
    sensor = node("sensor", 30, 90, 15)
    around = [node("plate", 30 + a, 90 + b, 0) for a, b in ((-10, -10), (10, -10), (10, 10), (-10, 10))]
    add("RBE3", "", sensor, 123456, "1.", 123, *around)

    print("$ A plate with a stiffener, an angle bolted on, a block under it, a motor, a sensor (make_deck.py)")
    print("SOL 103\nCEND\nBEGIN BULK")
    for k, place in enumerate(grids):
        print("GRID    " + f"{k + 1:<8}{'':8}" + "".join(f"{c + 0.0:<8.4f}" for c in place).rstrip())
    print("\n".join(cards))
    cards.clear()
    for prop, thickness in ((1, "2."), (2, "2."), (3, "3.")):
        write("PSHELL", prop, 1, thickness, 1)
    write("PSOLID", 4, 1)
    write("PBAR", 5, 1, "50.", "200.", "200.", "400.")
    write("PBUSH", 6, "K", "1.+4", "1.+4", "1.+4")
    write("MAT1", 1, "210000.", "", "0.3", "7.85-9")
    print("\n".join(cards))
    print("ENDDATA")


main()
