// SPDX-License-Identifier: MPL-2.0
// Fairing of curves: smoothing splines through noisy points, and local fairing of existing curves.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/curve_options.h"
#include "batten/fairing/curves/fairness.h"

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

}  // namespace batten
