# SPDX-License-Identifier: MPL-2.0
"""Stress analysis in memory: the results of the program, arrays at the points, messages."""

import json
import unittest

from properties import PropertyTests, batten, example, np, run_program

SWELL = '[[load]]\nname = "swell"\ntype = "pressure"\nvalue = 0\n'
STEEL = {"material": "steel", "thickness": 1, "supports": ["left", {"curve": "right", "type": "pinned"}]}


def vault(settings=SWELL):
    t = np.linspace(0, 1, 9)
    rise = 60 * t * (1 - t)
    return batten.skin(
        {"front": np.c_[100 * t, 0 * t, rise], "right": [[100, 0, 0], [100, 100, 0]],
         "back": np.c_[100 - 100 * t, 0 * t + 100, rise], "left": [[0, 100, 0], [0, 0, 0]]},
        edge_length=20, name="vault", settings=settings)


class InMemory(PropertyTests):
    def test_the_program_gives_the_same_results(self):
        both = 'combinations = [{name = "both", cases = ["loads", "push"], factors = [1.35, 1.5]}]'
        push = {"case": "push", "force": [0, 0, -20], "point": [50, 50, 15]}
        stress = batten.stress(vault(), **STEEL, yield_stress=235, modes=2, buckling=1,
                               loads=[{"pressure": -0.01}, push], settings=both)
        with open(self.file("scene.toml"), "w") as scene:
            scene.write(stress.scene)
        self.assertIn(run_program("stress", "--accuracy", "0", self.file("scene.toml"), "--out", self.file("out")), (0, 4))
        with open(self.file("out/report.json")) as report:
            self.assertEqual(json.load(report)["stress"], stress.report)
        self.assertEqual([case.name for case in stress.cases], ["loads", "push", "both"])
        # By the scene file, from Python.
        report = batten.stress(self.file("scene.toml"), self.file("again"), accuracy=0)
        self.assertEqual(report["stress"], stress.report)
        self.assertEqual(batten.stress(batten.load(self.file("scene.toml"))).report, stress.report)

    def test_the_stress_of_a_scene(self):
        stress = batten.stress(batten.load(example("18-lean", "scene.toml")))
        self.assertEqual(len(stress.frequencies), 4)
        self.assertTrue((np.diff(stress.frequencies) > 0).all())
        self.assertAlmostEqual(stress.load_case("lean").force[1], -100, places=6)
        governing = stress.load_case()
        self.assertEqual(governing.max_von_mises, stress.max_von_mises)
        self.assertEqual(governing.safety_factor, 180 / governing.max_von_mises)
        self.assertIn(governing.name, repr(stress))
        self.assertIn(governing.name, repr(governing))

    def test_laminates_and_temperatures(self):
        carbon = {"young": [140e3, 10e3], "shear_modulus": 5e3, "poisson": 0.3, "material_direction": [1, 0, 0],
                  "expansion": [-0.5e-6, 30e-6], "layup": "[0/90]s", "ply_thickness": 0.25,
                  "strength": {"tension": [1500, 50], "compression": [1200, 250], "shear": 70}}
        loads = [{"pressure": -1e-3}, {"case": "hot", "temperature": 100}, {"case": "hot", "temperature_difference": "x / 10"}]
        stress = batten.stress(vault(), material=carbon, supports=["left", "right"], loads=loads)
        one = stress.load_case("hot")
        self.assertEqual(sorted(one.reserve_factors), ["Hoffman", "Tsai-Hill"])
        self.assertIn(one.stress_ply, (1, 2, 3, 4))
        plies = stress.at([50, 50, 15], case="hot").ply_stresses
        self.assertEqual(plies.shape, (8, 3))
        self.assertAlmostEqual(stress.thickness[0], 1)
        # Plies of one isotropic material are that material.
        steel = batten.stress(vault(), material="steel", thickness=1, supports=["left", "right"], loads=loads[:1])
        plies = batten.stress(vault(), material={"plies": 4 * [{"material": "steel", "thickness": 0.25}]},
                              supports=["left", "right"], loads=loads[:1])
        self.assertAlmostEqual(plies.max_displacement / steel.max_displacement, 1, places=9)
        self.assertAlmostEqual(plies.max_von_mises / steel.max_von_mises, 1, places=6)
        with self.assertRaisesRegex(batten.InputError, "did you mean 'layup'"):
            batten.stress(vault(), material={"layups": "[0]"}, supports=["left"], loads=loads)

    def test_gradients_of_laminates_and_temperatures(self):
        carbon = {"young": [140e3, 10e3], "shear_modulus": 5e3, "poisson": 0.3, "material_direction": [1, 0, 0],
                  "expansion": [-0.5e-6, 30e-6], "layup": "[0/45]", "ply_thickness": 0.5, "density": 1.6e-9}
        settings = 'reference_surface = "bottom"\nstiffeners = [{ curve = "front", rectangle = [2, 6], material = "aluminium" }]'

        def analysed(swell):
            return batten.stress(vault().with_values({"swell": swell}), material=carbon, supports=["left", "right"], settings=settings,
                                 loads=[{"temperature": 50}, {"traction": [0, 0, -1e-3]}])

        found, h = analysed(1).gradients(), 1e-2
        up, down = analysed(1 + h).gradients(), analysed(1 - h).gradients()
        for name in ("compliance", "von_mises_norm", "mass"):
            difference = (getattr(up, name).value - getattr(down, name).value) / (2 * h)
            self.assertLess(abs(getattr(found, name).gradient["swell"] - difference), 2e-3 * abs(difference), name)

    def test_arrays_are_views_of_the_values_at_the_points(self):
        model = vault()
        stress = batten.stress(model, **STEEL, loads={"pressure": -0.01}, modes=1)
        values, moves, mode = stress.von_mises(), stress.displacement(), stress.mode_shape(0)
        self.assertEqual(values.shape, (len(model.points),))
        self.assertEqual(moves.shape, model.points.shape)
        self.assertEqual(mode.shape, model.points.shape)
        self.assertAlmostEqual(np.linalg.norm(mode, axis=1).max(), 1)
        for array in (values, moves, mode):
            self.assertFalse(array.flags.writeable)
        self.assertEqual(values.ctypes.data, stress.von_mises(case="loads").ctypes.data)
        case = stress.load_case("loads")
        self.assertLessEqual(np.linalg.norm(moves, axis=1).max(), 1.05 * case.max_displacement)
        at = stress.at(case.displacement_at)
        np.testing.assert_allclose(at.displacement, case.displacement, rtol=1e-6, atol=1e-9)
        for i in range(0, len(values), 41):
            p = stress.at(model.points[i])
            self.assertAlmostEqual(max(p.von_mises_top, p.von_mises_bottom), values[i], delta=1e-4 * values.max())
            self.assertEqual(p.forces.shape, (3, 3))
            np.testing.assert_allclose(p.moments, p.moments.T, atol=1e-9 * abs(p.moments).max())
        del stress, model, case
        self.assertGreater(values.max(), 0)  # an array keeps its memory
        self.assertLess(moves[:, 2].min(), 0)

    def test_reactions_balance_the_loads(self):
        case = batten.stress(vault(), **STEEL, loads=[{"traction": [0.01, 0.02, -0.03]}]).load_case()
        self.assertEqual(set(case.reactions), {"clamped left", "pinned right"})
        force = sum(force for force, _ in case.reactions.values())
        np.testing.assert_allclose(force, -case.force, rtol=0, atol=1e-6 * np.linalg.norm(case.force))

    def test_variants_of_a_model(self):
        model = vault()
        most = [batten.stress(model, **STEEL, loads=[{"pressure": -0.01}], values={"swell": swell})
                for swell in (0, 5, 10)]
        self.assertEqual(len({stress.max_displacement for stress in most}), 3)
        again = batten.stress(model.with_values({"swell": 5}), **STEEL, loads=[{"pressure": -0.01}])
        self.assertEqual(again.report, most[1].report)
        self.assertEqual(again.model.parameters["swell"], 5)
        # The arguments replace the [stress] of the model.
        replaced = batten.stress(batten.parse(again.scene), **dict(STEEL, thickness=2), loads=[{"pressure": -0.01}])
        self.assertLess(replaced.max_displacement, again.max_displacement)

    def test_values_of_numpy_and_python_are_the_same(self):
        model = vault()
        plain = batten.stress(model, material={"young": 70000, "poisson": 0.3, "density": 2.7e-9}, thickness=2,
                              supports=[{"curve": "left", "rotation": True}, {"point": [100, 50, 0]}],
                              loads=[{"gravity": [0, 0, -9810]}])
        numpy = batten.stress(model, material={"young": np.int32(70000), "density": np.float64(2.7e-9)},
                              thickness=np.float32(2),
                              supports=({"curve": np.str_("left"), "rotation": np.bool_(True)},
                                        {"point": np.array([100, 50, 0])}),
                              loads=({"gravity": (0, 0, np.int64(-9810))},))
        self.assertEqual(plain.report, numpy.report)

    def test_progress_can_stop_it(self):
        def stop(stage, fraction):
            raise KeyError(stage)
        with self.assertRaises(KeyError):
            batten.stress(vault(), **STEEL, progress=stop)


