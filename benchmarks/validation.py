# SPDX-License-Identifier: MPL-2.0
"""Analyses shells with known solutions through the Python package, and prints value, reference and error of each. The last
line is one JSON object: docs/validation.md has its numbers."""

import json
import math

import numpy as np

import batten

results = []


def record(name, values, reference):
    """Values for meshes whose elements are halved in turn; the order is that of the last two errors."""
    errors = [value / reference - 1 for value in values]
    order = math.log2(abs(errors[-2] / errors[-1])) if len(errors) > 1 and errors[-1] else None
    results.append({"name": name, "found": values, "reference": reference, "errors": errors, "order": order})
    print(f"{name:34} reference {reference:<12.6g} " + "  ".join(f"{v:.6g} ({100 * e:+.3f} %)" for v, e in zip(values, errors)))


analyses = []  # results of analyse()


def analyse(model, accuracy=0, **arguments):
    """Analyses the elements of the model, or finer ones for an accuracy."""
    analyses.append(batten.stress(model, accuracy=accuracy, **arguments))
    return analyses[-1]


def stress(model, young, poisson, density=None, **arguments):
    settings = f"young = {young}\npoisson = {poisson}\n" + (f"density = {density}\n" if density else "")
    return analyse(model, settings=settings, **arguments)


def arc(centre, x, y, start, end, count=49):
    angles = np.radians(np.linspace(start, end, count))[:, None]
    return np.asarray(centre, float) + np.cos(angles) * np.asarray(x, float) + np.sin(angles) * np.asarray(y, float)


def square(edge_length):
    return batten.skin({"front": [[0, 0, 0], [1, 0, 0]], "right": [[1, 0, 0], [1, 1, 0]], "back": [[1, 1, 0], [0, 1, 0]],
                        "left": [[0, 1, 0], [0, 0, 0]]}, edge_length=edge_length, unit="m")


EDGES = ("front", "right", "back", "left")
PLATE = {"young": 1e9, "poisson": 0.3, "density": 1000, "thickness": 0.01}
STIFFNESS = PLATE["young"] * PLATE["thickness"] ** 3 / (12 * (1 - PLATE["poisson"] ** 2))


def plates():
    for name, support, coefficient in (("clamped", "clamped", 0.00126532), ("simply supported", "pinned", 0.00406235)):
        values = []
        for h in (1 / 8, 1 / 16, 1 / 32):
            result = stress(square(h), **PLATE, supports=[{"curve": edge, "type": support} for edge in EDGES],
                                   loads=[{"pressure": 1}])
            values.append(abs(result.at([0.5, 0.5, 0]).displacement[2]))
        record(f"plate, {name}", values, coefficient / STIFFNESS)


def frequencies():
    result = stress(square(1 / 16), **PLATE, supports=[{"curve": edge, "type": "pinned"} for edge in EDGES], modes=5)
    unit = math.pi / 2 * math.sqrt(STIFFNESS / (PLATE["density"] * PLATE["thickness"]))
    for value, (m, n) in zip(result.frequencies, ((1, 1), (1, 2), (2, 1), (2, 2), (1, 3))):
        record(f"frequency {m}, {n}", [value], unit * (m * m + n * n))


def buckling():
    supports = [{"curve": edge, "type": "prescribed", "directions": [[0, 0, 1]], "rotation": False} for edge in EDGES]
    supports += [{"curve": "left", "type": "prescribed", "directions": [[1, 0, 0]], "rotation": False},
                 {"point": [0, 0, 0], "directions": [[0, 1, 0]]}]
    result = stress(square(1 / 16), **PLATE, supports=supports, loads=[{"curve": "right", "force": [-1, 0, 0]}], buckling=2)
    unit = math.pi ** 2 * STIFFNESS
    for value, factor in zip(result.report["cases"][0]["buckling_factors"], (4, 6.25)):
        record(f"buckling {factor}", [value], factor * unit)


