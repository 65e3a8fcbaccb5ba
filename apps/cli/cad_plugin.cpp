// SPDX-License-Identifier: MPL-2.0
// cad_plugin() of the command-line program: loads the OpenCASCADE module at the first call.
#include "batten/io/lines/cad_plugin.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/scenes/runs/plugins.h"

namespace batten {

const CadPlugin& cad_plugin() {
  static const CadPlugin& calls = []() -> const CadPlugin& {
    const std::string name = "batten_cad.so";
    const auto file = find_plugin(name);
    if (file.empty())
      throw InputError(name + ": not found next to the program or in " BATTEN_LIBDIR
                              "/batten, expected for CAD files");
    const CadPlugin& plugin =
        *reinterpret_cast<const CadPlugin* (*)()>(load_plugin(file, "batten_cad"))();
    plugin.enable_sandboxed_read(is_sandboxed_read_enabled());
    return plugin;
  }();
  calls.set_thread_count(thread_count());  // the module may have a thread count of its own
  return calls;
}

}  // namespace batten
