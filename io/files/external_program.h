// SPDX-License-Identifier: MPL-2.0
// Runs programs of other projects, such as CalculiX and Gmsh.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// A program that the user has installed.
struct ExternalProgram {
  std::string name;         ///< searched in PATH, for example "ccx"
  std::string variable;     ///< environment variable that names another program or path
  std::string description;  ///< for messages: "CalculiX (calculix-ccx)"
};

/// Runs the program with `arguments` in the folder `folder` and waits for its end. Its output goes
/// to the file `log`; an empty name discards it. The program ends together with this process.
/// Returns its exit status, or 128 plus the number of the signal that ended it. Throws InputError if
/// it is not found or cannot be started.
int run_external_program(const ExternalProgram& program, const std::vector<std::string>& arguments,
                         const std::filesystem::path& folder,
                         const std::filesystem::path& log = {});

}  // namespace batten
