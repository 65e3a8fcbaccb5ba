// SPDX-License-Identifier: MPL-2.0
// Fits C1 curves of few cubic segments to points or to input curves, within a tolerance.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_options.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Fits a curve through ordered points, C1 between corners, with few cubic segments.
///
/// The curve interpolates the first point, the last point and the corners. It is within the
/// tolerance of the points in both directions (Deviation::max, Deviation::between). Segments that
/// exceed the tolerance are split. After every solve, the parameter of each point moves to its foot
/// point (the closest point on the curve). Nodes that are not needed are removed again. The
/// parameter u of the result is close to arc length.
///
/// `name` is used in messages. `points`: two or more; points equal to the previous one are skipped.
/// Cost: about O(points · rounds), microseconds for a stroke of ten points. Throws InputError for
/// fewer than two distinct points, a number that is not finite, a tolerance that is not above 0, or
/// a corner index that is not a point, and if `max_segments` is reached.
CurveFit fit_points(const std::string& name, const std::vector<Vec3>& points,
                    const FitOptions& options);

/// Converts an input curve to a Hermite curve without approximation; nullopt if that is impossible.
///
/// The conversion is possible if the input is piecewise cubic and has no kink of at most
/// `corner_angle` degrees. Larger kinks become corners. Elsewhere the curve is C1: the parameter of
/// each segment is scaled so that the speed is continuous, and u is scaled to the length of the
/// curve. O(segments).
std::optional<HermiteCurve> exact_curve(const InputCurve& curve, double corner_angle);

/// Fits a Hermite curve to an input curve within options.tolerance.
///
/// Returns exact_curve() if it exists, unless one of these options is set: prescribed end tangents,
/// `bisection_only`, `fixed_parameters`, or a `closed` that differs from the input. Otherwise it
/// fits samples of the input, dense enough that the tolerance also holds between them. Half of them
/// are evenly spaced by arc length, half by the parameter of the input. The parameter u of the
/// result is roughly arc length; with options.fixed_parameters, it is arc length within the
/// tolerance.
///
/// `name` is used in messages. Cost: that of fit_points() on the samples. Throws InputError if the
/// tolerance cannot be reached.
HermiteCurve fit_curve(const std::string& name, std::shared_ptr<const InputCurve> curve,
                       const FitOptions& options);

}  // namespace batten
