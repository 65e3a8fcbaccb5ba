// SPDX-License-Identifier: MPL-2.0
// Finds the curves along which adjacent surfaces are tangent, and the common normals that their
// faces must have.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/step/face_boundary.h"
#include "batten/skinning/model/neighbour_edge.h"

namespace batten {

/// Surfaces that meet at less than this angle, degrees, count as tangent: networks join smoothly
/// within 0.1 degrees.
constexpr double kTangentDeg = 0.2;

/// One side of curves: the boundary of a model face, and the unit normal of its surface at (u, v).
struct TangentSide {
  FaceBoundary* boundary;
  std::function<Vec3(const Vec2& uv)> normal;
};

/// A piece of a curve between two cuts of the plan: the name of the curve, and the number of cuts
/// before the piece.
using LineSegmentId = std::pair<std::string, int>;
LineSegmentId segment_id_of(const StepPlan& plan, const FaceBoundarySegment& segment);

/// Sets the normal corrections of all segments that are shared by two sides. The common normals lie
/// between those of the two surfaces, are smooth along the curve, and agree for all joins that meet
/// at a point. `tolerance`: allowed deviation of the faces, model units. O(segments).
void find_tangent_joins(const StepPlan& plan, const std::vector<TangentSide>& sides,
                        double tolerance);

/// Sets the normal corrections of the segments of `side` that lie on edges of given surfaces, unless
/// the surfaces meet at more than kNeighbourDeg there. `neighbours`: by the name of the curve.
/// O(segments).
constexpr double kNeighbourDeg = 1;
void follow_neighbours(
    const TangentSide& side,
    const std::map<std::string, std::shared_ptr<const NeighbourEdge>>& neighbours);

/// The angle between two planes given by their normals, degrees in [0, 90]; the signs of the
/// normals do not matter.
double angle_between_planes(const Vec3& a, const Vec3& b);

// Twist compatibility of faces at the vertices where smooth joins meet.

/// The end of a smooth join at a vertex: the unit tangent of its curve, pointing away from the
/// vertex, the unit normal of both faces, and the derivative of that normal with respect to arc
/// length.
struct TwistEnd {
  Vec3 along, normal, slope;
};

/// The corner of a face between the ends of two joins. `sign`: -1 if the face's normal is opposite
/// to that of the end, else +1.
struct TwistCorner {
  std::array<int, 2> ends;
  std::array<double, 2> sign;
};

/// Twist rates that make the joins at each vertex compatible with C2 faces. In the corner of a face
/// with continuous curvature, both sides imply the same twist: n₁'·t₂ = n₂'·t₁. Surfaces of C1
/// elements need not satisfy this. Then the angle error of a C2 spline decreases only with the size
/// of its first knot interval. Returns for each end the rate c by which its normals rotate about
/// the curve, n' + c n × t. The rates are small and satisfy the condition in all corners as well as
/// possible:
///
///   min Σ over corners and their two ends |n' + c n × t + B t|² + ε Σ c²,
///   with one symmetric 2×2 matrix B (Weingarten map) per corner
///
/// Costs one sparse factorisation of size 3 corners + ends.
std::vector<double> matching_twists(const std::vector<TwistEnd>& ends,
                                    const std::vector<TwistCorner>& corners);

}  // namespace batten
