# SPDX-License-Identifier: MPL-2.0
"""Compares Batten with OpenCASCADE (through FreeCAD), Gordon surfaces, RBF and FFD morphing, and CalculiX, on the same
input. Prints tables, and in its last line one JSON object. Peers that are not installed are left out."""

import itertools
import json
import math
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

import batten

try:
    sys.path += ["/usr/lib/freecad-python3/lib", "/usr/lib/freecad/Mod", "/usr/lib/freecad/Ext"]
    import FreeCAD
    import Part
    import Surface  # noqa: F401 (adds the document objects of the workbench)
except ImportError:
    FreeCAD = None
try:
    import scipy.interpolate
except ImportError:
    scipy = None

SOURCE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
results = []


def timed(function, *arguments):
    """Median of three runs, in milliseconds, and the result."""
    times = []
    for _ in range(3):
        start = time.process_time()
        result = function(*arguments)
        times.append(1000 * (time.process_time() - start))
    return sorted(times)[1], result


# --- Surfaces between curves ---

def arc(centre, x, y, start, end, count=33):
    angles = np.radians(np.linspace(start, end, count))[:, None]
    return np.asarray(centre) + np.cos(angles) * np.asarray(x, float) + np.sin(angles) * np.asarray(y, float)


def line(start, end, count=17):
    return np.asarray(start, float) + np.linspace(0, 1, count)[:, None] * (np.asarray(end, float) - start)


def half_cylinder():
    front, back = (arc([x, 0, 0], [0, 50, 0], [0, 0, 50], 0, 180) for x in (0, 100))
    return [front, line(front[-1], back[-1]), back[::-1], line(back[0], front[0])], lambda p: np.abs(np.hypot(p[:, 1], p[:, 2]) - 50)


def sphere_octant():
    x, y, z = 50 * np.eye(3)
    return [arc([0] * 3, a, b, 0, 90) for a, b in ((x, y), (y, z), (z, x))], lambda p: np.abs(np.linalg.norm(p, axis=1) - 50)


def quarter_torus():
    def tube(angle):
        out = np.array([math.cos(angle), math.sin(angle), 0])
        return arc(60 * out, 20 * out, [0, 0, 20], -45, 45)

    def around(height):
        radius = 60 + math.sqrt(20 ** 2 - height ** 2)
        return arc([0, 0, height], [radius, 0, 0], [0, radius, 0], 0, 90)

    first, last, low, high = tube(0), tube(math.pi / 2), around(-20 / math.sqrt(2)), around(20 / math.sqrt(2))
    return [first, high, last[::-1], low[::-1]], lambda p: np.abs(np.hypot(np.hypot(p[:, 0], p[:, 1]) - 60, p[:, 2]) - 20)


def sphere_pentagon():
    corners = [np.array([50 * math.cos(a), 50 * math.sin(a), 50]) for a in np.radians(np.arange(5) * 72)]
    radius = np.linalg.norm(corners[0])
    curves = []
    for a, b in zip(corners, corners[1:] + corners[:1]):
        between = b - a * (a @ b) / (a @ a)
        curves.append(arc([0] * 3, a, between * radius / np.linalg.norm(between), 0, math.degrees(math.acos(a @ b / radius ** 2))))
    return curves, lambda p: np.abs(np.linalg.norm(p, axis=1) - radius)


def freeform():
    def cubic(*poles):
        t = np.linspace(0, 1, 33)[:, None]
        return sum(math.comb(3, i) * t ** i * (1 - t) ** (3 - i) * np.array(pole, float) for i, pole in enumerate(poles))

    return [cubic([0, 0, 0], [30, -10, 20], [70, 10, 25], [100, 0, 0]), cubic([100, 0, 0], [110, 30, 10], [95, 60, 20], [100, 100, 10]),
            cubic([100, 100, 10], [70, 105, 30], [30, 95, -10], [0, 100, 0]), cubic([0, 100, 0], [-10, 70, 15], [5, 30, 20], [0, 0, 0])], None


def ends_at_corners(curves):
    """The curves with equal coordinates where they meet."""
    for a, b in zip(curves, curves[1:] + curves[:1]):
        a[-1] = b[0]
    return curves


def edges(curves):
    shapes = []
    for points in curves:
        curve = Part.BSplineCurve()
        curve.interpolate([FreeCAD.Vector(*p) for p in points])
        shapes.append(curve.toShape())
    return shapes


