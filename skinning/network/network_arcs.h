// The curves of arcs: from node to node exactly, at even speed, with common tangents.
#pragma once

#include "batten/skinning/network/arcs.h"
#include "batten/skinning/network/network_nodes.h"

namespace batten::netting {

/// The data that the curve of an arc is made from.
struct ArcPlan {
  std::shared_ptr<const Piece> input;
  Vec3 start, end;                  ///< positions of the nodes
  Vec3 start_tangent, end_tangent;  ///< unit, along the arc
};

struct ArcShape {
  HermiteCurve curve;
  double length = 0, deviation = 0;
};

/// The input is displaced by what its ends lie off their nodes, fading from end to end with
/// 1 - 3σ² + 2σ³ of the arc length, and turned to the tangents by τ s (1 - s/R)² near an end, with
/// R so short that it moves no point by more than a half of `tolerance`. Then it is interpolated at
/// its nodes, position and unit tangent at even arc length; intervals are halved until the curve is
/// within `fit`. O(segments).
ArcShape make_arc_curve(const ArcPlan& plan, double size, double tolerance, double fit);

}  // namespace batten::netting
