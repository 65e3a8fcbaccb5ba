# SPDX-License-Identifier: MPL-2.0
"""Shows models: as pictures in Jupyter, elsewhere in the window of batten-studio."""

import os
import shutil
import subprocess
import sys
import tempfile

from ._batten import Error, InputError, Session


def show(self, *, width=800, height=500, azimuth=-30.0, elevation=30.0, field="none", contours=12, zebra=0,
         mesh=False, title=""):
    """Shows the surface: in Jupyter as a picture, elsewhere in the window of batten-studio.

    In Jupyter, the arguments are those of Model.picture(). Elsewhere, they are not used, and the call returns
    when the window is closed. A session is shown as its model(). Raises InputError without X server or
    batten-studio, Error if batten-studio fails.

    >>> model.show(field="mean")  # doctest: +SKIP
    """
    model = self.model() if isinstance(self, Session) else self
    if not _in_jupyter():
        _open_window(model)
        return
    from IPython.display import Image, display

    display(Image(_png(model, width=width, height=height, azimuth=azimuth, elevation=elevation, field=field,
                       contours=contours, zebra=zebra, mesh=mesh, title=title)))


def repr_png(self):
    """The bytes of a PNG picture, which Jupyter displays; None if there is no X server and no Xvfb."""
    try:
        return _png(self.model() if isinstance(self, Session) else self, width=800, height=500, contours=12)
    except InputError:
        return None


def _in_jupyter():
    """True in a kernel, whose front end displays pictures; False in a script or a terminal."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return getattr(shell, "kernel", None) is not None


def _png(model, **view):
    with tempfile.TemporaryDirectory(prefix="batten_") as folder:
        file = os.path.join(folder, "model.png")
        model.picture(file, **view)
        with open(file, "rb") as picture:
            return picture.read()


def _open_window(model):
    if not os.environ.get("DISPLAY"):
        raise InputError("no display: found no X server, expected one for the window of batten-studio; "
                         "write a picture() instead, which requires none")
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bin", "batten-studio")
    studio = beside if os.path.exists(beside) else shutil.which("batten-studio")
    if not studio:
        raise InputError("found no program batten-studio, expected it on the PATH; "
                         "picture() writes a picture to a file")
    with tempfile.TemporaryDirectory(prefix="batten_") as folder:
        file = os.path.join(folder, "model.toml")
        model.save(file)
        code = subprocess.run([studio, file]).returncode
    if code:
        raise Error(f"batten-studio ended with the exit code {code}")
