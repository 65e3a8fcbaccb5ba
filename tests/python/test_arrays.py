# SPDX-License-Identifier: MPL-2.0
"""Invalid input is rejected with a message; views stay valid."""

import gc
import unittest

from properties import PropertyTests, batten, grid, np, saddle


class Refusals(PropertyTests):
    def refused(self, said, call, *arguments, error=batten.InputError, **named):
        with self.assertRaises(error) as raised:
            call(*arguments, **named)
        self.assertIsInstance(raised.exception, batten.Error)
        for word in said.split("…"):
            self.assertIn(word, str(raised.exception))

    def line(self, points):
        return {"a": points, "b": [[1, 0, 0], [0, 1, 0]]}

    def test_curves_of_a_surface(self):
        for words, points in [
            ("found nan in row 1", [[0, 0, 0], [np.nan, 0, 0]]),
            ("found inf", [[0, 0, 0], [np.inf, 0, 0]]),
            ("found an array of 2×2…n×3", [[0, 0], [1, 1]]),
            ("found an array of 3", [0, 0, 1]),
            ("found a single value", 1.0),
            ("type 'str", [["0", "0", "0"], ["a", "b", "c"]]),
            ("type 'complex128'", np.zeros((4, 3), complex)),
            ("type 'object'", np.array([[None, 0, 0]] * 3)),
            ("rows of different lengths", [[0, 0, 0], [1, 1]]),
            ("found 1 points", [[0, 0, 0]]),
            ("found 0 points", np.zeros((0, 3))),
            ("curve 'a'", np.zeros((3, 3, 3))),
        ]:
            self.refused("curve 'a'…" + words, batten.skin, self.line(points))

    def test_arguments_of_skin(self):
        self.refused("curves: found none", batten.skin, {})
        self.refused("expected one of curves; did you mean 'front'", batten.skin, saddle(), smooth=["frunt"])
        self.refused("found a single text", batten.skin, saddle(), smooth="front")
        self.refused("the name '1' twice", batten.skin, {1: [[0, 0, 0], [1, 0, 0]], "1": [[0, 0, 0], [1, 1, 0]]})
        self.refused("fit_tolerance: found -1", batten.skin, saddle(), fit_tolerance=-1)
        self.refused("edge_length: found 'x'", batten.skin, saddle(), edge_length="x")
        self.refused("found a [[curve]]", batten.skin, saddle(), settings='[[curve]]\nname="x"\npoints=[[0,0,0],[1,0,0]]')
        self.refused("skin():3:", batten.skin, saddle(), settings='\n[[load]]\nnaem = "x"')
        self.refused("progress: found an object that is not callable", batten.skin, saddle(), progress=3)

    def test_files(self):
        self.refused("not_there", batten.load, "not_there.toml")
        self.refused("expected a file name", batten.load, 3)
        self.refused("not_there", batten.read_mesh, "not_there.obj")
        model = batten.skin(saddle())
        self.refused("extension", model.save, self.file("x.doc"))
        self.refused("", model.save, "/not/there/x.vtp", error=batten.FileError)
        with open(self.file("broken.step"), "w") as file:
            file.write("ISO-10303-21;\nHEADER;garbage")
        self.refused("broken.step", batten.load, self.file("broken.step"))

    def test_parameters(self):
        session = batten.Session(batten.skin(saddle()))
        session.add_pressure("swell", min=-10, max=10)
        self.refused("did you mean 'swell'", session.set, "swel", 1)
        for value in (np.nan, np.inf, 11):
            self.refused("swell", session.set, "swell", value)
        self.refused("swell", session.add_pressure, "swell")
        self.refused("max_iterations: found 0", session.update, 0)
        self.refused("tolerance: found nan", session.update, 4, np.nan)
        self.refused("at: found", session.add_point_constraint, "pin", at=[1, 2])
        self.refused("did you mean 'beta'", batten.skin(saddle()).with_values, {"betta": 1})
        self.refused("expected a number", batten.skin(saddle()).with_values, {"beta": "many"})

    def test_meshes(self):
        points, triangles = grid(3)
        self.refused("expected 0 to 15", batten.Mesh, points, [[0, 1, 16]])
        self.refused("found -1", batten.Mesh, points, [[0, 1, -1]])
        self.refused("type 'float64'", batten.Mesh, points, triangles.astype(float))
        self.refused("m×3", batten.Mesh, points, triangles[:, :2])
        self.refused("nan", batten.Mesh, points * np.nan, triangles)
        self.refused("", batten.Mesh, points, [])
        self.refused("found points without triangles", batten.Deformer, points)
        mesh = batten.Mesh(points, triangles)
        self.refused("fixed: found 16", batten.Deformer, mesh, fixed=[16])
        self.refused("as a mask", batten.Deformer, mesh, fixed=np.ones(5, bool))
        self.refused("", batten.Deformer, mesh)
        deformer = batten.Deformer(mesh, fixed=[0], handles={"end": [15]})
        self.refused("expected a handle's name", deformer.deform, {"ende": batten.Move()})
        self.refused("expected a batten.Move", deformer.deform, {"end": 3})
        self.refused("length 0", batten.Move, axis=[0, 0, 0])
        self.refused("scale", deformer.deform, {"end": batten.Move(scale=-1)})

    def test_curves(self):
        self.refused("points: found nan", batten.fair, [[0, 0, 0], [1, np.nan, 0], [2, 0, 0]])
        self.refused("found several", batten.fair, np.eye(3), noise=1, deviation=1)
        self.refused("closed: found 'x'", batten.fair, np.eye(3), closed="x")
        self.refused("corners: found 9", batten.fair, np.eye(3), corners=[9])
        self.refused("", batten.fit, np.eye(3), -1.0)
        curve = batten.fit(np.eye(3), 1e-3)
        self.refused("order", curve.evaluate, [0.0], order=4)
        self.refused("u: found", curve.evaluate, [["a"]])

    def test_an_input_error_is_a_value_error(self):
        with self.assertRaises(ValueError):
            batten.skin({})


