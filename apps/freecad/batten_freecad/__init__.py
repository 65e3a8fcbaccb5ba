# SPDX-License-Identifier: MPL-2.0
"""Batten in FreeCAD: surfaces between edges, interactive parameters, continuity checks.

scene        converts edges and options to a Batten scene; runs the program `batten`
skin         the parametric feature Skin: its surfaces are updated when an edge changes
fair         the parametric feature FairCurve
continuity   gaps and angles along the edges that faces share
commands     menus, tool bar and the task panel (needs FreeCAD's window)
"""
