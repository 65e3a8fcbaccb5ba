# SPDX-License-Identifier: MPL-2.0
"""Runs each block of Python in the documents separately."""

import os
import re
import subprocess
import sys
import unittest

from properties import SOURCE, PropertyTests


class Documents(PropertyTests):
    def setUp(self):
        super().setUp()
        os.symlink(os.path.join(SOURCE, "examples"), self.file("examples"))

    def blocks_run(self, document, least):
        with open(os.path.join(SOURCE, document)) as text:
            blocks = re.findall(r"^```python\n(.*?)^```", text.read(), re.MULTILINE | re.DOTALL)
        self.assertGreaterEqual(len(blocks), least, document)
        for block in blocks:
            done = subprocess.run([sys.executable, "-c", block], cwd=self.folder, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, text=True)
            missing = re.search(r"No module named '(scipy|meshio)'", done.stderr)
            if missing:
                print(f"skipped: a program of {document} needs {missing[1]}")
                continue
            self.assertEqual(done.returncode, 0, block + done.stderr)

    def test_python_md(self):
        self.blocks_run("docs/python.md", 3)
        self.assertTrue(os.path.exists(self.file("panel.step")))

    def test_pages(self):
        for page in ("fit", "sequence", "stress"):
            self.blocks_run(f"docs/{page}.md", 1)

    def test_readme(self):
        self.blocks_run("README.md", 1)


if __name__ == "__main__":
    unittest.main()
