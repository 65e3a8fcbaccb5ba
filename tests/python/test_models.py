"""Models: evaluation, scenes, copies and pickles."""

import copy
import gc
import multiprocessing
import pickle
import unittest

from properties import PropertyTests, batten, np, resident_kb, saddle


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

    def test_memory_of_many_models(self):
        model = batten.skin(saddle(), edge_length=0.5)
        data = pickle.dumps(model)

        def work(count):
            for _ in range(count):
                batten.Session(pickle.loads(data)).model()
        work(200)
        gc.collect()
        before = resident_kb()
        work(500)
        gc.collect()
        self.assertLess(resident_kb() - before, 8000)


if __name__ == "__main__":
    unittest.main()