class Views(PropertyTests):
    def test_views_outlive_their_owner(self):
        model = batten.skin(saddle())
        session = batten.Session(model)
        views = [model.points, model.normals, model.triangles, model.triangle_faces, session.points,
                 session.normals, session.triangles]
        mesh = batten.Mesh(*grid(10))
        views += [mesh.points, mesh.triangles, batten.fit(np.eye(3), 1e-3).sample()]
        deformer = batten.Deformer(mesh, fixed=[0], handles={"end": [120]})
        deformer.deform({"end": batten.Move(translate=[0, 0, 1])})
        views += [deformer.positions]
        copies = [view.copy() for view in views]
        del model, session, mesh, deformer
        gc.collect()
        noise = [np.random.default_rng(i).random(20000) for i in range(50)]
        for view, copy in zip(views, copies):
            self.same_bits(view, copy)
        self.assertEqual(len(noise), 50)

    def test_nothing_is_copied_and_nothing_can_be_written(self):
        model = batten.skin(saddle())
        session = batten.Session(model)
        mesh = batten.Mesh(*grid(3))
        for view in (model.points, model.triangles, session.points, session.triangles, mesh.points):
            self.assertFalse(view.flags.owndata)
            self.assertFalse(view.flags.writeable)
        self.assertEqual(model.points.ctypes.data, model.points.ctypes.data)
        self.assertEqual(mesh.points.ctypes.data, mesh.points.ctypes.data)
        self.assertIs(session.triangles, session.triangles)

    def test_a_frame_stays_while_the_surface_goes_on(self):
        session = batten.Session(batten.skin(saddle()))
        session.add_pressure("swell")
        kept = []
        for value in range(12):
            session["swell"] = 5.0 * value
            session.solve()
            kept.append((session.points, session.points.copy(), session.normals, session.normals.copy()))
        for points, points_copy, normals, normals_copy in kept:
            self.same_bits(points, points_copy)
            self.same_bits(normals, normals_copy)
        self.assertGreater(np.abs(kept[0][0] - kept[-1][0]).max(), 1e-3)


if __name__ == "__main__":
    unittest.main()
