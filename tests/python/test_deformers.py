"""Deformers: features keep their shape; the same bits as the example in C++."""

import math
import os
import subprocess
import unittest

from properties import PropertyTests, batten, example, grid, np, run_program


def plate():
    """The plate of examples/00-deformer: points; the mesh file contains the quads as triangles."""
    around, rings, radius, half = 96, 20, 30.0, 100.0
    points = np.zeros((around * (rings + 1), 3))
    for k in range(rings + 1):
        for i in range(around):
            angle = 2 * math.pi * i / around
            share = math.pow(k / rings, 1.3)
            way = np.array([math.cos(angle), math.sin(angle), 0.0])
            border = half / max(abs(way[0]), abs(way[1]))
            points[i + around * k] = ((1 - share) * radius + share * border) * way
    faces = [(i + around * k, i + around * (k + 1), (i + 1) % around + around * (k + 1), (i + 1) % around + around * k)
             for k in range(rings) for i in range(around)]
    return points, faces, around, half


def similarity_error(before, after):
    """Largest distance after the best-fit rigid motion, relative to the size."""
    a, b = before - before.mean(0), after - after.mean(0)
    u, _, v = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v
    return np.abs(a @ turn - b).max() / np.ptp(before, axis=0).max()


class Deformers(PropertyTests):
    def test_the_example_in_cpp_has_the_same_bits(self):
        program = os.environ.get("BATTEN_DEFORMER", "")
        if not os.path.exists(program):
            self.skipTest("the example deformer is not built")
        environment = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
        subprocess.run([program, self.folder], env=environment, stdout=subprocess.DEVNULL, check=True)
        points, faces, around, half = plate()
        with open(self.file("plate.obj"), "w") as file:
            file.writelines("v %r %r %r\n" % tuple(map(float, p)) for p in points)
            file.writelines("f %d %d %d %d\n" % tuple(v + 1 for v in face) for face in faces)
        mesh = batten.read_mesh(self.file("plate.obj"))
        self.same_bits(mesh.points, points)
        deformer = batten.Deformer(
            mesh, fixed=points[:, 0] < -half + 1e-6, handles={"right": points[:, 0] > half - 1e-6},
            features={"hole": np.arange(2 * around)})
        # The rotation as in the program: the full angle divided by the number of steps.
        move = batten.Move(translate=[-50, 0, 70], axis=[0, 1, 0], angle=-80, about=[half, 0, 0])
        self.same_bits(np.ascontiguousarray(deformer.deform({"right": move})),
                       np.ascontiguousarray(batten.read_mesh(self.file("bent.vtu")).points))
        rim = np.arange(around)
        before, after = (batten.measure_hole(p, rim) for p in (points, deformer.positions))
        self.assertLess(abs(before["radius"] - after["radius"]), 1e-12 * before["radius"])
        self.assertLess(deformer.residual, 1e-12)

    def bent_square(self):
        points, triangles = grid(20)
        feature = np.abs(points - [0.5, 0.5, 0]).max(1) < 0.16
        deformer = batten.Deformer(points, triangles, fixed=points[:, 0] == 0, handles={"end": points[:, 0] == 1},
                                   features={"patch": feature})
        return points, triangles, feature, deformer

    def test_features_keep_their_shape_and_edits_do_not_add_up(self):
        points, _, feature, deformer = self.bent_square()
        first = deformer.deform({"end": batten.Move(translate=[0, 0, 0.4], axis=[0, 1, 0], angle=-60)})
        self.assertLess(similarity_error(points[feature], first[feature]), 1e-12)
        self.assertGreater(np.abs(first[feature] - points[feature]).max(), 0.1)
        copy = first.copy()
        other = deformer.deform({"end": batten.Move(translate=[0.1, 0, 0])}, scales={"patch": 1.2})
        self.assertLess(similarity_error(1.2 * points[feature], other[feature]), 1e-12)
        self.same_bits(first, copy)  # results do not change later
        self.same_bits(deformer.deform({"end": batten.Move(translate=[0, 0, 0.4], axis=[0, 1, 0], angle=-60)}), copy)
        np.testing.assert_allclose(deformer.deform({}), points, atol=1e-14)
        np.testing.assert_allclose(deformer.deform({"end": batten.Move()}), points, atol=1e-14)

    def test_feature_regions_are_rigid(self):
        points, triangles, feature, deformer = self.bent_square()
        free = batten.Deformer(points, triangles, fixed=points[:, 0] == 0, handles={"end": points[:, 0] == 1})
        moves = {"end": batten.Move(translate=[-0.1, 0, 0.4], axis=[0, 1, 0], angle=-60)}
        estimate = free.deform(moves)
        inside = feature[triangles].all(1)
        self.assertGreater(similarity_error(points[feature], estimate[feature]), 1e-3)
        regions = batten.FeatureRegions(points, triangles, regions={"patch": inside}, fixed=points[:, 0] == 0,
                                        handles={"end": points[:, 0] == 1})
        kept = regions.deform(estimate, moves)
        self.assertLess(similarity_error(points[feature], kept[feature]), 1e-12)

    def test_conflicts_are_named(self):
        points, triangles = grid(4)
        deformer = batten.Deformer(points, triangles, fixed=[0], handles={"a": [12, 13], "b": [13, 14]})
        with self.assertRaises(batten.ConflictError) as raised:
            deformer.deform({"a": batten.Move(translate=[0, 0, 1]), "b": batten.Move(translate=[0, 0, 2])})
        self.assertTrue(raised.exception.conflicts)

    def test_a_deck_comes_back_with_other_coordinates_only(self):
        deck = os.path.join(os.environ["BATTEN_SOURCE"], "examples", "11-panel", "panel.bdf")
        mesh = batten.read_mesh(deck)
        mesh.save_as_read(self.file("same.bdf"), mesh.points)
        with open(deck, "rb") as a, open(self.file("same.bdf"), "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.assertGreater(len(mesh.boundary_loops), 1)

    def test_a_live_edit_is_what_the_program_makes(self):
        scene = example("11-panel", "edit.toml")
        deck = next(f for f in os.listdir(os.path.dirname(scene)) if f.endswith(".bdf"))
        self.assertIn(run_program("deform", scene, "--out", self.folder), (0, 4))
        written = next(f for f in os.listdir(self.folder) if f.endswith(".bdf"))
        edit = batten.MeshEdit(scene)
        edit.mesh.save_as_read(self.file("python.bdf"), edit.points)
        with open(self.file("python.bdf"), "rb") as a, open(self.file(written), "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.assertTrue(deck)
        name = next(n for n in reversed(edit.parameters) if n.endswith((".x", ".y", ".z")))
        before, number = edit.points, edit[name]
        edit[name] = number + 1
        edit.update()
        self.assertGreater(np.abs(edit.points - before).max(), 1e-3)
        edit[name] = number
        edit.solve()
        self.same_bits(edit.points, before)
        with self.assertRaises(batten.InputError):
            edit["no such"] = 1

    def test_a_sequence(self):
        for k in range(3):
            points, triangles = grid(4)
            batten.Mesh(points + [0, 0, k], triangles).save(self.file(f"frame_{k}.obj"))
        frames = batten.read_sequence(self.file("frame_0.obj"))
        self.assertEqual((len(frames), frames[0].shape, list(frames.times)), (3, (25, 3), [0, 1, 2]))
        self.assertEqual([float(frame[0, 2]) for frame in (frames[0], frames[-1])], [0, 2])
        with self.assertRaises(IndexError):
            frames[3]


if __name__ == "__main__":
    unittest.main()
