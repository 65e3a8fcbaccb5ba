// SPDX-License-Identifier: MPL-2.0
// What --version prints.
#pragma once

#include <string>

namespace batten {

/// Version, commit and its date, compiler, options and libraries of the build, plugins that were
/// found, and the licence of this program, one per line: "name  value".
std::string version_text();

}  // namespace batten
