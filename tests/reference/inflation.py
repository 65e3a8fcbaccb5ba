#!/usr/bin/python3
# SPDX-License-Identifier: MPL-2.0
"""Inflated disc and tube: converged numbers for tests/reference/inflation.json.

    python3 inflation.py > inflation.json

An elastic surface with the energy of Batten,

    E = ∬ alpha |grad X|² + beta |grad grad X|² du dv,    K x = F,    F = p ∬ N (x_u × x_v) du dv,

under a follower pressure p, for two rotationally symmetric shapes, which lead to ordinary
differential equations. The energy of each coordinate is that of its angular mode:

  disc   (u, v) = s (cos t, sin t), 0 ≤ s ≤ 1,    x = (r(s) cos t, r(s) sin t, z(s))
         bending      r''² + 3 ((r/s)')² + z''² + (z'/s)²
         stretching   r'² + (r/s)² + z'²
         x_u × x_v    (r/s) (r' e_z - z' e_r),    measure 2π s ds
         fixed at the boundary: r = 1, z = 0; "tangent plane": z' = 0 as well; "clamped": r' = 1 as well.
         Small p, alpha 0, tangent plane or clamped: z = p/(64 beta) (1 - s²)², volume p π/(192 beta);
         position only: z = p/(64 beta) (1 - s²)(5 - s²).
  tube   0 ≤ u < 2π, 0 ≤ v ≤ 2,    x = (r(v) cos u, r(v) sin u, z(v))
         bending      r''² + 2 r'² + r² + z''²
         stretching   r'² + r² + z'²
         x_u × x_v    r z' e_r - r r' e_z,    measure 2π dv
         fixed at the boundaries: r = 1, z = 0 and 2. Without pressure it has a waist:
         r = A cosh w + B w sinh w, w = v - 1, with r''(±1) = 0.

Method: Galerkin with polynomials (disc: r odd, z even in s; Legendre polynomials), weak form with
Gauss points, boundary conditions by elimination, natural ones for free dofs; Newton;
pseudo-arc-length continuation to the fold, where the Newton matrix is singular: the largest pressure
that the branch from p = 0 reaches. The results are the digits on which two numbers of polynomials agree.
"""
import json

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import null_space
from scipy.optimize import brentq


class Shape:
    """K q = p force(q) for the coefficients q = (of r, of z), with conditions C q = d by elimination:
    q = q0 + N y."""

    def newton(self, y, p, tolerance=1e-13):
        for _ in range(60):
            g, J, _ = self.residual(y, p)
            step = np.linalg.solve(J, -g)
            y = y + step
            if np.abs(step).max() < tolerance * (1 + np.abs(y).max()):
                return y
        return None

    def residual(self, y, p):
        q = self.q0 + self.N @ y
        f, df = self.force(q)
        return (self.N.T @ (self.K @ q - p * f), self.N.T @ (self.K - p * df) @ self.N,
                -self.N.T @ f)

    def setup(self, C, d):
        self.N = null_space(C)
        self.q0 = np.linalg.lstsq(C, d, rcond=None)[0]

    def unloaded(self):
        return np.linalg.solve(self.N.T @ self.K @ self.N, -self.N.T @ self.K @ self.q0)

    def fold(self):
        """Continuation by arc length along (y, p) until dp/ds changes sign, then bisection."""
        y, p = self.unloaded(), 0.0
        n = len(y)
        tangent = np.zeros(n + 1)
        tangent[n] = 1
        ds = 0.02 * self.scale

        def step(y, p, tangent, ds):
            Y, P = y + ds * tangent[:n], p + ds * tangent[n] * self.p_unit
            for _ in range(40):
                g, J, gp = self.residual(Y, P)
                A = np.zeros((n + 1, n + 1))
                A[:n, :n], A[:n, n] = J, gp * self.p_unit
                A[n] = tangent
                b = np.append(-g, ds - tangent[:n] @ (Y - y) - tangent[n] * (P - p) / self.p_unit)
                d = np.linalg.solve(A, b)
                Y, P = Y + d[:n], P + d[n] * self.p_unit
                if np.abs(d).max() < 1e-12 * (1 + np.abs(Y).max()):
                    break
            else:
                return None
            t = np.linalg.solve(A, np.append(np.zeros(n), 1))
            return Y, P, t / np.linalg.norm(t)

        first = step(y, p, tangent, 1e-6)
        tangent = first[2]
        for _ in range(4000):
            s = step(y, p, tangent, ds)
            if s is None:
                ds *= 0.5
                continue
            if s[2][n] < 0:
                rate = lambda h: step(y, p, tangent, h)[2][n]
                h = brentq(rate, 1e-9, ds, xtol=1e-10, rtol=1e-12)
                Y, P, _ = step(y, p, tangent, h)
                return Y, P
            y, p, tangent = s
        raise RuntimeError("no fold found")


