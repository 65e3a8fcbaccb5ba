# SPDX-License-Identifier: MPL-2.0
"""Converts edges to a Batten scene, and runs the program on it.

Lengths are in millimetres, as in FreeCAD. Edges are written as B-splines with their poles, so that the curves of the scene
are exact. The program is `batten` of the PATH, or the one named by the environment variable BATTEN_PROGRAM.
"""
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import Part


class BattenError(RuntimeError):
    """An error message of the program."""


def program():
    """The path of the program. Raises BattenError if there is none."""
    found = os.environ.get("BATTEN_PROGRAM") or shutil.which("batten")
    if not found or not os.access(found, os.X_OK):
        raise BattenError("found no program 'batten': install the package batten, or set BATTEN_PROGRAM to its path")
    return found


def numbers(values):
    """A list of numbers as TOML text that reads back exactly."""
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


def scene_of(edges, creases=(), smooth=(), pressure=0.0, loads=(), edge_length=0.0, gap_tolerance=0.0, angle_tolerance=0.0,
             neighbours="", continuity="Automatic"):
    """The text of a scene with the faces that the curves bound.

    edges            {name: Part.Edge}; names without dots
    creases, smooth  names of edges whose faces meet with a crease (G0) or smoothly (G1), instead of automatically
    pressure         along the normals; dimensionless, for surfaces scaled to size 1
    loads            [(point, force)]: point loads; the force is a vector with dimensionless length
    edge_length      target edge length of the elements, mm; 0: 1/20 of the size
    gap_tolerance    largest gap between curves that is closed, mm; 0: determined from the gaps
    angle_tolerance  angle between the faces at smooth edges, degrees; 0: default
    neighbours       file of faces that the surfaces continue at common edges; "": none
    continuity       with these faces: "Automatic", "G0", "G1" or "G2"
    """
    parts = ['unit = "mm"\n']
    parts += [table("curve", name=text(name), spline=spline(edge)) for name, edge in edges.items()]
    for kind, names in (("G0", creases), ("smooth", smooth)):
        if names:
            parts.append(table("join", curves=json.dumps(list(names)), continuity=text(kind)))
    if neighbours:
        stated = {} if continuity == "Automatic" else {"continuity": text(continuity)}
        parts.append(table("neighbour", file=text(neighbours), fill="false", **stated))
    keys = (("gap_tolerance", gap_tolerance), ("angle_tolerance", angle_tolerance))
    parts.append("[skin]\n" + "".join(f"{key} = {float(value)!r}\n" for key, value in keys if value > 0))
    if edge_length > 0:
        parts.append(f"[mesh]\nedge_length = {float(edge_length)!r}\n")
    if pressure:
        parts.append(table("load", name=text("pressure"), type=text("pressure"), value=repr(float(pressure))))
    for i, (point, force) in enumerate(loads, 1):
        if force.Length > 0:
            parts.append(table("load", name=text(f"point load {i}"), type=text("point"), at=numbers(point),
                               direction=numbers(force), value=repr(force.Length)))
    parts.append('[output]\nstep = "model.step"\n' + ("step_neighbours = false\n" if neighbours else ""))
    return "\n".join(parts)


def call(arguments, folder):
    """Runs the program in a folder; returns its output. Exit code 4 (done, but a check failed) is not an error."""
    done = subprocess.run([program(), *arguments], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        message = done.stderr.strip().replace(str(folder) + os.sep, "")
        raise BattenError(message.removeprefix("batten: ") or f"batten ended with exit code {done.returncode}")
    return done.stdout


def run(scene, files=()):
    """Computes a scene: (shape, report). The shape has one face per face of the scene; the report is report.json as a dict.
    `files`: shapes that the scene reads, [(name of a BREP file, shape)]."""
    with tempfile.TemporaryDirectory(prefix="batten-freecad-") as name:
        folder = Path(name)
        (folder / "scene.toml").write_text(scene, encoding="utf-8")
        for file, shape in files:
            shape.exportBrep(str(folder / file))
        call(["run", "scene.toml", "--out", "out", "--quiet"], folder)
        report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
        step = folder / "out" / "model.step"
        if not step.exists():
            reasons = "; ".join(messages_of(report))
            raise BattenError("the scene has no surface" + (f": {reasons}" if reasons else ""))
        return Part.read(str(step)), report


def messages_of(report):
    """The warnings and failed checks of a report, as texts."""
    failed = [f"{one['check']} {one['detail']}" for one in report.get("failed_checks", [])]
    return [str(one) for one in report.get("warnings", [])] + failed
