// How fair a curve is: what a batten would feel.
#pragma once

#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Measures of fairness: integrals by Gauss rules in each segment; counts from samples of the
/// signed curvature: |κ|, its sign turned over wherever the curvature vector turns by more than 90
/// degrees from one sample to the next (for a plane curve, where it bends to the other side). Waves
/// of curvature below a hundredth of the largest are not counted. Corners are left out, and cut the
/// counts.
struct Fairness {
  double length = 0;
  double bending = 0;            ///< ∫ κ² ds, 1/length
  double variation = 0;          ///< ∫ (dκ/ds)² ds between nodes, 1/length³
  double largest_curvature = 0;  ///< 1/length
  double largest_jump = 0;       ///< largest jump of the curvature vector at a node; 0: C2
  int extrema = 0;               ///< local extrema of the signed curvature
  int inflections = 0;
};
Fairness fairness(const HermiteCurve& curve);

/// A tooth of a curvature comb. Where the curvature jumps there is one for each side.
struct CurvatureCombSample {
  double u = 0;
  Vec3 point;
  Vec3 outward;          ///< unit vector away from the centre of curvature; 0 where straight
  double curvature = 0;  ///< 1/length, ≥ 0
};
/// A comb of about `teeth` teeth, evenly along the curve, and one at each end of each segment.
std::vector<CurvatureCombSample> curvature_comb(const HermiteCurve& curve, int teeth);

}  // namespace batten
