// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/fair_curve.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"
#include "batten/fairing/curves/local_fairing.h"
#include "batten/fairing/curves/smoothing_spline_solver.h"

namespace batten {

namespace {

NoiseLevel known_of(const FairOptions& options) {
  if (options.smoothing == FairOptions::Smoothing::Noise) return {options.noise, 0};
  if (options.smoothing == FairOptions::Smoothing::Wavelength) return {0, options.wavelength};
  return {};
}

// The curve through all points but outliers.
FairCurve interpolated(const std::vector<Vec3>& points, const PointSequence& sequence) {
  std::vector<double> u = interpolating_parameters(sequence);
  FairCurve result;
  const HermiteCurve curve = spline_through(sequence, u);
  const double scale = HermiteArcLength(curve).total() / u.back();
  result.curve = curve.with_scaled_parameter(scale);
  for (double& t : u) t *= scale;
  for (size_t i = 0; i < points.size(); ++i) {
    const int at = sequence.index[i];
    if (at < 0) result.outliers.push_back(static_cast<int>(i));
    result.parameters.push_back(at < 0 ? result.curve.closest_point(points[i]).u : u[at]);
  }
  u.resize(sequence.points.size());
  result.deviation = deviation_of(result.curve, sequence, u);
  result.effective_dofs = sequence.count();
  result.rounds = 1;
  result.converged = true;
  return result;
}

}  // namespace

FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options) {
  const PointSequence sequence(
      name, points, options.corner_angle, options.corners, options.closed,
      options.reject_outliers ? PointSequence::Outliers::Drop : PointSequence::Outliers::Keep,
      known_of(options));
  check(name, options, sequence.closed);
  const bool automatic = options.smoothing == FairOptions::Smoothing::CrossValidation &&
                         options.conditions.empty() && !options.drawn_by_hand;
  if (automatic && is_few(sequence.count(), options)) return interpolated(points, sequence);
  SmoothingSplineSolver solver(name, points, sequence, options);
  FairCurve result = solver.run();
  if (!automatic || !solver.exceeds_noise(result)) return result;
  FairCurve interpolating = interpolated(points, sequence);
  interpolating.noise = result.noise;
  return interpolating;
}

HermiteCurve interpolating_spline(const std::string& name, const std::vector<Vec3>& points,
                                  const FairOptions& options) {
  const PointSequence sequence(name, points, options.corner_angle, options.corners, options.closed);
  return spline_through(sequence, sequence.chord);
}

// Local fairing: an interval, a brush.

HermiteCurve fair_interval(const HermiteCurve& curve, double from, double to, double wavelength) {
  const double whole = curve.end() - curve.start();
  double extent = to - from;
  if (curve.closed() && extent < 0) extent += whole;
  if (!(extent > 0) || !std::isfinite(from) || !std::isfinite(to))
    throw InputError("local fairing: found a segment from " + format_number(from) + " to " +
                     format_number(to) +
                     ", expected two parameters of the curve, the second above the first");
  if (!curve.closed() && (from >= curve.end() || to <= curve.start()))
    throw InputError("local fairing: found a segment from " + format_number(from) + " to " +
                     format_number(to) + " of a curve from " + format_number(curve.start()) +
                     " to " + format_number(curve.end()));
  return fair_part(curve, {from, from + extent}, wavelength);
}

HermiteCurve fair_brush(const HermiteCurve& curve, const Vec3& centre, double radius,
                        double wavelength) {
  if (!(radius > 0) || !std::isfinite(radius) || !centre.allFinite())
    throw InputError("local fairing: found a brush of radius " + format_number(radius) +
                     ", expected a length above 0");
  const std::vector<CurvePart> parts = parts_inside(curve, centre, radius);
  if (parts.empty())
    throw InputError("local fairing: the curve lies outside of the brush; it is " +
                     format_number(curve.closest_point(centre).distance) +
                     " away from its centre, and the radius is " + format_number(radius));
  HermiteCurve result = curve;
  for (const CurvePart& part : parts) result = fair_part(result, part, wavelength);
  return result;
}

}  // namespace batten
