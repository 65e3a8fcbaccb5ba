# SPDX-License-Identifier: MPL-2.0
"""Writes scan.obj: a synthetic scan of the panel of examples/11-panel as it was built, with springback and noise.

One point per element of the deck, at its centre, moved by a twist and a bow, with normal noise of 0.2 mm. The scan has
no edges and other faces than the deck.
"""

import math
import random
from pathlib import Path

HERE = Path(__file__).parent
NOISE = 0.2  # mm


def springback(p):
    """Position after forming: bow of 6 mm, twist of 4 mm at the corners."""
    x, y, z = p
    return [x, y, z + 6 * math.sin(math.pi * x / 600) - 4 * (x / 300 - 1) * (y / 200 - 1)]


def main():
    nodes, faces = {}, []
    for line in (HERE.parent / "11-panel/panel.bdf").read_text().splitlines():
        fields = [line[i:i + 8].strip() for i in range(0, len(line), 8)]
        if fields[0] == "GRID":
            nodes[fields[1]] = [float(word) for word in fields[3:6]]
        elif fields[0] in ("CQUAD4", "CTRIA3"):
            faces.append(fields[3:7] if fields[0] == "CQUAD4" else fields[3:6])
    noise = random.Random(1)
    around = {}  # faces at each node
    points = []
    for f, face in enumerate(faces):
        corners = [nodes[n] for n in face]
        centre = [sum(c[k] for c in corners) / len(corners) for k in range(3)]
        centre = springback(centre)
        centre[2] += noise.gauss(0, NOISE)
        points.append(centre)
        for i, n in enumerate(face):
            around.setdefault(n, {})[face[(i + 1) % len(face)]] = (f, face[i - 1])
    with open(HERE / "scan.obj", "w", encoding="ascii") as out:
        out.write("# make_scan.py\n")
        for p in points:
            out.write("v %.3f %.3f %.3f\n" % tuple(p))
        for step in around.values():  # a polygon through the faces around each inner node
            first = next(iter(step))
            loop, n = [], first
            while n in step and len(loop) <= len(step):
                f, n = step[n]
                loop.append(f + 1)
                if n == first:
                    break
            if n == first and len(loop) >= 3:
                out.write("f " + " ".join(str(f) for f in loop) + "\n")


if __name__ == "__main__":
    main()
