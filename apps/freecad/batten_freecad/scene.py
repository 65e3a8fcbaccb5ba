"""Edges as a Batten scene, and what the program makes of it.

Lengths are millimetres, as in FreeCAD. Edges are written as B-splines by their poles, so that a line of the scene is the edge
to the last digit. The program is `batten` of the PATH, or what the environment variable BATTEN_PROGRAM names.
"""
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import Part


class BattenError(RuntimeError):
    """What the program refused, in its own words."""


def program():
    """The path of the program. Raises BattenError where there is none."""
    found = os.environ.get("BATTEN_PROGRAM") or shutil.which("batten")
    if not found or not os.access(found, os.X_OK):
        raise BattenError("the program 'batten' was not found: install the package batten, or set BATTEN_PROGRAM to it")
    return found


def numbers(values):
    """A list of numbers as TOML; every one reads back as it was."""
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def points(vectors):
    return "[" + ", ".join(numbers(v) for v in vectors) + "]"


def text(word):
    return json.dumps(word)


def bspline(edge):
    """The edge as a clamped B-spline curve, in the direction of the edge."""
    curve = edge.toNurbs().Edges[0].Curve
    if not isinstance(curve, Part.BSplineCurve):
        curve = curve.toBSpline()  # of a Bézier curve
    if curve.isPeriodic():
        curve.setNotPeriodic()
    if edge.Orientation == "Reversed":
        curve.reverse()
    return curve


def spline(edge):
    """The edge as a clamped B-spline of degree 1 or more: `{ poles, degree, weights, knots }`."""
    curve = bspline(edge)
    knots = [k for k, m in zip(curve.getKnots(), curve.getMultiplicities()) for _ in range(m)]
    return (f"{{ poles = {points(curve.getPoles())}, degree = {curve.Degree}, "
            f"weights = {numbers(curve.getWeights())}, knots = {numbers(knots)} }}")


def table(heading, **keys):
    """A table [[heading]] of values that are TOML already."""
    lines = [f"[[{heading}]]"] + [f"{key} = {value}" for key, value in keys.items()]
    return "\n".join(lines) + "\n"


def scene_of(edges, creases=(), smooth=(), pressure=0.0, pushes=(), edge_length=0.0, tolerance=0.0, join_tolerance=0.0):
    """The text of a scene that skins what curves bound.

    edges        {name: Part.Edge}; names without dots
    creases, smooth   names of edges where surfaces meet at an edge, or smoothly, whatever they would do by themselves
    pressure     along the normals; a pure number on surfaces scaled to size 1
    pushes       [(place, force)]: point loads; the force is a vector, its length a pure number
    edge_length  of elements, mm; 0: a twentieth of the size
    tolerance    distance within which lines meet, mm; 0: found from their gaps
    """
    parts = ['unit = "mm"\n']
    parts += [table("line", name=text(name), spline=spline(edge)) for name, edge in edges.items()]
    for kind, names in (("crease", creases), ("smooth", smooth)):
        if names:
            parts.append(table("join", lines=json.dumps(list(names)), kind=text(kind)))
    keys = (("edge_length", edge_length), ("gap_tolerance", tolerance), ("join_tolerance", join_tolerance))
    parts.append("[skin]\n" + "".join(f"{key} = {float(value)!r}\n" for key, value in keys if value > 0))
    if pressure:
        parts.append(table("load", name=text("pressure"), type=text("pressure"), value=repr(float(pressure))))
    for i, (place, force) in enumerate(pushes, 1):
        if force.Length > 0:
            parts.append(table("load", name=text(f"push {i}"), type=text("point"), at=numbers(place),
                               direction=numbers(force), value=repr(force.Length)))
    parts.append('[output]\nstep = "model.step"\n')
    return "\n".join(parts)


def call(arguments, folder):
    """Runs the program in a folder; returns what it printed. Exit code 4 (done, but a promise was missed) is no error."""
    done = subprocess.run([program(), *arguments], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        words = done.stderr.strip().replace(str(folder) + os.sep, "")
        raise BattenError(words.removeprefix("batten: ") or f"batten ended with the code {done.returncode}")
    return done.stdout


def run(scene):
    """Makes a scene: (shape, report). The shape has one face a region; the report is report.json as a dictionary."""
    with tempfile.TemporaryDirectory(prefix="batten-freecad-") as name:
        folder = Path(name)
        (folder / "scene.toml").write_text(scene, encoding="utf-8")
        call(["run", "scene.toml", "--out", "out", "--quiet"], folder)
        report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
        step = folder / "out" / "model.step"
        if not step.exists():
            raise BattenError("no surface: " + "; ".join(words_of(report)) if words_of(report) else "no surface")
        return Part.read(str(step)), report


def words_of(report):
    """What a report warns of and what it missed, one text each."""
    missed = [f"{one['promise']} {one['found']}" if isinstance(one, dict) and "promise" in one else str(one)
              for one in report.get("missed", [])]
    return [str(one) for one in report.get("warnings", [])] + missed
