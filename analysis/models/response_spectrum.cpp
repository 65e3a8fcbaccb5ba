// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/response_spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {

ResponseSpectrum::ResponseSpectrum(std::vector<std::pair<double, double>> points)
    : points_(std::move(points)) {
  if (points_.empty()) throw InputError("found a response spectrum without points");
  for (size_t k = 0; k < points_.size(); ++k) {
    const auto [frequency, acceleration] = points_[k];
    if (!(frequency > 0 && acceleration > 0) || !std::isfinite(frequency * acceleration))
      throw InputError(
          "found the point (" + format_number(frequency) + ", " + format_number(acceleration) +
          ") of a response spectrum, expected a frequency and an acceleration above 0");
    if (k > 0 && !(frequency > points_[k - 1].first))
      throw InputError("found the frequency " + format_number(frequency) + " after " +
                       format_number(points_[k - 1].first) + ", expected ascending frequencies");
  }
}

double ResponseSpectrum::operator()(double frequency) const {
  if (frequency <= points_.front().first) return points_.front().second;
  if (frequency >= points_.back().first) return points_.back().second;
  size_t k = 1;
  while (points_[k].first < frequency) ++k;
  const auto [f0, a0] = points_[k - 1];
  const auto [f1, a1] = points_[k];
  return a0 * std::pow(a1 / a0, std::log(frequency / f0) / std::log(f1 / f0));
}

namespace {

double correlation(double own, double other, double damping) {
  const double r = own / other, z = damping * damping;
  return 8 * z * (1 + r) * std::pow(r, 1.5) /
         (std::pow(1 - r * r, 2) + 4 * z * r * std::pow(1 + r, 2));
}

}  // namespace

SpectrumResponse::SpectrumResponse(const ShellModel& shell, const ShellModes& modes,
                                   const ResponseSpectrum& spectrum, const Vec3& direction,
                                   double damping) {
  if (!(damping > 0 && damping < 1))
    throw InputError("damping: found " + format_number(damping) +
                     ", expected a damping ratio above 0 and below 1");
  if (modes.rigid_body_count > 0)
    throw InputError("found a shell with rigid-body modes, expected one with supports");
  const Vec3 unit = direction.normalized();
  const SparseMatrix M = shell.mass();
  const auto times_mass = [&](const Points& u) -> Points {
    return M.selfadjointView<Eigen::Lower>() * u;
  };
  const auto count = isize(modes.shapes);
  Points rest = times_mass(shell.layout().position_dofs() * unit.transpose());
  for (int k = 0; k < count; ++k) {
    const auto i = static_cast<size_t>(k);
    const double participation = modes.participation[i].dot(unit),
                 acceleration = spectrum(modes.frequencies[k]),
                 square = std::pow(2 * std::numbers::pi * modes.frequencies[k], 2);
    const Points inertia = participation * times_mass(modes.shapes[i]);
    rest -= inertia;
    displacements_.push_back(participation * acceleration / square * modes.shapes[i]);
    loads_.push_back(acceleration * inertia);
    mass_fraction_ += participation * participation / modes.mass;
  }
  loads_.push_back(spectrum.rigid_acceleration() * rest);
  displacements_.push_back(shell.adjoint(loads_.back()));
  correlation_ = MatX::Identity(count + 1, count + 1);
  for (int j = 0; j < count; ++j)
    for (int k = 0; k < count; ++k)
      correlation_(j, k) = correlation(modes.frequencies[j], modes.frequencies[k], damping);
}

double SpectrumResponse::combine(const VecX& values) const {
  return std::sqrt(std::max(0.0, values.dot(correlation_ * values)));
}

// The square of the von Mises stress is a quadratic form of the stress: 3/2 of that of the deviator.
double SpectrumResponse::combined_von_mises(const std::vector<Mat3>& stresses) const {
  double sum = 0;
  for (int j = 0; j < isize(stresses); ++j)
    for (int k = 0; k < isize(stresses); ++k) {
      const Mat3 &a = stresses[static_cast<size_t>(j)], &b = stresses[static_cast<size_t>(k)];
      sum += correlation_(j, k) * (1.5 * a.cwiseProduct(b).sum() - 0.5 * a.trace() * b.trace());
    }
  return std::sqrt(std::max(0.0, sum));
}

}  // namespace batten
