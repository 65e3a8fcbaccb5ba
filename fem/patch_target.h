// A bicubic B-spline, and the surface that it should come near to. Internal.
#pragma once

#include <functional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/spline_axis.h"

namespace batten {

/// The spline S(u, v).
struct BicubicPatch {
  SplineAxis u, v;
  Points poles;  ///< of function i of u and j of v: row i · v.functions() + j

  Vec3 position(const Vec2& uv) const;
  Vec3 normal(const Vec2& uv) const;  ///< along S_u × S_v, of any length
};

/// What a fit may miss.
struct PatchGoal {
  double deviation = 0;
  double angle_deg = 180;  ///< where tangent planes count
};

/// A place on the rim, and derivatives that span the tangent plane which the spline is to have there.
struct PatchTangent {
  Vec2 uv;
  Vec3 x_u, x_v;
};

/// The longest steps in u and in v to take along the rim from a place: shares of the cell there.
using BoundaryStep = std::function<Vec2(const Vec2&)>;

/// A surface that is known inside a region of (u, v).
struct PatchTarget {
  std::function<bool(const Vec2&)> inside;    ///< called from several threads, as is the next
  std::function<Vec3(const Vec2&)> position;  ///< asked for inside and on the rim
  /// Points along the rim, none farther from the next than the step there.
  std::function<std::vector<Vec2>(const BoundaryStep& longest)> boundary;
  Vec2 low, high;  ///< box around the region; of a periodic one high - low in u is the period
  bool periodic = false;         ///< in u
  std::vector<Vec2> fixed = {};  ///< where the spline passes through the surface: corners
  /// Places along those parts of the rim where tangent planes count, likewise; null: nowhere.
  std::function<std::vector<PatchTangent>(const BoundaryStep& longest)> tangents = {};
};

}  // namespace batten
