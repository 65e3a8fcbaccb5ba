# SPDX-License-Identifier: MPL-2.0
"""Analyses published shell problems with the default accuracy, with 1 %, and with eight-node shells of CalculiX on the elements
of the model, and prints the errors."""

import json
import math
import os
import subprocess
import tempfile
import time

import numpy as np

import batten
import validation
from validation import analyse, arc, stress

CASES = []


def case(name, unit, reference, source, target=0.01):
    """Registers a function that takes accuracy (0: the elements of the model) and returns a value and the estimated relative error."""

    def add(function):
        CASES.append((name, unit, reference, source, target, function))
        return function

    return add


def outline(points, names=None, unit="m", **arguments):
    """A plane surface between straight lines."""
    names = names or [f"side {i + 1}" for i in range(len(points))]
    return batten.skin({name: [points[i], points[(i + 1) % len(points)]] for i, name in enumerate(names)}, unit=unit, **arguments)


def rounded(a, b=None, unit="m"):
    """An ellipse, of four arcs."""
    b = b or a
    return batten.skin({f"rim {k + 1}": arc([0, 0, 0], [a, 0, 0], [0, b, 0], 90 * k, 90 * k + 90) for k in range(4)}, unit=unit,
                       fit_tolerance=1e-6 * a)


def displacement(model, point, axis, accuracy, sign=1, **arguments):
    result = stress(model, accuracy=accuracy, **arguments)
    one = result.load_case()
    return sign * result.at(point).displacement[axis], one.max_displacement_error / one.max_displacement


STEEL = {"young": 210e9, "poisson": 0.3, "thickness": 0.01}
STEEL_D = 210e9 * 0.01 ** 3 / (12 * 0.91)
RIM = [f"rim {k + 1}" for k in range(4)]


def held(curve, *axes):
    return {"curve": curve, "type": "prescribed", "directions": [[float(k == axis) for k in range(3)] for axis in axes], "rotation": False}


def fixed_in_plane(*points):
    """Statically determinate supports in the plane at two points along x."""
    return [{"point": points[0], "directions": [[1, 0, 0], [0, 1, 0]]}, {"point": points[1], "directions": [[0, 1, 0]]}]


@case("disc, clamped, point load in the middle: deflection", "m", 1000 / (16 * math.pi * STEEL_D), "Timoshenko1959")
def clamped_disc(accuracy):
    return displacement(rounded(1), [0, 0, 0], 2, accuracy, -1, **STEEL, supports=RIM, loads=[{"point": [0, 0, 0], "force": [0, 0, -1000]}])


@case("disc, simply supported, pressure: deflection in the middle", "m", 5.3 * 1000 / (64 * 1.3 * STEEL_D), "Timoshenko1959")
def supported_disc(accuracy):
    return displacement(rounded(1), [0, 0, 0], 2, accuracy, **STEEL, loads=[{"traction": [0, 0, 1000]}],
                        supports=[held(rim, 2) for rim in RIM] + fixed_in_plane([-0.5, 0, 0], [0.5, 0, 0]))


@case("ellipse 2:1, clamped, pressure: deflection in the middle", "m", 1000 / (STEEL_D * (24 / 16 + 24 + 16 / 4)), "Timoshenko1959")
def ellipse(accuracy):
    return displacement(rounded(2, 1), [0, 0, 0], 2, accuracy, **STEEL, supports=RIM, loads=[{"traction": [0, 0, 1000]}])


@case("equilateral triangle, simply supported, pressure: deflection at the centroid", "m", 1000 / (972 * STEEL_D), "Timoshenko1959")
def triangle(accuracy):
    a = 2 / math.sqrt(3)
    model = outline([[0, 0, 0], [a, 0, 0], [a / 2, 1, 0]])
    return displacement(model, [a / 2, 1 / 3, 0], 2, accuracy, **STEEL, loads=[{"traction": [0, 0, 1000]}],
                        supports=[held(f"side {k + 1}", 2) for k in range(3)] + fixed_in_plane([0.3, 0.2, 0], [0.8, 0.2, 0]))


