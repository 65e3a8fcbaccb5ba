// SPDX-License-Identifier: MPL-2.0
// Measures of fairness: curvature integrals, extrema and inflections, and curvature combs.
#pragma once

#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Fairness measures of a curve.
///
/// The integrals use Gauss rules per segment. The counts use samples of the signed curvature: |κ|,
/// with a sign that changes if the curvature vector turns by more than 90 degrees from one sample
/// to the next (for a plane curve: if it bends to the other side). Curvature waves below a
/// hundredth of the largest curvature are not counted. Corners are not counted, and counting
/// restarts after each corner.
struct Fairness {
  double length = 0;     ///< length of the curve, model units
  double bending = 0;    ///< ∫ κ² ds of the curvature κ, 1/length
  double variation = 0;  ///< ∫ (dκ/ds)² ds of the curvature κ inside the segments, 1/length³
  double largest_curvature = 0;  ///< largest curvature, 1/length
  /// Largest jump of the curvature vector at a node, 1/length; 0 if the curve is C2.
  double largest_jump = 0;
  int extrema = 0;      ///< local extrema of the signed curvature
  int inflections = 0;  ///< sign changes of the signed curvature
};
/// Computes the fairness measures of a curve. At points with zero derivative, the curvature counts
/// as 0. O(segments).
///
/// `scale`: curvature, 1/length; waves below a hundredth of it are not counted either. If a bump
/// has the largest curvature of a curve, waves elsewhere begin to count when it is removed. To
/// count the same waves before and after, pass the largest curvature before.
Fairness fairness(const HermiteCurve& curve, double scale = 0);

/// One sample of a curvature comb. A node with a curvature jump has one sample per side.
struct CurvatureCombSample {
  double u = 0;  ///< parameter of the sample on the curve
  Vec3 point;    ///< point of the curve, model units
  /// Unit vector pointing away from the centre of curvature; zero vector where the curvature is 0.
  Vec3 outward;
  double curvature = 0;  ///< curvature at the sample, 1/length, ≥ 0
};
/// Samples a curvature comb: about `teeth` samples evenly in u along the curve, and one at each end
/// of each segment. O(teeth + segments).
std::vector<CurvatureCombSample> curvature_comb(const HermiteCurve& curve, int teeth);

}  // namespace batten
