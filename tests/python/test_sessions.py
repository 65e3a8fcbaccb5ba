# SPDX-License-Identifier: MPL-2.0
"""Sessions: undo, parameters as a mapping, conflicts, threads, and interruption of long calls."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest

from properties import PropertyTests, batten, example, np, run_program, saddle


def session_of(edge_length=None):
    session = batten.Session(batten.skin(saddle(), edge_length=edge_length))
    session.add_pressure("swell", min=-500, max=500)
    session.add_parameter("double")
    session.add_force("push", at=[0.5, 0.5, 0.2], direction=[0, 0, 1])
    return session


def shell_model():
    """A vault of 100 by 100 with a pressure."""
    arc = np.linspace(0, 1, 9)
    front = np.c_[100 * arc, 0 * arc, 80 * arc * (1 - arc)]
    return batten.skin({"front": front, "right": [[100, 0, 0], [100, 100, 0]],
                        "back": front[::-1] + [0, 100, 0], "left": [[0, 100, 0], [0, 0, 0]]}, edge_length=20,
                       settings='[[load]]\nname = "swell"\ntype = "pressure"\nvalue = 0\nmin = -50\nmax = 50')


def drag(session, seed, answers=30):
    """Frames of a random drag."""
    frames = []
    for value in np.random.default_rng(seed).uniform(-20, 20, answers):
        session["swell"] = value
        session["push"] = value / 10
        session.update()
        frames.append(session.points.copy())
    session.solve()
    frames.append(session.points.copy())
    return frames


class Sessions(PropertyTests):
    def test_undo_gives_the_same_bits(self):
        session = session_of()
        before, dofs = session.points.copy(), session.dofs
        session["swell"] = 20
        session.solve()
        after = session.points.copy()
        self.assertGreater(np.abs(after - before).max(), 1e-3)
        self.assertTrue(session.undo())
        self.same_bits(session.points, before)
        self.same_bits(session.dofs, dofs)
        self.assertEqual(session["swell"], 0)
        self.assertTrue(session.redo())
        self.same_bits(session.points, after)
        self.assertEqual(session["swell"], 20)

    def test_undo_stops_at_the_model(self):
        session = batten.Session(example("05-door", "scene.toml"))
        names, parameters, dofs = session.names, session.parameters, session.dofs
        self.assertIn("swell", names)
        self.assertFalse(session.undo())
        self.assertFalse(session.redo())
        for i in range(210):
            session["swell"] = 6 + 0.1 * (i + 1)
            session.solve()
        end = session.dofs
        for _ in range(210):
            self.assertTrue(session.undo())
        self.assertFalse(session.undo())
        self.assertEqual((session.names, session.parameters), (names, parameters))
        self.same_bits(session.dofs, dofs)
        while session.redo():
            pass
        self.same_bits(session.dofs, end)
        # A session of its model begins there.
        again = batten.Session(session.model())
        self.assertFalse(again.undo())
        self.same_bits(again.dofs, end)

    def test_points_of_a_session_can_be_held(self):
        for model in (batten.skin(saddle()), batten.load(example("09-mouse", "scene.toml"))):
            session = batten.Session(model)
            before = session.points.astype(float)
            low, high = model.bounds
            size = np.linalg.norm(np.subtract(high, low))
            for i in range(0, len(before), len(before) // 60):
                for point in (before[i], session.points[i], np.round(before[i], 6)):
                    session.add_point_constraint("pin", at=point)
                    self.assertLess(session.residual, 1e-10)
                    self.assertLess(np.abs(session.points - before).max(), 1e-5 * size)
                    self.assertTrue(session.undo())
        session, corner = session_of(), np.array(saddle()["front"][0], float)
        session.add_point_constraint("pin", at=corner + 5e-7)
        with self.assertRaises(batten.ConflictError) as raised:
            session.add_point_constraint("off", at=corner, target=corner + [0, 0, 1e-4])
        self.assertAlmostEqual(raised.exception.conflicts[0][1], 1e-4, 6)

    def test_parameters_are_a_mapping(self):
        session = session_of()
        self.assertIn("swell", session)
        self.assertNotIn("swel", session)
        self.assertNotIn(3, session)
        self.assertEqual(list(session), list(session.parameters))
        self.assertEqual(len(session), len(session.parameters))
        self.assertEqual(dict(session), session.parameters)
        self.assertEqual(session.keys(), session._ipython_key_completions_())
        self.assertEqual(list(zip(session.keys(), session.values())), session.items())
        for name in session:
            if name.startswith("sw"):
                session[name] = 7
        self.assertIn("swell = 7", repr(session))
        report = session.solve()
        self.assertIn(f"converged, iterations {report.iterations}", repr(report))

    def test_unknown_names_are_named(self):
        session = session_of()
        for words, call in {
            "parameter 'swel'.*did you mean 'swell'": lambda: session["swel"],
            "parameter 'pusch'.*did you mean 'push'": lambda: session.set("pusch", 1),
            "'srface'.*did you mean 'surface'": lambda: session.add_pressure("more", faces=["srface"]),
            "faces: found a single text": lambda: session.add_pressure("more", faces="surface"),
            "'frnt'.*did you mean 'front'": lambda: session.add_offset("lift", "frnt"),
            "'swel'.*did you mean 'swell'": lambda: session.remove("swel"),
            "'doubel'.*did you mean 'double'": lambda: session.drive("swell", {"doubel": 1}),
            r"follows\['double'\]: found 'x', expected a number": lambda: session.drive("swell", {"double": "x"}),
        }.items():
            with self.assertRaisesRegex(batten.InputError, words):
                call()
        self.assertEqual(sorted(session.names), ["push", "swell"])

    def test_one_slider_drives_others(self):
        session = session_of()
        session.drive("swell", {"double": 2}, offset=1)
        session["double"] = 5
        self.assertEqual(session["swell"], 11)
        with self.assertRaisesRegex(batten.InputError, "double"):
            session["swell"] = 3

    def test_constraints_in_conflict_are_named_and_change_nothing(self):
        session = session_of()
        session.add_point_constraint("pin", at=[0.5, 0.5, 0.2], target=[0.5, 0.5, 0.4])
        before = session.points.copy()
        with self.assertRaises(batten.ConflictError) as raised:
            session.add_point_constraint("nail", at=[0.5, 0, 0.2], target=[0.5, 0, 0.5])
        (names, amount), = raised.exception.conflicts[:1]
        self.assertIn("nail", names)
        self.assertGreater(abs(amount), 0.01)
        self.same_bits(session.points, before)
        self.assertEqual(sorted(session.names), ["pin", "push", "swell"])
        session.remove("pin")
        self.assertNotIn("pin.x", session.parameters)

    def test_a_held_point_is_where_it_should_be(self):
        session = session_of()
        session.add_point_constraint("pin", at=[0.5, 0.5, 0.2])
        session["pin.z"] = 0.5
        session.solve()
        self.assertLess(session.residual, 1e-12)
        self.assertLess(np.linalg.norm(session.points - [0.5, 0.5, 0.5], axis=1).min(), 0.05)
        self.assertGreater(session.reactions()["pin"][2], 0)

    def test_a_load_past_its_limit(self):
        lines = {"rim": [[np.cos(t), np.sin(t), 0] for t in np.linspace(0, 2 * np.pi, 49)]}
        session = batten.Session(batten.skin(lines))
        session.add_pressure("swell")
        session["swell"] = 30
        session.solve()
        before = session.points.copy()
        session["swell"] = 1e9
        with self.assertRaises(batten.NoSolutionError):
            session.solve()
        self.same_bits(session.points, before)
        self.assertEqual(session["swell"], 30)

    def test_a_model_of_a_session_stays(self):
        session = session_of()
        model = session.model()
        before = model.points.copy()
        session["swell"] = 20
        session.solve()
        self.same_bits(model.points, before)
        self.assertGreater(np.abs(session.model().points - before).max(), 1e-3)

    def test_stress_of_the_present_shape(self):
        session = batten.Session(example("18-lean", "scene.toml"))
        stress = session.stress()
        self.assertEqual(stress.von_mises.shape, (len(session.points),))
        self.assertEqual(stress.displacement.shape, session.points.shape)
        self.assertGreater(stress.max_von_mises, 0)
        with self.assertRaisesRegex(batten.InputError, "stress"):
            session_of().stress()

    def test_stress_during_a_drag_is_that_of_the_model(self):
        shell = {"material": "steel", "thickness": 1, "supports": ["left", "right"],
                 "loads": [{"pressure": -0.01}, {"gravity": [0, 0, -9810], "case": "weight"}]}
        session = batten.Session(shell_model())
        for swell in np.linspace(0.1, 3, 6):
            session["swell"] = swell
            session.solve()
            live, exact = session.stress(**shell), batten.stress(session.model(), **shell)
            self.assertEqual(live.load_case, exact.load_case().name)
            self.assertAlmostEqual(live.max_von_mises / exact.max_von_mises, 1, 6)
            self.assertAlmostEqual(live.max_displacement / exact.max_displacement, 1, 6)
            np.testing.assert_allclose(live.von_mises.max(), exact.von_mises().max(), rtol=1e-5)
        # Other settings are another shell.
        thicker = session.stress(**{**shell, "thickness": 2})
        self.assertLess(thicker.max_displacement, live.max_displacement)
        self.assertEqual(session.stress(**shell).max_von_mises, session.stress(**shell).max_von_mises)

    def test_stress_names_the_setting_that_is_wrong(self):
        session = batten.Session(shell_model())
        shell = {"material": "steel", "thickness": 1, "supports": ["left"], "loads": {"pressure": 1}}
        for change, message in (({"material": "steal"}, "material.*did you mean 'steel'"),
                                ({"thickness": -1}, "thickness"), ({"supports": ["lefd"]}, "supports.*'left'"),
                                ({"loads": {"pressur": 1}}, "loads.*pressure")):
            with self.subTest(change), self.assertRaisesRegex(batten.InputError, message):
                session.stress(**{**shell, **change})
        with self.assertRaisesRegex(batten.NoSolutionError, "do not constrain"):
            session.stress(**{**shell, "supports": {"point": [0, 0, 0]}})
        self.assertGreater(session.stress(**shell).max_von_mises, 0)


class Threads(PropertyTests):
    def test_two_sessions_at_once_give_the_same_bits(self):
        expected = [drag(session_of(), seed) for seed in (1, 2)]
        sessions = [session_of(), session_of()]
        found = [None, None]

        def work(i):
            found[i] = drag(sessions[i], i + 1)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for a, b in zip(expected, found):
            self.assertEqual(len(a), len(b))
            for x, y in zip(a, b):
                self.same_bits(x, y)

    def ticks_during(self, call):
        """How often this thread ran during a call in another one.

        It does not request the interpreter's lock, so it only runs while the lock is released."""
        events = []

        def work():
            events.append("begin")
            call()
            events.append("end")
        interval = sys.getswitchinterval()
        sys.setswitchinterval(1000)
        try:
            thread = threading.Thread(target=work)
            thread.start()
            while thread.is_alive():
                events.append("tick")
                time.sleep(1e-3)
        finally:
            sys.setswitchinterval(interval)
        return events[events.index("begin"):events.index("end")].count("tick")

    def test_python_goes_on_while_the_kernel_works(self):
        self.assertGreater(self.ticks_during(lambda: batten.skin(saddle(), edge_length=0.02)), 2)
        session = session_of(0.02)

        def settle_often():
            for value in range(10):
                session["swell"] = value
                session.solve()
        self.assertGreater(self.ticks_during(settle_often), 2)
        self.assertGreater(self.ticks_during(lambda: session.model().points), 0)

    def test_held_locks_would_be_seen(self):
        numbers = list(range(3_000_000, 0, -1))
        self.assertEqual(self.ticks_during(numbers.sort), 0)

    def test_a_session_is_used_by_one_thread_after_the_other(self):
        session = session_of()
        session["swell"] = 10
        failed = []

        def work():
            try:
                for _ in range(20):
                    session.update()
                    self.assertTrue(np.isfinite(session.points).all())
            except BaseException as error:  # noqa: BLE001
                failed.append(error)
        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failed, [])


