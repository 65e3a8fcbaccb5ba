// SPDX-License-Identifier: MPL-2.0
// The command line of `batten`, with all its commands.
#pragma once

#include <vector>

#include "batten/apps/cli/commands.h"

namespace batten {

/// The command line of the program. `common` must outlive it.
struct Program {
  explicit Program(CommonOptions& common);

  CommandLine line;
  std::vector<Command> commands;
};

}  // namespace batten
