# SPDX-License-Identifier: MPL-2.0
"""Pictures in Jupyter, and the window of batten-studio elsewhere."""

import os
import stat
import subprocess
import sys
import types
import unittest
import unittest.mock

from properties import PropertyTests, batten, saddle

PNG = b"\x89PNG\r\n\x1a\n"
# Draws in a process without DISPLAY.
WITHOUT_DISPLAY = """
import os, sys, batten
sys.path.insert(0, %r)
from properties import saddle
model = batten.skin(saddle())
png = model._repr_png_()
print(png[:4] if png else None, os.environ.get("DISPLAY"), batten.Session(model)._repr_png_() == png)
""" % os.path.dirname(__file__)


class Show(PropertyTests):
    def without_display(self, **environment):
        variables = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
        return subprocess.run([sys.executable, "-c", WITHOUT_DISPLAY], env={**variables, **environment},
                              capture_output=True, text=True, check=True).stdout.strip()

    def test_a_virtual_server_draws_without_display(self):
        if not any(os.path.exists(os.path.join(folder, "Xvfb")) for folder in os.environ["PATH"].split(":")):
            self.skipTest("xvfb is not there")
        self.assertEqual(self.without_display(), f"{PNG[:4]} None True")

    def test_without_any_server_there_is_no_picture(self):
        self.assertEqual(self.without_display(BATTEN_XVFB=""), "None None True")
        self.shown_in(None, "found no X server", DISPLAY="")

    def test_pictures_in_jupyter(self):
        shown = []
        display = types.ModuleType("IPython.display")
        display.Image, display.display = (lambda data: data), shown.append
        ipython = types.ModuleType("IPython")
        ipython.display, ipython.get_ipython = display, lambda: types.SimpleNamespace(kernel="kernel")
        model = batten.skin(saddle())
        with unittest.mock.patch.dict(sys.modules, {"IPython": ipython, "IPython.display": display}):
            try:
                model.show(field="mean", width=200, height=100)
            except batten.InputError as error:
                self.skipTest(str(error))
            batten.Session(model).show()
            ipython.get_ipython = lambda: types.SimpleNamespace()  # IPython in a terminal
            self.shown_in(None, "found no X server", DISPLAY="")
        self.assertEqual([picture[:8] for picture in shown], [PNG, PNG])
        self.assertEqual(int.from_bytes(shown[0][16:20], "big"), 200)

    def shown_in(self, studio, error, **environment):
        """Calls show() with this program as batten-studio, or expects an error."""
        elsewhere = unittest.mock.patch("batten.pictures.__file__", self.file("python/batten/pictures.py"))
        with unittest.mock.patch.dict(os.environ, environment), elsewhere:
            if error:
                with self.assertRaisesRegex(batten.InputError, error):
                    batten.skin(saddle()).show()
            else:
                batten.skin(saddle(), name="panel").show()

    def test_scripts_open_the_window(self):
        program = self.file("batten-studio")
        with open(program, "w") as text:
            text.write(f"#!/bin/sh\ngrep name $1 > {self.folder}/read\n")
        os.chmod(program, stat.S_IRWXU)
        path = self.folder + ":" + os.environ["PATH"]
        self.shown_in(program, None, DISPLAY=":none", PATH=path)
        with open(self.file("read")) as read:
            self.assertIn('"panel"', read.read())
        with open(program, "w") as text:
            text.write("#!/bin/sh\nexit 3\n")
        with self.assertRaisesRegex(batten.Error, "exit code 3"):
            self.shown_in(program, None, DISPLAY=":none", PATH=path)
        self.shown_in(None, "found no program batten-studio", DISPLAY=":none", PATH="/nowhere")


if __name__ == "__main__":
    unittest.main()
