"""Batten in FreeCAD: surfaces between edges, live parameters, continuity.

scene        edges and options as a Batten scene; runs the program `batten`
skin         the parametric feature: its surfaces are made again when an edge changes
fair         a fair curve from points or an edge
continuity   gaps and angles along the edges that faces share
commands     menus, tool bar and the task panel (needs FreeCAD's window)
"""
