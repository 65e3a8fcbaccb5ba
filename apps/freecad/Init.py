"""Batten for FreeCAD: what a FreeCAD without a window needs of it is in the package batten_freecad."""
