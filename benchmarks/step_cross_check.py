#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Measures a STEP file of B-spline faces without a CAD library: parses and evaluates its splines.

usage: step_cross_check.py FILE.step POINTS.csv [JOINS.csv]
POINTS.csv: lines "face,x,y,z": points of the expected surface of the face of that name.
JOINS.csv:  lines "curve,x,y,z,degrees": points along edges where two surfaces are tangent, and the
angle between these surfaces.
Coordinates are in the unit of the file. Prints one JSON object:
  faces, edges     of the file
  points, distance the largest distance of a point from the spline of its face
  joins, places    curves in JOINS.csv with an edge between two faces of the file; their points
  creased          points where the surfaces themselves meet at more than 0.1 degrees, or briefly less
  degrees, worst   the largest angle between the faces' normals along the other edges; the curve's name
  above            curves with an angle above 0.1 degrees there
  beyond           the largest angle of faces minus that of surfaces, over all points
"""
import csv
import json
import re
import sys
from collections import defaultdict

import numpy as np
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

LIMIT = 0.1  # degrees: surfaces above it are not tangent
SAMPLES = 4  # per knot interval and direction: starting points of the closest-point search


# ---- the file ------------------------------------------------------------------------------------

def entities(path):
    """Number -> text of each entity."""
    text = open(path, encoding="latin-1").read()
    text = text[text.index("DATA;") + 5:]
    return {int(n): body for n, body in
            re.findall(r"#(\d+)\s*=\s*((?:[^;']|'(?:[^']|'')*')*);", text)}


def arguments(text):
    """The arguments of "NAME(...)" as nested lists of strings."""
    stack = [[]]
    for token in re.findall(r"'(?:[^']|'')*'|[(),]|[^(),'\s]+", text[text.index("("):]):
        if token == "(":
            stack.append([])
        elif token == ")":
            done = stack.pop()
            stack[-1].append(done)
            if len(stack) == 1:
                break
        elif token != ",":
            stack[-1].append(token)
    return stack[0][0]


def part(text, name):
    """The arguments of one part of a complex entity, or of the entity itself."""
    found = re.search(r"\b" + name + r"\s*(?=\()", text)
    return arguments(text[found.end():]) if found else None


def number(reference):
    return int(reference[1:])


class StepFile:
    def __init__(self, path):
        self.text = entities(path)
        self.points = {}
        for n, body in self.text.items():
            if body.startswith("CARTESIAN_POINT"):
                self.points[n] = [float(x) for x in arguments(body)[1]]
        self.faces = []
        edges = set()
        for n, body in self.text.items():
            if not body.startswith("ADVANCED_FACE"):
                continue
            name, bounds, surface, _ = arguments(body)
            rims = []
            for bound in bounds:
                loop = arguments(self.text[number(arguments(self.text[number(bound)])[1])])
                for oriented in loop[1]:
                    edge = number(arguments(self.text[number(oriented)])[3])
                    edges.add(edge)
                    line = arguments(self.text[edge])[0].strip("'")
                    rims += [(line, rim) for rim in self.rims(edge, surface)]
            self.faces.append((name.strip("'"), self.spline(number(surface))))
            self.faces[-1][1].rims = [rim for _, rim in rims]
            self.faces[-1][1].lines = rims
        self.edges = len(edges)

    def rims(self, edge, surface):
        """Polygons along an edge in the parameters of a surface; straight seams are omitted."""
        curve = self.text[number(arguments(self.text[edge])[3])]
        found = []
        for reference in arguments(curve)[2] if "SURFACE_CURVE" in curve or "SEAM_CURVE" in curve else []:
            on, flat = arguments(self.text[number(reference)])[1:3]
            if on == surface:
                line = self.flat_spline(number(arguments(self.text[number(flat)])[1][0]))
                found += [line] if line is not None else []
        return found

    def flat_spline(self, n):
        body = self.text[n]
        if "B_SPLINE_CURVE_WITH_KNOTS" not in body:
            return None
        plain = body.startswith("B_SPLINE_CURVE_WITH_KNOTS")
        knots = part(body, "B_SPLINE_CURVE_WITH_KNOTS")
        degree, poles = knots[1:3] if plain else part(body, "B_SPLINE_CURVE")[:2]
        times, values = knots[6:8] if plain else knots[:2]
        weights = part(body, "RATIONAL_B_SPLINE_CURVE")
        w = np.array([float(x) for x in weights[0]])[:, None] if weights else np.ones((len(poles), 1))
        p = np.array([self.points[number(q)] for q in poles]) * w
        all_knots = np.repeat([float(x) for x in values], [int(t) for t in times])
        spline = BSpline(all_knots, np.hstack([p, w]), int(degree))
        ends = np.unique(all_knots)
        t = np.append((ends[:-1, None] + np.arange(32) / 32 * np.diff(ends)[:, None]).ravel(), ends[-1])
        x = spline(t)
        return x[:, :2] / x[:, 2:]

    def spline(self, n):
        body = self.text[n]
        plain = body.startswith("B_SPLINE_SURFACE_WITH_KNOTS")
        if "RATIONAL" in body or "B_SPLINE_SURFACE_WITH_KNOTS" not in body:
            raise SystemExit(f"#{n}: expected a B-spline surface without weights, found {body[:40]}")
        of = part(body, "B_SPLINE_SURFACE_WITH_KNOTS" if plain else "B_SPLINE_SURFACE")
        with_knots = of[8:] if plain else part(body, "B_SPLINE_SURFACE_WITH_KNOTS")
        degrees, net = of[1:4] if plain else of[:3], None
        net, degrees = degrees[2], [int(d) for d in degrees[:2]]
        poles = np.array([[self.points[number(p)] for p in row] for row in net])
        times, values = with_knots[:2], with_knots[2:4]
        return Spline(degrees, poles, [np.repeat([float(x) for x in values[k]], [int(t) for t in times[k]])
                                       for k in (0, 1)])


# ---- splines -------------------------------------------------------------------------------------

def basis(knots, degree, span, x):
    """Values of the non-zero basis functions at x: rows of degree + 1."""
    values = np.ones((len(x), 1))
    for d in range(1, degree + 1):
        more = np.zeros((len(x), d + 1))
        for j in range(d):
            low, high = knots[span - d + 1 + j], knots[span + 1 + j]
            share = values[:, j] / (high - low)
            more[:, j] += (high - x) * share
            more[:, j + 1] += (x - low) * share
        values = more
    return values


def slopes(knots, degree, span, x, order):
    """Derivatives of these functions with respect to x."""
    if order == 0:
        return basis(knots, degree, span, x)
    lower = slopes(knots, degree - 1, span, x, order - 1)
    result = np.zeros((len(x), degree + 1))
    for j in range(degree):
        share = degree * lower[:, j] / (knots[span + 1 + j] - knots[span - degree + 1 + j])
        result[:, j] -= share
        result[:, j + 1] += share
    return result


class Spline:
    def __init__(self, degrees, poles, knots):
        self.degrees, self.poles, self.knots = degrees, poles, knots
        self.low = np.array([k[d] for k, d in zip(knots, degrees)])
        self.high = np.array([k[-d - 1] for k, d in zip(knots, degrees)])

    def derivatives(self, uv, orders):
        """x and its derivatives at parameters: orders is a list of (of u, of v)."""
        spans, result = [], []
        for k in (0, 1):
            inner = self.knots[k][self.degrees[k]:len(self.knots[k]) - self.degrees[k]]
            at = np.searchsorted(inner, uv[:, k], side="right") - 1
            last = np.searchsorted(inner, inner[-1], side="left") - 1
            spans.append(np.clip(at, 0, last) + self.degrees[k])
        rows, columns = (spans[k][:, None] - self.degrees[k] + np.arange(self.degrees[k] + 1)
                         for k in (0, 1))
        near = self.poles[rows[:, :, None], columns[:, None, :]]
        for of_u, of_v in orders:
            in_u = slopes(self.knots[0], self.degrees[0], spans[0], uv[:, 0], of_u)
            in_v = slopes(self.knots[1], self.degrees[1], spans[1], uv[:, 1], of_v)
            result.append(np.einsum("na,nb,nabc->nc", in_u, in_v, near))
        return result

    def samples(self):
        if not hasattr(self, "tree"):
            lines = []
            for k in (0, 1):
                ends = np.unique(self.knots[k])
                ends = ends[(ends >= self.low[k]) & (ends <= self.high[k])]
                shares = np.arange(SAMPLES) / SAMPLES
                inner = ends[:-1, None] + shares * np.diff(ends)[:, None]
                lines.append(np.append(inner.ravel(), ends[-1]))
            self.uv = np.clip(np.vstack(self.inside(*lines) + self.rims), self.low, self.high)
            self.tree = cKDTree(self.derivatives(self.uv, [(0, 0)])[0])
        return self.tree

    def inside(self, u, v):
        """Pairs of values of u and v inside the trim, from the boundary points of each constant u.
        (The spline beyond its boundary is not part of the face and may be close to anything.)"""
        a = np.vstack([rim[:-1] for rim in self.rims])
        b = np.vstack([rim[1:] for rim in self.rims])
        found = []
        for at in u:
            crossed = (a[:, 0] <= at) != (b[:, 0] <= at)
            p, q = a[crossed], b[crossed]
            share = (at - p[:, 0]) / (q[:, 0] - p[:, 0])
            above = np.sort(p[:, 1] + share * (q[:, 1] - p[:, 1]))
            kept = v[np.searchsorted(above, v) % 2 == 1]
            found.append(np.column_stack([np.full(len(kept), at), kept]))
        return found

    def descend(self, points, uv):
        """Damped Newton steps to the closest points, each halved until the distance decreases."""
        orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
        uv, best = uv.copy(), np.full(len(points), np.inf)
        trial, step = uv.copy(), np.zeros_like(uv)
        for _ in range(30):
            x, xu, xv, xuu, xuv, xvv = self.derivatives(trial, orders)
            miss = x - points
            far = np.linalg.norm(miss, axis=1)
            nearer = far < best
            uv[nearer], best[nearer] = trial[nearer], far[nearer]
            dot = lambda a, b: np.einsum("nc,nc->n", a, b)
            g = np.column_stack([dot(xu, miss), dot(xv, miss)])
            a, b, c = dot(xu, xu), dot(xu, xv), dot(xv, xv)
            full = a + dot(xuu, miss), b + dot(xuv, miss), c + dot(xvv, miss)
            convex = (full[0] > 0) & (full[0] * full[2] > full[1] ** 2)
            a, b, c = (np.where(convex, f, plain) for f, plain in zip(full, (a, b, c)))
            # At the border of the rectangle the search continues along it.
            for k in (0, 1):
                out = ((trial[:, k] <= self.low[k]) & (g[:, k] > 0)) | ((trial[:, k] >= self.high[k]) & (g[:, k] < 0))
                g[out, k], b[out] = 0, 0
            det = a * c - b * b + 1e-300
            newton = -np.column_stack([c * g[:, 0] - b * g[:, 1], a * g[:, 1] - b * g[:, 0]]) / det[:, None]
            step = np.where(nearer[:, None], newton, step / 4)
            trial = np.clip(uv + step, self.low, self.high)
            if np.all(np.abs(trial - uv) <= 1e-12 * (self.high - self.low)):
                break
        return uv, best

    def nearest(self, points, candidates):
        """Parameters and distances of the closest points."""
        starts = self.samples().query(points, k=candidates)[1].reshape(len(points), candidates)
        uv, best = self.descend(points, self.uv[starts[:, 0]])
        for k in range(1, candidates):
            other, far = self.descend(points, self.uv[starts[:, k]])
            nearer = far < best
            uv[nearer], best[nearer] = other[nearer], far[nearer]
        return uv, best

    def along(self, line, points):
        """Parameters on the spline's own pcurve of an edge, closest to points."""
        best, uv = np.full(len(points), np.inf), np.zeros((len(points), 2))
        for rim in (np.clip(rim, self.low, self.high) for name, rim in self.lines if name == line):
            x = self.derivatives(rim, [(0, 0)])[0]
            near = cKDTree(x).query(points)[1]
            for first in (np.maximum(near - 1, 0), np.minimum(near, len(x) - 2)):
                step = x[first + 1] - x[first]
                dot = np.einsum("nc,nc->n", points - x[first], step)
                s = np.clip(dot / (np.einsum("nc,nc->n", step, step) + 1e-300), 0, 1)[:, None]
                far = np.linalg.norm(x[first] + s * step - points, axis=1)
                nearer = far < best
                best[nearer] = far[nearer]
                uv[nearer] = (rim[first] + s * (rim[first + 1] - rim[first]))[nearer]
        return uv

    def normals(self, uv):
        xu, xv = self.derivatives(uv, [(1, 0), (0, 1)])
        return np.cross(xu, xv)


