// SPDX-License-Identifier: MPL-2.0
// The extension module `_batten`, the base of the Python package `batten`.

#include <filesystem>

#include "batten/apps/python/bindings.h"
#include "batten/core/errors.h"
#include "batten/core/log.h"
#include "batten/core/parallel.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/scenes/runs/plugins.h"

namespace batten::python {
namespace {

/// Registers the folders of plugins (OpenCASCADE): next to this module in a build, or as installed.
void find_plugins(const std::string& package) {
  add_plugin_folder(package);
  add_plugin_folder(std::filesystem::path(package) / BATTEN_PYTHON_TO_LIBDIR);
}

/// Forwards messages to a Python callable(level, message); None: to nothing.
void set_python_log(const py::object& function) {
  if (function.is_none()) {
    const py::gil_scoped_release free;  // a thread that logs waits for the GIL
    set_log({});
    return;
  }
  if (!PyCallable_Check(function.ptr()))
    throw InputError("function: found " + py::repr(function).cast<std::string>() +
                     ", expected a function of (level, message), or None");
  // The last reference may be dropped without the GIL.
  const std::shared_ptr<py::object> shared(new py::object(function), [](py::object* object) {
    const py::gil_scoped_acquire gil;
    delete object;
  });
  LogFunction forward = [shared](LogLevel level, std::string_view message) {
    const py::gil_scoped_acquire gil;
    try {
      (*shared)(static_cast<int>(level), py::str(printable(message)));
    } catch (py::error_already_set& error) {
      error.discard_as_unraisable("batten.set_log");
    }
  };
  const py::gil_scoped_release free;
  set_log(std::move(forward));
}

void set_threads(int count) {
  if (count < 0) throw InputError("count: found " + std::to_string(count) + ", expected 0 or more");
  set_thread_count(count);
}

}  // namespace

PYBIND11_MODULE(_batten, m) {
  m.doc() = "Batten: smooth, sculptable surfaces from curves, and mesh morphing. Import `batten`.";
  m.attr("__version__") = BATTEN_VERSION;
  // Read foreign formats in a child process: damaged files could crash the interpreter.
  enable_sandboxed_read(true);
  bind_errors(m);
  bind_curves(m);
  bind_gradients(m);
  bind_models(m);
  bind_sessions(m);
  bind_meshes(m);
  bind_deformers(m);
  bind_edits(m);
  bind_sequences(m);
  bind_stress(m);
  bind_runs(m);
  m.def("_find_modules", &find_plugins, py::arg("package"));
  m.def("set_threads", &set_threads, py::arg("count"),
        R"(Sets the number of threads of the kernel; 0: all cores. Results do not depend on it.

    >>> batten.set_threads(0))");
  m.def(
      "set_log", &set_python_log, py::arg("function"),
      R"(Sets the function that receives messages of the kernel: function(level, message); None: no messages.

`level` is that of the module logging: 10 (debug: steps of the solvers), 20 (info: models, files) or 30
(warnings, which are also in the reports). It may be called by any thread, one at a time.

    >>> import logging
    >>> batten.set_log(logging.getLogger("batten").log)
    >>> batten.set_log(None))");
  // Before the interpreter ends, and the function with it.
  py::module_::import("atexit").attr("register")(
      py::cpp_function([] { set_python_log(py::none()); }));
  give_signatures(m);
}

// The kernel's errors as Python exceptions.

namespace {

/// The exception classes. They are never released.
struct ErrorTypes {
  PyObject *error = nullptr, *input = nullptr, *mesh = nullptr, *file = nullptr,
           *conflict = nullptr, *no_solution = nullptr, *cancelled = nullptr;
};
ErrorTypes error_types;

PyObject* new_error(py::module_& module, const char* name, const char* words,
                    const py::object& bases) {
  const std::string full = std::string("batten.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full.c_str(), words, bases.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  module.add_object(name, type);
  return type;
}

std::string text_of(const Error& error) {
  return printable(error.what(), LineFeeds::KeepBeforeIndent);
}

void raise_conflict(const ConflictError& error) {
  py::list conflicts;
  for (const ConflictError::Conflict& one : error.conflicts()) {
    py::tuple names(one.names.size());
    for (size_t i = 0; i < one.names.size(); ++i) names[i] = one.names[i];
    conflicts.append(py::make_tuple(names, one.amount));
  }
  const py::object raised =
      py::reinterpret_borrow<py::object>(error_types.conflict)(py::str(text_of(error)));
  raised.attr("conflicts") = conflicts;
  PyErr_SetObject(error_types.conflict, raised.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const ConflictError& error) {
    raise_conflict(error);
  } catch (const MeshError& error) {
    PyErr_SetString(error_types.mesh, text_of(error).c_str());
  } catch (const FileError& error) {
    PyErr_SetString(error_types.file, text_of(error).c_str());
  } catch (const InputError& error) {
    PyErr_SetString(error_types.input, text_of(error).c_str());
  } catch (const NoSolutionError& error) {
    PyErr_SetString(error_types.no_solution, text_of(error).c_str());
  } catch (const CancelledError& error) {
    PyErr_SetString(error_types.cancelled, text_of(error).c_str());
  } catch (const Error& error) {
    PyErr_SetString(error_types.error, text_of(error).c_str());
  }
}

}  // namespace

void bind_errors(py::module_& m) {
  const auto type = [](PyObject* of) { return py::reinterpret_borrow<py::object>(of); };
  error_types.error =
      new_error(m, "Error", "Base class of the exceptions of Batten.", type(PyExc_Exception));
  const py::object error = type(error_types.error);
  error_types.input = new_error(
      m, "InputError",
      "Invalid input: the location, what was found and what is expected. Also a ValueError.",
      py::make_tuple(error, type(PyExc_ValueError)));
  const py::object input = type(error_types.input);
  error_types.mesh =
      new_error(m, "MeshError", "An invalid mesh, or curves that cannot be meshed.", input);
  error_types.file = new_error(m, "FileError", "A file cannot be written.", input);
  error_types.conflict = new_error(
      m, "ConflictError",
      "Contradictory constraints. `conflicts`: a list of ((name, …), amount of the contradiction).",
      error);
  error_types.no_solution =
      new_error(m, "NoSolutionError", "A singular system, or a load beyond its limit.", error);
  error_types.cancelled = new_error(m, "CancelledError", "The computation was stopped.", error);
  py::register_exception_translator(translate);
}

}  // namespace batten::python
