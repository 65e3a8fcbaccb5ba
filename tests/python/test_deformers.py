# SPDX-License-Identifier: MPL-2.0
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
    def test_derivatives_are_those_of_differences_and_adjoint(self):
        mesh = batten.read_mesh(example("10-plate-with-holes", "plate.obj"))
        x, holes = mesh.points[:, 0], mesh.holes()
        for mode in ("harmonic", "estimated"):
            deformer = batten.Deformer(
                mesh, fixed=x == 0, handles={"end": x == 300}, features=holes, rotation_mode=mode,
                constraints={"level": batten.OnPlane(holes[2].loop, normal=[0, 0, 1])})
            base = dict(translate=[-40, 0, 110], axis=[0, -1, 0], angle=75, scale=1.1)
            origin = mesh.points[holes[2].loop].mean(0) + [0, 0, 50]

            def shape(h):
                move = dict(base, translate=np.add(base["translate"], [h, 0, -2 * h]), angle=75 - 0.5 * h,
                            scale=1.1 + 0.01 * h)
                return deformer.deform({"end": batten.Move(**move)}, scales={"hole-1": 1 + 0.02 * h}, correct=True,
                                       origins={"level": origin + [0, 0, h]})

            rates = dict(moves={"end": {"translate": [1, 0, -2], "rotation": [0, 0.5, 0], "scale": 0.01}},
                         scales={"hole-1": 0.02}, origins={"level": [0, 0, 1]})
            # Differences of order six, with other steps than those of jvp().
            near, middle, far = (shape(h) - shape(-h) for h in (0.4, 0.8, 1.6))
            order_four = [(8 * a - b) / (12 * h) for a, b, h in ((near, middle, 0.4), (middle, far, 0.8))]
            expected = (16 * order_four[0] - order_four[1]) / 15
            before = shape(0).copy()
            found = deformer.jvp(**rates)
            self.assertLess(np.abs(found - expected).max(), 1e-7 * np.abs(expected).max())
            self.same_bits(np.ascontiguousarray(deformer.positions), before)  # jvp() changes nothing
            weights = np.random.default_rng(3).normal(size=mesh.points.shape)
            gradient = deformer.vjp(weights)
            product = sum(np.dot(rates["moves"]["end"][k], gradient["moves"]["end"][k]) for k in ("translate", "rotation"))
            product += 0.01 * gradient["moves"]["end"]["scale"] + 0.02 * gradient["scales"]["hole-1"]
            product += gradient["origins"]["level"][2]
            self.assertLess(abs(product - (weights * found).sum()), 1e-6 * np.abs(weights * found).sum())
        for bad in ({"moves": {"side": {}}}, {"moves": {"end": {"turn": 1}}}, {"scales": {"hole-1": float("nan")}},
                    {"moves": {"end": {"translate": [1, 2]}}}):
            with self.assertRaises(batten.InputError):
                deformer.jvp(**bad)
        with self.assertRaises(batten.InputError):
            deformer.vjp(np.zeros((3, 3)))

    def test_design_study_of_a_deck(self):
        text = open(example("11-panel", "edit.toml"), encoding="utf-8").read()
        text = text[:text.index("[modes]")].replace("panel.bdf", example("11-panel", "panel.bdf").replace("\\", "/"))
        with open(self.file("edit.toml"), "w", encoding="utf-8") as file:
            file.write(text + '[[dimension]]\nname = "length"\ntype = "distance"\nof = ["left", "right"]\n')
        report = batten.deform(self.file("edit.toml"), self.file("out"), doe="grid",
                               derivatives=[self.file("d.npz"), self.file("d.csv")],
                               ranges={"longer.right.x": (0, 20, 2), "longer.right.z": (0, 40, 2)})
        self.assertEqual(report["variants"], {"count": 4, "failed": 0, "table": "variants.csv"})
        with np.load(self.file("d.npz")) as arrays:
            self.assertEqual(list(arrays["parameters"]), ["longer.right.x", "longer.right.z"])
            self.assertEqual(list(arrays["values"]), [12, 40])
            self.assertEqual(list(arrays["dimensions"]), ["length"])
            nodes, points, derivatives = arrays["nodes"], arrays["points"], arrays["derivatives"]
            self.assertEqual(derivatives.shape, (2, len(nodes), 3))
            self.assertEqual(arrays["dimension_derivatives"].shape, (1, 2))
        table = np.genfromtxt(self.file("d.csv"), delimiter=",", skip_header=1)
        self.assertTrue(np.array_equal(table[:, 0], nodes))
        self.assertTrue(np.array_equal(table[:, 1:4], points))
        self.assertTrue(np.array_equal(table[:, 4:], np.hstack(derivatives)))

    def test_the_example_in_cpp_has_the_same_bits(self):
        program = os.environ.get("BATTEN_DEFORMER", "")
        if not os.path.exists(program):
            self.skipTest("the example deformer is not built")
        subprocess.run([program, self.folder], stdout=subprocess.DEVNULL, check=True)
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


