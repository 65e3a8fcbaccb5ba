# SPDX-License-Identifier: MPL-2.0
"""Gradients: derivatives against differences, and the same optimum by SciPy with and without them."""

import unittest

from properties import PropertyTests, batten, np

SHELL = {"material": "steel", "thickness": 1, "supports": ["left", "right"], "loads": {"pressure": -0.02}}
NAMES = ["left push", "right push", "swell"]
SCALES = np.array([100.0, 100.0, 5.0])


def vault():
    """A vault of 100 by 100 that two forces and a pressure shape."""
    arc = np.linspace(0, 1, 9)
    front = np.c_[100 * arc, 0 * arc, 40 * arc * (1 - arc)]
    loads = "".join(f'[[load]]\nname = "{name}"\ntype = "point"\nat = [{x}, 50, 9]\ndirection = [0, 0, 1]\n'
                    "value = 0\nmin = -300\nmax = 300\n" for name, x in (("left push", 30), ("right push", 70)))
    return batten.skin({"front": front, "right": [[100, 0, 0], [100, 100, 0]],
                        "back": front[::-1] + [0, 100, 0], "left": [[0, 100, 0], [0, 0, 0]]}, edge_length=20,
                       settings=loads + '[[load]]\nname = "swell"\ntype = "pressure"\nvalue = 0\nmin = -20\nmax = 20')


class Optimum:
    """Least norm of the stress of the vault at a mass of at most 1.02 times the initial one."""

    def __init__(self):
        self.model, self.known = vault(), {}
        self.initial = self.at(np.zeros(3))

    def at(self, x):
        key = tuple(x)
        if key not in self.known:
            model = self.model.with_values(dict(zip(NAMES, x * SCALES)))
            self.known[key] = batten.stress(model, **SHELL).gradients()
        return self.known[key]

    def derivative(self, quantity):
        return np.array([quantity.gradient[name] for name in NAMES]) * SCALES

    def found(self, with_gradient):
        from scipy.optimize import minimize

        self.known.clear()
        norm, mass = self.initial.von_mises_norm.value, self.initial.mass.value
        heavier = {"type": "ineq", "fun": lambda x: 50 * (1.02 - self.at(x).mass.value / mass)}
        slope = None
        if with_gradient:
            heavier["jac"] = lambda x: -50 * self.derivative(self.at(x).mass) / mass
            slope = lambda x: self.derivative(self.at(x).von_mises_norm) / norm  # noqa: E731
        result = minimize(lambda x: self.at(x).von_mises_norm.value / norm, np.zeros(3), jac=slope,
                          bounds=[(-3, 3), (-3, 3), (-4, 4)], constraints=[heavier], method="SLSQP",
                          options={"ftol": 1e-9})
        return result, len(self.known)


class Gradients(PropertyTests):
    def test_gradients_equal_differences(self):
        model = vault().with_values({"swell": 2, "left push": 20})
        gradients, area = batten.stress(model, **SHELL).gradients(norm_exponent=6), model.gradients().area
        self.assertEqual(area.value, model.area)
        self.assertEqual(set(area.gradient), set(model.parameters))
        for name, step in (("left push", 0.01), ("swell", 0.01), ("beta", 1e-3)):
            value = model.parameters[name]
            up, down = (model.with_values({name: value + s}) for s in (step, -step))
            self.assertAlmostEqual(area.gradient[name], (up.area - down.area) / (2 * step), delta=1e-4 * area.value / 100)
            up, down = (batten.stress(m, **SHELL).gradients(norm_exponent=6) for m in (up, down))
            for quantity in ("max_displacement", "compliance", "von_mises_norm", "mass"):
                with self.subTest(parameter=name, quantity=quantity):
                    here = getattr(gradients, quantity)
                    difference = (getattr(up, quantity).value - getattr(down, quantity).value) / (2 * step)
                    np.testing.assert_allclose(here.gradient[name], difference, rtol=2e-3, atol=1e-5 * here.value)

    def test_the_optimum_is_the_same_with_and_without_gradients(self):
        try:
            import scipy  # noqa: F401
        except ImportError:
            self.skipTest("scipy is not there (python3-scipy)")
        problem = Optimum()
        (fast, few), (slow, many) = problem.found(True), problem.found(False)
        self.assertTrue(fast.success and slow.success)
        self.assertLess(fast.fun, 0.99)
        np.testing.assert_allclose(fast.x, slow.x, atol=1e-4)
        self.assertAlmostEqual(fast.fun, slow.fun, 7)
        self.assertLess(2 * few, many)


if __name__ == "__main__":
    unittest.main()
