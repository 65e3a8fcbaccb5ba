// Least-squares fit of a tensor-product bicubic B-spline to a surface that is known inside a region
// of (u, v).
//
//   min  Σ |S(u_k, v_k) - x_k|² / 16  +  ε ∑ over cells of the bending of S in the cell's own units
//        + Σ w (|S_s - x_s|² + |S_t - x_t|²) / 16   at prescribed tangent planes, with s, t in the
//          cell's units; w = (deviation goal / (angle goal · |x_s|))², limited to 4 … 1000, so that
//          both errors are weighted relative to their goals
//
// Samples: 16 per knot cell, as far as they are inside, and points on the boundary of the region.
// The bending term extends the spline over the part of the rectangle outside of the region. ε is so
// small that it costs a hundredth of the goal (1e-10 to 1e-6).
//
// Knots are simple (S is C2) and adapted to the errors. Each iteration uses the error e of every
// cell, and the jumps of x_uuu and x_vvv at its sides, which distinguish the two directions. New
// knots have a density ~ (e / goal)^¼ / h in each direction. Finally S interpolates the surface at
// the fixed points: the smallest change of the poles that achieves this is added, min Σ |ΔP|², N
// ΔP = x - S.
#pragma once

#include <functional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/spline_axis.h"

namespace batten {

// Bicubic B-spline, and the target surface of a fit.

/// Bicubic B-spline surface S(u, v).
struct BicubicPatch {
  SplineAxis u, v;
  Points poles;  ///< pole of function i of u and j of v: row i · v.functions() + j

  Vec3 position(const Vec2& uv) const;
  Vec3 normal(const Vec2& uv) const;  ///< along S_u × S_v, not normalised
};

/// Tolerances of a fit.
struct PatchGoal {
  /// Largest distance from the target, in model units, > 0.
  double deviation = 0;
  double angle_deg = 180;  ///< largest angle between tangent planes, degrees
};

/// A point on the boundary of the region, and derivatives that span the tangent plane prescribed
/// there.
struct PatchTangent {
  Vec2 uv;
  Vec3 x_u, x_v;
};

/// Longest steps in u and in v between samples of the boundary that start at the given point. They
/// depend on the size of the knot cell that contains the point.
using BoundaryStep = std::function<Vec2(const Vec2&)>;

/// Target of a fit: a surface that is known inside a region of (u, v).
struct PatchTarget {
  std::function<bool(const Vec2&)> inside;    ///< thread-safe, as is `position`
  std::function<Vec3(const Vec2&)> position;  ///< defined inside and on the boundary
  /// Samples the boundary: points in order, with steps in u and in v of at most `longest`.
  std::function<std::vector<Vec2>(const BoundaryStep& longest)> boundary;
  Vec2 low, high;  ///< bounding box of the region; if periodic, high - low in u is the period
  bool periodic = false;         ///< in u
  std::vector<Vec2> fixed = {};  ///< points that the spline interpolates: corners
  /// Samples those parts of the boundary along which tangent planes are prescribed, with steps of
  /// at most `longest`. Null: no tangent planes are prescribed.
  std::function<std::vector<PatchTangent>(const BoundaryStep& longest)> tangents = {};
};

/// Result of fit_bicubic_patch().
struct PatchFit {
  BicubicPatch patch;
  /// Largest |S - x| at check points, inside and on the boundary, that were not fitted.
  double deviation = 0;
  double angle_deg = 0;  ///< largest angle to the prescribed tangent planes, at such points
  bool reached = false;  ///< deviation and angle are at most their goals
};

/// Limits on the size of a fit.
struct PatchLimits {
  int max_poles_per_direction = 400;  ///< poles in u or in v
  int max_poles = 60'000;
  /// Intervals along the longer side of the first fit, 2 or more. Features much shorter than one
  /// interval lie between its samples and are missed.
  int initial_intervals = 8;
};

/// Fits a bicubic B-spline with as few poles as possible whose deviation and angle are at most
/// `goal`, both > 0.
///
/// If the goal is not reached, within the limits or because finer knots no longer help, the best
/// fit found is returned. Coordinates should be near the origin, to keep accuracy. `start`: a patch
/// whose knots are used first, or null. Cost: about 3 µs per cell and iteration, plus one sparse
/// factorization per iteration.
PatchFit fit_bicubic_patch(const PatchTarget& target, const PatchGoal& goal,
                           const PatchLimits& limits = {}, const BicubicPatch* start = nullptr);

}  // namespace batten
