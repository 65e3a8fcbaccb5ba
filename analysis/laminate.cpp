// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/laminate.h"

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <utility>

#include "batten/core/errors.h"

namespace batten {
namespace {

// Integral of ζ^k from `bottom` to `top`.
double power_integral(int k, double bottom, double top) {
  return (std::pow(top, k + 1) - std::pow(bottom, k + 1)) / (k + 1);
}

void add(const Ply& ply, double bottom, double top, SectionIntegrals& sum) {
  const Mat3 T = strain_rotation(ply.angle), Q = T.transpose() * ply.material.Q * T;
  const Vec3 thermal = T.transpose() * ply.material.thermal_stress();
  Mat3* const stiffness[] = {&sum.A, &sum.B, &sum.D};
  for (int k = 0; k < 3; ++k) {
    const double integral = power_integral(k, bottom, top);
    *stiffness[k] += integral * Q;
    sum.thermal[static_cast<size_t>(k)] += integral * thermal;
  }
  sum.density += (top - bottom) * ply.material.density;
}

}  // namespace

Mat3 strain_rotation(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Mat3 T;
  T << c * c, s * s, c * s, s * s, c * c, -c * s, -2 * c * s, 2 * c * s, c * c - s * s;
  return T;
}

SectionIntegrals SectionIntegrals::homogeneous(const ShellMaterial& material) {
  const Vec3 thermal = material.thermal_stress();
  return {material.Q,
          Mat3::Zero(),
          material.Q / 12,
          {thermal, Vec3::Zero(), thermal / 12},
          material.density};
}

Eigen::Matrix<double, 6, 6> SectionIntegrals::compliance() const {
  Eigen::Matrix<double, 6, 6> stiffness;
  stiffness << A, B, B, D;
  return stiffness.inverse();
}

Laminate::Laminate(std::vector<Ply> plies) : plies_(std::move(plies)) {
  if (plies_.empty()) throw InputError("found a laminate without plies, expected one or more");
  for (size_t k = 0; k < plies_.size(); ++k) {
    require_material(plies_[k].material);
    if (!(plies_[k].thickness > 0) || !std::isfinite(plies_[k].thickness))
      throw InputError("ply " + std::to_string(k + 1) + ": found thickness = " +
                       format_number(plies_[k].thickness) + ", expected a length above 0");
    if (!std::isfinite(plies_[k].angle))
      throw InputError("ply " + std::to_string(k + 1) + ": found an angle that is not finite");
    thickness_ += plies_[k].thickness;
  }
  double below = 0;
  for (const Ply& ply : plies_) {
    heights_.push_back(below / thickness_ - 0.5);
    below += ply.thickness;
  }
  heights_.push_back(0.5);
  for (size_t k = 0; k < plies_.size(); ++k)
    add(plies_[k], heights_[k], heights_[k + 1], integrals_);
  compliance_ = integrals_.compliance();
}

}  // namespace batten
