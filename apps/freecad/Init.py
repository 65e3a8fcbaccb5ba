# SPDX-License-Identifier: MPL-2.0
"""Batten for FreeCAD. The package batten_freecad also works without a window."""
