// What is known of a shape beside its dofs.
#pragma once

#include <string>

#include "batten/core/eigen.h"

namespace batten {

/// The force with which a named line or constraint holds the surface: the sum of its reaction over
/// the position dofs, in the units of the loads.
struct Reaction {
  std::string name;
  Vec3 force = Vec3::Zero();
};

/// How far the points of a scan are from the surface, model units. Points beyond the rim are left
/// out.
struct ScanDistances {
  std::string name;
  int points = 0, left_out = 0;
  double before_max = 0, before_rms = 0;  ///< of the shape to compare with
  double max = 0, rms = 0;
};

}  // namespace batten
