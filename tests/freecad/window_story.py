"""A story in FreeCAD's own window: four splines are skinned, pressed, pushed, one of them changes, the result is exported. Writes
pictures and a STEP file to the folder BATTEN_SCRATCH; ends FreeCAD with 0 where all went well. Run it as
    freecad -M apps/freecad tests/freecad/window_story.py
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


def settle(milliseconds=600):
    loop = QtCore.QEventLoop()
    QtCore.QTimer.singleShot(milliseconds, loop.quit)
    loop.exec_()


def picture(name):
    settle()
    screen = QtWidgets.QApplication.primaryScreen().grabWindow(0)  # with what OpenGL draws
    screen.save(str(FOLDER / f"{name}.png"))


def story():
    window = Gui.getMainWindow()
    window.resize(1360, 860)
    document = FreeCAD.newDocument("Batten")
    Gui.activateWorkbench("BattenWorkbench")
    corners = [V(0, 0, 0), V(200, 0, 0), V(200, 120, 0), V(0, 120, 0)]
    for i in range(4):
        line = document.addObject("Part::Feature", f"Line{i + 1}")
        line.Shape = arch(corners[i], corners[(i + 1) % 4], V(0, 0, 20))
    Gui.activeDocument().activeView().viewIsometric()
    Gui.SendMsgToActiveView("ViewFit")
    picture("freecad_lines")
    for i in range(4):
        Gui.Selection.addSelection(document.Name, f"Line{i + 1}", "Edge1")
    Gui.runCommand("Batten_Skin")
    skin = document.getObject("Skin")
    assert skin and skin.Shape.isValid() and len(skin.Shape.Faces) == 1
    picture("freecad_skin")
    panel = Gui.getMainWindow().findChildren(QtGui.QSlider)
    slider = next(s for s in panel if hasattr(s, "number") or s.maximum() == 200)
    before = skin.Shape.BoundBox.ZMax
    slider.setValue(150)
    settle(2500)
    assert skin.Pressure > 0 and abs(skin.Shape.BoundBox.ZMax - before) > 0.01, (skin.Pressure, before)
    face = skin.Shape.Faces[0]
    place = face.valueAt(*[sum(r) / 2 for r in (face.ParameterRange[:2], face.ParameterRange[2:])])
    Gui.Selection.clearSelection()
    Gui.Selection.addSelection(document.Name, "Skin", "Face1", place.x, place.y, place.z)
    next(b for b in window.findChildren(QtGui.QPushButton) if b.text().startswith("Push where")).click()
    assert len(skin.PushAt) == 1
    force = [s for s in window.findChildren(QtGui.QSlider) if s.maximum() == 200][-1]
    force.setValue(180)
    settle(2500)
    assert skin.PushBy[0].Length > 1
    Gui.Selection.clearSelection()
    picture("freecad_pushed")
    Gui.Control.closeDialog()
    Gui.activeDocument().resetEdit()
    document.getObject("Line1").Shape = arch(corners[0], corners[1], V(0, -40, 60))
    document.recompute()
    assert skin.Shape.isValid()
    assert skin.Shape.distToShape(document.getObject("Line1").Shape)[0] < 0.05
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