@case("rectangle 2:1, simply supported, pressure: deflection in the middle", "m", 0.0101287 * 1000 / STEEL_D, "Timoshenko1959")
def rectangle(accuracy):
    model = outline([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    return displacement(model, [1, 0.5, 0], 2, accuracy, **STEEL, loads=[{"traction": [0, 0, 1000]}],
                        supports=[held(f"side {k + 1}", 2) for k in range(4)] + fixed_in_plane([0.5, 0.5, 0], [1.5, 0.5, 0]))


def strip(corner, kink, accuracy):
    """Half of a strip between two planes of symmetry, simply supported at its ends. One corner or one side is off by 1e-6."""
    points = [[0, 0, 0], [0.5, kink, 0], [2, corner, 0], [2, 1, 0], [0, 1, 0]]
    names = ["s1", "s2", "e", "n", "w"]
    supports = [held("w", 0, 2), held("e", 2)] + [{"curve": name, "type": "symmetric", "normal": [0, 1, 0]} for name in ("s1", "s2", "n")]
    return displacement(outline(points, names), [1, 0.5, 0], 2, accuracy, **STEEL, supports=supports, loads=[{"traction": [0, 0, 1000]}])


STRIP = 5 * 1000 * 16 / (384 * STEEL_D)


@case("strip between planes of symmetry, one corner off by 1e-6: deflection", "m", STRIP, "Timoshenko1959")
def tilted_strip(accuracy):
    return strip(-1e-6, -2.5e-7, accuracy)


@case("the same, with a kink of 1e-8 in one side", "m", STRIP, "Timoshenko1959")
def kinked_strip(accuracy):
    return strip(0, -1e-8, accuracy)


@case("NAFEMS LE6, skew plate of 30 degrees, simply supported: deflection in the middle", "m", 1.485e-5, "NAFEMS")
def skew(accuracy):
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    points = [[0, 0, 0], [1, 0, 0], [1 + c, s, 0], [c, s, 0]]
    return displacement(outline(points), [(1 + c) / 2, s / 2, 0], 2, accuracy, -1, young=210e9, poisson=0.3, thickness=0.01,
                        loads=[{"traction": [0, 0, -700]}],
                        supports=[held(f"side {k + 1}", 2) for k in range(4)] + fixed_in_plane([0.5, 0.1, 0], [1.2, 0.1, 0]))


@case("plate with a hole, d/W = 0.1, tension: largest stress (Howland)", "MPa", 302, "Howland1930")
def hole(accuracy):
    W, L = 200, 400
    model = batten.skin({"left": [[-L / 2, -W / 2, 0], [-L / 2, W / 2, 0]], "right": [[L / 2, -W / 2, 0], [L / 2, W / 2, 0]],
                         "south": [[-L / 2, -W / 2, 0], [L / 2, -W / 2, 0]], "north": [[-L / 2, W / 2, 0], [L / 2, W / 2, 0]],
                         "hole": arc([0, 0, 0], [10, 0, 0], [0, 10, 0], 0, 360, 193)}, holes=["hole"])
    result = stress(model, young=210e3, poisson=0.3, thickness=1, accuracy=accuracy,
                    supports=[{"point": [-L / 2, -W / 2, 0]}, {"point": [-L / 2, W / 2, 0], "directions": [[1, 0, 0], [0, 0, 1]]},
                              {"point": [L / 2, W / 2, 0], "directions": [[0, 0, 1]]}],
                    loads=[{"curve": "right", "force": [100, 0, 0]}, {"curve": "left", "force": [-100, 0, 0]}])
    one = result.load_case()
    return one.max_von_mises, one.stress_spread / one.max_von_mises


@case("Cook's membrane: displacement in the middle of the tip", "m", 23.96, "Cook1974")
def cook(accuracy):
    model = outline([[0, 0, 0], [48, 44, 0], [48, 60, 0], [0, 44, 0]], ["south", "tip", "north", "root"])
    return displacement(model, [48, 52, 0], 1, accuracy, young=1, poisson=1 / 3, thickness=1,
                        supports=["root"], loads=[{"curve": "tip", "force": [0, 1 / 16, 0]}])


@case("twisted beam, t = 0.0032, force out of the plane: tip deflection", "m", 1.29439e-3, "Belytschko1985")
def twisted_beam(accuracy):
    L, b, n = 12, 1.1, 61
    s = np.linspace(0, 1, n)[:, None]
    sides = [np.hstack([L * s, h * np.cos(math.pi / 2 * s), h * np.sin(math.pi / 2 * s)]) for h in (-b / 2, b / 2)]
    model = batten.skin({"low": sides[0], "high": sides[1], "root": [sides[0][0], sides[1][0]], "tip": [sides[0][-1], sides[1][-1]]},
                        unit="m", fit_tolerance=1e-6)
    return displacement(model, [L, 0, 0], 1, accuracy, young=29e6, poisson=0.22, thickness=0.0032, supports=["root"],
                        loads=[{"curve": "tip", "force": [0, 1e-6 / b, 0]}])


def free_plate(accuracy):
    model = outline([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]], edge_length=1)
    return stress(model, young=200e9, poisson=0.3, density=8000, thickness=0.05, modes=6, supports=[], accuracy=0).frequencies


FREE = math.sqrt(200e9 * 0.05 ** 3 / (12 * 0.91) / (8000 * 0.05)) / (2 * math.pi * 100)
for number, root in enumerate((13.468, 19.596, 24.270, 34.801, 34.801, 61.093)):
    case(f"free square plate: elastic mode {number + 1}", "Hz", root * FREE, "Leissa1969")(
        lambda accuracy, number=number: (free_plate(accuracy)[6 + number], None))



@case("ring under fluid pressure: buckling factor", "", 3 * 210e9 * 0.01 ** 3 / 12 / 1000, "Timoshenko1961")
def ring(accuracy):
    return ring_factor(True)


@case("ring under pressure that keeps its direction: buckling factor", "", 4 * 210e9 * 0.01 ** 3 / 12 / 1000, "Timoshenko1961")
def dead_ring(accuracy):
    return ring_factor(False)


def ring_factor(follows):
    low, high = (arc([0, 0, z], [1, 0, 0], [0, 1, 0], 0, 90) for z in (0, 0.1))
    model = batten.skin({"low": low, "gy": [low[-1], high[-1]], "high": high[::-1], "gx": [high[0], low[0]]}, unit="m", fit_tolerance=1e-6)
    inwards = -1 if model.normals[0] @ model.points[0] > 0 else 1
    result = analyse(model, thickness=0.01, buckling=1, loads=[{"pressure": inwards * 1000}],
                           settings=f"young = 210e9\npoisson = 0\nfollower_pressure = {str(follows).lower()}",
                           supports=[{"curve": "gx", "type": "symmetric", "normal": [0, 1, 0]},
                                     {"curve": "gy", "type": "symmetric", "normal": [1, 0, 0]}, held("low", 2)])
    return result.load_case().buckling_factors[0], None


def by_calculix(value, unit):
    """The value of the last analysis by eight-node shells (S8R) of CalculiX on elements of the same size: at the place of
    Batten's maximum, in proportion. None if a deck cannot contain the problem."""
    result = validation.analyses[-1]
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "scene.toml")
        with open(scene, "w") as file:
            file.write(result.scene)
        subprocess.run([os.path.join(os.environ["BATTEN_BUILD"], "bin", "batten"), "stress", scene, "--accuracy", "0", "--out", folder,
                        "--with-ccx", "--ccx-elements", "S8R"], capture_output=True, env=dict(os.environ, BATTEN_XVFB="", DISPLAY=""))
        try:
            with open(os.path.join(folder, "report.json")) as file:
                report = json.load(file)
        except OSError:
            return None
    one = report["stress"]["cases"][0] if report["stress"]["cases"] else {}
    found = one.get("calculix", {})
    if "Hz" in unit or "factor" in unit:
        ours = [f for f in report["stress"]["frequencies"] if f] if "Hz" in unit else one["buckling_factors"]
        theirs = report["stress"].get("calculix_frequencies", []) if "Hz" in unit else found.get("buckling_factors", [])
        nearest = min(range(len(ours)), key=lambda k: abs(ours[k] - value))
        follows = any("keep their direction" in warning for warning in report["warnings"])
        return None if follows or nearest >= len(theirs) else theirs[nearest]
    if not found:
        return None
    if unit == "MPa":
        return value * found["von_mises_at_same_point"] / one["max_von_mises"]
    return value * found["displacement_at_same_point"] / one["max_displacement"]


