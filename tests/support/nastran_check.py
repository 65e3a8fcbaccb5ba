#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Compares a Nastran deck with its edited copy, independently of the program that edited it.

usage: nastran_check.py BEFORE AFTER

Reads bulk data in small, large and free field format, CORD2R, CORD2C and CORD2S systems, GRID and
RBE2. INCLUDE is not followed. Prints JSON:
  nodes     number of GRID cards
  moved     number of those whose global position changed
  largest   largest displacement
  other     the first line that differs in anything but coordinates of a GRID, the orientation
            vector of a bar and the points of a system; "" if none
  spiders   number of RBE2
  bent      largest distance of a node of an RBE2 from its position after the best-fit rigid motion
"""
import json
import math
import re
import sys

import numpy as np


def number(field):
    """A real in Nastran's notation: 1.5, 1.5-3, 1.5D-3; a blank is 0."""
    field = field.upper().replace("D", "E")
    short = re.fullmatch(r"([+-]?[\d.]+)([+-]\d+)", field)
    return float(short[1] + "E" + short[2] if short else field or 0)


def fields(line):
    """Name and data fields of one line: four in large field format, else eight."""
    line = line.split("$")[0].rstrip().expandtabs(8)
    if "," in line:
        name, *data = line.split(",")
        count = 4 if "*" in name else 8
    else:
        wide = "*" in line[:8]
        count, width = (4, 16) if wide else (8, 8)
        name, data = line[:8], [line[8 + width * i:8 + width * (i + 1)] for i in range(count)]
    data = [x.strip() for x in data[:count]]
    return name.strip(), data + [""] * (count - len(data))


class Deck:
    def __init__(self, path):
        with open(path, encoding="latin-1", newline="") as file:
            lines = file.readlines()
        starts = [i for i, line in enumerate(lines) if re.match(r"(?i)\s*BEGIN\s+BULK", line)]
        first = starts[0] + 1 if starts else 0
        cards = []  # (name, fields, lines); text that is not a card has no name
        for i, line in enumerate(lines):
            name, data = fields(line)
            if i < first or not line.split("$")[0].strip():
                cards.append(("", [], [line]))
            elif name == "" or name[0] in "+*":
                card = next(c for c in reversed(cards) if c[0])
                card[1].extend(data)
                card[2].append(line)
            else:
                cards.append((name.rstrip("*").upper(), data, [line]))

        self.systems, self.nodes, self.spiders, self.text = {}, {}, [], []
        for name, data, own in cards:
            if name == "GRID":
                data = (data + [""] * 8)[:8]
                self.nodes[int(data[0])] = (data[1], [number(x) for x in data[2:5]])
                # Content that an editor must not change: everything but the coordinates, with line
                # endings.
                ending = own[0][len(own[0].rstrip("\r\n")):]
                self.text.append(" ".join(["GRID", *data[:2], *data[5:]]) + ending)
            elif name in ("CORD2R", "CORD2C", "CORD2S"):  # its points may move with the mesh
                self.text.append(" ".join([name, *data[:2]]))
            else:
                self.text += own
            if name in ("CORD2R", "CORD2C", "CORD2S"):
                points = [[number(x) for x in data[2 + 3 * k:5 + 3 * k]] for k in range(3)]
                self.systems[data[0]] = (name[-1], data[1], points)
            elif name == "RBE2":
                self.spiders.append([int(x) for x in [data[1]] + data[3:] if x.isdigit()])
        self.places = {label: self.place(*node) for label, node in self.nodes.items()}

    def place(self, system, x):
        """Global coordinates of a point x of a system."""
        if system in ("", "0"):
            return np.array(x, float)
        kind, parent, points = self.systems[system]
        origin, on_z, on_xz = (self.place(parent, p) for p in points)
        z = (on_z - origin) / np.linalg.norm(on_z - origin)
        y = np.cross(z, on_xz - origin)
        y /= np.linalg.norm(y)
        if kind == "C":
            r, angle = x[0], math.radians(x[1])
            x = [r * math.cos(angle), r * math.sin(angle), x[2]]
        elif kind == "S":
            r, polar, angle = x[0], math.radians(x[1]), math.radians(x[2])
            x = [r * math.sin(polar) * math.cos(angle), r * math.sin(polar) * math.sin(angle),
                 r * math.cos(polar)]
        return origin + x[0] * np.cross(y, z) + x[1] * y + x[2] * z


def bent(before, after):
    """Largest distance between the points after and the rigidly moved points before (Kabsch)."""
    a, b = before - before.mean(0), after - after.mean(0)
    u, _, v = np.linalg.svd(b.T @ a)
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v
    return float(np.linalg.norm(b - a @ turn.T, axis=1).max())


def without_vector(line):
    """A card of a bar, in columns, without its orientation vector."""
    bar = re.match(r"(CBAR|CBEAM|CBUSH) ", line)
    return line[:40] + line[64:].rstrip() if bar else line


def main(before, after):
    a, b = Deck(before), Deck(after)
    other = next((y for x, y in zip(a.text + [""], b.text + [""])
                  if x != y and without_vector(x) != without_vector(y)), "")
    if len(a.text) != len(b.text):
        other = other or f"{len(a.text)} and {len(b.text)} cards and lines"
    moves = [float(np.linalg.norm(b.places[n] - p)) for n, p in a.places.items() if n in b.places]
    shapes = [[np.array([d.places[n] for n in spider]) for d in (a, b)] for spider in a.spiders]
    print(json.dumps({
        "nodes": len(a.nodes), "moved": sum(m > 0 for m in moves), "largest": max(moves),
        "other": other, "spiders": len(shapes), "bent": max((bent(*s) for s in shapes), default=0)}))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
