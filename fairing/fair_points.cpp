#include "batten/fairing/fair_curve.h"

#include "batten/fairing/fair_conditions.h"
#include "batten/fairing/fair_rounds.h"

namespace batten {

namespace {

KnownNoise known_of(const FairOptions& options) {
  if (options.balance == FairOptions::Balance::Noise) return {options.noise, 0};
  if (options.balance == FairOptions::Balance::Wavelength) return {0, options.wavelength};
  return {};
}

}  // namespace

FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options) {
  const PointRow row(name, points, options.corner_angle, options.corners, options.closed,
                     options.drop_outliers ? PointRow::Outliers::Drop : PointRow::Outliers::Keep,
                     known_of(options));
  check(name, options, row.closed);
  return FairRounds(name, points, row, options).run();
}

HermiteCurve curve_as_given(const std::string& name, const std::vector<Vec3>& points,
                            const FairOptions& options) {
  const PointRow row(name, points, options.corner_angle, options.corners, options.closed);
  const CurveMesh mesh(row.chord, row.closed, row.corners);
  std::vector<Spring> springs;
  std::vector<std::pair<int, Vec3>> held;
  for (int i = 0; i < row.count(); ++i) {
    springs.push_back({mesh.where(row.chord[i]), row.points[i]});
    held.emplace_back(mesh.position_dof(i), row.points[i]);
  }
  constexpr double mu = 1e8;  // C2, to some digits
  const FairEnergy energy(mesh, {}, 0, mu);
  return {mesh, SpringBalance(mesh, springs, energy, held).solve(1e-6 * row.length())};
}

}  // namespace batten