class Disc(Shape):
    def __init__(self, n, alpha, beta, rim):
        x, w = legendre.leggauss(4 * n + 8)
        s, w = 0.5 * (x + 1), 0.5 * w
        self.s, self.w = s, w
        t = 2 * s * s - 1  # Legendre polynomials of t; d/ds by the chain rule
        self.scale, self.p_unit = 1.0, 16 * (alpha + 4 * beta)

        def basis(t):
            V = [legendre.legval(t, c) for c in np.eye(n)]
            D = [legendre.legval(t, legendre.legder(c)) for c in np.eye(n)]
            E = [legendre.legval(t, legendre.legder(c, 2)) for c in np.eye(n)]
            return [np.array(M).T for M in (V, D, E)]

        g, g1, g2 = basis(t)  # of t; t = 2 s² - 1, dt/ds = 4 s
        S = s[:, None]
        q, dq = g, 4 * S * g1  # r/s and its derivative
        r, dr = S * g, g + S * dq
        ddr = 2 * dq + S * (4 * g1 + 16 * S * S * g2)
        z, dz, ddz, dzs = g, 4 * S * g1, 4 * g1 + 16 * S * S * g2, 4 * g1
        o = np.zeros_like(g)
        W = (w * s)[:, None]
        quad = lambda A, B: A.T @ (W * B)
        Kr = beta * (quad(ddr, ddr) + 3 * quad(dq, dq)) + alpha * (quad(dr, dr) + quad(q, q))
        Kz = beta * (quad(ddz, ddz) + quad(dzs, dzs)) + alpha * quad(dz, dz)
        self.K = np.block([[Kr, np.zeros((n, n))], [np.zeros((n, n)), Kz]])
        self.R, self.dR, self.Q = (np.hstack([m, o]) for m in (r, dr, q))
        self.Z, self.dZ = (np.hstack([o, m]) for m in (z, dz))
        e, e1, _ = (m[0] for m in basis(np.array([1.0])))
        n0 = np.zeros(n)
        C, d = [np.append(e, n0), np.append(n0, e)], [1.0, 0.0]
        if rim != "position":
            C.append(np.append(n0, 4 * e1))
            d.append(0.0)
        if rim == "clamped":
            C.append(np.append(e + 4 * e1, n0))
            d.append(1.0)
        self.setup(np.array(C), np.array(d))
        self.top = np.append(n0, basis(np.array([-1.0]))[0][0])
        self.middle = basis(np.array([-0.5]))[0][0]  # s = 1/2

    def force(self, q):
        W = self.w * self.s
        r, dr, dz, qs = self.R @ q, self.dR @ q, self.dZ @ q, self.Q @ q
        f = self.R.T @ (-W * qs * dz) + self.Z.T @ (W * qs * dr)
        df = (self.R.T @ (-W[:, None] * (dz[:, None] * self.Q + qs[:, None] * self.dZ))
              + self.Z.T @ (W[:, None] * (dr[:, None] * self.Q + qs[:, None] * self.dR)))
        return f, df

    def numbers(self, y):
        q = self.q0 + self.N @ y
        n = len(self.middle)
        W = self.w * self.s
        r, dr, z, dz, qs = self.R @ q, self.dR @ q, self.Z @ q, self.dZ @ q, self.Q @ q
        # 1/3 ∬ x·(x_u × x_v): the cone from the origin adds nothing, because the boundary is flat
        # at z = 0.
        volume = 2 * np.pi / 3 * np.sum(W * qs * (z * dr - r * dz))
        return {"height": self.top @ q, "radius_at_half": 0.5 * self.middle @ q[:n],
                "height_at_half": self.middle @ q[n:], "volume": volume,
                "energy": 2 * np.pi * q @ self.K @ q}


