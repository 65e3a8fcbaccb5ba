// The program's cad_calls(): OpenCASCADE comes with a module, at the first call.
#include "batten/apps/commands/runs/module_file.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/lines/cad_calls.h"

namespace batten {

const CadCalls& cad_calls() {
  static const CadCalls& calls = []() -> const CadCalls& {
    const std::string name = "batten_cad.so";
    const auto file = module_file(name);
    if (file.empty())
      throw InputError(name + ": not found beside the program or in " BATTEN_LIBDIR
                              "/batten, expected for CAD files");
    const CadCalls& of_module =
        *reinterpret_cast<const CadCalls* (*)()>(module_entry(file, "batten_cad"))();
    of_module.read_in_child(reads_in_child());
    return of_module;
  }();
  calls.set_thread_count(thread_count());  // the module may have one of its own
  return calls;
}

}  // namespace batten
