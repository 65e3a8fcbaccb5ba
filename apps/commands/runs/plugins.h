// Modules: parts of the program that are loaded when they are needed.
#pragma once

#include <filesystem>
#include <string>

namespace batten {

/// Where the module of this name lies: in an added folder, beside the program, as in a build, or in
/// lib/batten, as installed; empty where it was not built.
std::filesystem::path find_plugin(const std::string& name);

/// Adds a folder in which modules are looked for first: of a library that other programs load. Call it
/// before the first module is looked for.
void add_plugin_folder(const std::filesystem::path& folder);

/// Loads a module and finds the function by which it is entered. `global`: all libraries that are loaded
/// later see its symbols. Throws InputError with the linker's reason.
void* load_plugin(const std::filesystem::path& file, const char* function, bool global = false);

}  // namespace batten