class Tube(Shape):
    def __init__(self, n, alpha, beta):
        x, w = legendre.leggauss(3 * n + 8)  # v = x + 1, so dv = dx
        self.x, self.w = x, w
        self.scale, self.p_unit = 1.0, alpha + beta

        def basis(t):
            return [np.array([legendre.legval(t, legendre.legder(c, k)) for c in np.eye(n)]).T
                    for k in range(3)]

        g, g1, g2 = basis(x)
        o = np.zeros_like(g)
        quad = lambda A, B: A.T @ (w[:, None] * B)
        Kr = (beta * (quad(g2, g2) + 2 * quad(g1, g1) + quad(g, g))
              + alpha * (quad(g1, g1) + quad(g, g)))
        Kz = beta * quad(g2, g2) + alpha * quad(g1, g1)
        self.K = np.block([[Kr, np.zeros((n, n))], [np.zeros((n, n)), Kz]])
        self.R, self.dR = np.hstack([g, o]), np.hstack([g1, o])
        self.Z, self.dZ = np.hstack([o, g]), np.hstack([o, g1])
        ends = basis(np.array([-1.0, 1.0]))[0]
        n0 = np.zeros(n)
        self.setup(np.array([np.append(ends[0], n0), np.append(ends[1], n0),
                             np.append(n0, ends[0]), np.append(n0, ends[1])]),
                   np.array([1.0, 1, 0, 2]))
        self.middle = np.append(basis(np.array([0.0]))[0][0], n0)
        self.quarter = basis(np.array([-0.5]))[0][0]

    def force(self, q):
        w = self.w
        r, dr, dz = self.R @ q, self.dR @ q, self.dZ @ q
        f = self.R.T @ (w * r * dz) - self.Z.T @ (w * r * dr)
        df = (self.R.T @ (w[:, None] * (dz[:, None] * self.R + r[:, None] * self.dZ))
              - self.Z.T @ (w[:, None] * (dr[:, None] * self.R + r[:, None] * self.dR)))
        return f, df

    def numbers(self, y):
        q = self.q0 + self.N @ y
        n = len(self.quarter)
        r, dr, z, dz = self.R @ q, self.dR @ q, self.Z @ q, self.dZ @ q
        # 1/3 ∬ x·(x_u × x_v), open ends: with z from 0 the cap at z = 2 would add 2π/3.
        volume = 2 * np.pi / 3 * np.sum(self.w * (r * r * dz - z * r * dr))
        return {"radius_at_half": self.middle @ q, "radius_at_quarter": self.quarter @ q[:n],
                "height_at_quarter": self.quarter @ q[n:], "volume": volume,
                "energy": 2 * np.pi * q @ self.K @ q}


def difference(a, b):
    return max(abs(a[k] - b[k]) / max(1, abs(a[k])) for k in a)


def series(make, pressures, sizes):
    """Numbers at each pressure, for two numbers of polynomials that must agree."""
    result, worst = None, 0.0
    for n in sizes:
        shape = make(n)
        y, p, rows = shape.unloaded(), 0.0, []
        for target in pressures:
            for k in range(1, 9):
                y = shape.newton(y, p + (target - p) * k / 8)
            p = target
            rows.append({"pressure": target, **shape.numbers(y)})
        Y, P = shape.fold()
        rows.append({"pressure": P, "fold": True, **shape.numbers(Y)})
        if result:
            worst = max(difference(a, b) for a, b in zip(rows, result))
        result = rows
    return {"states": result[:-1], "fold": result[-1], "agreement": worst}


def main():
    cases = []
    for rim in ("position", "tangent plane", "clamped"):
        for alpha, beta in ((0.0, 1.0), (2.0, 1.0)):
            folds = Disc(14, alpha, beta, rim).fold()[1]
            pressures = [1e-3] + [float("%.2g" % (x * folds)) for x in (0.25, 0.5, 0.8, 0.95)]
            cases.append({"shape": "disc", "rim": rim, "alpha": alpha, "beta": beta,
                          **series(lambda n: Disc(n, alpha, beta, rim), pressures, (14, 18))})
    for alpha, beta in ((0.0, 1.0), (2.0, 1.0)):
        folds = Tube(20, alpha, beta).fold()[1]
        pressures = [0.0, 1e-3] + [float("%.2g" % (x * folds)) for x in (0.25, 0.5, 0.8, 0.95)]
        cases.append({"shape": "tube", "rim": "position", "alpha": alpha, "beta": beta,
                      **series(lambda n: Tube(n, alpha, beta), pressures, (20, 26))})
    print(json.dumps({"source": "inflation.py", "cases": cases}, indent=1))


if __name__ == "__main__":
    main()
