# SPDX-License-Identifier: MPL-2.0
# SciPy's smoothing splines for the benchmark `curves`.
#
#     scipy_curves.py version              prints SciPy's version
#     scipy_curves.py noise IN OUT         smooths noisy points, writes uniform samples
#     scipy_curves.py sketch IN OUT        fits strokes to a tolerance, writes counts and times
#
# Files are rows of doubles. noise: IN = number of problems, points per problem, requested samples,
# then for each problem sigma and the points; OUT = for each problem the samples of splprep, then of
# make_smoothing_spline (NaN if this SciPy has none). sketch: IN = number of strokes, then for each
# the number of points, two largest deviations, the points; OUT = for each stroke and deviation:
# spans, measured deviation, distance of the curve from the polyline, seconds.
import gc
import sys
import time

import numpy as np
import scipy
from scipy.interpolate import splev, splprep

try:
    from scipy.interpolate import make_smoothing_spline
except ImportError:
    make_smoothing_spline = None

SAMPLES_A_SPAN = 64  # as in curve_measures.h: both measure in the same way
NEWTON_STEPS = 6
LONGEST_GAP = 1 / 300
STEPS = 32  # of the bisection
REPEATS = 15


def even_samples(curve, count):
    """`count` points of curve(u), u in [0, 1], uniform in arc length."""
    u = np.linspace(0, 1, 8 * count)
    arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve(u), axis=0), axis=1))])
    return curve(np.interp(np.linspace(0, arc[-1], count), arc, u))


def noise(data):
    problems, points, samples = (int(v) for v in data[:3])
    out = []
    for row in data[3:].reshape(problems, 1 + 3 * points):
        sigma, p = row[0], row[1:].reshape(points, 3)
        # The manual's recommendation for known noise, summed over all coordinates.
        tck, _ = splprep(p.T, s=points * sigma**2 * 3)
        out.append(even_samples(lambda u: np.array(splev(u, tck)).T, samples))
        if make_smoothing_spline is None:
            out.append(np.full((samples, 3), np.nan))
            continue
        chord = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
        chord /= chord[-1]
        splines = [make_smoothing_spline(chord, p[:, c]) for c in range(3)]
        out.append(even_samples(lambda u: np.stack([f(u) for f in splines], axis=1), samples))
    return np.concatenate(out).ravel()


def samples(tck):
    """Parameters and points of a curve; gaps are subdivided until they are short."""
    knots = np.unique(tck[0])
    u = np.concatenate(
        [np.linspace(a, b, SAMPLES_A_SPAN, endpoint=False) for a, b in zip(knots, knots[1:])]
        + [knots[-1:]]
    )
    x = np.array(splev(u, tck)).T
    gap = LONGEST_GAP * np.linalg.norm(x.max(axis=0) - x.min(axis=0))
    for _ in range(3):
        parts = np.ceil(np.linalg.norm(np.diff(x, axis=0), axis=1) / gap).astype(int)
        if gap <= 0 or parts.max() <= 1:
            break
        parts = np.maximum(parts, 1)
        start = np.cumsum(parts) - parts
        k = np.arange(parts.sum()) - np.repeat(start, parts)
        step = np.repeat(np.diff(u) / parts, parts)
        u = np.append(np.repeat(u[:-1], parts) + k * step, u[-1])
        x = np.array(splev(u, tck)).T
    return u, x


def straying(tck, p):
    """Largest distance of the curve from the polyline through the points."""
    _, x = samples(tck)
    chord = np.diff(p, axis=0)
    away = x[:, None, :] - p[None, :-1, :]
    s = np.clip((away * chord).sum(axis=2) / (chord * chord).sum(axis=1), 0, 1)
    return np.sqrt(((away - s[:, :, None] * chord) ** 2).sum(axis=2).min(axis=1).max())


def deviation(tck, p):
    """Largest distance of the points from the curve: nearest sample, then Newton's method."""
    u, x = samples(tck)
    squares = ((p[:, None, :] - x[None, :, :]) ** 2).sum(axis=2)
    i = squares.argmin(axis=1)
    best = squares[np.arange(len(p)), i]
    low, high, t = u[np.maximum(i - 1, 0)], u[np.minimum(i + 1, len(u) - 1)], u[i]
    for _ in range(NEWTON_STEPS):
        d = np.array(splev(t, tck)).T - p
        d1 = np.array(splev(t, tck, der=1)).T
        d2 = np.array(splev(t, tck, der=2)).T if tck[2] > 1 else np.zeros_like(d1)
        slope = (d1 * d1).sum(axis=1) + (d * d2).sum(axis=1)
        step = np.where(slope > 0, (d * d1).sum(axis=1) / np.where(slope > 0, slope, 1), 0)
        t = np.clip(t - step, low, high)
        best = np.minimum(best, ((np.array(splev(t, tck)).T - p) ** 2).sum(axis=1))
    return np.sqrt(best.max())


def fit(p, most):
    """Fit with the largest s within `most` of the points: (spans, deviation, straying, seconds)."""
    degree = min(3, len(p) - 1)
    x = [np.ascontiguousarray(c) for c in p.T]

    def spline(s):
        return splprep(x, s=s, k=degree, quiet=1)[0]

    def reached(s):
        return deviation(spline(s), p)

    size = np.linalg.norm(p.max(axis=0) - p.min(axis=0))
    bad = good = len(p) * size**2
    while reached(good) > most and good > 1e-12 * most**2:
        bad, good = good, good / 4
    if reached(good) > most:
        good = 0.0  # interpolation
    elif good < bad:
        for _ in range(STEPS):
            middle = np.sqrt(good * bad)
            if reached(middle) <= most:
                good = middle
            else:
                bad = middle
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        tck = spline(good)
        seconds.append(time.perf_counter() - start)
    spans = len(np.unique(tck[0])) - 1
    return spans, deviation(tck, p), straying(tck, p), np.median(seconds)


def sketch(data):
    out, at = [], 1
    for _ in range(int(data[0])):
        n = int(data[at])
        p = data[at + 3 : at + 3 + 3 * n].reshape(n, 3)
        for most in data[at + 1 : at + 3]:
            out += fit(p, most)
        at += 3 + 3 * n
    return np.array(out)


if __name__ == "__main__":
    if sys.argv[1] == "version":
        print(scipy.__version__)
    else:
        gc.disable()
        np.seterr(all="ignore")
        import warnings

        warnings.simplefilter("ignore")
        work = {"noise": noise, "sketch": sketch}[sys.argv[1]]
        work(np.fromfile(sys.argv[2])).astype(float).tofile(sys.argv[3])
