// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/runs/plugins.h"

#include <dlfcn.h>

#include <algorithm>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/memory.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path>& plugin_folders() {
  static std::vector<fs::path> folders;
  return folders;
}

}  // namespace

void add_plugin_folder(const fs::path& folder) { plugin_folders().push_back(folder); }

fs::path find_plugin(const std::string& name) {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none).parent_path();
  std::vector<fs::path> folders = plugin_folders();
  folders.push_back(program);
  folders.push_back(program / ".." / BATTEN_LIBDIR / "batten");
  for (const fs::path& folder : folders)
    if (fs::exists(folder / name, none)) return folder / name;
  return {};
}

// OpenCASCADE maps 85 MB of addresses; with less, the dynamic linker may end the process.
constexpr double kAddressesToLoad = 1e8;  // bytes

void* load_plugin(const fs::path& file, const char* function, bool global) {
  if (const double found = available_addresses(); found < kAddressesToLoad)
    throw NoSolutionError(file.string() + ": not enough memory to load this plugin: it needs " +
                          format_bytes(kAddressesToLoad) + " of address space, but only " +
                          format_bytes(std::max(found, 0.0)) + " are available (ulimit -v)");
  void* library = dlopen(file.c_str(), global ? RTLD_NOW | RTLD_GLOBAL : RTLD_LAZY | RTLD_LOCAL);
  void* entry = library ? dlsym(library, function) : nullptr;
  if (entry) return entry;
  const std::string reason = dlerror();
  for (const char* shortage :
       {"failed to map segment", "cannot map zero-fill", "annot allocate memory"})
    if (reason.find(shortage) != reason.npos)
      throw NoSolutionError(file.string() + ": not enough memory to load this plugin: " + reason);
  throw InputError(file.string() + ": cannot load this plugin: " + reason);
}

std::unique_ptr<MpiProcesses> connect_mpi_processes() {
  if (MpiProcesses::count() < 2) return nullptr;
  const fs::path file = find_plugin("batten_petsc.so");
  if (file.empty())
    throw InputError("found " + std::to_string(MpiProcesses::count()) +
                     " MPI processes, expected one: this program was built without PETSc "
                     "(libpetsc-real-dev)");
  // Open MPI's own plugins need its symbols to be global.
  return std::make_unique<MpiProcesses>(reinterpret_cast<decltype(&batten_distributed)>(
      load_plugin(file, "batten_distributed", true)));
}

}  // namespace batten
