"""The task panel of a Skin: a slider for the pressure, pushes by clicks, creases and smooth edges by choice."""
import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

STEPS = 200  # of a slider, to either side
NUMBER_WIDTH = 90  # pixels
WAIT = 150   # ms until the surface follows a slider


def picked():
    """The place and the normal of the face that was clicked last; None where there is none."""
    for chosen in FreeCADGui.Selection.getSelectionEx():
        for sub, point in zip(chosen.SubObjects, chosen.PickedPoints):
            if sub.ShapeType == "Face":
                u, v = sub.Surface.parameter(point)
                return point, sub.normalAt(u, v)
    return None


def chosen_edges():
    """The edges that are chosen, as links."""
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
        self.pushes = QtGui.QVBoxLayout()
        column.addLayout(self.pushes)
        for i in range(len(obj.PushAt)):
            self.add_push_row(i)
        self.button(column, "Push where the surface was clicked", self.add_push)
        self.button(column, "Chosen edges are creases", lambda: self.join("Creases", "Smooth"))
        self.button(column, "Chosen edges are smooth", lambda: self.join("Smooth", "Creases"))
        self.words = QtGui.QLabel()
        self.words.setWordWrap(True)
        column.addWidget(self.words)
        self.show_words()

    def button(self, column, words, act):
        button = QtGui.QPushButton(words)
        button.clicked.connect(act)
        column.addWidget(button)

    def slider(self, column, words, value, act):
        """A slider with its number; both say the same."""
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
        column.addWidget(QtGui.QLabel(words))
        row.addWidget(slider, 1)
        row.addWidget(number)
        column.addLayout(row)
        slider.number = number
        return slider

    def set_pressure(self, value):
        self.obj.Pressure = value
        self.timer.start()

    def add_push_row(self, i):
        force = self.obj.PushBy[i]
        way = FreeCAD.Vector(force).normalize() if force.Length > 0 else FreeCAD.Vector(0, 0, 1)

        def set_force(value, i=i, way=way):
            forces = list(self.obj.PushBy)
            forces[i] = way * value
            self.obj.PushBy = forces
            self.timer.start()

        return self.slider(self.pushes, f"Push {i + 1}", force.Length, set_force)

    def add_push(self):
        found = picked()
        if not found:
            self.words.setText("Click on the surface first, then push.")
            return
        place, normal = found
        self.obj.PushAt = list(self.obj.PushAt) + [place]
        self.obj.PushBy = list(self.obj.PushBy) + [normal * 1e-9]  # keeps its way until the slider moves
        self.add_push_row(len(self.obj.PushAt) - 1)

    def join(self, into, out_of):
        """Takes the chosen edges of the lines into one list of joins and out of the other."""
        wanted = {(o.Name, s) for o, subs in chosen_edges() for s in subs}
        if not wanted:
            self.words.setText("Choose edges of the sketches first.")
            return
        for name, inside in ((into, True), (out_of, False)):
            kept = [(o, s) for o, subs in getattr(self.obj, name) for s in subs if (o.Name, s) not in wanted]
            new = [(self.obj.Document.getObject(o), s) for o, s in sorted(wanted)] if inside else []
            setattr(self.obj, name, kept + new)
        self.recompute()

    def recompute(self):
        self.obj.Document.recompute()
        self.show_words()

    def show_words(self):
        broken = "Invalid" in self.obj.State
        self.words.setText("\n".join(self.obj.Words) if not broken else "This could not be made: see the report view.")

    def accept(self):
        if self.timer.isActive():
            self.timer.stop()
            self.recompute()
        FreeCADGui.ActiveDocument.resetEdit()
        return True

    reject = accept
