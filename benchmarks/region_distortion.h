// SPDX-License-Identifier: MPL-2.0
// Changes of lengths and angles if feature regions are kept: one table per model.
#pragma once

#include <optional>

#include "batten/tests/support/featured_models.h"
#include "bench.h"

namespace batten::bench {

/// Largest and mean value.
struct Spread {
  double most = 0, mean = 0;
};

/// Relative changes of edges, and changes of angles in degrees. "Inside" are the faces of the
/// regions and their edges. Edges and triangles whose vertices are all fixed or moved are excluded.
struct Distortion {
  Spread edges_inside, angles_inside, edges_outside, angles_outside;
};

/// Values for the checks.
struct DistortionSummary {
  double soft = 0, hard = 0;  // largest edge change inside; `hard`: the worse of both estimates
  double outside = 0;         // mean edge change outside: hard divided by its estimate
  double nonlinear_outside = 0;
  std::optional<double> tilt_apart;  // degrees between the region and the surrounding sheet
};

/// Runs every deformer on the model and prints the table.
DistortionSummary distortion_of(const batten_test::FeaturedModel& model);

/// A real mesh: the lowest tenth along its longest axis is fixed, the farthest tenth is moved
/// sideways by 0.15 of the size without a rotation. Discs of 5 % of the size around salient
/// vertices are kept. Throws std::logic_error if there are fewer than three separated salient
/// vertices.
batten_test::FeaturedModel pushed_sideways(const std::string& name, const TriangleMesh& mesh);

}  // namespace batten::bench
