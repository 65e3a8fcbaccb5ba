"""Batten: smooth surfaces from the lines that carry a design, and meshes whose features keep their shape.

    import batten, numpy as np
    lines = {"front": [[0, 0, 0], [1, 0, 0]], "right": [[1, 0, 0], [1, 1, .3], ...], ...}
    model = batten.skin(lines, tolerance=1e-4)
    model.save("panel.step")
    session = batten.Session(model)

Points are arrays n×3 in model units, triangles m×3 from 0. See docs/python.md.
"""

import os as _os

from . import _batten
from . import exchange as _exchange
from ._batten import (
    Answer,
    CancelledError,
    ConflictError,
    Curve,
    Deformer,
    Error,
    FairCurve,
    FeatureRegions,
    FileError,
    InputError,
    Mesh,
    MeshEdit,
    MeshError,
    Model,
    Move,
    NoSolutionError,
    Sequence,
    Session,
    __version__,
    convert,
    deform,
    fair,
    fit,
    load,
    measure_hole,
    parse,
    read_lines,
    read_mesh,
    read_sequence,
    run,
    sequence,
    set_threads,
    skin,
    stress,
    write_lines,
)

__all__ = [
    "Answer", "CancelledError", "ConflictError", "Curve", "Deformer", "Error", "FairCurve", "FeatureRegions",
    "FileError", "InputError", "Mesh", "MeshEdit", "MeshError", "Model", "Move", "NoSolutionError", "Sequence", "Session",
    "convert", "deform", "fair", "fit", "load", "measure_hole", "parse", "read_lines", "read_mesh",
    "read_sequence", "run", "sequence", "set_threads", "skin", "stress", "write_lines",
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