class Constraints(PropertyTests):
    """Constraints and rotation modes of a Deformer, compared with deform scenes of the same edit."""

    move = {"translate": [-40, 0, 110], "axis": [0, -1, 0], "angle": 75}

    def setUp(self):
        super().setUp()
        self.plate = batten.read_mesh(example("10-plate-with-holes", "plate.obj"))
        self.holes = self.plate.holes()
        self.settings = {"fixed": self.plate.vertices_in([0, 0, 0], [0, 300, 0]),
                         "handles": {"end": self.plate.vertices_in([300, 0, 0], [300, 300, 0])},
                         "features": self.holes}
        self.moves = {"end": batten.Move(**self.move)}

    def refused(self, words, call, *arguments, **named):
        with self.assertRaises(batten.InputError) as raised:
            call(*arguments, **named)
        self.assertIn(words, str(raised.exception))

    def of_scene(self, shared="", edit="", top=""):
        """Positions that a deform scene of the same edit gives."""
        with open(self.file("edit.toml"), "w") as file:
            file.write(f"""unit = "mm"
mesh = "{self.plate_file()}"
{top}
[[select]]
name = "left"
box = [[0, 0, 0], [0, 300, 0]]
[[select]]
name = "end"
box = [[300, 0, 0], [300, 300, 0]]
[[features]]
of = ["hole-*"]
{shared}
[[edit]]
fixed = "left"
centres = "free"
{edit}
[[edit.handle]]
name = "end"
translate = {self.move["translate"]}
rotate = {{ axis = {self.move["axis"]}, angle = {self.move["angle"]} }}
""")
        return batten.MeshEdit(self.file("edit.toml")).points

    def plate_file(self):
        return example("10-plate-with-holes", "plate.obj")

    def deformed(self, **named):
        deformer = batten.Deformer(self.plate, **self.settings, **named)
        return deformer, deformer.deform(self.moves, correct=True)

    def near(self, found, expected, tolerance=1e-9):
        self.assertLess(np.abs(found - expected).max(), tolerance * 300)

    def test_each_rotation_mode_equals_the_scene(self):
        found = {}
        for mode in ("harmonic", "estimated", "dual", "nonlinear"):
            deformer, points = self.deformed(rotation_mode=mode)
            self.near(points, self.of_scene(edit=f'rotation_mode = "{mode}"'))
            self.assertLess(deformer.residual, 1e-12)
            self.assertTrue(deformer.report.converged)
            self.assertEqual(deformer.report.iterations > 0, mode != "harmonic")
            self.assertLess(deformer.report.last_correction, 1e-9)
            self.assertGreater(deformer.unknowns, 0)
            self.same_bits(points, deformer.positions)
            # Edits do not add up, and a copy gives the same bits.
            deformer.deform({"end": batten.Move(translate=[0, 50, 0])})
            self.same_bits(deformer.deform(self.moves, correct=True), points)
            again = pickle.loads(pickle.dumps(deformer))
            self.same_bits(np.ascontiguousarray(again.positions), np.ascontiguousarray(self.plate.points))
            self.same_bits(again.deform(self.moves, correct=True), points)
            found[mode] = points
        for mode, points in found.items():
            for other in found:
                if other != mode:
                    self.assertGreater(np.abs(points - found[other]).max(), 1e-3, (mode, other))

    def test_each_rotation_mode_equals_the_program(self):
        for mode in ("estimated", "nonlinear"):
            self.of_scene(edit=f'rotation_mode = "{mode}"')
            self.assertEqual(run_program("deform", self.file("edit.toml"), "--out", self.file(mode)), 0)
            written = batten.read_mesh(os.path.join(self.file(mode), "plate-deformed.obj"))
            self.near(self.deformed(rotation_mode=mode)[1], written.points)

    def test_each_rotation_mode_reproduces_rigid_motions(self):
        points, triangles = grid(12)
        points[:, 2] = 0.2 * np.sin(3 * points[:, 0]) * points[:, 1]
        axis = np.array([1, 2, -1]) / math.sqrt(6)
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        angle = math.radians(40)
        rotation = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
        expected = points @ rotation.T + [1, -2, 3]
        ends = {"left": points[:, 0] < 0.1, "right": points[:, 0] > 0.9}
        move = batten.Move(translate=[1, -2, 3], axis=axis, angle=40, about=[0, 0, 0])
        for mode in ("harmonic", "estimated", "dual", "nonlinear"):
            deformer = batten.Deformer(points, triangles, handles=ends, features={"patch": [60, 61, 62, 73, 74, 75]},
                                       rotation_mode=mode)
            found = deformer.deform({"left": move, "right": move}, correct=True)
            self.assertLess(np.abs(found - expected).max(), 1e-9, mode)
            np.testing.assert_allclose(deformer.deform({}), points, atol=1e-14)

    def test_the_uniform_weighting_equals_the_scene(self):
        found = self.deformed(rotation_mode="estimated", weighting="uniform")[1]
        self.near(found, self.of_scene(top='weighting = "uniform"'))
        self.assertGreater(np.abs(found - self.deformed(rotation_mode="estimated")[1]).max(), 1e-3)

    def test_features_slide_on_planes_and_lines(self):
        top, side = self.holes[2], self.holes[0]
        named = {"constraints": {"plane": batten.OnPlane(top.loop, [1, 0, 2]),
                                 "line": batten.OnLine(side.loop, direction=[3, 0, 1], origin=[45, 50, 5])}}
        shared = """[[constraint]]
name = "plane"
of = "hole-3"
plane = { normal = [1, 0, 2] }
[[constraint]]
name = "line"
of = "hole-1"
axis = { direction = [3, 0, 1], origin = [45, 50, 5] }
"""
        for mode in ("harmonic", "estimated", "nonlinear"):
            deformer, found = self.deformed(rotation_mode=mode, **named)
            self.near(found, self.of_scene(shared, f'rotation_mode = "{mode}"'))
            centre = found[top.loop].mean(0) - self.plate.points[top.loop].mean(0)
            self.assertLess(abs(centre @ [1, 0, 2]), 1e-10)
            self.assertGreater(np.abs(centre).max(), 1)
            self.assertLess(np.abs(np.cross(found[side.loop].mean(0) - [45, 50, 5], [3, 0, 1])).max(), 1e-10)
            self.assertLess(deformer.residual, 1e-12)
            # The plane moves with its origin.
            moved = deformer.deform(self.moves, origins={"plane": [150, 150, 20]}, correct=True)
            self.assertLess(abs((moved[top.loop].mean(0) - [150, 150, 20]) @ [1, 0, 2]), 1e-10)
            self.near(moved, self.of_scene(shared, f'''rotation_mode = "{mode}"
[[edit.constraint]]
name = "plane"
origin = [150, 150, 20]'''))
            again = copy.deepcopy(deformer)
            self.same_bits(again.deform(self.moves, correct=True), found)
        free = self.deformed()[1]
        self.assertGreater(abs((free[top.loop].mean(0) - [150, 150, 0]) @ [1, 0, 2]), 1)

    def test_vertices_slide_on_a_plane(self):
        edge = self.plate.vertices_in([1, 0, 0], [299, 0, 0])
        deformer = batten.Deformer(
            self.plate, **self.settings,
            constraints={f"symmetry {v}": batten.OnPlane([v], [0, 1, 0]) for v in edge})
        found = deformer.deform({"end": batten.Move(translate=[0, 0, 60], axis=[1, 0, 0], angle=0)}, correct=True)
        self.assertLess(np.abs(found[edge, 1]).max(), 1e-10)
        self.assertGreater(found[edge, 2].max(), 10)

    def test_a_chain_equals_that_of_the_scene(self):
        chain = self.plate.crease_path([[100, 0, 0], [100, 300, 0]])
        along = self.plate.points[chain]
        self.assertLess(np.abs(np.diff(along[:, 1])).max(), 40)
        numbers = [int(v) + 1 for v in chain]
        for width, key in ((None, ""), (500, "width = 500")):
            made = batten.Chain(chain, width=width)
            found = self.deformed(rotation_mode="estimated", chains={"rib": made})[1]
            self.near(found, self.of_scene(f"[[chain]]\nname = \"rib\"\nnodes = {numbers}\n{key}\n"))
            self.assertGreater(np.abs(found - self.deformed(rotation_mode="estimated")[1]).max(), 1e-3)

        # A closed chain, and the same one through points.
        loop = self.plate.boundary_loops[0]
        found = self.deformed(rotation_mode="estimated", chains={"rim": batten.Chain(loop, closed=True)})[1]
        numbers = [int(v) + 1 for v in loop]
        self.near(found, self.of_scene(f"[[chain]]\nname = \"rim\"\nnodes = {numbers}\nclosed = true\n"))

    def test_crease_paths_follow_creases(self):
        points, triangles = grid(10)
        points[:, 2] = np.abs(points[:, 0] - 0.5)  # a crease at x = 0.5
        mesh = batten.Mesh(points, triangles)
        path = mesh.crease_path([[0.5, 0, 0], [0.5, 1, 0]])
        np.testing.assert_allclose(points[path, 0], 0.5)
        self.assertEqual(len(path), 11)
        rim = mesh.crease_path([[0, 0, 0.5], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0.5]], closed=True)
        self.assertEqual((set(rim), len(rim)), (set(mesh.boundary_loops[0]), 40))
        self.refused("through: found an array of 3", mesh.crease_path, [0, 0, 0])
        self.refused("through: found nan", mesh.crease_path, [[0, 0, math.nan]])
        self.refused("through: found a path through no vertices", mesh.crease_path, np.zeros((0, 3)))
        two = batten.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], [[0, 1, 2], [3, 4, 5]])
        self.refused("parts of the mesh that are not connected", two.crease_path, [[0, 0, 0], [5, 0, 0]])

    def test_linear_constraints(self):
        v, target = 1300, np.array([100.0, 200, 30])
        self.assertFalse(any(v in hole.vertices for hole in self.holes))
        for weight, key in ((None, ""), (0.01, "weight = 0.01")):
            pull = batten.LinearConstraint({v: 1}, target, weight=weight)
            deformer, found = self.deformed(rotation_mode="estimated", linear_constraints={"pull": pull})
            self.near(found, self.of_scene(f"""[[position_constraint]]
name = "pull"
node = {v + 1}
to = {list(target)}
{key}"""))
            gap = np.abs(found[v] - target).max()
            self.assertEqual(gap < 1e-9, weight is None)
            other = deformer.deform(self.moves, targets={"pull": target + [0, 0, 20]}, correct=True)
            self.assertGreater(other[v, 2], found[v, 2] + (19.999999 if weight is None else 0.001))
            self.same_bits(pickle.loads(pickle.dumps(deformer)).deform(self.moves, correct=True), found)

        # The distance vector of two vertices, as it is in the mesh, or rotated like the mesh.
        a, b = 900, 1300
        apart = self.plate.points[b] - self.plate.points[a]
        fixed = batten.LinearConstraint({b: 1, a: -1}, apart)
        rotated = batten.LinearConstraint({b: 1, a: -1}, apart, rotates_with=a)
        found = self.deformed(linear_constraints={"vector": fixed})[1]
        self.assertLess(np.abs(found[b] - found[a] - apart).max(), 1e-9)
        found = self.deformed(linear_constraints={"vector": rotated})[1]
        self.assertGreater(np.abs(found[b] - found[a] - apart).max(), 1)
        self.assertAlmostEqual(np.linalg.norm(found[b] - found[a]), np.linalg.norm(apart), places=9)

    def test_constraints_can_be_read_copied_and_pickled(self):
        mask = np.zeros(len(self.plate.points), bool)
        mask[[3, 5]] = True
        plane = batten.OnPlane(mask, [0, 0, 2])
        line = batten.OnLine([5, 3], [1, 0, 0], origin=[0, 1, 2])
        chain = batten.Chain([1, 2, 3], closed=True, width=4)
        row = batten.LinearConstraint({2: 0.5, 7: -1}, [1, 2, 3], weight=4, rotates_with=9)
        for copied in (copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))):
            self.assertEqual((list(copied(plane).vertices), list(copied(plane).normal), copied(plane).origin),
                             (list(mask), [0, 0, 2], None))
            self.assertEqual([list(x) for x in (copied(line).vertices, copied(line).direction, copied(line).origin)],
                             [[5, 3], [1, 0, 0], [0, 1, 2]])
            again = copied(chain)
            self.assertEqual((list(again.vertices), again.closed, again.width), ([1, 2, 3], True, 4))
            again = copied(row)
            self.assertEqual((again.coefficients, list(again.target), again.weight, again.rotates_with),
                             ({2: 0.5, 7: -1}, [1, 2, 3], 4, 9))
        self.assertEqual((batten.Chain([1, 2, 3]).width, batten.LinearConstraint({0: 1}, [0, 0, 0]).weight,
                          batten.LinearConstraint({0: 1}, [0, 0, 0]).rotates_with), (None, None, None))
        self.assertEqual(repr(plane), "<batten.OnPlane: normal (0, 0, 2)>")
        self.assertEqual(repr(line), "<batten.OnLine: direction (1, 0, 0), origin (0, 1, 2)>")
        self.assertEqual(repr(chain), "<batten.Chain of 3 vertices, closed>")
        self.assertEqual(repr(row), "<batten.LinearConstraint of 2 vertices: target (1, 2, 3)>")
        # A mask and the same indices are the same constraint.
        given = [batten.Deformer(self.plate, **self.settings, constraints={"p": batten.OnPlane(v, [0, 1, 1])})
                 for v in (mask, [3, 5])]
        self.same_bits(*(one.deform(self.moves) for one in given))

    def test_invalid_constraints_are_refused(self):
        nan = math.nan
        self.refused("normal: found length 0, expected a direction", batten.OnPlane, [0], [0, 0, 0])
        self.refused("normal: found nan", batten.OnPlane, [0], [0, 0, nan])
        self.refused("direction: found an array of 2", batten.OnLine, [0], [0, 1])
        self.refused("origin: found inf", batten.OnLine, [0], [0, 0, 1], origin=[0, math.inf, 0])
        self.refused("vertices: found no vertices", batten.OnLine, [], [0, 0, 1])
        self.refused("vertices: found -1", batten.OnLine, [-1], [0, 0, 1])
        self.refused("vertices: found a mask", batten.Chain, [True, True, False])
        self.refused("width: found 0, expected a number above 0", batten.Chain, [0, 1, 2], width=0)
        self.refused("width: found nan", batten.Chain, [0, 1, 2], width=nan)
        self.refused("coefficients: found no vertices", batten.LinearConstraint, {}, [0, 0, 0])
        self.refused("coefficients[3]: found nan", batten.LinearConstraint, {3: nan}, [0, 0, 0])
        self.refused("coefficients, vertex: found -3", batten.LinearConstraint, {-3: 1}, [0, 0, 0])
        self.refused("coefficients, vertex: found 1.5, expected a whole number from 0", batten.LinearConstraint, {1.5: 1},
                     [0, 0, 0])
        self.refused("rotates_with: found 'a', expected a whole number", batten.LinearConstraint, {1: 1}, [0, 0, 0],
                     rotates_with="a")
        self.refused("expected whole numbers from 0", batten.OnPlane, [0.5], [0, 0, 1])
        self.refused("target: found a single value", batten.LinearConstraint, {3: 1}, 5)
        self.refused("weight: found -1, expected a number above 0", batten.LinearConstraint, {3: 1}, [0, 0, 0], weight=-1)

        def made(**named):
            return batten.Deformer(self.plate, **self.settings, **named)
        many = len(self.plate.points)
        self.refused("constraint 'p': found 5, expected a batten.OnPlane or batten.OnLine", made, constraints={"p": 5})
        self.refused(f"constraint 'p': found {many}, expected 0 to {many - 1}", made,
                     constraints={"p": batten.OnPlane([many], [0, 0, 1])})
        self.refused("constraint 'p': found an array of 3 as a mask", made,
                     constraints={"p": batten.OnPlane(np.ones(3, bool), [0, 0, 1])})
        self.refused("chain 'rib': found <batten.OnPlane", made, chains={"rib": batten.OnPlane([0], [0, 0, 1])})
        self.refused("chain 'rib': found 100000, expected 0 to", made, chains={"rib": batten.Chain([0, 1, 100000])})
        self.refused("the chain 'rib': found 4 nodes, 3 of them different", made,
                     chains={"rib": batten.Chain([0, 1, 2, 0])})
        self.refused("linear constraint 'pull': found 100000, expected 0 to", made,
                     linear_constraints={"pull": batten.LinearConstraint({100000: 1}, [0, 0, 0])})
        self.refused("linear constraint 'pull', rotates_with: found 100000, expected 0 to", made,
                     linear_constraints={"pull": batten.LinearConstraint({1: 1}, [0, 0, 0], rotates_with=100000)})
        self.refused("rotation_mode: found 'nonlinar', expected one of: harmonic, estimated, dual, nonlinear; "
                     "did you mean 'nonlinear'?", made, rotation_mode="nonlinar")
        self.refused("weighting: found 'areas', expected one of: area, uniform; did you mean 'area'?", made,
                     weighting="areas")
        with self.assertRaisesRegex(TypeError, "rotation_mode"):
            made(rotation_mod="dual")

    def test_unknown_origins_and_targets_are_refused_with_the_nearest_name(self):
        deformer = batten.Deformer(self.plate, **self.settings, constraints={"rail": batten.OnLine([700], [1, 0, 0])},
                                   linear_constraints={"pull": batten.LinearConstraint({900: 1}, [0, 0, 0], weight=1)})
        self.refused("origins: found 'rails', expected a constraint's name; did you mean 'rail'?", deformer.deform, {},
                     origins={"rails": [0, 0, 0]})
        self.refused("targets: found 'pul', expected a linear constraint's name; did you mean 'pull'?", deformer.deform,
                     {}, targets={"pul": [0, 0, 0]})
        self.refused("origins 'rail': found an array of 2", deformer.deform, {}, origins={"rail": [0, 0]})
        self.refused("targets 'pull': found nan", deformer.deform, {}, targets={"pull": [0, math.nan, 0]})
        self.same_bits(np.ascontiguousarray(deformer.positions), np.ascontiguousarray(self.plate.points))

    def test_contradictory_constraints_are_named_and_change_nothing(self):
        v = self.settings["handles"]["end"][0]
        for mode in ("harmonic", "estimated"):
            deformer = batten.Deformer(self.plate, **self.settings, rotation_mode=mode,
                                       constraints={"floor": batten.OnPlane([v], [0, 0, 1])})
            kept = deformer.deform({"end": batten.Move(translate=[10, 0, 0])})
            with self.assertRaises(batten.ConflictError) as raised:
                deformer.deform({"end": batten.Move(translate=[0, 0, 5])})
            self.assertIn("floor", str(raised.exception))
            self.same_bits(np.ascontiguousarray(deformer.positions), np.ascontiguousarray(kept))


