// Loops of arcs that lie in one plane.
#pragma once

#include <optional>

#include "batten/skinning/search/region_graph.h"

namespace batten {

/// Sine of 15 degrees: corners nearer to straight have no plane.
inline constexpr double kMinCornerSine = 0.2588;

/// A loop in one plane, but for 3e-4 of the network's size.
struct PlanarFace {
  Vec3 at, normal;
  double tolerance = 0, area = 0;
  std::vector<Vec3> outline;  ///< a polygon, counter-clockwise around the normal
  /// Whether all points lie in the plane and inside of the outline, not on it.
  bool contains(const std::vector<Vec3>& points) const;
};
/// Returns nothing for a loop that lies in no plane.
std::optional<PlanarFace> planar_face(const RegionGraph& graph, const EdgeLoop& loop);

/// Whether an arc is straight, but for 1e-3 of its length.
bool is_straight(const GraphEdge& edge);

/// Returns at how many places straight arcs of a loop go on in curved ones, where all of it lies in
/// one plane but for 3e-4 of the network's size: the outline of a part that was drawn with straight
/// edges and fillets. 0 for any other loop.
int fillet_ends(const RegionGraph& graph, const EdgeLoop& loop);

/// Returns the loop that arrives by `in`, goes on by `out`, and then goes on by the arcs in the
/// plane of these two that turn most to the inside: a face of the plane graph that the arcs in this
/// plane make. `normal`: of the plane; the loop runs counter-clockwise around it. Empty where both
/// arcs do not lie in such a plane, the way does not come home, or runs around the outside.
/// O(arcs at the nodes of the loop).
EdgeLoop loop_in_plane(const RegionGraph& graph, const OrientedEdge& in, const OrientedEdge& out,
                       const Vec3& normal);

}  // namespace batten
