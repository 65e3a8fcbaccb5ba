// SPDX-License-Identifier: MPL-2.0
// Stresses at one point of a shell, from its stress resultants.
#pragma once

#include <array>
#include <functional>

#include "batten/analysis/shell_assembler.h"

namespace batten {

/// Von Mises equivalent stress √(σ1² - σ1 σ2 + σ2²) of a plane stress.
double von_mises(const Mat3& stress);
/// Principal stresses σ1 ≥ σ2 of a plane stress.
std::array<double, 2> principal(const Mat3& stress);
/// Direction of σ1 of a plane stress in the plane with this unit normal, a unit vector; any direction
/// in the plane if σ1 = σ2.
Vec3 principal_direction(const Mat3& stress, const Vec3& normal);

/// A stress on the bottom or top of a ply.
struct PlyStress {
  int ply = 0;                 ///< from 0, from the bottom
  double height = 0;           ///< above the middle of the shell, relative to half of its thickness
  Vec3 stress = Vec3::Zero();  ///< (σ1, σ2, τ12) in the directions of the ply's material
};

/// Stress resultants at one point: symmetric tensors in the tangent plane, in space coordinates, and
/// the stresses in the section. Keeps a pointer to the section.
class ShellStress {
 public:
  Mat3 forces = Mat3::Zero();  ///< membrane forces, force per length
  /// Bending moments about the reference surface, moment per length; positive: tension at the top.
  Mat3 moments = Mat3::Zero();
  double thickness = 0;

  /// `point`: local axes; `temperature`: that of the load case at the point.
  ShellStress(const Mat3& forces, const Mat3& moments, const ShellSection& section,
              double thickness, const ShellPoint& point, const TemperatureAt& temperature);

  /// Stress at a height above the middle of the shell, relative to half of the thickness: 1 is the top
  /// (where the normal points), -1 the bottom. With the thickness t and one material,
  /// σ = forces/t + height · 6 moments/t², if the reference surface is the middle. On the common face
  /// of two plies, the stress is that in the upper one.
  Mat3 at(double height) const;

  /// Stress linearised over the thickness t, as codes for pressure vessels use it: the membrane stress
  /// N/t, and the bending stress 6 M/t² at the top, with the moments M about the middle. With one
  /// material and without temperature, at(h) = membrane() + h bending().
  Mat3 membrane() const { return forces / thickness; }
  Mat3 bending() const { return 6 / (thickness * thickness) * moments_about_middle(); }

  /// Calls `visit` for the bottom and the top of each ply, from the bottom.
  void for_each_ply_face(const std::function<void(const PlyStress&)>& visit) const;

  /// The largest von Mises stress: at the top or bottom, in laminates of any ply.
  struct Largest {
    double value = 0, height = 1;
    int ply = 0;
  };
  Largest largest_von_mises() const;
  /// The smallest reserve factor of all plies whose material has strengths; infinity: none has.
  Largest smallest_reserve_factor(FailureCriterion criterion) const;

 private:
  Mat3 moments_about_middle() const { return moments - section_->offset * thickness * forces; }
  /// Strain of the middle, and t κ.
  Eigen::Matrix<double, 6, 1> strains() const;

  const ShellSection* section_;
  Vec3 e1_, e2_;
  TemperatureAt temperature_;
};

}  // namespace batten
