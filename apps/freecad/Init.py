"""Batten for FreeCAD. The package batten_freecad also works without a window."""
