# SPDX-License-Identifier: MPL-2.0
"""Sequences: arrays, files, edits that give the bits of `batten sequence`, and the words of refusals."""

import copy
import os
import pickle
import re
import tomllib
import unittest

from properties import PropertyTests, batten, example, grid, np, run_program


def swing(frames=9, n=6):
    """A square sheet that swings: frames k×n×3 and quads."""
    points, _ = grid(n)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a = i * (n + 1) + j
    quads = np.column_stack([a, a + n + 1, a + n + 2, a + 1])
    t = np.linspace(0, 2 * np.pi, frames)
    moved = np.repeat(points[None], frames, axis=0)
    moved[:, :, 2] += 0.2 * np.sin(t)[:, None] * points[None, :, 0] ** 2
    return moved, quads


def edits_of(text):
    """A scene without [sequence], [output] and [[picture]]."""
    parts = re.split(r"(?m)^(?=\[)", text)
    return "".join(part for part in parts if not re.match(r"\[\[?(sequence|output|picture)\b", part))


class Frames(PropertyTests):
    def test_arrays(self):
        frames, quads = swing()
        s = batten.Sequence(frames, quads)
        self.assertEqual(len(s), 9)
        for k, frame in enumerate(s):
            self.same_bits(np.ascontiguousarray(frame), frames[k])
        self.same_bits(s[-1], s[8])
        np.testing.assert_array_equal(s.times, np.arange(1, 10))
        self.assertEqual(s.faces, [tuple(q) for q in quads.tolist()])
        self.assertFalse(s[0].flags.writeable)
        self.assertEqual((s.report, s.warnings, s.failed_checks), ({}, [], []))
        with self.assertRaises(IndexError):
            s[9]
        timed = batten.Sequence(list(frames), [list(q) for q in quads], times=np.linspace(0, 1, 9))
        np.testing.assert_array_equal(timed.times, np.linspace(0, 1, 9))
        same = batten.Sequence(frames, s.mesh(3))
        self.assertEqual(same.faces, s.faces)
        self.same_bits(s.mesh(3).points, s[3])

    def test_an_array_outlives_its_sequence(self):
        frames, quads = swing()
        last = batten.Sequence(frames, quads)[8]
        self.same_bits(np.ascontiguousarray(last), frames[8])

    def test_refusals(self):
        frames, quads = swing()
        bad = frames.copy()
        bad[2, 5, 1] = np.nan
        for given, words in (((bad, quads), r"frames\[2\]"), (([frames[0], frames[1][:-1]], quads), "frame 2 has"),
                             (([], quads), "frames: found none"), ((frames[0], quads), r"frames\[0\]"),
                             ((frames, quads + 1000), "faces: found"), ((3, quads), "frames: found 3"),
                             ((frames, quads, [1, 2]), "times: found 2, expected 9"),
                             ((frames, quads, [1, 2, 3, 3, 5, 6, 7, 8, 9]), "time that is not after"),
                             ((frames, quads, np.full(9, np.nan)), "times")):
            with self.subTest(words), self.assertRaisesRegex(batten.InputError, words):
                batten.Sequence(*given)

    def test_files(self):
        frames, quads = swing()
        s = batten.Sequence(frames, quads)
        files = s.save(self.file("out/f_*.vtp"))
        self.assertEqual(len(files), 9)
        back = batten.read_sequence(self.file("out/f_*.vtp"))
        for a, b in zip(back, s):
            self.same_bits(a, b)
        self.assertEqual(back.faces, s.faces)
        for name in ("s.pc2", "s.mdd", "s.pvd", "s.glb"):
            with self.subTest(name):
                written = s.save(self.file(name))
                self.assertTrue(all(os.path.isfile(file) for file in written))
                again = batten.read_sequence(self.file(name), frames_per_second=0)
                self.assertEqual(len(again), 9)
                if name != "s.glb":
                    np.testing.assert_allclose(np.stack(list(again)), frames, atol=1e-6)
        s.save(self.file("slow.glb"), frames_per_second=2)
        self.assertAlmostEqual(batten.read_sequence(self.file("slow.glb"), frames_per_second=0).times[-1], 4)
        part = batten.read_sequence(self.file("s.pc2"), first=3, last=5)
        np.testing.assert_allclose(part[0], frames[2], atol=1e-6)
        with self.assertRaisesRegex(batten.InputError, "xyz"):
            s.save(self.file("s.xyz"))
        with self.assertRaisesRegex(batten.InputError, "frames_per_second: found 0"):
            s.save(self.file("s.glb"), frames_per_second=0)

    def test_copies(self):
        walk = batten.read_sequence(example("24-stairs", "walker.pc2"))
        hand = walk.mesh().vertices_in([-1, 0.2, 0.5], [1, 1, 0.85])
        edited = walk.filter("low", handles={"hand": hand}, sigma=1)
        self.assertIs(copy.copy(edited), edited)
        self.assertIs(copy.deepcopy(edited), edited)
        back = pickle.loads(pickle.dumps(edited))
        for a, b in zip(back, edited):
            self.same_bits(a, b)
        self.assertEqual((back.faces, back.report, back.warnings), (edited.faces, edited.report, edited.warnings))
        np.testing.assert_array_equal(back.times, edited.times)
        self.assertTrue(back.report["handles"])