class Saliency(PropertyTests):
    def bumps(self):
        points, triangles = grid(30)
        for centre, height in (((0.3, 0.4), 0.05), ((0.7, 0.6), 0.03)):
            points[:, 2] += height * np.exp(-((points[:, :2] - centre) ** 2).sum(1) / 0.002)
        return points, triangles

    def test_saliency_is_largest_at_a_bump_and_invariant_under_rigid_motions(self):
        points, triangles = self.bumps()
        saliency = batten.Mesh(points, triangles).saliency()
        self.assertEqual((saliency.shape, saliency.dtype), ((len(points),), np.float64))
        self.assertEqual((saliency.max(), saliency.min() >= 0), (1, True))
        most = points[saliency.argmax()]
        self.assertLess(np.abs(most[:2] - [0.3, 0.4]).max(), 0.1)
        # The length scale is the diagonal of the bounding box: rotations of the axes onto each other keep it.
        moved = batten.Mesh(points[:, [1, 2, 0]] * [1, -1, -1] + [5, -7, 2], triangles)
        np.testing.assert_allclose(moved.saliency(), saliency, atol=1e-9)
        np.testing.assert_allclose(batten.Mesh(1000 * points, triangles).saliency(), saliency, atol=1e-9)
        np.testing.assert_array_equal(batten.Mesh(*grid(4)).saliency(), np.zeros(25))  # a plane

    def test_suggested_features_are_the_proposals_of_a_scene(self):
        file = example("11-panel", "panel.bdf")
        panel = batten.read_mesh(file)
        features = panel.suggested_features()
        self.assertEqual([one.name for one in features if one.kind == "hole"], [hole.name for hole in panel.holes()])
        for hole, one in zip(panel.holes(), features):
            self.assertEqual((list(one.vertices), list(one.loop)), (list(hole.vertices), list(hole.loop)))
            self.assertEqual((one.radius, one.equivalent_radius, list(one.centre), list(one.axis)),
                             (hole.radius, hole.equivalent_radius, list(hole.centre), list(hole.axis)))
        self.assertIn("crease", [one.kind for one in features])
        text = subprocess.run([os.environ["BATTEN_PROGRAM"], "info", file], capture_output=True, text=True).stdout
        for one in features:
            self.assertIn(f"feature '{one.name}': {len(one.vertices)} nodes", text)
            self.assertIn("'%s': radius " % one.name, repr(one))
            self.assertTrue(set(one.loop) <= set(one.vertices))
        self.assertEqual(text.count("feature '"), len(features))
        outlines = panel.suggested_features(outer_loops=True)
        self.assertGreater(len(outlines), len(features))
        self.assertLess(sum(one.kind == "crease" for one in panel.suggested_features(crease_angle=170)),
                        sum(one.kind == "crease" for one in features))

    def test_invalid_options_are_refused(self):
        mesh = batten.Mesh(*grid(4))
        for named, words in (({"crease_angle": 0}, "crease_angle: found 0, expected degrees above 0 and below 180"),
                             ({"crease_angle": math.nan}, "crease_angle: found nan"),
                             ({"flange_rings": 0}, "flange_rings: found 0, expected 1 or more"),
                             ({"flange_width": -1}, "flange_width: found -1, expected a number from 0"),
                             ({"flange_width": math.inf}, "flange_width: found inf")):
            with self.assertRaises(batten.InputError) as raised:
                mesh.suggested_features(**named)
            self.assertIn(words, str(raised.exception))


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

    def test_groups_are_holes_or_features(self):
        mesh, by_dict = self.plate()
        moves = {"end": batten.Move(translate=[-40, 0, 110], axis=[0, -1, 0], angle=75)}
        named = {"fixed": mesh.vertices_in([0, 0, 0], [0, 300, 0]),
                 "handles": {"end": mesh.vertices_in([300, 0, 0], [300, 300, 0])}}
        for features in (mesh.holes(), mesh.suggested_features(), iter(mesh.holes())):
            self.same_bits(batten.Deformer(mesh, features=features, **named).deform(moves), by_dict.deform(moves))
        for wrong in ([5], "hole-1", 3):
            self.refused("expected a dict {name: vertices}, or a list of holes or features", batten.Deformer, mesh,
                         features=wrong, **named)

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
