// The curves of arcs: from node to node exactly, at even speed, with common tangents.
#pragma once

#include "batten/skinning/network/network_edge.h"
#include "batten/skinning/network/network_nodes.h"

namespace batten::detail {

/// The data that the curve of an arc is made from.
struct EdgeCurveInput {
  std::shared_ptr<const TrimmedCurve> input;
  Vec3 start, end;                  ///< positions of the nodes
  Vec3 start_tangent, end_tangent;  ///< unit, along the arc
};

struct EdgeCurve {
  HermiteCurve curve;
  double length = 0, deviation = 0;
};

/// The input is displaced by what its ends lie off their nodes, fading from end to end with
/// 1 - 3σ² + 2σ³ of the arc length, and turned to the tangents by τ s (1 - s/R)² near an end, with
/// R so short that it moves no point by more than a half of `tolerance`. Then it is interpolated at
/// its nodes, position and unit tangent at even arc length; intervals are halved until the curve is
/// within `fit`. O(segments).
EdgeCurve make_edge_curve(const EdgeCurveInput& plan, double size, double tolerance, double fit);

}  // namespace batten::detail
