#include "batten/sculpting/curves/sculpted_curve.h"

#include <algorithm>

#include "batten/constraints/shape/shape_constraints.h"

namespace batten {
namespace {

ConstraintSet end_constraints(const HermiteCurve& curve, SculptedCurveOptions::Ends ends) {
  using Ends = SculptedCurveOptions::Ends;
  ConstraintSet set(curve.mesh().dof_count());
  if (curve.closed() || ends == Ends::Free) return set;
  CurveConstraints rows(curve.mesh(), set);
  for (const double u : {curve.start(), curve.end()}) {
    rows.point("ends", u, curve.evaluate(u));
    if (ends == Ends::Clamped) rows.derivative("ends", u, curve.evaluate(u, 1));
  }
  return set;
}

}  // namespace

SculptedCurve sculpt_curve(const std::string& name, const std::vector<Vec3>& points,
                           const SculptedCurveOptions& options) {
  FairOptions fair_options = options.fair;
  fair_options.reject_outliers = false;
  fair_options.closed = options.closed;
  fair_options.fix_ends = !options.closed;
  const HermiteCurve given = interpolating_spline(name, points, fair_options);
  if (!options.faired) {
    fair_options.smoothing = FairOptions::Smoothing::Wavelength;
    fair_options.wavelength = 1e-6 * given.length();  // interpolates the points
  }
  const FairCurve fair = fair_points(name, points, fair_options);
  SculptedCurve result;
  result.fairing = fair.deviation;
  result.wavelength = fair.wavelength;
  result.before = fairness(given);
  result.curve = fair.curve;
  if (!options.loads.empty()) {
    CurveMaterial material;
    material.alpha = {options.alpha};
    material.beta = {options.beta};
    DeformableCurve deformable(fair.curve, end_constraints(fair.curve, options.ends), material,
                               options.loads);
    result.curve = deformable.solve();
  }
  for (const double u : fair.parameters) {
    result.targets.push_back(result.curve.evaluate(u));
    result.largest_shift =
        std::max(result.largest_shift, (result.targets.back() - fair.curve.evaluate(u)).norm());
  }
  result.after = fairness(result.curve);
  return result;
}

}  // namespace batten