class Motion(PropertyTests):
    def scene(self):
        curves = "".join(f'[[curve]]\nname = "{name}"\npoints = {points}\n' for name, points in saddle().items())
        with open(self.file("plate.toml"), "w") as out:
            out.write('name = "plate"\nunit = "m"\n' + curves + '[mesh]\nedge_length = 0.2\n'
                      '[[load]]\nname = "swell"\ntype = "pressure"\nvalue = [[0, 0], [0.2, 20]]\n'
                      '[motion]\ndensity = 0.5\ndamping = 0.2\ntheta = 0.6\n[output]\nvtp = "plate.vtp"\n')
        return self.file("plate.toml")

    def test_steps_are_those_of_sculpt(self):
        scene = self.scene()
        self.assertIn(run_program("sculpt", scene, "--out", self.file("out"), "--time", "0.5", "--dt", "0.05"), (0, 4))
        session = batten.Session(scene)
        session.start_motion(0.05)
        for k in range(11):
            self.same_bits(session.model().points, batten.read_mesh(self.file(f"out/plate_time_{k:03}.vtp")).points)
            session.step()
        self.assertAlmostEqual(session.time, 0.55)
        self.assertAlmostEqual(session["swell"], 20)

    def test_several_steps_at_once(self):
        one, many = batten.Session(self.scene()), batten.Session(self.scene())
        stages = []
        for session in (one, many):
            session.start_motion(0.05)
        for _ in range(6):
            one.step()
        many.step(6, progress=lambda stage, fraction: stages.append(stage))
        self.same_bits(one.dofs, many.dofs)
        self.assertIn("motion", stages)
        self.assertTrue(many.undo())
        self.assertTrue(many.in_motion)
        self.assertEqual(many.time, 0)

    def test_energy_without_damping(self):
        session = session_of(0.2)
        session["push"] = 2
        session.solve()
        session["push"] = 0
        session.start_motion(0.01, density=1, damping=0, theta=0.5)
        session.step()
        energy = session.total_energy
        elastic = []
        for _ in range(50):
            session.step()
            self.assertLess(abs(session.total_energy / energy - 1), 1e-6)
            elastic.append(session.energy)
        self.assertGreater(max(elastic) - min(elastic), 0.1 * abs(max(elastic)))
        session.stop_motion()
        self.assertFalse(session.in_motion)

    def test_refusals(self):
        session = session_of(0.2)
        for action, words in ((lambda: session.step(), "start the motion first"),
                              (lambda: session.start_motion(0), "time step 0"),
                              (lambda: session.start_motion(float("nan")), "time step nan"),
                              (lambda: session.start_motion(0.1, theta=0.2), "theta = 0.2"),
                              (lambda: session.start_motion(0.1, density=-1), "density -1"),
                              (lambda: session.start_motion(0.1, damping="much"), "damping: found"),
                              (lambda: session.step(0), "count: found 0")):
            with self.subTest(words), self.assertRaisesRegex(batten.InputError, words):
                action()
        session.start_motion(0.1)
        with self.assertRaisesRegex(batten.InputError, "stop_motion"):
            session.update()