def batten_surface(curves, tolerance=0):
    model = batten.skin({f"curve {i}": c for i, c in enumerate(curves)}, **({"fit_tolerance": tolerance} if tolerance else {}))
    return model, model.points, lambda p: np.array([np.linalg.norm(model.nearest(q).position - q) for q in p])


def measured_face(face):
    surface = face.Surface
    u0, u1, v0, v1 = face.ParameterRange
    grid = ((u0 + (u1 - u0) * i / 60, v0 + (v1 - v0) * j / 60) for i, j in itertools.product(range(61), range(61)))
    points = [surface.value(u, v) for u, v in grid if face.isPartOfDomain(u, v)]

    def distance(p):
        shape = surface.toShape()
        return np.array([shape.distToShape(Part.Vertex(*q))[0] for q in p])

    return face, np.array([[p.x, p.y, p.z] for p in points]), distance


def filled(curves):
    return Part.makeFilledFace(edges(curves))


def coons(curves):
    document = FreeCAD.newDocument()
    parts = [document.addObject("Part::Feature", f"e{i}") for i in range(len(curves))]
    for part, shape in zip(parts, edges(curves)):
        part.Shape = shape
    surface = document.addObject("Surface::GeomFillSurface", "s")
    surface.BoundaryList = [(part, "Edge1") for part in parts]
    surface.FillType = "Coons"
    document.recompute()
    face = surface.Shape.Faces[0].copy()
    FreeCAD.closeDocument(document.Name)
    return face


def compare_surfaces():
    print("Surfaces from boundary curves: largest distance, divided by the size of the curves")
    print(f"{'curves':18} {'program':28} {'from the curves':>16} {'from the shape':>16} {'ms':>8}")
    for name, make in (("half cylinder", half_cylinder), ("octant of a sphere", sphere_octant), ("part of a torus", quarter_torus),
                       ("pentagon, sphere", sphere_pentagon), ("free form", freeform)):
        curves, error = make()
        curves = ends_at_corners(curves)
        size = np.linalg.norm(np.ptp(np.vstack(curves), axis=0))
        programs = [("Batten", batten_surface), ("Batten, 1e-6 of the size", lambda c: batten_surface(c, 1e-6 * size))]
        if FreeCAD:
            programs += [("OpenCASCADE filling", filled), ("OpenCASCADE Coons", coons)][:2 if len(curves) <= 4 else 1]
        for program, build in programs:
            ms, made = timed(build, [c.copy() for c in curves])
            _, points, distance = made if program.startswith("Batten") else measured_face(made)
            off_curves = max(distance(c[1:-1:3]).max() for c in curves) / size
            off_shape = error(points).max() / size if error else None
            print(f"{name:18} {program:28} {off_curves:16.1e} {'' if off_shape is None else format(off_shape, '16.1e'):>16} {ms:8.0f}")
            results.append({"name": f"{name}: {program}", "curves": off_curves, "shape": off_shape, "ms": ms})


# --- Curve networks ---

def wave(x, y):
    return 12 * np.sin(x / 25) * np.cos(y / 30)


def gordon(grid):
    """Gordon surface of the curves x = grid[i] and y = grid[j]: loft along u plus loft along v minus tensor product."""
    weights = [scipy.interpolate.CubicSpline(grid, row) for row in np.eye(len(grid))]

    def height(x, y):
        wx, wy = np.array([w(x) for w in weights]), np.array([w(y) for w in weights])
        along = sum(wx[i] * wave(grid[i], y) for i in range(len(grid)))
        across = sum(wy[j] * wave(x, grid[j]) for j in range(len(grid)))
        return along + across - np.einsum("i...,j...,ij->...", wx, wy, wave(*np.meshgrid(grid, grid, indexing="ij")))

    return height


def network_curves(grid):
    fine = np.linspace(0, 100, 61)
    along = {f"x{i}": np.c_[0 * fine + g, fine, wave(g, fine)] for i, g in enumerate(grid)}
    return along | {f"y{i}": np.c_[fine, 0 * fine + g, wave(fine, g)] for i, g in enumerate(grid)}


