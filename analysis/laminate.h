// SPDX-License-Identifier: MPL-2.0
// Classical lamination theory: plies, and integrals over the thickness of a section.
#pragma once

#include <array>
#include <vector>

#include "batten/analysis/shell_material.h"
#include "batten/core/eigen.h"

namespace batten {

/// A ply of a laminate.
struct Ply {
  ShellMaterial material;
  double thickness = 0;
  /// Angle in radians from direction 1 of the section to direction 1 of the material, about the normal
  /// of the surface (counterclockwise seen from the top).
  double angle = 0;
};

/// Integrals over the thickness t of a section, with the height ζ t above its middle, ζ from -1/2 to
/// 1/2:
///
///     A = ∫ Q dζ,   B = ∫ ζ Q dζ,   D = ∫ ζ² Q dζ,   a_k = ∫ ζ^k Q α dζ
///
/// With the strain ε of the middle and the curvature change κ, the temperature T of the middle and
/// the difference ΔT between top and bottom, membrane forces and moments about the middle are
///
///     N = t (A ε + B t κ - a_0 T - a_1 ΔT),   M = t² (B ε + D t κ - a_1 T - a_2 ΔT).
struct SectionIntegrals {
  Mat3 A = Mat3::Zero(), B = Mat3::Zero(), D = Mat3::Zero();
  std::array<Vec3, 3> thermal = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  double density = 0;  ///< mean density

  /// Integrals of one homogeneous material.
  static SectionIntegrals homogeneous(const ShellMaterial& material);
  /// The inverse of [A B; B D], which maps (N/t, M/t²) to (ε, t κ).
  Eigen::Matrix<double, 6, 6> compliance() const;
};

/// A laminate: plies that are bonded to each other, from the bottom to the top (where the normal of the
/// surface points). Immutable. Reference: [Jones1999], chapter 4.
class Laminate {
 public:
  /// Throws InputError without plies, for a thickness that is not above 0, an angle that is not
  /// finite, and as require_material().
  explicit Laminate(std::vector<Ply> plies);

  const std::vector<Ply>& plies() const { return plies_; }
  double thickness() const { return thickness_; }
  /// Heights of the lower faces of the plies above the middle, and that of the top, relative to the
  /// thickness: -1/2 … 1/2.
  const std::vector<double>& heights() const { return heights_; }
  const SectionIntegrals& integrals() const { return integrals_; }
  const Eigen::Matrix<double, 6, 6>& compliance() const { return compliance_; }

 private:
  std::vector<Ply> plies_;
  double thickness_ = 0;
  std::vector<double> heights_;
  SectionIntegrals integrals_;
  Eigen::Matrix<double, 6, 6> compliance_;
};

/// Strains (11, 22, 2·12) in axes that are rotated by `angle` about the normal, as a matrix of those
/// in the original axes. Its transpose maps stresses back: σ = Tᵀ σ'.
Mat3 strain_rotation(double angle);

}  // namespace batten
