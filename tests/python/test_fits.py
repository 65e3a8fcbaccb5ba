# SPDX-License-Identifier: MPL-2.0
"""Models that are fitted to a surface: the same as `batten fit`, from files and from meshes."""

import json
import pickle
import unittest

from properties import PropertyTests, batten, example, np, run_program


class Fits(PropertyTests):
    def fitted_by_program(self, *words):
        self.assertIn(run_program("fit", *words, "--out", self.file("out")), (0, 4))
        with open(self.file("out/report.json")) as report:
            made = json.load(report)
        return batten.read_mesh(self.file("out/" + made["name"] + ".vtp")), made["target"]

    def agrees(self, model, made):
        points, target = made
        self.same_bits(model.points, points.points)
        self.assertEqual(model.report["target"], target)

    def block(self, n=12, hill=3):
        """A block with a hill as its upper face."""
        s, t = (a.ravel() for a in np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n))
        top = np.column_stack([40 * s, 30 * t, 20 + 16 * hill * s * (1 - s) * t * (1 - t)])
        points = np.vstack([top, [[0, 0, 0], [40, 0, 0], [40, 30, 0], [0, 30, 0]]])
        low = np.arange(4) + len(top)
        v = lambda i, j: j * (n + 1) + i
        faces = [[v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)] for j in range(n) for i in range(n)]
        faces.append(low[::-1].tolist())
        sides = [[v(i, 0) for i in range(n, -1, -1)], [v(n, i) for i in range(n, -1, -1)],
                 [v(n - i, n) for i in range(n, -1, -1)], [v(0, n - i) for i in range(n, -1, -1)]]
        for k in range(4):
            faces.append([int(low[k]), int(low[(k + 1) % 4])] + sides[k])
        return batten.Mesh(points, faces)

    def test_creases_of_a_mesh(self):
        mesh = self.block()
        mesh.save(self.file("block.obj"))
        made = self.fitted_by_program(self.file("block.obj"), "--fit-tolerance", "0.05")
        model = batten.fit_surface(self.file("block.obj"), fit_tolerance=0.05)
        self.agrees(model, made)
        self.assertEqual(len(model.faces), 6)
        self.assertLessEqual(model.report["target"]["to_target"]["max"], 0.05)
        self.assertLessEqual(model.report["target"]["from_target"]["max"], 0.05)
        in_memory = batten.fit_surface(batten.read_mesh(self.file("block.obj")), fit_tolerance=0.05, name="block")
        self.same_bits(in_memory.points, model.points)
        self.same_bits(pickle.loads(pickle.dumps(in_memory)).points, model.points)
        # A CAD file of it, and the model of that.
        model.save(self.file("block.step"))
        self.agrees(batten.fit_surface(self.file("block.step"), fit_tolerance=0.1, unit="mm"),
                    self.fitted_by_program(self.file("block.step"), "--fit-tolerance", "0.1"))

    def test_given_curves(self):
        scan, rims = example("30-refit", "scan.obj"), example("30-refit", "rims.csv")
        made = self.fitted_by_program(scan, "--curves", rims, "--fit-tolerance", "0.5", "--edge-length", "25")
        options = {"fit_tolerance": 0.5, "edge_length": 25}
        self.agrees(batten.fit_surface(scan, curves=rims, **options), made)
        self.agrees(batten.fit_surface(scan, curves=[rims], **options), made)
        points = batten.read_curves(rims, corner_angle=20)
        from_arrays = batten.fit_surface(batten.read_mesh(scan), curves=points, **options)
        self.assertTrue(from_arrays.report["target"]["reached"])

    def test_the_scene_is_the_model(self):
        model = batten.fit_surface(example("30-refit", "scan.obj"), curves=example("30-refit", "rims.csv"), fit_tolerance=0.5,
                                   edge_length=25)
        model.save(self.file("fitted.toml"))
        self.same_bits(batten.load(self.file("fitted.toml")).points, model.points)
        session = batten.Session(model)
        session.add_pressure("dent", value=-20)
        session.solve()
        self.assertGreater(np.abs(session.model().points - model.points).max(), 1e-3)

    def test_refusals(self):
        mesh = self.block(4)
        sphere = batten.Mesh([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]],
                             [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
        for action, words in (
                (lambda: batten.fit_surface("missing.step"), "missing.step"),
                (lambda: batten.fit_surface(mesh, fit_tolerance=0), "fit_tolerance: found 0"),
                (lambda: batten.fit_surface(mesh, edge_length=float("nan")), "edge_length: found nan"),
                (lambda: batten.fit_surface(mesh, unit="mn"), "'mn'.*did you mean 'mm'"),
                (lambda: batten.fit_surface(mesh, curves={}), "curves: found none"),
                (lambda: batten.fit_surface(mesh, curves={"a": [[0, 0, 0]]}), "curve 'a': found 1 points"),
                (lambda: batten.fit_surface(3), "found 3"),
                (lambda: batten.fit_surface(self.file("no.obj")), "no.obj"),
                (lambda: batten.parse('unit = "mm"\n[[curve]]\nname = "a"\npoints = [[0,0,0],[1,0,0]]\n[[target]]\n'
                                      'points = [[0,0,0],[1,0,0],[0,1,0]]\nfaces = [[0, 1, 3]]'), "faces|found 3")):
            with self.subTest(words), self.assertRaisesRegex(batten.InputError, words):
                action()
        self.assertEqual(len(sphere.faces), 8)


if __name__ == "__main__":
    unittest.main()
