#include "batten/fairing/fair_curve.h"

#include "batten/fairing/fair_conditions.h"
#include "batten/fairing/smoothing_spline_solver.h"

namespace batten {

namespace {

NoiseLevel known_of(const FairOptions& options) {
  if (options.smoothing == FairOptions::Smoothing::Noise) return {options.noise, 0};
  if (options.smoothing == FairOptions::Smoothing::Wavelength) return {0, options.wavelength};
  return {};
}

}  // namespace

FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options) {
  const PointSequence sequence(
      name, points, options.corner_angle, options.corners, options.closed,
      options.reject_outliers ? PointSequence::Outliers::Drop : PointSequence::Outliers::Keep,
      known_of(options));
  check(name, options, sequence.closed);
  return SmoothingSplineSolver(name, points, sequence, options).run();
}

HermiteCurve interpolating_spline(const std::string& name, const std::vector<Vec3>& points,
                                  const FairOptions& options) {
  const PointSequence sequence(name, points, options.corner_angle, options.corners, options.closed);
  const CurveMesh mesh(sequence.chord, sequence.closed, sequence.corners);
  std::vector<Spring> springs;
  std::vector<std::pair<int, Vec3>> fixed_dofs;
  for (int i = 0; i < sequence.count(); ++i) {
    springs.push_back({mesh.locate(sequence.chord[i]), sequence.points[i]});
    fixed_dofs.emplace_back(mesh.position_dof(i), sequence.points[i]);
  }
  constexpr double mu = 1e8;  // C2, to some digits
  const FairingEnergy energy(mesh, {}, 0, mu);
  return {mesh,
          PenalisedLeastSquares(mesh, springs, energy, fixed_dofs).solve(1e-6 * sequence.length())};
}

}  // namespace batten
