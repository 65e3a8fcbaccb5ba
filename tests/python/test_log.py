# SPDX-License-Identifier: MPL-2.0
"""Messages to a function or to the module logging, and the number of threads."""

import logging
import os
import threading
import time
import unittest

from properties import PropertyTests, batten, np, saddle


class Log(PropertyTests):
    def tearDown(self):
        batten.set_log(None)
        batten.set_threads(0)

    def test_messages_go_to_logging(self):
        with self.assertLogs("batten", logging.INFO) as seen:
            batten.set_log(logging.getLogger("batten").log)
            batten.skin(saddle())
            batten.set_log(None)
            batten.skin(saddle())
        self.assertEqual(len(seen.records), 1)
        self.assertRegex(seen.records[0].getMessage(), r"model of 1 face, \d+ elements")

    def test_a_warning_is_logged(self):
        seen = []
        batten.set_log(lambda level, message: seen.append((level, message)))
        x = np.linspace(0, 1, 9)
        curves = {"front": np.c_[x, 0 * x, 0 * x], "right": [[1, 0, 0], [1, 1, 0]], "back": [[1, 1, 0], [0, 1, 0]],
                  "left": [[0, 1, 0], [0, 0, 0]]}
        weak = [{"point": [0, 0, 0]}, {"point": [1, 0, 0]}, {"point": [0.5, 0.004, 0]}]
        batten.stress(batten.skin(curves), material="steel", thickness=0.01, supports=weak, loads={"pressure": 1e-6})
        self.assertTrue([m for level, m in seen if level == logging.WARNING and "hardly prevent" in m], seen)

    def test_an_exception_of_the_function_does_not_end_the_call(self):
        def fail(level, message):
            raise RuntimeError("from the function")

        batten.set_log(fail)
        self.assertGreater(len(batten.skin(saddle()).points), 0)

    def test_other_values_are_refused(self):
        with self.assertRaisesRegex(batten.InputError, "function: found 3"):
            batten.set_log(3)
        with self.assertRaisesRegex(batten.InputError, "count: found -1, expected 0"):
            batten.set_threads(-1)

    @unittest.skipUnless(os.cpu_count() > 1, "needs two cores")
    def test_one_thread_is_one_thread(self):
        """Processor time of all threads of the process per time, while the kernel computes."""
        batten.set_threads(1)
        started = set(threading.enumerate())
        tasks = len(os.listdir("/proc/self/task"))
        wall, used = time.perf_counter(), time.process_time()
        model = batten.skin(saddle(), edge_length=0.03)
        batten.stress(model, material="steel", thickness=0.01, supports=["left", "right"] if "left" in model.curves
                      else [model.curves[0]], loads={"pressure": 1e-6}, modes=2)
        wall, used = time.perf_counter() - wall, time.process_time() - used
        self.assertLess(used, 1.15 * wall + 0.05)
        self.assertEqual(set(threading.enumerate()), started)
        self.assertLessEqual(len(os.listdir("/proc/self/task")), tasks)


if __name__ == "__main__":
    unittest.main()
