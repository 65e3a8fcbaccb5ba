// From points and input curves to few C1 cubic segments: the one curve fit of the kernel.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_options.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Fits a curve that is C1 between corners, through the first and the last point and the corners
/// exactly, not farther than the tolerance from the points, both ways (Deviation::max and
/// ::between). Segments get a node more where they miss the tolerance, points move to the nearest
/// parameter after every solve, nodes that are not needed are taken out again. u is close to arc
/// length.
///
/// Two points or more; points that repeat the one before them are passed over. Cost: about
/// O(points · rounds), microseconds for a stroke of ten points.
/// Throws InputError: fewer than two distinct points, a number that is not finite, a tolerance that
/// is not above 0, a corner that is not a point, `max_segments` reached. `name` is used in
/// messages.
CurveFit fit_points(const std::string& name, const std::vector<Vec3>& points,
                    const FitOptions& options);

/// The input itself when it is piecewise cubic: corners where its direction turns by more than
/// `corner_angle`, C1 elsewhere (the parameter of each segment is scaled so that the speed goes on,
/// and u to the length of the curve). None when it is not, or has a kink below the angle.
std::optional<HermiteCurve> exact_curve(const InputCurve& curve, double corner_angle);

/// exact_curve() where there is one; otherwise, or when ends are given, nodes halved, u is to run
/// evenly or the curve to be open though it comes back, a fit to samples of the input, evenly by
/// arc length, so dense that the tolerance holds between them too. u is roughly arc length; with
/// options.even, it is so within the tolerance. Throws InputError when the tolerance cannot be
/// reached.
HermiteCurve fit_curve(const std::string& name, std::shared_ptr<const InputCurve> curve,
                       const FitOptions& options);

}  // namespace batten
