// The Python module `_batten`, which the package `batten` is made of.
#include <filesystem>

#include "batten/apps/commands/runs/plugins.h"
#include "batten/apps/python/bindings.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/files/sandboxed_read.h"

namespace batten::python {
namespace {

/// Says where the module of OpenCASCADE lies: beside this one in a build, or as installed.
void find_plugins(const std::string& package) {
  add_plugin_folder(package);
  add_plugin_folder(std::filesystem::path(package) / BATTEN_PYTHON_TO_LIBDIR);
}

void set_threads(int count) {
  if (count < 0) throw InputError("count: found " + std::to_string(count) + ", expected 0 or more");
  set_thread_count(count);
}

}  // namespace

PYBIND11_MODULE(_batten, m) {
  m.doc() = "Batten: continuous surfaces that shape themselves. Import `batten`.";
  m.attr("__version__") = BATTEN_VERSION;
  // Damaged files of other libraries' formats bring down a child process, not the interpreter.
  enable_sandboxed_read(true);
  bind_errors(m);
  bind_curves(m);
  bind_models(m);
  bind_sessions(m);
  bind_meshes(m);
  bind_deformers(m);
  bind_edits(m);
  bind_sequences(m);
  bind_runs(m);
  m.def("_find_modules", &find_plugins, py::arg("package"));
  m.def("set_threads", &set_threads, py::arg("count"),
        "How many threads the kernel uses; 0: all cores. Results do not depend on it.");
}

}  // namespace batten::python
