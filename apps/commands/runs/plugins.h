// Plugins: shared libraries that are loaded on demand.
#pragma once

#include <filesystem>
#include <string>

namespace batten {

/// Path of the plugin with this name; empty if it was not built. It is searched in the added
/// folders, beside the program (build tree), and in lib/batten (installation).
std::filesystem::path find_plugin(const std::string& name);

/// Adds a folder that is searched first, for programs that embed Batten as a library. Call it
/// before the first plugin is searched.
void add_plugin_folder(const std::filesystem::path& folder);

/// Loads a plugin and finds its entry function. `global`: true makes its symbols visible to
/// libraries loaded later. Throws InputError with the dynamic linker's message.
void* load_plugin(const std::filesystem::path& file, const char* function, bool global = false);

}  // namespace batten
