// Where the surfaces beside a line have one tangent plane, which their faces are to keep. Internal.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/cad/face_boundary.h"

namespace batten {

/// Surfaces that meet by less than this are tangent: networks join smoothly within 0.1 degrees.
constexpr double kTangentDeg = 0.2;

/// One of the sides of lines: a region's boundary, and the unit normal of its surface at (u, v).
struct TangentSide {
  FaceBoundary* boundary;
  std::function<Vec3(const Vec2& uv)> normal;
};

/// A piece of a line between two of the plan's cuts: the line's name, and how many cuts are before.
using LineSegmentId = std::pair<std::string, int>;
LineSegmentId segment_id_of(const StepPlan& plan, const FaceBoundarySegment& segment);

/// Sets the turns of all stretches that two sides have in common: to normals between those of the two
/// surfaces, smooth along the line and one for all joins that meet in a place. O(stretches).
void find_tangent_joins(const StepPlan& plan, const std::vector<TangentSide>& sides,
                        double tolerance);

/// The angle between two planes by their normals, degrees in [0, 90]: a plane has no side.
double angle_between_planes(const Vec3& a, const Vec3& b);

}  // namespace batten