# ---- measurement
# -------------------------------------------------------------------------------------

def rows(path):
    """Name -> array of its values."""
    found = defaultdict(list)
    with open(path, newline="") as file:
        for row in csv.reader(file):
            found[row[0]].append([float(x) for x in row[1:]])
    return {name: np.array(of) for name, of in found.items()}


def measure_points(step, path):
    count, most = 0, 0.0
    for name, points in rows(path).items():
        own = [s for n, s in step.faces if n == name] or [s for _, s in step.faces if len(step.faces) == 1]
        if not own:
            raise SystemExit(f"{path}: found points of '{name}', expected the name of a face")
        far = np.min([s.nearest(points, 2)[1] for s in own], axis=0)
        # A search that started on the wrong side of a bend restarts from more points.
        again = far > 5 * np.median(far)
        far[again] = np.min([s.nearest(points[again], min(50, len(s.uv)))[1] for s in own], axis=0)
        most = max(most, far.max())
        count += len(points)
    return {"points": count, "distance": most}


def tangent_runs(smooth):
    """Without runs shorter than 1/16 of the curve: a crease that is briefly tangent."""
    kept, first = smooth.copy(), 0
    for k in np.append(np.flatnonzero(~smooth), len(smooth)):
        if k - first < len(smooth) // 16:
            kept[first:k] = False
        first = k + 1
    return kept


