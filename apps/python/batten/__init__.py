# SPDX-License-Identifier: MPL-2.0
"""Batten: smooth surfaces through curves, and mesh morphing with exact form features.

Points are arrays n×3 in model units, triangles are arrays m×3 of 0-based indices. See docs/python.md.
The examples in the docstrings of the package use the following objects:

    >>> import batten
    >>> import numpy as np
    >>> rim = {"front": [[0, 0, 0], [50, 0, 20], [100, 0, 0]], "right": [[100, 0, 0], [100, 100, 20]],
    ...        "back": [[100, 100, 20], [0, 100, 0]], "left": [[0, 100, 0], [0, 0, 0]]}
    >>> model = batten.skin(rim, name="panel")
    >>> session = batten.Session(model)
    >>> session.add_pressure("swell", min=-50, max=50)
    >>> mesh = model.mesh()
    >>> stress = batten.stress(model, material="steel", thickness=2, supports=["front", "back"],
    ...                        loads=[{"pressure": -0.01}])
"""

import os as _os

from . import _batten
from . import exchange as _exchange
from . import pictures as _pictures
from ._batten import (
    CancelledError,
    Chain,
    ConflictError,
    Curve,
    Deformer,
    DeformerReport,
    DetectedFeature,
    Edge,
    Error,
    FairCurve,
    FeatureRegions,
    FileError,
    Hole,
    InputError,
    LinearConstraint,
    LoadEffect,
    Mesh,
    MeshEdit,
    MeshError,
    Model,
    ModelGradients,
    Move,
    NoSolutionError,
    OnLine,
    OnPlane,
    Sequence,
    Session,
    SessionStress,
    SolveReport,
    Stress,
    StressCase,
    StressGradients,
    StressPoint,
    SurfacePoint,
    ValueWithGradient,
    __version__,
    convert,
    deform,
    fair,
    fit,
    fit_surface,
    load,
    measure_hole,
    parse,
    read_curves,
    read_mesh,
    read_sequence,
    run,
    sequence,
    set_log,
    set_threads,
    skin,
    stress,
    write_curves,
)

__all__ = [
    "CancelledError", "Chain", "ConflictError", "Curve", "Deformer", "DeformerReport", "DetectedFeature", "Edge", "Error", "FairCurve", "FeatureRegions",
    "FileError", "Hole", "InputError", "LinearConstraint", "LoadEffect", "Mesh", "MeshEdit", "MeshError", "Model", "ModelGradients", "Move", "NoSolutionError", "OnLine", "OnPlane", "Sequence", "Session", "SessionStress",
    "SolveReport", "Stress", "StressCase", "StressGradients", "StressPoint", "SurfacePoint", "ValueWithGradient", "convert", "deform", "fair", "fit", "fit_surface", "load", "measure_hole", "parse", "read_curves", "read_mesh",
    "read_sequence", "run", "sequence", "set_log", "set_threads", "skin", "stress", "write_curves",
]

_batten._find_modules(_os.path.dirname(_os.path.abspath(__file__)))

_exchange.add_to((Model, Mesh, Session, Stress))
for _class in (Model, Session):
    _class.show = _pictures.show
    _class._repr_png_ = _pictures.repr_png
for _name in __all__:
    if isinstance(globals()[_name], type):
        globals()[_name].__module__ = "batten"
del _class, _name
