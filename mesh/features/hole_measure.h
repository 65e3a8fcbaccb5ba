// Where a hole is, how large, how round and how flat.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Place, size and shape of a hole. Lengths are in the unit of the points.
struct HoleMeasure {
  Vec3 centre;       ///< centre of the circle
  Vec3 axis;         ///< unit normal of the plane, on the side of the mesh's normals
  double radius;     ///< radius of the circle
  double roundness;  ///< largest | |x_i - centre| - radius | in the plane
  double flatness;   ///< largest distance of a vertex from the plane
  double perimeter;  ///< length of the closed polygon
  /// Radius of the circle of the same area as the polygon in the plane: what a slotted or hexagonal
  /// hole is as large as.
  double equivalent_radius;
  /// Whether it has five vertices or more, roundness up to the given share of the radius, and
  /// encloses half of the circle's area or more. Four vertices never tell: every rectangle has a
  /// circle through its corners; a slender loop lies on a short arc of a large circle.
  bool circular;
};

/// The circle nearest to a closed loop of vertices.
///
/// Plane: through the centroid of the vertices, its normal the right singular vector of the least
/// singular value of the centred points (least sum of squared distances). Circle in this plane:
/// first the algebraic fit, |x|² = 2 m·x + c in the least-squares sense, from it by Gauss-Newton
/// the geometric one, min Σ (|x_i - m| - R)². Both are exact for points on a circle, to rounding.
///
/// The axis points to where the loop runs clockwise: for loops of MeshTopology, which have the
/// surface on their left, that is the side of the mesh's normals. A loop keeps its direction when
/// the mesh deforms, so axes before and after are comparable.
///
/// Loops that are no circles (door openings) have a measure, too: the best circle, whose roundness
/// says how far it is off. Throws InputError for fewer than three vertices, numbers out of range,
/// a coordinate that is not finite. O(loop).
HoleMeasure measure_hole(const Points& points, const std::vector<int>& loop,
                         double circular_tolerance = 0.02);

}  // namespace batten
