# SPDX-License-Identifier: MPL-2.0
"""Models, sessions and stresses that are made, pickled and dropped leave no memory behind.

The full run: BATTEN_OBJECTS=10000 PYTHONPATH=build/release/python /usr/bin/python3 tests/python/test_memory.py
"""

import gc
import os
import pickle
import sys
import unittest

from properties import PropertyTests, batten, resident_kb, saddle

COUNT = int(os.environ.get("BATTEN_OBJECTS", "200"))


def use_models():
    model = batten.skin(saddle(), edge_length=0.5)
    twin = pickle.loads(pickle.dumps(model))
    return len(twin.points) + len(twin.triangles) + len(twin.curvatures)


def use_sessions():
    session = batten.Session(use_sessions.model)
    session.add_pressure("swell")
    session["swell"] = 5
    session.update()
    twin = pickle.loads(pickle.dumps(session))
    return len(session.points) + len(twin.triangles) + len(twin.model().mesh().points)


def use_stresses():
    stress = batten.stress(use_sessions.model, material="steel", thickness=0.01, supports=["left", "right"],
                           loads=[{"pressure": 1}])
    return len(stress.von_mises()) + len(stress.displacement()) + len(stress.thickness)


class Memory(PropertyTests):
    def test_dropped_objects_leave_nothing(self):
        use_sessions.model = batten.skin(saddle(), edge_length=0.5)
        for use in (use_models, use_sessions, use_stresses):
            with self.subTest(use.__name__):
                self.assertLess(self.growth(use), 3000)  # KB; one of the objects has more than 100

    def test_a_leak_would_be_seen(self):
        kept = []
        self.assertGreater(self.growth(lambda: kept.append(bytearray(100_000)), 100), 3000)

    def growth(self, use, count=COUNT):
        """Growth of the resident memory, KB, by `count` uses; earlier ones fill caches and free lists."""
        for _ in range(max(50, count // 4)):
            use()
        gc.collect()
        before = resident_kb()
        for _ in range(count):
            use()
        gc.collect()
        grown = resident_kb() - before
        print(f"{use.__name__}: {count} times, resident memory {before} KB, then {before + grown} KB", file=sys.stderr)
        return grown


if __name__ == "__main__":
    unittest.main()