class Messages(PropertyTests):
    def refused(self, words, **changes):
        with self.assertRaisesRegex(batten.InputError, words):
            batten.stress(self.model, **dict(STEEL, **changes))

    def test_the_argument_is_named(self):
        self.model = vault()
        self.refused(r"supports\[1\]: found the curve 'rihgt'.*did you mean 'right'", supports=["left", "rihgt"])
        self.refused(r"supports\[0\]: found 3, expected the name of a curve", supports=[3])
        self.refused(r"supports\[0\]\.curve: found None", supports=[{"curve": None}])
        self.refused(r"supports: found \{'left'\}", supports={"left"})
        self.refused(r"loads\[0\]: found 'left', expected a dict", loads=["left"])
        self.refused(r"loads\[0\]\.pressure: found nan", loads=[{"pressure": float("nan")}])
        self.refused(r"loads\[0\]\.force\[2\]: found", loads=[{"force": [0, 0, object()], "point": [50, 50, 15]}])
        self.refused(r"loads\[0\].*found key 'presure'.*did you mean 'pressure'", loads=[{"presure": 1}])
        self.refused(r"material: .*did you mean 'steel'", material="stel")
        self.refused(r"material: found the key 'yuong'.*did you mean 'young'", material={"yuong": 1})
        self.refused(r"material: found 3", material=3)
        self.refused(r"thickness: .*above 0", thickness=-1)
        self.refused(r"found no 'thickness'", thickness=None)
        self.refused(r"yield", yield_stress=-1)
        self.refused(r"modes", modes=-1)
        self.refused(r"settings:1:\d+: found the curve 'lid'", settings='hinges = ["lid"]')
        self.refused(r"out: ", out=self.folder)
        self.refused(r"accuracy: found -1, expected", accuracy=-1)
        self.refused(r"accuracy: found nan", accuracy=float("nan"))
        endless = []
        endless.append(endless)
        self.refused(r"nested", loads=[{"force": endless}])
        with self.assertRaisesRegex(batten.InputError, r"found no \[stress\]"):
            batten.stress(self.model)
        with self.assertRaisesRegex(batten.InputError, "did you mean 'loads'"):
            batten.stress(self.model, **STEEL, loads=[{"pressure": 1}]).von_mises(case="load")

    def test_free_motions_are_named(self):
        with self.assertRaisesRegex(batten.NoSolutionError, "the whole model can rotate"):
            batten.stress(vault(), **dict(STEEL, supports=[{"point": [0, 0, 0]}]))

    def test_a_scene_file_needs_a_folder_and_no_settings(self):
        scene = example("18-lean", "scene.toml")
        with self.assertRaisesRegex(batten.InputError, "out: "):
            batten.stress(scene)
        with self.assertRaisesRegex(batten.InputError, "thickness: "):
            batten.stress(scene, self.folder, thickness=1)


if __name__ == "__main__":
    unittest.main()
