"""What FreeCAD keeps of a feature in a file."""


class Stateless:
    """Nothing but its properties: FreeCAD keeps these by itself."""

    def dumps(self):
        return None

    def loads(self, state):
        return None

    __getstate__ = dumps  # FreeCAD 0.20 asks for these names

    def __setstate__(self, state):
        return None
