// SPDX-License-Identifier: MPL-2.0
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
#include "batten/fem/curves/bspline.h"

namespace batten {

// Bicubic B-spline, and the target surface of a fit.

/// Bicubic B-spline surface S(u, v).
struct BicubicPatch {
  SplineAxis u, v;
  /// Control points, one per row: that of basis functions i in u and j in v at i · v.functions() +
  /// j.
  Points poles;

  Vec3 position(const Vec2& uv) const;
  Vec3 normal(const Vec2& uv) const;  ///< vector along S_u × S_v, not normalised
};

/// Tolerances of fit_bicubic_patch().
struct PatchGoal {
  /// Maximum distance of the spline from the target surface, model units, above 0.
  double deviation = 0;
  /// Maximum angle between the spline and the prescribed tangent planes, degrees, above 0.
  double angle_deg = 180;
};

/// A boundary point (u, v) of the fitted region, and the tangent plane that the spline shall have
/// there: the plane spanned by the derivatives x_u and x_v.
struct PatchTangent {
  Vec2 uv;
  Vec3 x_u, x_v;
};

/// Limits the spacing of samples on the boundary of the fitted region: maps the (u, v) of a sample
/// to the maximum steps in u and in v to the next sample. The step depends on the size of the knot
/// cell that contains the sample.
using BoundaryStep = std::function<Vec2(const Vec2&)>;

/// Target surface of fit_bicubic_patch(), known only inside a region of the (u, v) plane.
struct PatchTarget {
  std::function<bool(const Vec2&)> inside;  ///< whether (u, v) lies in the region; thread-safe
  /// Point of the target surface at (u, v), inside the region or on its boundary; thread-safe.
  std::function<Vec3(const Vec2&)> position;
  /// Samples the boundary of the fitted region: returns points (u, v) in order along it, with steps
  /// in u and in v of at most `longest`.
  std::function<std::vector<Vec2>(const BoundaryStep& longest)> boundary;
  /// Corners of the region's bounding box in (u, v). If `periodic`, high - low in u is the period.
  Vec2 low, high;
  bool periodic = false;  ///< true: the region is periodic in u
  /// Points (u, v) at which the spline interpolates the target exactly, such as corners.
  std::vector<Vec2> fixed = {};
  /// Samples the parts of the region's boundary along which tangent planes are prescribed, with
  /// steps of at most `longest`. Null: no tangent planes are prescribed.
  std::function<std::vector<PatchTangent>(const BoundaryStep& longest)> tangents = {};
};

/// Result of fit_bicubic_patch().
struct PatchFit {
  BicubicPatch patch;
  /// Largest distance of the spline from the target at check points inside and on the boundary,
  /// which differ from the fitted samples; model units.
  double deviation = 0;
  double angle_deg = 0;  ///< largest angle to the prescribed tangent planes at check points
  bool reached = false;  ///< true: the tolerances in PatchGoal are met
};

/// Limits on the number of poles (control points) of a fitted B-spline.
struct PatchLimits {
  int max_poles_per_direction = 400;  ///< maximum number of poles in u and in v
  int max_poles = 60'000;
  /// Number of knot intervals along the longer side of the (u, v) rectangle in the first iteration,
  /// 2 or more. Surface features much shorter than one interval fall between the samples and are
  /// missed.
  int initial_intervals = 8;
};

/// Fits a bicubic B-spline to `target` with as few poles as possible, within the tolerances `goal`.
///
/// If the goal is not reached because of the limits, or because finer knots no longer reduce the
/// error, the best fit found is returned. Coordinates should be near the origin, to keep accuracy.
/// `start`: a patch whose knots are used in the first iteration, or null. Cost: about 3 µs per knot
/// cell and iteration, plus one sparse factorization per iteration.
PatchFit fit_bicubic_patch(const PatchTarget& target, const PatchGoal& goal,
                           const PatchLimits& limits = {}, const BicubicPatch* start = nullptr);

}  // namespace batten
