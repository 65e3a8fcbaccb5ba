// Inside of fair_points: where the faired curve has nodes.
#pragma once

#include <vector>

#include "batten/fairing/point_sequence.h"
#include "batten/fem/curve_mesh.h"

namespace batten {

struct KnotPlacement {
  CurveMesh mesh;                ///< over [0, length]
  std::vector<int> corner_node;  ///< of each corner of the row
};

/// A node at every parameter of `forced`, and at every point that is not too near to another node:
/// of more than `max_knots` points at every second, or third, …; of fewer half way between, too.
/// u: of the points, in [0, length]. Where the curve is `mirrored`, its second half has the mirror
/// images of the nodes of the first.
KnotPlacement place_knots(const PointSequence& sequence, const std::vector<double>& u,
                          double length, std::vector<double> forced, bool mirrored, int max_knots);

}  // namespace batten