def measure_joins(step, path):
    found = {"joins": 0, "places": 0, "degrees": 0.0, "worst": "", "above": 0, "beyond": 0.0,
             "creased": 0}
    for line, places in rows(path).items():
        beside = [s for _, s in step.faces if any(name == line for name, _ in s.lines)]
        if len(beside) != 2:
            continue
        one, other = (s.normals(s.along(line, places[:, :3])) for s in beside)
        across = np.linalg.norm(np.cross(one, other), axis=1)
        angles = np.degrees(np.arctan2(across, np.abs(np.einsum("nc,nc->n", one, other))))
        smooth = tangent_runs(places[:, 3] <= LIMIT)
        found["joins"] += 1
        found["places"] += len(places)
        found["creased"] += int(np.sum(~smooth))
        found["beyond"] = max(found["beyond"], (angles - places[:, 3]).max())
        most = angles[smooth].max(initial=0)
        found["above"] += int(most > LIMIT)
        if most > found["degrees"]:
            found["degrees"], found["worst"] = most, line
    return found


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    step = StepFile(sys.argv[1])
    found = {"faces": len(step.faces), "edges": step.edges, **measure_points(step, sys.argv[2])}
    if len(sys.argv) == 4:
        found.update(measure_joins(step, sys.argv[3]))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
