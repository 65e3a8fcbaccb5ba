# SPDX-License-Identifier: MPL-2.0
"""The task panel of a Skin: a slider for the pressure, point loads at clicked points, continuity of selected edges."""
import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

STEPS = 200  # of a slider, to either side
NUMBER_WIDTH = 90  # pixels
WAIT = 150   # ms until the surface follows a slider


def picked():
    """The clicked point of a face and the normal there; None if no face is selected."""
    for selected in FreeCADGui.Selection.getSelectionEx():
        for sub, point in zip(selected.SubObjects, selected.PickedPoints):
            if sub.ShapeType == "Face":
                u, v = sub.Surface.parameter(point)
                return point, sub.normalAt(u, v)
    return None


def selected_edges():
    """The selected edges, as links."""
    return [(one.Object, tuple(s for s in one.SubElementNames if s.startswith("Edge")))
            for one in FreeCADGui.Selection.getSelectionEx()
            if any(s.startswith("Edge") for s in one.SubElementNames)]


class SkinPanel:
    """`form` is what FreeCAD shows in its task view."""

    def __init__(self, obj):
        self.obj = obj
        self.form = QtGui.QWidget()
        self.form.setWindowTitle("Skin")
        column = QtGui.QVBoxLayout(self.form)
        self.timer = QtCore.QTimer(self.form)
        self.timer.setSingleShot(True)
        self.timer.setInterval(WAIT)
        self.timer.timeout.connect(self.recompute)
        self.range = max(100.0, 2 * abs(obj.Pressure))
        self.pressure = self.slider(column, "Pressure", obj.Pressure, self.set_pressure)
        self.loads = QtGui.QVBoxLayout()
        column.addLayout(self.loads)
        for i in range(len(obj.LoadPoints)):
            self.add_load_row(i)
        self.button(column, "Add point load at the clicked point", self.add_load)
        self.button(column, "Selected edges: crease (G0)", lambda: self.join("Creases", "Smooth"))
        self.button(column, "Selected edges: smooth (G1)", lambda: self.join("Smooth", "Creases"))
        self.messages = QtGui.QLabel()
        self.messages.setWordWrap(True)
        column.addWidget(self.messages)
        self.show_messages()

    def button(self, column, label, act):
        button = QtGui.QPushButton(label)
        button.clicked.connect(act)
        column.addWidget(button)

    def slider(self, column, label, value, act):
        """A slider with a spin box for the same value."""
        row = QtGui.QHBoxLayout()
        slider = QtGui.QSlider(QtCore.Qt.Horizontal)
        slider.setRange(-STEPS, STEPS)
        number = QtGui.QDoubleSpinBox()
        number.setRange(-1e9, 1e9)
        number.setDecimals(3)
        number.setValue(value)
        slider.setValue(round(STEPS * value / self.range))
        slider.valueChanged.connect(lambda step: number.setValue(self.range * step / STEPS))
        number.valueChanged.connect(act)
        number.setMaximumWidth(NUMBER_WIDTH)
        column.addWidget(QtGui.QLabel(label))
        row.addWidget(slider, 1)
        row.addWidget(number)
        column.addLayout(row)
        slider.number = number
        return slider

    def set_pressure(self, value):
        self.obj.Pressure = value
        self.timer.start()

    def add_load_row(self, i):
        force = self.obj.LoadForces[i]
        direction = FreeCAD.Vector(force).normalize() if force.Length > 0 else FreeCAD.Vector(0, 0, 1)

        def set_force(value, i=i, direction=direction):
            forces = list(self.obj.LoadForces)
            forces[i] = direction * value
            self.obj.LoadForces = forces
            self.timer.start()

        return self.slider(self.loads, f"Point load {i + 1}", force.Length, set_force)

    def add_load(self):
        found = picked()
        if not found:
            self.messages.setText("Click on the surface first, then add the point load.")
            return
        point, normal = found
        self.obj.LoadPoints = list(self.obj.LoadPoints) + [point]
        # The tiny force keeps the direction until the slider moves.
        self.obj.LoadForces = list(self.obj.LoadForces) + [normal * 1e-9]
        self.add_load_row(len(self.obj.LoadPoints) - 1)

    def join(self, into, out_of):
        """Adds the selected edges to one list of edges (Creases or Smooth), and removes them from the other."""
        wanted = {(o.Name, s) for o, subs in selected_edges() for s in subs}
        if not wanted:
            self.messages.setText("Select edges of the sketches first.")
            return
        for name, inside in ((into, True), (out_of, False)):
            kept = [(o, s) for o, subs in getattr(self.obj, name) for s in subs if (o.Name, s) not in wanted]
            new = [(self.obj.Document.getObject(o), s) for o, s in sorted(wanted)] if inside else []
            setattr(self.obj, name, kept + new)
        self.recompute()

    def recompute(self):
        self.obj.Document.recompute()
        self.show_messages()

    def show_messages(self):
        failed = "Invalid" in self.obj.State
        self.messages.setText("\n".join(self.obj.Messages) if not failed else
                              "The surface could not be computed: see the report view.")

    def accept(self):
        if self.timer.isActive():
            self.timer.stop()
            self.recompute()
        FreeCADGui.ActiveDocument.resetEdit()
        return True

    reject = accept
