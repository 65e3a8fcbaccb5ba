// Measures of curve fairness: curvature integrals, extrema and inflections, and curvature combs.
#pragma once

#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Fairness measures of a curve.
///
/// The integrals use Gauss rules per segment. The counts use samples of the signed curvature. That
/// is |κ|, with a sign that flips wherever the curvature vector turns by more than 90 degrees from
/// one sample to the next (for a plane curve: where it bends to the other side). Curvature waves
/// below a hundredth of the largest curvature are not counted. Corners are left out, and counting
/// starts anew behind them.
struct Fairness {
  /// Model units.
  double length = 0;
  double bending = 0;            ///< ∫ κ² ds, 1/length
  double variation = 0;          ///< ∫ (dκ/ds)² ds inside the segments, 1/length³
  double largest_curvature = 0;  ///< 1/length
  /// Largest jump of the curvature vector at a node, 1/length; 0: C2.
  double largest_jump = 0;
  int extrema = 0;  ///< local extrema of the signed curvature
  int inflections = 0;
};
/// Computes the fairness measures of a curve.
Fairness fairness(const HermiteCurve& curve);

/// One sample of a curvature comb. A node at which the curvature jumps has one sample per side.
struct CurvatureCombSample {
  double u = 0;
  Vec3 point;
  /// Unit vector away from the centre of curvature; 0 if the curve is straight.
  Vec3 outward;
  double curvature = 0;  ///< 1/length, ≥ 0
};
/// Samples a curvature comb: about `teeth` samples evenly along the curve, and one at each end of
/// each segment.
std::vector<CurvatureCombSample> curvature_comb(const HermiteCurve& curve, int teeth);

}  // namespace batten
