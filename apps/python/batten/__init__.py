"""Batten: smooth surfaces through curves, and mesh morphing with exact form features.

    import batten, numpy as np
    curves = {"front": [[0, 0, 0], [1, 0, 0]], "right": [[1, 0, 0], [1, 1, .3], ...], ...}
    model = batten.skin(curves, fit_tolerance=1e-4)
    model.save("panel.step")
    session = batten.Session(model)

Points are arrays n×3 in model units, triangles are arrays m×3 of 0-based indices. See docs/python.md.
"""

import os as _os

from . import _batten
from . import exchange as _exchange
from ._batten import (
    CancelledError,
    ConflictError,
    Curve,
    Deformer,
    Edge,
    Error,
    FairCurve,
    FeatureRegions,
    FileError,
    Hole,
    InputError,
    Mesh,
    MeshEdit,
    MeshError,
    Model,
    Move,
    NoSolutionError,
    Sequence,
    Session,
    SolveReport,
    Stress,
    StressCase,
    StressPoint,
    SurfacePoint,
    __version__,
    convert,
    deform,
    fair,
    fit,
    load,
    measure_hole,
    parse,
    read_curves,
    read_mesh,
    read_sequence,
    run,
    sequence,
    set_threads,
    skin,
    stress,
    write_curves,
)

__all__ = [
    "CancelledError", "ConflictError", "Curve", "Deformer", "Edge", "Error", "FairCurve", "FeatureRegions",
    "FileError", "Hole", "InputError", "Mesh", "MeshEdit", "MeshError", "Model", "Move", "NoSolutionError", "Sequence", "Session",
    "SolveReport", "Stress", "StressCase", "StressPoint", "SurfacePoint", "convert", "deform", "fair", "fit", "load", "measure_hole", "parse", "read_curves", "read_mesh",
    "read_sequence", "run", "sequence", "set_threads", "skin", "stress", "write_curves",
]

_batten._find_modules(_os.path.dirname(_os.path.abspath(__file__)))

for _class in (Model, Mesh, Session):
    _class.to_meshio = _exchange.to_meshio
    _class.to_vtk = _exchange.to_vtk
    _class.to_pyvista = _exchange.to_pyvista
Model._repr_png_ = _exchange.model_png
Session._repr_png_ = _exchange.session_png
for _name in __all__:
    if isinstance(globals()[_name], type):
        globals()[_name].__module__ = "batten"
del _class, _name
