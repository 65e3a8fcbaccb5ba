# SPDX-License-Identifier: MPL-2.0
"""The notebooks of examples/32-notebooks run without errors and draw pictures.

With BATTEN_PICTURES=FOLDER, the pictures are written to this folder.
"""

import base64
import contextlib
import glob
import io
import json
import os
import sys
import unittest

from properties import PropertyTests, example

FOLDER = os.path.dirname(example("32-notebooks", "README.md"))


def sources_of(notebook):
    return ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]


def run_in_jupyter(notebook):
    """Pictures (PNG) of the executed cells. Raises CellExecutionError."""
    import nbclient
    import nbformat
    from jupyter_client.manager import AsyncKernelManager

    class Manager(AsyncKernelManager):  # a kernel of this interpreter
        def format_kernel_cmd(self, extra_arguments=None):
            return [sys.executable, *super().format_kernel_cmd(extra_arguments)[1:]]

    executed = nbformat.reads(json.dumps(notebook), as_version=4)
    nbclient.NotebookClient(executed, timeout=300, kernel_manager_class=Manager,
                            resources={"metadata": {"path": FOLDER}}).execute()
    outputs = [output for cell in executed.cells if cell.cell_type == "code" for output in cell.outputs]
    return [base64.b64decode(o.data["image/png"]) for o in outputs if "image/png" in o.get("data", {})]


def run_in_process(notebook):
    """The same without Jupyter: runs the code cells one after the other."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    pictures, names, before = [], {}, os.getcwd()
    os.chdir(FOLDER)
    try:
        for source in sources_of(notebook):
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(source, "cell", "exec"), names)
            for number in plt.get_fignums():
                file = io.BytesIO()
                plt.figure(number).savefig(file, format="png")
                pictures.append(file.getvalue())
            plt.close("all")
    finally:
        os.chdir(before)
    return pictures


class Notebooks(PropertyTests):
    def setUp(self):
        super().setUp()
        os.environ["MPLCONFIGDIR"] = os.environ["IPYTHONDIR"] = os.environ["JUPYTER_RUNTIME_DIR"] = self.folder
        self.files = sorted(glob.glob(os.path.join(FOLDER, "*.ipynb")))
        self.assertEqual(len(self.files), 3)

    def notebook(self, file):
        with open(file, encoding="utf-8") as text:
            return json.load(text)

    def test_they_run_and_draw(self):
        try:
            import matplotlib  # noqa: F401
            import pandas  # noqa: F401
        except ImportError as error:
            self.skipTest(f"{error.name} is not there")
        try:
            import ipykernel  # noqa: F401
            import nbclient  # noqa: F401
            run = run_in_jupyter
        except ImportError as error:
            print(f"{error.name} is not there: the cells run without Jupyter", file=sys.stderr)
            run = run_in_process
        for file in self.files:
            with self.subTest(file):
                pictures = run(self.notebook(file))
                self.assertGreaterEqual(len(pictures), 1)
                for i, picture in enumerate(pictures):
                    self.assertGreater(len(picture), 10000)
                    if os.environ.get("BATTEN_PICTURES"):
                        name = f"{os.path.basename(file)[:-6]}-{i + 1}.png"
                        with open(os.path.join(os.environ["BATTEN_PICTURES"], name), "wb") as out:
                            out.write(picture)

    def test_models_are_displayed(self):
        try:
            import ipykernel  # noqa: F401
            import nbclient  # noqa: F401
        except ImportError as error:
            self.skipTest(f"{error.name} is not there")
        cell = {"cell_type": "code", "id": "a", "metadata": {}, "execution_count": None, "outputs": []}
        curves = "{'rim': [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0], [0, 0, 0]]}"
        source = f"import batten\nmodel = batten.skin({curves})\nmodel.show(width=300, field='mean')\nmodel"
        with open(self.files[0], encoding="utf-8") as text:
            notebook = {**json.load(text), "cells": [{**cell, "source": source}]}
        pictures = run_in_jupyter(notebook)
        if not pictures and not os.environ.get("DISPLAY"):
            self.skipTest("there is no X server and no Xvfb")
        self.assertEqual([int.from_bytes(picture[16:20], "big") for picture in pictures], [300, 800])

    def test_they_are_stored_without_outputs(self):
        for file in self.files:
            for cell in self.notebook(file)["cells"]:
                self.assertFalse(cell.get("outputs"), file)
                self.assertIsNone(cell.get("execution_count"), file)

    def test_they_use_files_of_the_source_tree_only(self):
        for file in self.files:
            for source in sources_of(self.notebook(file)):
                for piece in source.split('"')[1::2]:
                    if piece.startswith("../"):
                        self.assertTrue(os.path.exists(os.path.join(FOLDER, piece)), piece)
                    self.assertFalse(piece.startswith("/"), piece)


if __name__ == "__main__":
    unittest.main()
