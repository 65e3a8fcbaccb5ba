# SPDX-License-Identifier: MPL-2.0
"""Test in the window of FreeCAD: creates a Skin from four splines, sets its pressure, adds a point load, changes a spline and
exports the result. Writes pictures and a STEP file to the folder BATTEN_SCRATCH; FreeCAD exits with 0 on success. Run it as
    freecad tests/freecad/window_story.py
with apps/freecad as Mod/Batten in FreeCAD's folder of the user.
"""
import os
import sys
import traceback
from pathlib import Path

import FreeCAD
import FreeCADGui as Gui
import Part
from PySide import QtCore, QtGui
from PySide2 import QtWidgets

V = FreeCAD.Vector
FOLDER = Path(os.environ["BATTEN_SCRATCH"])


def arch(a, b, up):
    curve = Part.BSplineCurve()
    curve.interpolate([a, (a + b) * 0.5 + up, b])
    return curve.toShape()


def process_events(milliseconds=600):
    loop = QtCore.QEventLoop()
    QtCore.QTimer.singleShot(milliseconds, loop.quit)
    loop.exec_()


def picture(name):
    process_events()
    screen = QtWidgets.QApplication.primaryScreen().grabWindow(0)  # including the OpenGL view
    screen.save(str(FOLDER / f"{name}.png"))


def story():
    window = Gui.getMainWindow()
    window.resize(1360, 860)
    document = FreeCAD.newDocument("Batten")
    Gui.activateWorkbench("BattenWorkbench")
    corners = [V(0, 0, 0), V(200, 0, 0), V(200, 120, 0), V(0, 120, 0)]
    for i in range(4):
        curve = document.addObject("Part::Feature", f"Curve{i + 1}")
        curve.Shape = arch(corners[i], corners[(i + 1) % 4], V(0, 0, 20))
    Gui.activeDocument().activeView().viewIsometric()
    Gui.SendMsgToActiveView("ViewFit")
    picture("freecad_curves")
    for i in range(4):
        Gui.Selection.addSelection(document.Name, f"Curve{i + 1}", "Edge1")
    Gui.runCommand("Batten_Skin")
    skin = document.getObject("Skin")
    assert skin and skin.Shape.isValid() and len(skin.Shape.Faces) == 1
    picture("freecad_skin")
    panel = Gui.getMainWindow().findChildren(QtGui.QSlider)
    slider = next(s for s in panel if hasattr(s, "number") or s.maximum() == 200)
    before = skin.Shape.BoundBox.ZMax
    slider.setValue(60)
    process_events(2500)
    assert skin.Pressure > 0 and abs(skin.Shape.BoundBox.ZMax - before) > 0.01, (skin.Pressure, before)
    face = skin.Shape.Faces[0]
    point = face.valueAt(*[sum(r) / 2 for r in (face.ParameterRange[:2], face.ParameterRange[2:])])
    Gui.Selection.clearSelection()
    Gui.Selection.addSelection(document.Name, "Skin", "Face1", point.x, point.y, point.z)
    next(b for b in window.findChildren(QtGui.QPushButton) if b.text().startswith("Add point load")).click()
    assert len(skin.LoadPoints) == 1
    force = [s for s in window.findChildren(QtGui.QSlider) if s.maximum() == 200][-1]
    force.setValue(50)
    process_events(2500)
    assert skin.LoadForces[0].Length > 1
    Gui.Selection.clearSelection()
    Gui.SendMsgToActiveView("ViewFit")
    picture("freecad_pushed")
    Gui.Control.closeDialog()
    Gui.activeDocument().resetEdit()
    document.getObject("Curve1").Shape = arch(corners[0], corners[1], V(0, -40, 60))
    document.recompute()
    assert skin.Shape.isValid()
    assert skin.Shape.distToShape(document.getObject("Curve1").Shape)[0] < 0.05
    Gui.Selection.addSelection(document.Name, "Skin")
    picture("freecad_changed")
    Part.export([skin], str(FOLDER / "freecad_skin.step"))
    assert Part.read(str(FOLDER / "freecad_skin.step")).isValid()


def main():
    try:
        story()
        code = 0
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


QtCore.QTimer.singleShot(1500, main)