def roof():
    R, a = 25, 40
    values = []
    for h in (6, 3, 1.5):
        front, middle = (arc([0, y, 0], [0, 0, R], [R, 0, 0], 0, a) for y in (0, 25))
        model = batten.skin({"front": front, "edge": [front[-1], middle[-1]], "middle": middle[::-1], "crown": [middle[0], front[0]]},
                            edge_length=h, fit_tolerance=1e-5, unit="m")
        result = stress(model, young=4.32e8, poisson=0, thickness=0.25, loads=[{"traction": [0, 0, -90]}], supports=[
            {"curve": "front", "type": "prescribed", "directions": [[1, 0, 0], [0, 0, 1]], "rotation": False},
            {"curve": "crown", "type": "symmetric", "normal": [1, 0, 0]}, {"curve": "middle", "type": "symmetric", "normal": [0, 1, 0]}])
        values.append(-result.at(middle[-1]).displacement[2])
    record("Scordelis-Lo roof", values, 0.30059)


def pinched_cylinder():
    values = []
    for h in (30, 15, 7.5):
        end, middle = (arc([0, y, 0], [0, 0, 300], [300, 0, 0], 0, 90) for y in (300, 0))
        model = batten.skin({"end": end, "side": [end[-1], middle[-1]], "middle": middle[::-1], "top": [middle[0], end[0]]},
                            edge_length=h, fit_tolerance=1e-4, unit="m")
        result = stress(model, young=3e6, poisson=0.3, thickness=3, supports=[
            {"curve": "end", "type": "prescribed", "directions": [[1, 0, 0], [0, 0, 1]], "rotation": False},
            {"curve": "top", "type": "symmetric", "normal": [1, 0, 0]}, {"curve": "side", "type": "symmetric", "normal": [0, 0, 1]},
            {"curve": "middle", "type": "symmetric", "normal": [0, 1, 0]}],
            loads=[{"point": [0, 0, 300], "force": [0, 0, -0.25]}])
        values.append(-result.at([0, 0, 300]).displacement[2])
    record("pinched cylinder", values, 1.8248e-5)


def hemisphere():
    R, top = 10, math.radians(72)
    values = []
    for h in (1.6, 0.8, 0.4):
        low = arc([0, 0, 0], [R, 0, 0], [0, R, 0], 0, 90)
        high = arc([0, 0, R * math.sin(top)], [R * math.cos(top), 0, 0], [0, R * math.cos(top), 0], 0, 90)
        first, last = (arc([0, 0, 0], x, [0, 0, R], 0, 72) for x in ([R, 0, 0], [0, R, 0]))
        model = batten.skin({"low": low, "last": last, "high": high[::-1], "first": first[::-1]}, edge_length=h, fit_tolerance=1e-5,
                            unit="m")
        result = stress(model, young=6.825e7, poisson=0.3, thickness=0.04, supports=[
            {"curve": "first", "type": "symmetric", "normal": [0, 1, 0]}, {"curve": "last", "type": "symmetric", "normal": [1, 0, 0]},
            {"point": [R, 0, 0], "directions": [[0, 0, 1]]}],
            loads=[{"point": [R, 0, 0], "force": [1, 0, 0]}, {"point": [0, R, 0], "force": [0, -1, 0]}])
        values.append(result.at([R, 0, 0]).displacement[0])
    record("hemisphere", values, 0.0935)


def main():
    for case in (plates, frequencies, buckling, roof, pinched_cylinder, hemisphere):
        case()
    import published_cases  # uses the functions of this file
    import section_cases  # adds its own to them

    print()
    published = published_cases.table()
    promises = [{"name": one["name"], "value": abs(one["error"]), "target": one["target"], "ok": abs(one["error"]) <= one["target"]} for one in published]
    print(json.dumps({"bench": "validation", "promises": promises, "results": results, "published": published}))


if __name__ == "__main__":
    main()
