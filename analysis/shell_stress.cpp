// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/shell_stress.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace batten {
namespace {

// Plane stress: the equivalent of (11, 22, 12).
double von_mises(const Vec3& s) {
  return std::sqrt(std::max(0.0, s[0] * s[0] - s[0] * s[1] + s[1] * s[1] + 3 * s[2] * s[2]));
}

// Stress in the directions of a ply at the height ζ, from the strain of the middle and t κ.
Vec3 stress_in(const ShellSection::PlyView& ply, double height,
               const Eigen::Matrix<double, 6, 1>& strains, const TemperatureAt& temperature) {
  return ply.material.Q *
             (strain_rotation(ply.angle) * (strains.head<3>() + height * strains.tail<3>())) -
         (temperature.middle + height * temperature.difference) * ply.material.thermal_stress();
}

}  // namespace

double von_mises(const Mat3& stress) {
  const auto [a, b] = principal(stress);
  return std::sqrt(std::max(0.0, a * a - a * b + b * b));
}

std::array<double, 2> principal(const Mat3& stress) {
  const double mean = 0.5 * stress.trace();
  const double radius =
      std::sqrt(std::max(0.0, 0.5 * stress.cwiseProduct(stress).sum() - mean * mean));
  return {mean + radius, mean - radius};
}

Vec3 principal_direction(const Mat3& stress, const Vec3& normal) {
  const Mat3 in_plane = Mat3::Identity() - normal * normal.transpose();
  const auto [first, second] = principal(stress);
  if (!(first > second)) return normal.unitOrthogonal();
  // Its columns are multiples of the direction.
  const Mat3 onto = in_plane * stress * in_plane - second * in_plane;
  int longest;
  onto.colwise().norm().maxCoeff(&longest);
  return onto.col(longest).normalized();
}

ShellStress::ShellStress(const Mat3& of_forces, const Mat3& of_moments, const ShellSection& section,
                         double of_thickness, const ShellPoint& point,
                         const TemperatureAt& temperature)
    : forces(of_forces),
      moments(of_moments),
      thickness(of_thickness),
      section_(&section),
      e1_(point.e1()),
      e2_(point.e2()),
      temperature_(temperature) {}

Eigen::Matrix<double, 6, 1> ShellStress::strains() const {
  const auto in_axes = [&](const Mat3& s) {
    return Vec3(e1_.dot(s * e1_), e2_.dot(s * e2_), e1_.dot(s * e2_));
  };
  const auto& [a0, a1, a2] = section_->integrals().thermal;
  Eigen::Matrix<double, 6, 1> resultants;
  resultants << in_axes(forces) / thickness + temperature_.middle * a0 +
                    temperature_.difference * a1,
      in_axes(moments_about_middle()) / (thickness * thickness) + temperature_.middle * a1 +
          temperature_.difference * a2;
  return section_->compliance() * resultants;
}

Mat3 ShellStress::at(double height) const {
  constexpr double bending = 6;
  if (!section_->laminate)
    return forces / thickness + height * bending / (thickness * thickness) * moments_about_middle();
  int k = 0;
  while (k + 1 < section_->ply_count() && section_->ply(k).top <= height / 2) ++k;
  const ShellSection::PlyView ply = section_->ply(k);
  const Vec3 s =
      strain_rotation(ply.angle).transpose() * stress_in(ply, height / 2, strains(), temperature_);
  return s[0] * e1_ * e1_.transpose() + s[1] * e2_ * e2_.transpose() +
         s[2] * (e1_ * e2_.transpose() + e2_ * e1_.transpose());
}

void ShellStress::for_each_ply_face(const std::function<void(const PlyStress&)>& visit) const {
  const Eigen::Matrix<double, 6, 1> strains = this->strains();
  for (int k = 0; k < section_->ply_count(); ++k) {
    const ShellSection::PlyView ply = section_->ply(k);
    for (const double height : {ply.bottom, ply.top})
      visit({k, 2 * height, stress_in(ply, height, strains, temperature_)});
  }
}

ShellStress::Largest ShellStress::largest_von_mises() const {
  Largest largest;
  if (!section_->laminate) {
    for (const double height : {1.0, -1.0})
      if (const double value = batten::von_mises(at(height)); value > largest.value)
        largest = {value, height, 0};
    return largest;
  }
  for_each_ply_face([&](const PlyStress& face) {
    if (const double value = von_mises(face.stress); value > largest.value)
      largest = {value, face.height, face.ply};
  });
  return largest;
}

ShellStress::Largest ShellStress::smallest_reserve_factor(FailureCriterion criterion) const {
  Largest smallest{std::numeric_limits<double>::infinity(), 1, 0};
  for_each_ply_face([&](const PlyStress& face) {
    const auto& strength = section_->ply(face.ply).material.strength;
    if (!strength) return;
    const double value = reserve_factor(criterion, *strength, face.stress);
    if (value < smallest.value) smallest = {value, face.height, face.ply};
  });
  return smallest;
}

}  // namespace batten
