// SPDX-License-Identifier: MPL-2.0
// Fairing of curves: smoothing splines through noisy points, local fairing of existing curves, and
// measures of fairness.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/curve_options.h"

namespace batten {

/// Fairs ordered points: computes the curve that minimises a weighted sum of its squared distances
/// from the points and its bending; FairOptions describes the functional.
///
/// `points`: two or more. `name` is used in messages. Cost: O(points) per round, about 0.2 ms for a
/// hundred points. Throws InputError under the conditions of fit_points(), for a condition on the
/// ends of a closed curve, and for a noise, deviation or wavelength that is not above 0. Throws
/// ConflictError if conditions contradict each other. Throws NoSolutionError if the curve shrinks
/// to a point (a closed curve shorter than the wavelength).
FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options = {});

/// Largest RMS distance by which fair_points() moves points, unless a noise, a deviation or a
/// wavelength is stated: twice their estimated noise, because larger distances cannot be noise,
/// plus 1e-6 of their size. Conditions and FairOptions::drawn_by_hand permit more.
double largest_movement(double noise, double size);

/// Interpolates ordered points by a spline that is C2 between corners, without fairing, for
/// comparison with fair_points().
HermiteCurve interpolating_spline(const std::string& name, const std::vector<Vec3>& points,
                                  const FairOptions& options = {});

/// Fairs one interval of a curve: replaces it by a fairer one that joins the rest with continuous
/// curvature.
///
/// Waves of length `wavelength` keep half of their height, waves of length v 1 / (1 +
/// (wavelength/v)⁶), as after fair_points(). The curve gets no additional curvature extrema; see
/// fair_part() for the functional. Segments outside of the interval stay bit-identical.
///
/// The interval extends from parameter `from` to `to`; on a closed curve with to < from, it crosses
/// the seam. Throws InputError if the interval is not a part of the curve, or if `wavelength` is
/// not above 0.
HermiteCurve fair_interval(const HermiteCurve& curve, double from, double to, double wavelength);
/// Fairs the parts of a curve inside a sphere (a brush), as fair_interval() does. Throws InputError
/// if the curve does not meet the sphere.
HermiteCurve fair_brush(const HermiteCurve& curve, const Vec3& centre, double radius,
                        double wavelength);

// Measures of fairness: curvature integrals, extrema and inflections, and curvature combs.

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
