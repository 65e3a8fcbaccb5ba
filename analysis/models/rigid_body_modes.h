// The motions that supports leave to a shell, or nearly so.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_ties.h"

namespace batten {

/// Motions in which each region stays rigid, in words: "all of it can slide along [0, 0, 1]", "region
/// 'lid' can turn about the axis along … through …".
struct RigidBodyModes {
  /// Nothing resists these: rows and springs do by less than 1e-5 of what they do to others.
  std::vector<std::string> unconstrained;
  /// These are resisted, but by supports that lie within a hundredth of the shell's size of where they
  /// would not be: three points almost in one line.
  std::vector<std::string> weakly_constrained;
  double smallest_lever =
      0;  ///< the smallest lever of them, over the shell's size (root of mean square)
};

/// O(rows + (6 regions)³); models of more than 500 regions are looked at as one body.
RigidBodyModes find_rigid_body_modes(const ModelLayout& model, const Points& shape,
                                     const ShellTies& ties);

}  // namespace batten
