# SPDX-License-Identifier: MPL-2.0
"""Serialization of features in FreeCAD documents."""


class Stateless:
    """A feature without state of its own: FreeCAD saves its properties."""

    def dumps(self):
        return None

    def loads(self, state):
        return None

    __getstate__ = dumps  # names that FreeCAD 0.20 requires

    def __setstate__(self, state):
        return None
