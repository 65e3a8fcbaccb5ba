// Fairing of noisy curves: smoothing splines through points, and local fairing of existing curves.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/curve_options.h"

namespace batten {

/// Fairs ordered points: balances their distances from a curve against its bending, see
/// FairOptions.
///
/// Takes two points or more; `name` is used in messages. Cost: O(points) per round, about 0.2 ms
/// for a hundred points. Throws InputError under the conditions of fit_points(), for a condition of
/// an open curve on a closed one, and for a noise, deviation or wavelength that is not above 0.
/// Throws ConflictError if conditions contradict each other. Throws NoSolutionError if nothing is
/// left of the curve (a loop shorter than the wavelength).
FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options = {});

/// Interpolates the points without fairing; C2 between corners. For comparison with fair_points().
HermiteCurve interpolating_spline(const std::string& name, const std::vector<Vec3>& points,
                                  const FairOptions& options = {});

/// Fairs a part of a curve; the rest stays bit-identical.
///
/// Minimises ∫ |X - X⁰|² + (φ(u) wavelength / 2π)⁴ |X_uu|² du (u in arc length) over the segments
/// that the interval touches. φ falls smoothly from 1 in the middle of the interval to 0 at its
/// ends. The wave that keeps half of its height thus grows from nothing to `wavelength`. The nodes
/// at the ends of these segments keep position and slope; only at the end of an open curve is the
/// slope free. Before the solve, nodes are inserted without a change of shape, as many as the
/// wavelength needs.
///
/// The interval goes from parameter `from` to `to`; on closed curves it crosses the seam if to <
/// from. Throws InputError if it is not a part of the curve, or if `wavelength` is not above 0.
HermiteCurve fair_interval(const HermiteCurve& curve, double from, double to, double wavelength);
/// Fairs a curve inside a sphere (a brush), as fair_interval() does, with φ falling from 1 at the
/// centre to 0 at `radius`. Throws InputError if the curve does not meet the sphere.
HermiteCurve fair_brush(const HermiteCurve& curve, const Vec3& centre, double radius,
                        double wavelength);

}  // namespace batten
