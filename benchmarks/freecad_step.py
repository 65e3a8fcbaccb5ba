# SPDX-License-Identifier: MPL-2.0
"""FreeCAD reads STEP files, counts their faces and checks them.

usage: STEP_FILES=A.step:B.step freecadcmd freecad_step.py
Prints one line per file: name, shape type, faces, isValid, and the findings of its check for
Boolean operations within SECONDS (self-intersections: minutes for files with many poles).
"""
import os
import signal
import sys

import Part

SECONDS = int(os.environ.get("STEP_SECONDS", "20"))


def checked(shape):
    """Findings of the check, run in a child process: it cannot be stopped otherwise."""
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(SECONDS)
        try:
            shape.check(True)
            found = "nothing"
        except Exception as error:
            lines = str(error).strip().splitlines()
            found = f"{len(lines)} lines: {lines[0][:60]}" if lines else "something"
        os.write(theirs, found.encode())
        os._exit(0)
    os.close(theirs)
    said = os.read(ours, 1000).decode()
    os.waitpid(child, 0)
    return f"check finds {said}" if said else f"check not done in {SECONDS} s"


for path in os.environ["STEP_FILES"].split(":"):
    shape = Part.Shape()
    shape.read(path)
    valid = "valid" if shape.isValid() else "NOT valid"
    print(os.path.basename(path), shape.ShapeType, len(shape.Faces), "faces", valid, checked(shape), flush=True)
sys.stdout.flush()
