# SPDX-License-Identifier: MPL-2.0
"""Python and the program give the same bits."""

import json
import os
import unittest

from properties import PropertyTests, batten, example, np, run_program


def bytes_of(file):
    with open(file, "rb") as read:
        return read.read()


class SameBits(PropertyTests):
    def scene_agrees(self, scene):
        self.assertIn(run_program("run", scene, "--out", self.folder), (0, 4))
        name = next(file for file in os.listdir(self.folder) if file.endswith(".vtp"))
        model = batten.load(scene)
        self.same_bits(model.points, batten.read_mesh(self.file(name)).points)
        return model, name

    def test_a_region_under_pressure(self):
        model, name = self.scene_agrees(example("05-door", "scene.toml"))
        model.save(self.file("again.vtp"))
        self.same_bits(batten.read_mesh(self.file("again.vtp")).points, model.points)

    def test_a_network(self):
        self.scene_agrees(example("09-mouse", "scene.toml"))

    def test_a_drag(self):
        scene = example("05-door", "scene.toml")
        with open(self.file("drag.txt"), "w") as script:
            script.write(f"open {scene}\nslide swell 250\nupdate\nslide swell 180\nupdate\nsolve\n"
                         f"export {self.file('drag.vtp')}\n")
        self.assertIn(run_program("run-script", self.file("drag.txt")), (0, 4))
        session = batten.Session(scene)
        for value in (250, 180):
            session["swell"] = value
            session.update()
        session.solve()
        self.same_bits(session.model().points, batten.read_mesh(self.file("drag.vtp")).points)
        session.model().save(self.file("python.vtp"))
        self.assertEqual(bytes_of(self.file("python.vtp")), bytes_of(self.file("drag.vtp")))

    def test_a_deform_scene(self):
        scene = example("11-panel", "edit.toml")
        self.assertIn(run_program("deform", scene, "--out", self.file("program")), (0, 4))
        batten.deform(scene, self.file("python"))
        decks = [file for file in os.listdir(self.file("program")) if file.endswith((".bdf", ".inp"))]
        self.assertTrue(decks)
        for deck in decks:
            self.assertEqual(bytes_of(self.file("program/" + deck)), bytes_of(self.file("python/" + deck)))

    def reports_agree(self, python, key):
        with open(self.file("program/report.json")) as report:
            self.assertEqual(json.load(report)[key], python[key])

    def test_stresses(self):
        scene = example("18-lean", "scene.toml")
        self.assertIn(run_program("stress", scene, "--out", self.file("program")), (0, 4))
        self.reports_agree(batten.stress(scene, self.file("python")), "stress")

    def test_a_sequence(self):
        scene = example("29-forming", "forming.toml")
        self.assertIn(run_program("sequence", scene, "--out", self.file("program")), (0, 4))
        batten.sequence(scene, self.file("python"))  # with pictures only if there is a display
        for folder, _, files in os.walk(self.file("program")):
            for file in files:
                if not file.endswith((".json", ".png", ".gif")):
                    at = os.path.join(folder, file)
                    self.assertEqual(bytes_of(at), bytes_of(at.replace(self.file("program"), self.file("python"))))

    def test_lines_alone_are_made_fair(self):
        scene = example("04-fairing", "scene.toml")
        self.assertIn(run_program("run", scene, "--out", self.file("program")), (0, 4))
        batten.run(scene, self.file("python"))
        written = [f for f in os.listdir(self.file("program")) if not f.endswith((".json", ".png", ".step"))]
        self.assertTrue(written)
        for file in written:
            self.assertEqual(bytes_of(os.path.join(self.file("program"), file)),
                             bytes_of(os.path.join(self.file("python"), file)))

    def test_lines_as_arrays_and_as_text(self):
        lines = {"a": [[0, 0, 0], [1, 0, 0.1]], "b": [[1, 0, 0.1], [1, 1, 0]], "c": [[1, 1, 0], [0, 0, 0]]}
        text = 'unit = "mm"\n\n' + "".join(
            f'[[curve]]\nname = "{name}"\npoints = {points}\n' for name, points in lines.items())
        self.same_bits(batten.skin(lines).points, batten.parse(text).points)

    def test_values(self):
        scene = example("05-door", "scene.toml")
        self.same_bits(batten.load(scene).with_values({"swell": 100}).points,
                       batten.load(scene, values={"swell": 100}).points)


if __name__ == "__main__":
    unittest.main()
