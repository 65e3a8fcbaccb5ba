// SPDX-License-Identifier: MPL-2.0
// Plugins: shared libraries that are loaded on demand, so that programs that do not use them do not
// depend on their libraries.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "batten/core/solvers/distributed_solver.h"

namespace batten {

/// Path of the plugin with this name; empty if it was not built. It is searched in the added
/// folders, beside the program (build tree), and in lib/batten (installation).
std::filesystem::path find_plugin(const std::string& name);

/// Adds a folder that is searched first, for programs that embed Batten as a library. Call it
/// before the first plugin is searched.
void add_plugin_folder(const std::filesystem::path& folder);

/// Loads a plugin and finds its entry function. `global`: true makes its symbols visible to
/// libraries loaded later. Throws InputError with the dynamic linker's message, and NoSolutionError
/// if the memory does not suffice.
void* load_plugin(const std::filesystem::path& file, const char* function, bool global = false);

/// The MPI processes of this run, connected by the PETSc plugin; null if there is only one process.
/// Throws InputError if the plugin was not built (no PETSc) or cannot be started.
std::unique_ptr<MpiProcesses> connect_mpi_processes();

}  // namespace batten
