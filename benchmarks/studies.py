# SPDX-License-Identifier: MPL-2.0
"""Design studies of a deck of 14,577 nodes with 24 holes that stay rigid: a design of 100 variants, derivatives, and a fit
to a scan. The last line is one JSON object with the promises."""

import csv
import json
import math
import os
import tempfile
import time

import numpy as np

import batten

HOLE, CELL, AROUND, RINGS = 25, 100, 80, 7
NOISE = 0.2


def height(x, y):
    return 20 * np.sin(x / 200) * np.sin(y / 150)


def styled(x, y):
    """The surface that was scanned: bent and twisted by up to 12 mm."""
    return height(x, y) + 8 * np.sin(x / 190) * np.cos(y / 130) + 4 * np.sin((x + y) / 240)


def square(i):
    """Point i of AROUND on the border of the square [-1, 1]², from (1, 0) on."""
    s = 8 * i / AROUND
    for start, point in ((7, (1, s - 8)), (5, (s - 6, -1)), (3, (-1, 4 - s)), (1, (2 - s, 1)), (0, (1, s))):
        if s >= start:
            return np.array(point, float)


def plate():
    """Nodes and quads of 6 × 4 cells, each with a hole in its middle."""
    numbers, points, quads = {}, [], []
    angles = 2 * math.pi * np.arange(AROUND) / AROUND
    circle = HOLE * np.c_[np.cos(angles), np.sin(angles)]
    border = np.array([square(i) for i in range(AROUND)]) * CELL / 2
    for column in range(6):
        for row in range(4):
            centre = np.array([column + 0.5, row + 0.5]) * CELL
            rings = []
            for k in range(RINGS + 1):
                ring = []
                for x, y in centre + (1 - k / RINGS) * circle + k / RINGS * border:
                    key = round(x * 1e6), round(y * 1e6)
                    if key not in numbers:
                        numbers[key] = len(points) + 1
                        points.append((x, y, float(height(x, y))))
                    ring.append(numbers[key])
                rings.append(ring)
            for inner, outer in zip(rings, rings[1:]):
                for i in range(AROUND):
                    j = (i + 1) % AROUND
                    quads.append((inner[i], outer[i], outer[j], inner[j]))
    return np.array(points), quads


def write_deck(path, points, quads):
    with open(path, "w") as deck:
        deck.write("CEND\nBEGIN BULK\n")
        for number, (x, y, z) in enumerate(points, 1):
            deck.write(f"GRID*   {number:<16d}{0:<16d}{x:<16.9f}{y:<16.9f}\n*       {z:<16.9f}\n")
        for number, quad in enumerate(quads, 1):
            deck.write(f"CQUAD4  {number:<8d}{1:<8d}" + "".join(f"{node:<8d}" for node in quad) + "\n")
        deck.write("ENDDATA\n")


def write_scan(path):
    """A grid of triangles with Gaussian noise across the surface, larger than the plate."""
    random = np.random.default_rng(1)
    x, y = np.meshgrid(np.linspace(-10, 610, 311), np.linspace(-10, 410, 136))
    z = styled(x, y) + random.normal(0, NOISE, x.shape)
    with open(path, "w") as scan:
        for point in zip(x.ravel(), y.ravel(), z.ravel()):
            scan.write("v {:.6f} {:.6f} {:.6f}\n".format(*point))
        columns = x.shape[1]
        for i in range(x.shape[0] - 1):
            for j in range(columns - 1):
                a = i * columns + j + 1
                scan.write(f"f {a} {a + 1} {a + columns + 1}\nf {a} {a + columns + 1} {a + columns}\n")


HEAD = 'unit = "mm"\nmesh = "plate.bdf"\n[[features]]\nof = "hole-*"\n[output]\nlarge_field = true\n'
EDIT = """
[[select]]
name = "left"
box = [[-1, -1, -99], [1, 401, 99]]
grow = 1
[[select]]
name = "right"
box = [[599, -1, -99], [601, 401, 99]]
grow = 1
[[dimension]]
name = "length"
type = "distance"
of = ["left", "right"]
[[edit]]
name = "move"
fixed = "left"
[[edit.handle]]
name = "right"
translate = [20, 0, 30]
rotate = { axis = [0, 1, 0], angle = 5 }
"""


def timed(work):
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def largest_distortion(before, after):
    """Largest distance of a hole from its original after the best-fitting rigid motion, over its radius."""
    worst = 0
    for column in range(6):
        for row in range(4):
            centre = np.array([column + 0.5, row + 0.5]) * CELL
            ids = np.abs(np.linalg.norm(before[:, :2] - centre, axis=1) - HOLE) < 1e-6
            a, b = before[ids] - before[ids].mean(0), after[ids] - after[ids].mean(0)
            u, _, v = np.linalg.svd(a.T @ b)
            rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v
            worst = max(worst, np.abs(a @ rotation - b).max() / HOLE)
    return worst


def main():
    promises = []

    def promise(name, value, target):
        promises.append({"name": name, "value": value, "target": target, "ok": bool(value <= target)})
        print(f"{name:58} {value:<12.4g} at most {target:g}")

    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        points, quads = plate()
        write_deck("plate.bdf", points, quads)
        write_scan("scan.obj")
        for name, text in (("move.toml", HEAD + EDIT), ("scan.toml", HEAD + '[[target]]\nfile = "scan.obj"\n')):
            with open(name, "w") as scene:
                scene.write(text)
        print(f"{len(points)} nodes, {len(quads)} quads, 24 holes, {os.cpu_count()} processors")

        ranges = {"move.right.x": (0, 40), "move.right.z": (0, 60), "move.right.angle": (-10, 10)}
        report, seconds = timed(lambda: batten.deform("move.toml", "variants", doe="lhs:100", ranges=ranges))
        with open("variants/variants.csv") as table:
            good = sum(row["status"] == "ok" for row in csv.DictReader(table))
        promise("100 variants with their table, seconds", seconds, 20)
        promise("variants that are not in the table as ok", 100 - good, 0)

        report, seconds = timed(lambda: batten.deform("move.toml", "derivatives", derivatives=["d.npz"]))
        found = report["derivatives"]
        promise("derivatives: largest error, estimated", found["largest_error"], 1e-7)
        print(f"    {len(found['parameters'])} parameters in {seconds:.1f} s")

        report, seconds = timed(lambda: batten.deform("scan.toml", "fit"))
        mesh = batten.read_mesh("fit/plate-deformed.bdf")
        fitted = np.array(mesh.points)
        error = np.sqrt(np.mean((fitted[:, 2] - styled(fitted[:, 0], fitted[:, 1])) ** 2))
        promise("scan with noise of 0.2 mm: RMS to the scan over the noise", report["targets"][0]["rms"] / NOISE, 1.2)
        promise("holes: largest distortion over the radius", largest_distortion(points, fitted), 1e-9)
        print(f"    RMS to the surface without noise {error:.3f} mm, worst Jacobian "
              f"{report['quality']['before']['jacobian']['worst']:.4f} -> "
              f"{report['quality']['after']['jacobian']['worst']:.4f}, {seconds:.1f} s")
        promise("scan: edits, seconds", report["timings_s"]["edits"], 1)
        os.chdir("/")
    print(json.dumps({"bench": "studies", "promises": promises}))


if __name__ == "__main__":
    main()
