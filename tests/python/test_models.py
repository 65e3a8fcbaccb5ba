# SPDX-License-Identifier: MPL-2.0
"""Models: evaluation, scenes, copies and pickles."""

import copy
import multiprocessing
import pickle
import unittest

from properties import PropertyTests, batten, np, saddle


def sculpted():
    session = batten.Session(batten.skin(saddle(), name="panel"))
    session.add_pressure("swell", value=8, min=-100, max=100)
    session.add_force("push", at=[0.4, 0.5, 0.5], direction=[0, 0, 2], value=3)
    session.add_point_constraint("peak", at=[0.6, 0.6, 0.5])
    session.solve()
    return session


def area_of(model):
    return model.area, model.name, model.parameters


class Models(PropertyTests):
    def test_what_was_added_to_a_session_is_in_its_model(self):
        session = sculpted()
        model = session.model()
        self.assertEqual(model.parameters["swell"], 8)
        again = batten.Session(model)
        self.same_bits(again.dofs, session.dofs)
        self.assertEqual(again.names, session.names)
        self.assertEqual(again["swell"], 8)
        self.assertEqual(model.save(self.file("panel.toml")), [])
        read = batten.load(self.file("panel.toml"))
        self.assertEqual(read.parameters, model.parameters)
        self.assertLess(np.abs(read.points - batten.parse(model.scene).points).max(), 1e-12)
        self.assertLess(np.abs(batten.Session(read).dofs - session.dofs).max(), 1e-7)

    def test_the_scene_of_a_model_is_the_model(self):
        model = batten.skin(saddle(), name="panel", edge_length=0.1, crease=["front"])
        self.same_bits(batten.parse(model.scene).points, model.points)

    def test_copies_and_pickles(self):
        model = sculpted().model()
        self.assertIs(type(copy.copy(model)), batten.Model)
        self.same_bits(copy.deepcopy(model).points, model.points)
        other = pickle.loads(pickle.dumps(model))
        self.assertEqual(other.parameters, model.parameters)
        self.assertEqual(other.name, "panel")
        self.assertLess(np.abs(other.points - model.points).max(), 1e-7)
        plain = batten.skin(saddle())
        self.same_bits(pickle.loads(pickle.dumps(plain)).points, plain.points)
        session = sculpted()
        twin = pickle.loads(pickle.dumps(session))
        self.assertEqual(twin.names, session.names)
        self.assertLess(np.abs(twin.dofs - session.dofs).max(), 1e-7)

    def test_models_go_to_other_processes(self):
        models = [batten.skin(saddle()).with_values({"beta": b}) for b in (1, 2)]
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            self.assertEqual(pool.map(area_of, models), [area_of(m) for m in models])

    def test_evaluation(self):
        model = batten.skin(saddle())
        point = model.nearest([0.3, 0.6, 2])
        same = model.at(point.face, point.u, point.v)
        self.assertLess(np.abs(point.position - same.position).max(), 1e-9)
        self.assertAlmostEqual(float(np.linalg.norm(point.normal)), 1, 13)
        self.assertGreaterEqual(point.k1, point.k2)
        low, high = model.bounds
        self.assertTrue((low <= point.position).all() and (point.position <= high).all())
        self.assertEqual({edge.continuity for edge in model.edges}, {"free edge"})
        with self.assertRaisesRegex(batten.InputError, "closed"):
            model.volume
        self.assertIn("SurfacePoint", repr(point))

    def test_curvatures_at_the_points(self):
        angle = np.linspace(0, 2 * np.pi, 73)
        ring = np.c_[2 * np.cos(angle), 2 * np.sin(angle), 0 * angle]
        ring[-1] = ring[0]
        cylinder = batten.skin({"low": ring, "high": ring + [0, 0, 5]})
        self.assertEqual(cylinder.curvatures.shape, (len(cylinder.points), 2))
        self.assertFalse(cylinder.curvatures.flags.writeable)
        # Outward normals: the surface bends away from them, with radius 2.
        outwards = np.sign((cylinder.points * cylinder.normals)[:, :2].sum())
        np.testing.assert_allclose(outwards * cylinder.curvatures.sum(axis=1), -0.5, atol=0.02)
        np.testing.assert_allclose(cylinder.curvatures.prod(axis=1), 0, atol=0.01)
        self.assertTrue((cylinder.curvatures[:, 0] >= cylinder.curvatures[:, 1]).all())

    def test_unknown_names_are_named(self):
        model = batten.skin(saddle())
        for words, call in {
            "values: found parameter 'bta'.*did you mean 'beta'": lambda: model.with_values({"bta": 1}),
            "values: found 3, expected a dict": lambda: batten.Session(model, values=3),
            r"values\['beta'\]: found 'x', expected a number": lambda: model.with_values({"beta": "x"}),
            "curve name 'frnt'.*did you mean 'front'": lambda: model.curve("frnt"),
            "face name 'srface'.*did you mean 'surface'": lambda: model.at("srface", 0, 0),
            "crease: found the curve name 'frnt'.*did you mean 'front'": lambda: batten.skin(saddle(), crease=["frnt"]),
            "crease: found a single text": lambda: batten.skin(saddle(), crease="front"),
            "field: found 'meen'.*did you mean 'mean'": lambda: model.picture(self.file("x.png"), field="meen"),
        }.items():
            with self.assertRaisesRegex(batten.InputError, words):
                call()


if __name__ == "__main__":
    unittest.main()
