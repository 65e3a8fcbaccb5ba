// What becomes of lengths and angles when feature regions are kept: one table a model.
#pragma once

#include <optional>

#include "batten/tests/support/featured_models.h"
#include "bench.h"

namespace batten::bench {

/// Largest and mean of something.
struct Spread {
  double most = 0, mean = 0;
};

/// Relative changes of edges, changes of angles in degrees; inside: faces of the regions and their
/// edges. Edges and triangles whose vertices are all held or moved are left out.
struct Distortion {
  Spread edges_inside, angles_inside, edges_outside, angles_outside;
};

/// What the promises are about.
struct DistortionSummary {
  double soft = 0, hard = 0;  // largest edge change inside, the worse of both estimates for `hard`
  double outside = 0;         // mean edge change outside: hard over its estimate
  double nonlinear_outside = 0;
  std::optional<double> tilt_apart;  // degrees between the region and the sheet around it
};

/// Runs every deformer on the model and prints the table.
DistortionSummary distortion_of(const batten_test::FeaturedModel& model);

/// A real mesh: the lowest tenth along its longest axis is fixed, the farthest tenth moved sideways
/// by 0.15 of its size without a turn; discs of 5 % of the size around salient vertices are kept.
/// Throws std::logic_error where fewer than three such vertices lie apart.
batten_test::FeaturedModel pushed_sideways(const std::string& name, const TriangleMesh& mesh);

}  // namespace batten::bench
