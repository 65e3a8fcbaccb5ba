// One tensor-product bicubic B-spline for a surface that is known inside a region of (u, v).
// Internal.
//
//   min  Σ |S(u_k, v_k) - x_k|² / 16  +  ε ∑ over cells of the bending of S in the cell's own units
//        + Σ w (|S_s - x_s|² + |S_t - x_t|²) / 16   where tangent planes count; s, t in the cell's units;
//          w = (goal of the deviation / (goal of the angle · |x_s|))², 4 to 1000: both miss as much of theirs
//
// Samples: 16 in each cell of the knots as far as they are inside, and the region's rim. The
// bending carries the spline across the part of the rectangle that is outside of the region; ε is
// so small that it costs a hundredth of the goal (1e-10 to 1e-6). Knots are simple (S is
// C2) and lie where the errors are: each round, from the error e of every cell and the jumps of
// x_uuu and x_vvv at its sides (which tell the directions apart), new knots with a density ~ (e /
// goal)^¼ / h in each direction. At the fixed points the spline is the surface: the least change of
// the poles that makes it so is added, min Σ |ΔP|², N ΔP = x - S.
#pragma once

#include <functional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/spline_axis.h"

namespace batten {

// A bicubic B-spline, and the surface that it should come near to. Internal.

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


struct PatchFit {
  BicubicPatch patch;
  /// Largest |S - x| at points inside and on the rim that were not fitted.
  double deviation = 0;
  double angle_deg = 0;  ///< largest angle from the target's tangent planes, at such places
  bool reached = false;  ///< deviation and angle are at most their goals
};

struct PatchLimits {
  int max_poles_per_direction = 400;  ///< poles
  int max_poles = 60'000;
  /// Intervals along the longer side of the first fit, 2 or more: a bend much shorter than one lies
  /// between its samples and is not seen.
  int initial_intervals = 8;
};

/// The fit with the fewest poles that was found for a deviation and an angle of at most `goal`, both
/// > 0; where none reaches it, within the limits or because finer knots no longer help, the one
/// that comes nearest.
/// x near the origin keeps the digits. About 3 µs a cell and round, and one sparse factor each.
/// With `start`, its knots are the first.
PatchFit fit_bicubic_patch(const PatchTarget& target, const PatchGoal& goal,
                           const PatchLimits& limits = {}, const BicubicPatch* start = nullptr);

}  // namespace batten