def table():
    """Prints a table of all cases, and returns their results."""
    results = []
    print(f"{'case':86} {'reference':>10} {'default':>10} {'error':>9} {'1 %':>10} {'error':>9} {'estimate':>8} {'S8R':>9} {'seconds':>7}")
    for name, unit, reference, source, target, function in CASES:
        value, _ = function(0)
        eight_node = by_calculix(float(value), unit or name.split(": ")[-1])
        values, start = [], time.perf_counter()
        for accuracy in (0.02, 0.01):
            value, estimate = function(accuracy)
            values.append((float(value), float(value / reference - 1), None if estimate is None else float(estimate)))
        seconds = time.perf_counter() - start
        (default, default_error, _), (accurate, error, estimate) = values
        shown = "" if estimate is None else f"{100 * estimate:.2f} %"
        calculix = "" if eight_node is None else f"{100 * (eight_node / reference - 1):+.2f} %"
        print(f"{name + (', ' + unit if unit else ''):86} {reference:10.5g} {default:10.5g} {100 * default_error:+7.2f} % {accurate:10.5g} "
              f"{100 * error:+7.2f} % {shown:>8} {calculix:>9} {seconds:7.1f}", flush=True)
        results.append({"name": name, "reference": float(reference), "source": source, "default": default, "accurate": accurate,
                        "error": error, "target": target, "estimate": estimate, "calculix": eight_node, "seconds": seconds})
    return results