class Edits(PropertyTests):
    def program_frames(self, text, folder):
        """The frames that the program makes of a scene."""
        scene = re.sub(r"(?m)^file = \"(.*?)\"", lambda m: f'file = "{example(folder, m[1])}"', text)
        scene = re.sub(r"\{ file = \"(.*?)\"", lambda m: f'{{ file = "{example(folder, m[1])}"', scene)
        parts = re.split(r"(?m)^(?=\[)", scene)
        scene = "".join(part for part in parts if not re.match(r"\[\[?(output|picture)\b", part))
        with open(self.file("scene.toml"), "w") as out:
            out.write(scene + '\n[output]\nframes = "frames/f_*.vtp"\n')
        self.assertIn(run_program("sequence", self.file("scene.toml"), "--out", self.file("out")), (0, 4))
        return batten.read_sequence(self.file("out/frames/f_*.vtp"))

    def same_frames(self, a, b):
        self.assertEqual(len(a), len(b))
        for p, q in zip(a, b):
            self.same_bits(p, q)

    def scene(self, folder, name, change=lambda text: text):
        """A scene as text, its input, and its result."""
        with open(example(folder, name)) as file:
            text = change(file.read())
        source = tomllib.loads(text)["sequence"]["file"]
        return text, batten.read_sequence(example(folder, source)), self.program_frames(text, folder)

    def test_keyframes_and_features(self):
        text, input, made = self.scene("29-forming", "forming.toml")
        edited = input.edited(edits_of(text))
        self.same_frames(edited, made)
        self.assertEqual(edited.failed_checks, [])
        self.assertTrue(edited.report["features"])
        mesh = input.mesh()
        left, right = mesh.points[:, 0] <= 7, mesh.points[:, 0] >= 210
        holes = {hole.name: hole.vertices for hole in mesh.holes()}
        typed = input.keyframes({20: {"left edge": batten.Move(translate=[-10, 0, 0])}}, handles={"left edge": left},
                                features=holes, fixed=right, influence=[0, 20])
        self.same_frames(typed, made)

    def test_feet_on_stairs(self):
        text, input, made = self.scene("24-stairs", "stairs.toml", lambda text: text.replace("cycles = 5", "cycles = 2"))
        self.same_frames(input.edited(edits_of(text), folder=example("24-stairs")), made)
        operations = tomllib.loads(text)["operation"]
        operations[1]["terrain"] = {"file": "steps"}
        points = input.mesh().points
        low = points[:, 2] <= 0.08
        edited = input.edited(operations=operations, meshes={"steps": batten.read_mesh(example("24-stairs", "stairs.obj"))},
                              handles={"left foot": low & (points[:, 1] >= 0), "right foot": low & (points[:, 1] <= 0)})
        self.same_frames(edited, made)
        self.assertEqual(edited.failed_checks, [])
        self.assertLess(max(foot["foot_skate"] for foot in edited.report["foot_plants"]), 1e-3)

    def test_a_filter(self):
        text, input, made = self.scene("27-cartoon", "cartoon.toml")
        self.same_frames(input.edited(edits_of(text)), made)
        mesh = input.mesh()
        select = {s["name"]: mesh.vertices_in(*s["box"]) for s in tomllib.loads(text)["select"]}
        typed = input.filter("cartoon", handles=select, sigma=2.5, amount=1, feet=["left foot", "right foot"],
                             contact_detection={"distance": 0.02, "min_frames": 4},
                             parents={"head": "hips", "left hand": "hips", "right hand": "hips"})
        self.same_frames(typed, made)

    def test_a_mix(self):
        text, input, made = self.scene("26-flag", "flag.toml")
        walk = batten.read_sequence(example("24-stairs", "walker.pc2"))
        points, other = input.mesh().points, walk.mesh()
        corners = {side + " corner": np.linalg.norm(points - [0, y, 0], axis=1) <= 0.11
                   for side, y in (("left", 0.8), ("right", -0.8))}
        hands = {"left corner": other.vertices_in([-1, 0.2, 0.5], [1, 1, 0.85]),
                 "right corner": other.vertices_in([-1, -1, 0.5], [1, -0.2, 0.85])}
        typed = input.mix(walk, hands, handles=corners, rotations=False, align="translate", iterations=200)
        self.same_frames(typed, made)

    def test_a_morph(self):
        text, input, made = self.scene("28-morph", "morph.toml")
        landmarks = [(pair["from"], pair["to"]) for pair in tomllib.loads(text)["operation"][0]["landmark"]]
        fish = batten.read_sequence(example("28-morph", "fish.pc2"))
        typed = input.morph(fish, interval=[6, 18], target_interval=[6, 18], landmarks=landmarks)
        self.same_frames(typed, made)
        self.assertTrue(any("fitted to the target" in words for words in typed.warnings))
        self.same_bits(typed[0], input[0])

    def test_a_morph_of_a_part(self):
        frames, quads = swing()
        s = batten.Sequence(frames, quads)
        other = batten.Sequence(frames + [3, 0, 0], quads)
        whole = s.morph(other, align={"translate": [-3, 0, 0]})
        np.testing.assert_allclose(np.stack(list(whole)), frames, atol=1e-9)
        part = s.edited(operations=[{"type": "morph", "target": {"file": "other", "frames": [2, 9]}}],
                        sequences={"other": other})
        alone = s.edited(operations=[{"type": "morph", "target": {"file": "other"}}],
                         sequences={"other": batten.Sequence(frames[1:] + [3, 0, 0], quads)})
        self.same_frames(part, alone)

    def test_nothing_changes_without_an_operation(self):
        frames, quads = swing()
        s = batten.Sequence(frames, quads)
        self.same_frames(s.edited('name = "none"'), s)

    def test_handles_follow_their_moves(self):
        frames, quads = swing()
        s = batten.Sequence(frames, quads)
        points = s.mesh().points
        start, end = points[:, 0] == 0, points[:, 0] == 1
        turn = batten.Move(translate=[0, 0, 0.5], axis=[0, 1, 0], angle=-30, about=[0.5, 0, 0])
        edited = s.keyframes({3: {"end": turn}}, handles={"end": end}, fixed=start, influence=[0, 8])
        angle = np.radians(-30)
        rotation = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        wanted = (s[3][end] - [0.5, 0, 0]) @ rotation.T + [0.5, 0, 0.5]
        np.testing.assert_allclose(edited[3][end], wanted, atol=1e-12)
        np.testing.assert_array_equal(edited[3][start], s[3][start])
        self.same_bits(edited[0], s[0])
        self.same_bits(edited[8], s[8])

    def test_refusals(self):
        frames, quads = swing()
        s = batten.Sequence(frames, quads)
        end = s.mesh().points[:, 0] == 1
        move, handles = batten.Move(translate=[0, 0, 1]), {"end": end}
        filter = {"type": "filter", "filter": "low", "handles": ["end"]}
        for action, words in (
                (lambda: s.keyframes({4: {"right edn": move}}, handles={"right end": end}),
                 r"^keyframes\(\): found the handle 'right edn'.*did you mean 'right end'"),
                (lambda: s.keyframes({9: {"end": move}}, handles=handles), r"moves\[9\].*expected 0 to 8"),
                (lambda: s.keyframes({}, handles=handles), "found no keyframes"),
                (lambda: s.keyframes({4: {"end": batten.Move(scale=2)}}, handles=handles), "scale: found 2"),
                (lambda: s.keyframes({4: {"end": 3}}, handles=handles), r"moves\[4\]\['end'\]: found 3"),
                (lambda: s.keyframes({4: {"end": move}}, handles=handles, influence=[5, 2]), "influence: found"),
                (lambda: s.filter("low", handles=handles, simga=2), r"^filter\(\): found key 'simga'.*'sigma'"),
                (lambda: s.filter("carton", handles=handles), r"^filter\(\): found .*carton.*did you mean 'cartoon'"),
                (lambda: s.filter("low", handles=handles, sigma=float("nan")), r"sigma: found nan"),
                (lambda: s.filter("low", handles={}), "handles: found none"),
                (lambda: s.filter("low", handles={"end": [999]}), r"handles\['end'\].*found 999"),
                (lambda: s.filter("low", handles={"end": []}), "handle 'end': found no vertices"),
                (lambda: s.filter("low", handles=handles, parents={"end": "hip"}), "parents: found the handle 'hip'"),
                (lambda: s.filter("low", handles=handles, features=handles), "feature 'end': found the name twice"),
                (lambda: s.mix(s, {"end": [1000]}, handles=handles), r"source_vertices\['end'\]"),
                (lambda: s.morph(s, interval=[0, 30]), r"^morph\(\): "),
                (lambda: s.morph(s, landmarks=[1]), r"landmarks\[0\]: found 1"),
                (lambda: s.morph(s, up="w"), "up: found 'w'"),
                (lambda: s.edited(operations=[filter, dict(filter, name="b", sigma=-1)], handles=handles),
                 r"^edited\(\): operations\[1\]: .*sigma"),
                (lambda: s.edited(operations=[3]), r"operations\[0\]: found 3"),
                (lambda: s.edited('up = "z"\n\n[[handel]]\nname = "a"'), r"^edited\(\):3:.*'handel'.*'handle'"),
                (lambda: s.edited('[sequence]\nfile = "a"'), "found key 'sequence'"),
                (lambda: s.edited(operations=[{"type": "morph", "target": {"file": "fsh"}}], sequences={"fish": s}),
                 r"operations\[0\]: found the sequence 'fsh'.*did you mean 'fish'"),
                (lambda: s.edited("", sequences={"fish": 3}), r"sequences\['fish'\]: found 3, expected a Sequence"),
                (lambda: s.edited(""), "expected edits of a sequence")):
            with self.subTest(words), self.assertRaisesRegex(batten.InputError, words):
                action()

    def test_progress_stops_an_edit(self):
        walk = batten.read_sequence(example("24-stairs", "walker.pc2"))
        hand = walk.mesh().vertices_in([-1, 0.2, 0.5], [1, 1, 0.85])

        def stop(stage, fraction):
            raise RuntimeError("enough")
        with self.assertRaisesRegex(RuntimeError, "enough"):
            walk.filter("low", handles={"hand": hand}, progress=stop)


if __name__ == "__main__":
    unittest.main()
