// Pieces of strands between nodes. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::detail {

/// A piece of a strand between two nodes.
struct CurveInterval {
  int sampled_curve = 0;
  double s0 = 0, s1 = 0;  ///< arc lengths; s1 above the strand's length: across its seam
  std::array<int, 2> nodes{};
  std::vector<int> shared;  ///< lines that ran along it, whose piece was left out
};

struct NetworkTopology {
  std::vector<Vec3> nodes;               ///< positions
  std::vector<CurveInterval> intervals;  ///< by strand, along it

  /// Number of ends of cuts at each node.
  std::vector<int> degrees() const;
};

}  // namespace batten::detail
