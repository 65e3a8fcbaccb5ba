// Curves that fair themselves: springs to the data balanced against bending.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/curve_options.h"

namespace batten {

/// Fairs two points or more. Cost: O(points) a round; about 0.2 ms for a hundred points.
/// Throws InputError (as fit_points; a condition of an open curve on a closed one; a deviation or
/// wavelength that is not above 0), ConflictError when conditions contradict each other,
/// NoSolutionError when fairing leaves no curve (a loop shorter than the wavelength).
FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options = {});

/// The curve through the points as they are, before any fairing: C2 between corners.
HermiteCurve interpolating_spline(const std::string& name, const std::vector<Vec3>& points,
                                  const FairOptions& options = {});

/// Local fairing. Minimises ∫ |X - X⁰|² + (φ(u) wavelength / 2π)⁴ |X_uu|² du (u in arc length) over
/// the segments that the stretch touches, φ falling smoothly from 1 in its middle to 0 at its ends:
/// the wave that keeps half of its height grows from nothing to `wavelength`. The nodes at the ends
/// of those segments keep position and slope: outside nothing changes, not a bit. Inside, nodes are
/// added first, without a change of shape, as many as the wavelength needs. At the end of an open
/// curve the slope is free.
///
/// The stretch goes from parameter `from` to `to` (on closed curves across the seam when to <
/// from). Throws InputError when that is no part of the curve, or wavelength is not above 0.
HermiteCurve fair_interval(const HermiteCurve& curve, double from, double to, double wavelength);
/// A brush: every stretch inside the sphere, φ falling from 1 at its centre to 0 at `radius`. A
/// sphere that the curve does not meet: InputError.
HermiteCurve fair_brush(const HermiteCurve& curve, const Vec3& centre, double radius,
                        double wavelength);

}  // namespace batten
