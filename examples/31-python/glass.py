# SPDX-License-Identifier: MPL-2.0
"""A glass that holds a third of a litre: curves from formulas, a session, a root search, output files.

1. curves: foot and rim, two circles, as numpy arrays
2. surface: the annular surface of minimum bending energy between them
3. session: a pressure inflates the glass, and each update gives its volume
4. the pressure at which the glass holds 330 ml, by the secant method
5. output files, and a picture if there is a display

Usage: glass.py [OUTPUT FOLDER]
"""

import os
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

import batten

Array = NDArray[Any]
FOOT, RIM, HEIGHT, WANTED = 22.0, 34.0, 110.0, 330.0  # mm, mm, mm, ml


def circle(radius: float, z: float, count: int = 72) -> Array:
    """Points of a circle about the z axis, (count + 1) × 3. The last point equals the first."""
    angle = np.linspace(0, 2 * np.pi, count + 1)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count + 1, z)])
    points[-1] = points[0]
    return points


def millilitres(session: batten.Session) -> float:
    """Volume between foot and rim, ml: ⅓ ∬ x·n over the wall and a lid. The floor at z = 0 contributes nothing."""
    lid = HEIGHT * np.pi * RIM**2 / 3
    return (abs(session.volume) + lid) / 1000


def main(out: str) -> int:
    os.makedirs(out, exist_ok=True)

    # 1. and 2. Curves and surface.
    model = batten.skin({"foot": circle(FOOT, 0), "rim": circle(RIM, HEIGHT)}, name="glass",
                        settings='[skin]\nfair = "bending"')
    assert model.failed_checks == [], model.failed_checks

    # 3. Find whether the surface normal points outwards.
    session = batten.Session(model)
    outwards = 1 if (model.normals * model.points)[:, :2].sum() > 0 else -1
    session.add_pressure("blow")

    def filled(pressure: float) -> float:
        session["blow"] = outwards * pressure
        session.solve()
        return millilitres(session)

    # 4. Like a balloon, the glass has a limit pressure. Beyond it, solve() raises an exception, and the step is halved.
    before = filled(0.0)
    p, f, q = 0.0, before - WANTED, 5.0
    steps = refused = 0
    while steps < 40:
        steps += 1
        try:
            g = filled(q) - WANTED
        except batten.NoSolutionError:
            refused += 1
            q = (p + q) / 2
            continue
        if abs(g) <= 1e-9 * WANTED:
            break
        p, f, q = q, g, q - g * (q - p) / (g - f)
    glass = session.model()

    # 5. Output.
    failed = glass.save(os.path.join(out, "glass.step"))
    points, triangles = glass.points, glass.triangles
    np.savez(os.path.join(out, "glass.npz"), points=points, triangles=triangles)
    glass.picture(os.path.join(out, "glass.png"), width=900, height=900, azimuth=-25, elevation=12, contours=14,
                  title=f"{millilitres(session):.0f} ml")
    print(f"{before:.3f} ml without pressure; {millilitres(session):.9f} ml at a pressure of {q:.6f}, "
          f"{steps} steps, {refused} beyond the limit")
    print(f"{len(points)} points, {len(triangles)} triangles; widest at {2 * np.hypot(*points[:, :2].T).max():.2f} mm")
    print("files in", out)
    return 0 if not failed and abs(millilitres(session) - WANTED) < 1e-6 else 4


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else "out/31-python"))