def compare_networks():
    print("\nSurfaces through a network of curves on z = 12 sin(x/25) cos(y/30), 100 by 100")
    print(f"{'curves':10} {'program':28} {'from the surface':>18} {'from the curves':>18} {'ms':>8}")
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(1, 99, 99), np.linspace(1, 99, 99)))
    for count in (3, 5):
        grid = np.linspace(0, 100, count)
        curves = network_curves(grid)
        ms, model = timed(lambda: batten.skin(curves))
        on_curves = np.vstack([c[5:-5:10] for c in curves.values()])
        off = np.linalg.norm([model.nearest(p).position - p for p in on_curves], axis=1).max()
        rows = [("Batten", np.abs(model.points[:, 2] - wave(*model.points[:, :2].T)).max(), off, ms)]
        if scipy:
            ms, height = timed(lambda: gordon(grid)(x, y))
            rows.append(("Gordon surface (SciPy)", np.abs(height - wave(x, y)).max(), 0.0, ms))  # on its curves by construction
        if FreeCAD:
            def fill():
                shapes = {name: edges([c])[0] for name, c in curves.items()}
                document = FreeCAD.newDocument()
                parts = {name: document.addObject("Part::Feature", name) for name in shapes}
                for name, part in parts.items():
                    part.Shape = shapes[name]
                surface = document.addObject("Surface::Filling", "s")
                last = count - 1
                surface.BoundaryEdges = [(parts[n], "Edge1") for n in ("x0", f"y{last}", f"x{last}", "y0")]
                surface.UnboundEdges = [(parts[n], "Edge1") for n in parts if n[1:] not in ("0", str(last))]
                document.recompute()
                face = surface.Shape.Faces[0].copy()
                FreeCAD.closeDocument(document.Name)
                return face

            ms, face = timed(fill)
            _, points, distance = measured_face(face)
            rows.append(("OpenCASCADE filling", np.abs(points[:, 2] - wave(*points[:, :2].T)).max(), distance(on_curves).max(), ms))
        for program, off_surface, off_curves, ms in rows:
            print(f"{f'{count} by {count}':10} {program:28} {off_surface:18.4f} {off_curves:18.1e} {ms:8.0f}")
            results.append({"name": f"network {count}: {program}", "surface": off_surface, "curves": off_curves, "ms": ms})


# --- Morphing ---

def rotated(points, axis, degrees, about):
    axis, a = np.asarray(axis, float), math.radians(degrees)
    k = np.cross(np.eye(3), axis)
    matrix = np.eye(3) + math.sin(a) * k + (1 - math.cos(a)) * (k @ k)
    return (points - about) @ matrix.T + about


def rbf(points, control, moved, kernel):
    interpolation = scipy.interpolate.RBFInterpolator(points[control], moved[control] - points[control], kernel=kernel)
    return points + interpolation(points)


def ffd(points, control, moved, degrees=(6, 4, 1)):
    """Free-form deformation: Bernstein polynomials of a box whose control points move the given nodes best."""
    low, high = points.min(0) - 1e-6, points.max(0) + 1e-6
    local = (points - low) / (high - low)
    bases = [np.array([math.comb(n, i) * local[:, k] ** i * (1 - local[:, k]) ** (n - i) for i in range(n + 1)])
             for k, n in enumerate(degrees)]
    values = np.einsum("in,jn,kn->nijk", *bases).reshape(len(points), -1)
    displacements = np.linalg.lstsq(values[control], moved[control] - points[control], rcond=1e-10)[0]
    return points + values @ displacements


