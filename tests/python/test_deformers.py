"""Meshes and deformers: features keep their shape; the same bits as the example in C++."""

import copy
import math
import os
import pickle
import subprocess
import unittest
from types import SimpleNamespace

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
        kept = first.copy()
        other = deformer.deform({"end": batten.Move(translate=[0.1, 0, 0])}, scales={"patch": 1.2})
        self.assertLess(similarity_error(1.2 * points[feature], other[feature]), 1e-12)
        self.same_bits(first, kept)  # results do not change later
        self.same_bits(deformer.deform({"end": batten.Move(translate=[0, 0, 0.4], axis=[0, 1, 0], angle=-60)}), kept)
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
        self.assertIn(name, edit)
        self.assertNotIn("no such", edit)
        self.assertEqual(list(edit), list(edit.parameters))
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


class Meshes(PropertyTests):
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0.5, 0]])

    def refused(self, words, call, *arguments, **named):
        with self.assertRaises(batten.InputError) as raised:
            call(*arguments, **named)
        self.assertIn(words, str(raised.exception))

    def test_faces_are_triangles_quads_or_a_mixture(self):
        points = self.points
        quads = batten.Mesh(points, np.array([[0, 1, 2, 3]]))
        self.assertEqual((quads.faces, quads.triangles.shape), ([(0, 1, 2, 3)], (2, 3)))
        mixed = batten.Mesh(points, [[0, 1, 2, 3], (1, 4, 2)])
        self.assertEqual(mixed.faces, [(0, 1, 2, 3), (1, 4, 2)])
        self.assertEqual(list(mixed.triangle_faces), [0, 0, 1])
        self.assertEqual([list(loop) for loop in mixed.boundary_loops], [[0, 1, 4, 2, 3]])
        self.assertEqual(batten.Mesh(points, [[0, 1, 4, 2, 3]]).faces, [(0, 1, 4, 2, 3)])
        self.assertEqual(batten.Mesh(points, triangles=[[0, 1, 2]]).faces, [(0, 1, 2)])
        np.testing.assert_array_equal(mixed.bounds, [[0, 0, 0], [2, 1, 0]])
        self.assertEqual(list(mixed.vertices_in([0, 0, 0], [0, 1, 0])), [0, 3])
        self.assertEqual(mixed.format, "")
        self.assertIn("5 nodes, 2 faces", repr(mixed))
        self.refused("expected 0 to 4", batten.Mesh, points, [[0, 1, 2, 3], [1, 5, 2]])
        self.refused("found an array of 2 for one face", batten.Mesh, points, [[0, 1, 2], [1, 2]])
        self.refused("type 'float64'", batten.Mesh, points, [[0, 1, 2, 3], [1, 4, 2.5]])
        self.refused("m×3 or m×4", batten.Mesh, points, np.array([[0, 1, 4, 2, 3]]))
        self.refused("found points without triangles", batten.Mesh, points)
        self.refused("lower corner first", mixed.vertices_in, [0, 0, 1], [1, 1, 0])
        self.refused("not read from a file", mixed.save_as_read, self.file("x.obj"), points)

    def test_a_mesh_of_meshio(self):
        cells = [SimpleNamespace(type="triangle", data=np.array([[1, 4, 2]])), ("quad", [[0, 1, 2, 3]])]
        given = SimpleNamespace(points=self.points, cells=cells)
        mesh = batten.Mesh(given)
        self.assertEqual(mesh.faces, [(1, 4, 2), (0, 1, 2, 3)])
        self.same_bits(np.ascontiguousarray(mesh.points), self.points)
        self.assertEqual(batten.Deformer(given, fixed=[0]).mesh.faces, mesh.faces)
        given.cells = [("triangle6", [[0, 1, 2, 3, 4, 0]])]
        self.refused("the type 'triangle6', expected cells of the types triangle and quad", batten.Mesh, given)
        given.cells = [5]
        self.refused("cells: found 5", batten.Mesh, given)
        try:
            import meshio
        except ImportError:
            self.skipTest("python3-meshio is not there")
        quad = meshio.Mesh(self.points, [("quad", np.array([[0, 1, 2, 3]]))])
        self.assertEqual(batten.Mesh(quad).faces, [(0, 1, 2, 3)])

    def test_copies_and_pickles_of_meshes(self):
        deck = batten.read_mesh(example("11-panel", "panel.bdf"))
        self.assertIs(copy.copy(deck), deck)
        self.assertIs(copy.deepcopy({"mesh": deck})["mesh"], deck)
        again = pickle.loads(pickle.dumps(deck))
        self.same_bits(again.points, deck.points)
        self.same_bits(again.triangles, deck.triangles)
        self.same_bits(again.triangle_faces, deck.triangle_faces)
        self.assertEqual(again.faces, deck.faces)
        self.assertEqual({name: (list(s["nodes"]), list(s["faces"])) for name, s in again.sets.items()},
                         {name: (list(s["nodes"]), list(s["faces"])) for name, s in deck.sets.items()})
        self.refused("not read from a file", again.save_as_read, self.file("x.bdf"), again.points)
        moved = deck.with_points(deck.points + [0, 0, 1])
        self.same_bits(np.ascontiguousarray(moved.points), np.ascontiguousarray(deck.points) + [0, 0, 1])
        self.assertEqual(moved.faces, deck.faces)

    def plate(self, **named):
        mesh = batten.read_mesh(example("10-plate-with-holes", "plate.obj"))
        return mesh, batten.Deformer(
            mesh, fixed=mesh.vertices_in([0, 0, 0], [0, 300, 0]),
            handles={"end": mesh.vertices_in([300, 0, 0], [300, 300, 0])},
            features={hole.name: hole.vertices for hole in mesh.holes()}, **named)

    def test_holes_keep_their_radius(self):
        mesh, deformer = self.plate()
        holes = mesh.holes()
        self.assertEqual([hole.name for hole in holes], [f"hole-{i}" for i in range(1, 6)])
        np.testing.assert_allclose(holes[2].centre, [150, 150, 0], atol=1e-8)
        self.assertAlmostEqual(holes[2].radius, 42, places=8)
        self.assertIn("'hole-3': radius 42", repr(holes[2]))
        self.assertTrue(set(holes[2].loop) < set(holes[2].vertices))
        self.assertGreater(len(mesh.holes(flange_width=20)[0].vertices), len(holes[0].vertices))
        self.refused("flange_width: found -1", mesh.holes, -1)
        bent = deformer.deform({"end": batten.Move(translate=[-40, 0, 110], axis=[0, -1, 0], angle=75)})
        for hole in holes:
            after = batten.measure_hole(bent, hole.loop)
            self.assertLess(abs(after["radius"] / hole.radius - 1), 1e-12)
        self.assertLess(deformer.residual, 1e-12)

    def test_a_deformer_is_its_mesh_and_its_settings(self):
        mesh, deformer = self.plate(region_of_interest=np.ones(2784, bool))
        moves = {"end": batten.Move(translate=[-40, 0, 110], axis=[0, -1, 0], angle=75)}
        bent = deformer.deform(moves, scales={"hole-1": 1.1})
        for again in (pickle.loads(pickle.dumps(deformer)), copy.copy(deformer), copy.deepcopy(deformer)):
            self.same_bits(np.ascontiguousarray(again.positions), np.ascontiguousarray(mesh.points))
            self.same_bits(again.deform(moves, scales={"hole-1": 1.1}), bent)
        self.assertEqual(deformer.mesh.faces, mesh.faces)
        self.refused("expected a handle's name; did you mean 'end'?", deformer.deform, {"ende": batten.Move()})
        self.refused("expected a feature's name; did you mean 'hole-1'?", deformer.deform, {}, scales={"hole1": 2})
        self.same_bits(np.ascontiguousarray(deformer.positions), np.ascontiguousarray(bent))

    def test_a_move_can_be_read_and_pickled(self):
        move = batten.Move(translate=[0, 0, 0.4], axis=[0, 1, 0], angle=-60, about=[1, 0, 0])
        self.assertEqual(
            repr(move), "batten.Move(translate=(0.0, 0.0, 0.4), axis=(0.0, 1.0, 0.0), angle=-60.0, "
            "about=(1.0, 0.0, 0.0))")
        for again in (eval(repr(move)), pickle.loads(pickle.dumps(move)), copy.deepcopy(move)):
            self.assertEqual(repr(again), repr(move))
        self.assertEqual((list(move.translate), list(move.about)), ([0, 0, 0.4], [1, 0, 0]))
        self.assertEqual((move.angle, move.scale), (-60, 1))
        self.assertEqual(repr(batten.Move()), "batten.Move()")
        self.assertIsNone(batten.Move(scale=2).about)


if __name__ == "__main__":
    unittest.main()
