# SPDX-License-Identifier: MPL-2.0
"""Shared by the tests of the Python package. Without numpy they are skipped (exit code 77)."""

import os
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
try:
    import numpy as np
except ImportError:
    print("skipped: numpy is not there (python3-numpy)")
    sys.exit(SKIPPED)

import batten

SOURCE = os.environ["BATTEN_SOURCE"]
PROGRAM = os.environ["BATTEN_PROGRAM"]


def example(*names):
    return os.path.join(SOURCE, "examples", *names)


def run_program(*words):
    """The program's exit code; runs without a display."""
    environment = {**os.environ, "DISPLAY": "", "BATTEN_XVFB": ""}
    done = subprocess.run([PROGRAM, *words], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    return done.returncode


class PropertyTests(unittest.TestCase):
    """A test case with its own folder, and comparison of arrays bit by bit."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="batten_python_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def file(self, name):
        return os.path.join(self.folder, name)

    def same_bits(self, a, b):
        self.assertEqual(a.shape, b.shape)
        self.assertEqual(a.dtype, b.dtype)
        self.assertEqual(np.ascontiguousarray(a).tobytes(), np.ascontiguousarray(b).tobytes())


def saddle():
    """Four curves around a square, two of them not straight."""
    return {
        "front": [[0, 0, 0], [0.5, 0, 0.2], [1, 0, 0]],
        "right": [[1, 0, 0], [1, 1, 0.3]],
        "back": [[1, 1, 0.3], [0.5, 1, 0.45], [0, 1, 0.2]],
        "left": [[0, 1, 0.2], [0, 0, 0]],
    }


def grid(n):
    """A flat square of 2n² triangles: points n×3 and triangles m×3."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1
    return points, np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def resident_kb():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))
