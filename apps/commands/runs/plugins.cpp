#include "batten/apps/commands/runs/plugins.h"

#include <dlfcn.h>

#include <vector>

#include "batten/core/errors.h"

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

void* load_plugin(const fs::path& file, const char* function, bool global) {
  void* library = dlopen(file.c_str(), global ? RTLD_NOW | RTLD_GLOBAL : RTLD_LAZY | RTLD_LOCAL);
  void* entry = library ? dlsym(library, function) : nullptr;
  if (!entry) throw InputError(file.string() + ": cannot load this plugin: " + dlerror());
  return entry;
}

}  // namespace batten
