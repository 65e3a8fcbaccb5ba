#include "batten/fairing/fair_conditions.h"

#include <algorithm>
#include <cmath>

#include "batten/constraints/shape/curve_constraints.h"
#include "batten/core/errors.h"

namespace batten {

using Type = CurveCondition::Type;

double signed_distance(const CurveCondition& plane, const Vec3& p) {
  return plane.direction.normalized().dot(p - plane.at);
}

void check(const std::string& name, const FairOptions& options, bool closed) {
  const std::string line = "line '" + name + "': ";
  const auto positive = [&](double value, const char* what) {
    if (!(value > 0) || !std::isfinite(value))
      throw InputError(line + "found the " + what + " " + format_number(value) +
                       ", expected a length above 0");
  };
  if (options.smoothing == FairOptions::Smoothing::Deviation)
    positive(options.deviation, "deviation");
  if (options.smoothing == FairOptions::Smoothing::Noise) positive(options.noise, "noise");
  if (options.smoothing == FairOptions::Smoothing::Wavelength)
    positive(options.wavelength, "wavelength");
  if (!(options.alpha >= 0) || !std::isfinite(options.alpha))
    throw InputError(line + "found alpha = " + format_number(options.alpha) +
                     ", expected 0 or more");
  if (options.max_rounds < 1)
    throw InputError(line + "found " + std::to_string(options.max_rounds) +
                     " rounds, expected one or more");
  for (const auto& c : options.conditions) {
    if (!c.at.allFinite() || !c.direction.allFinite() ||
        (c.type != Type::Point && !(c.direction.norm() > 0)))
      throw InputError(line + "condition '" + c.name +
                       "' has a number that is not finite, or a direction of length 0");
    if (closed && c.type == Type::ZeroEndCurvature)
      throw InputError(line + "condition '" + c.name +
                       "' is for the ends of an open line, found a closed one");
  }
}

void add_rows(const std::vector<CurveCondition>& conditions, const std::vector<double>& at,
              const CurveMesh& mesh, ConstraintSet& set) {
  CurveConstraints rows(mesh, set);
  for (size_t k = 0; k < conditions.size(); ++k) {
    const CurveCondition& c = conditions[k];
    switch (c.type) {
      case Type::Point:
        rows.point(c.name, at[k], c.at);
        break;
      case Type::Tangent:
        rows.direction(c.name, at[k], c.direction);
        break;
      case Type::ZeroEndCurvature:
        rows.zero_curvature(c.name, mesh.start());
        rows.zero_curvature(c.name, mesh.end());
        break;
      case Type::Plane:
        rows.in_plane(c.name, c.at, c.direction);
        break;
      case Type::Symmetry:
        rows.symmetric(c.name, c.at, c.direction);
        break;
    }
  }
}

double max_residual(const std::vector<CurveCondition>& conditions,
                    const std::vector<double>& constrained_at, const HermiteCurve& curve,
                    double size) {
  double worst = 0;
  constexpr int samples = 200;
  for (size_t k = 0; k < conditions.size(); ++k) {
    const CurveCondition& c = conditions[k];
    const auto along = [&](int i) {
      return curve.start() + (curve.end() - curve.start()) * i / samples;
    };
    switch (c.type) {
      case Type::Point:
        worst = std::max(worst, curve.closest_point(c.at).distance / size);
        break;
      case Type::Tangent: {
        // The direction where it is held, and how far that is from the nearest point.
        const Vec3 tangent = curve.evaluate(constrained_at[k], 1).normalized();
        const Vec3 nearest = curve.evaluate(curve.closest_point(c.at).u);
        worst = std::max({worst, tangent.cross(c.direction.normalized()).norm(),
                          (curve.evaluate(constrained_at[k]) - nearest).norm() / size});
        break;
      }
      case Type::ZeroEndCurvature:
        for (const double s : {0.0, 1.0}) {
          // By how much it would bend the last segment.
          const int segment = s > 0 ? curve.segment_count() - 1 : 0;
          const double h = curve.mesh().length(segment);
          worst = std::max(worst, h * h * curve.evaluate({segment, s}, 2).norm() / size);
        }
        break;
      case Type::Plane:
        for (int i = 0; i <= samples; ++i)
          worst = std::max(worst, std::abs(signed_distance(c, curve.evaluate(along(i)))) / size);
        break;
      case Type::Symmetry:
        for (int i = 0; i <= samples; ++i) {
          const Vec3 p = curve.evaluate(along(i));
          const Vec3 image = p - 2 * signed_distance(c, p) * c.direction.normalized();
          worst = std::max(worst, (image - curve.evaluate(along(samples - i))).norm() / size);
        }
        break;
    }
  }
  return worst;
}

}  // namespace batten