def compare_morphing():
    print("\nMorphing of examples/11-panel: its right end is lifted by 40 mm and rotated by 8 degrees, its left end is fixed")
    print(f"{'method':34} {'radius, largest change':>24} {'out of round':>14} {'handles off, mm':>16} {'ms':>8}")
    mesh = batten.read_mesh(os.path.join(SOURCE, "examples/11-panel/panel.bdf"))
    points = np.array(mesh.points)
    left, right = (mesh.vertices_in([x - 13, -1, -100], [x + 13, 401, 100]) for x in (0, 600))
    holes = [hole for hole in mesh.holes() if hole.roundness < 1e-3 * hole.radius]
    about = points[right].mean(0)
    moved = points.copy()
    moved[right] = rotated(points[right], [0, -1, 0], 8, about) + [12, 0, 40]
    control = np.r_[left, right]
    move = batten.Move(translate=[12, 0, 40], axis=[0, -1, 0], angle=8)

    def morph(**settings):
        return np.array(batten.Deformer(mesh, fixed=left, handles={"end": right}, **settings).deform({"end": move}))

    methods = [("Batten, holes as features", lambda: morph(features=holes)), ("Batten, no features", morph),
               ("Batten, no features, ARAP", lambda: morph(rotation_mode="nonlinear"))]
    if scipy:
        methods += [(f"RBF, {kernel} (SciPy)", lambda kernel=kernel: rbf(points, control, moved, kernel))
                    for kernel in ("thin_plate_spline", "cubic")]
    methods.append(("FFD, 7 x 5 x 2 points (NumPy)", lambda: ffd(points, control, moved)))
    for method, run in methods:
        ms, after = timed(run)
        measures = [batten.measure_hole(after, hole.loop) for hole in holes]
        change = max(abs(m["radius"] - h.radius) / h.radius for m, h in zip(measures, holes))
        round_off = max(m["roundness"] / h.radius for m, h in zip(measures, holes))
        off = np.linalg.norm(after[control] - moved[control], axis=1).max()
        print(f"{method:34} {change:24.1e} {round_off:14.1e} {off:16.1e} {ms:8.0f}")
        results.append({"name": f"morph: {method}", "radius": change, "round": round_off, "handles": off, "ms": ms})


# --- Shells ---

ROOF = """unit = "m"
name = "roof"
[[curve]]
name = "front"
arc = {{ centre = [0, 0, 0], normal = [0, -1, 0], radius = 25, angles = [50, 130] }}
[[curve]]
name = "left"
points = [[-16.069690242163484, 0, 19.151111077974452], [-16.069690242163484, 50, 19.151111077974452]]
[[curve]]
name = "back"
arc = {{ centre = [0, 50, 0], normal = [0, -1, 0], radius = 25, angles = [130, 50] }}
[[curve]]
name = "right"
points = [[16.069690242163484, 50, 19.151111077974452], [16.069690242163484, 0, 19.151111077974452]]
[mesh]
edge_length = {edge_length}
[stress]
thickness = 0.25
young = 4.32e8
poisson = 0
loads = [{{ traction = [0, 0, -90] }}]
supports = [
  {{ curve = "front", type = "prescribed", directions = [[1, 0, 0], [0, 0, 1]], rotation = false }},
  {{ curve = "back", type = "prescribed", directions = [[1, 0, 0], [0, 0, 1]], rotation = false }},
  {{ curve = "front", type = "prescribed", directions = [[0, 1, 0]], rotation = false, box = [[-0.5, -1, 24], [0.5, 1, 26]] }},
]
"""
ROOF_REFERENCE = 0.3006  # vertical displacement in the middle of the free edge [Belytschko1985]


def compare_shells(program):
    print("\nScordelis-Lo roof: vertical displacement of Batten over the reference value 0.3006, and magnitude of the largest"
          "\ndisplacement of all programs, m")
    print(f"{'edge length':>12} {'vertical':>10} {'Batten':>10} {'CalculiX S6':>12} {'CalculiX S8R':>13}")
    for edge_length in (6, 3, 1.5):
        row = {"name": f"roof {edge_length}"}
        for elements in ("S6", "S8R"):
            with tempfile.TemporaryDirectory() as folder:
                scene = os.path.join(folder, "roof.toml")
                with open(scene, "w") as file:
                    file.write(ROOF.format(edge_length=edge_length))
                done = subprocess.run([program, "stress", scene, "--accuracy", "0", "--out", folder, "--with-ccx", "--ccx-elements",
                                       elements],
                                      capture_output=True, text=True)
                if not os.path.exists(os.path.join(folder, "report.json")):
                    print(done.stderr)
                    return
                with open(os.path.join(folder, "report.json")) as file:
                    case = json.load(file)["stress"]["cases"][0]
            row["vertical"] = abs(case["displacement"][2]) / ROOF_REFERENCE
            row["Batten"] = case["max_displacement"]
            row[elements] = case.get("calculix", {}).get("max_displacement", math.nan)
        print(f"{edge_length:12} {row['vertical']:10.4f} {row['Batten']:10.4f} {row['S6']:12.4f} {row['S8R']:13.4f}")
        results.append(row)


def main():
    batten.set_threads(1)
    compare_surfaces()
    compare_networks()
    compare_morphing()
    compare_shells(os.path.join(os.environ["BATTEN_BUILD"], "bin", "batten"))
    print(json.dumps({"bench": "comparison", "promises": [], "results": results}))


if __name__ == "__main__":
    main()
