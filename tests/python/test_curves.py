# SPDX-License-Identifier: MPL-2.0
"""Curves: fair ones, fitted ones, and curves of surfaces."""

import unittest

from properties import PropertyTests, batten, np


def noisy_circle(noise=1e-3):
    t = np.linspace(0, np.pi, 61)
    points = np.column_stack([np.cos(t), np.sin(t), 0 * t])
    return points + np.random.default_rng(7).normal(0, noise, points.shape)


class Curves(PropertyTests):
    def test_a_noisy_half_circle_is_faired(self):
        fair = batten.fair(noisy_circle())
        self.assertLess(np.abs(np.linalg.norm(fair.points, axis=1) - 1).max(), 2e-3)
        self.assertTrue(2e-4 < fair.noise < 5e-3)
        self.assertEqual(fair.curve.fairness()["inflections"], 0)
        self.same_bits(fair.points, fair.curve.evaluate(fair.parameters))

    def test_a_stated_deviation_is_kept(self):
        fair = batten.fair(noisy_circle(), deviation=5e-3, reject_outliers=False)
        self.assertLess(fair.deviation, 5.0001e-3)

    def test_an_outlier_is_passed_over(self):
        points = noisy_circle()
        points[20] *= 1.3
        self.assertEqual(list(batten.fair(points).outliers), [20])

    def test_a_fit_is_within_its_tolerance(self):
        points = noisy_circle(0)
        curve = batten.fit(points, 1e-5)
        self.assertLess(len(curve.parameters), 40)
        fine = curve.sample(2001)
        for p in points:
            self.assertLess(np.linalg.norm(fine - p, axis=1).min(), 2e-3)
        self.assertLess(abs(curve.length - np.pi), 1e-4)
        self.assertLess(np.abs(curve.curvature(curve.parameters[1:-1]) - 1).max(), 0.05)
        self.assertEqual(curve.evaluate([0.0], order=1).shape, (1, 3))

    def test_lines_are_written_and_read(self):
        fair = batten.fair(noisy_circle())
        lines = {"fair": fair, "fit": batten.fit(noisy_circle(0), 1e-5), "points": np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.5]])}
        self.assertEqual(batten.write_curves(self.file("lines.csv"), lines), [])
        read = list(batten.read_curves(self.file("lines.csv")).values())
        self.same_bits(np.ascontiguousarray(read[2]), lines["points"].astype(float))
        self.same_bits(np.ascontiguousarray(read[0]), np.ascontiguousarray(fair.points))
        self.assertEqual(batten.write_curves(self.file("lines.step"), lines), [])
        self.assertGreaterEqual(len(batten.read_curves(self.file("lines.step"))), 3)
        with self.assertRaises(batten.InputError):
            batten.write_curves(self.file("lines.doc"), lines)

    def test_a_curve_is_a_line_of_a_surface(self):
        arc = batten.fit(noisy_circle(0), 1e-6)
        ends = arc.sample(2)
        model = batten.skin({"arc": arc, "chord": ends[::-1]})
        self.assertEqual(model.failed_checks, [])
        rim = np.linalg.norm(model.curve("arc") - arc.sample(), axis=1)
        self.assertLess(rim.max(), 1e-12)


if __name__ == "__main__":
    unittest.main()