class Stopping(PropertyTests):
    def test_progress_is_told_and_may_stop(self):
        stages = []
        batten.skin(saddle(), progress=lambda stage, fraction: stages.append((stage, fraction)))
        self.assertTrue(stages)
        self.assertTrue(all(isinstance(stage, str) and 0 <= fraction <= 1 for stage, fraction in stages))

        def stop(stage, fraction):
            raise KeyError("enough")
        with self.assertRaisesRegex(KeyError, "enough"):
            batten.skin(saddle(), progress=stop)

    def test_an_interrupt_stops_a_long_call(self):
        program = """
import batten, sys
points = [[[i, j, 0], [i + 1, j, 0]] for i in range(40) for j in range(41)]
points += [[[i, j, 0], [i, j + 1, 0]] for i in range(41) for j in range(40)]
try:
    print("begin", flush=True)
    for _ in range(1000):
        batten.skin({str(i): p for i, p in enumerate(points)})
except KeyboardInterrupt:
    print("stopped")
    sys.exit(7)
"""
        running = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        self.assertEqual(running.stdout.readline(), "begin\n")
        try:
            running.stdout.flush()
            threading.Event().wait(1.5)
            running.send_signal(signal.SIGINT)
            out, _ = running.communicate(timeout=60)
        finally:
            running.kill()
        self.assertEqual((running.returncode, out), (7, "stopped\n"))


if __name__ == "__main__":
    unittest.main()
