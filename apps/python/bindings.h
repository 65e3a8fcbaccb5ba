// SPDX-License-Identifier: MPL-2.0
// Declares the binding functions of the Python module `_batten`, one per group of names.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace batten::python {

namespace py = pybind11;

/// Each adds its classes and functions to the module. bind_errors() must come first, because the
/// others throw these exceptions.
void bind_errors(py::module_& module);
void bind_curves(py::module_& module);
void bind_gradients(py::module_& module);
void bind_models(py::module_& module);
void bind_sessions(py::module_& module);
void bind_meshes(py::module_& module);
void bind_constraints(py::module_& module);  // of deformers; called by bind_deformers()
void bind_deformers(py::module_& module);
void bind_edits(py::module_& module);
void bind_sequences(py::module_& module);
void bind_stress(py::module_& module);
void bind_runs(py::module_& module);

/// Same as `batten stress` of a scene or curve file; the result is the report (bind_runs.cpp).
py::object run_stress_file(const py::object& path, const py::object& out, const py::object& values,
                           std::optional<double> accuracy, const py::object& progress);

/// Gives all functions and methods of a module or class the signature that inspect.signature() reads
/// (__text_signature__), and messages that name unknown keyword arguments. Call it last.
void give_signatures(py::handle scope);

}  // namespace batten::python
