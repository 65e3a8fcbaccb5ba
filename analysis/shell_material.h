// SPDX-License-Identifier: MPL-2.0
// Materials of shells in plane stress, and failure criteria of their plies.
#pragma once

#include <optional>

#include "batten/core/eigen.h"

namespace batten {

/// Strengths of a material in its directions 1 and 2: the stresses at failure, all above 0.
struct PlyStrength {
  double tension_1 = 0, compression_1 = 0;
  double tension_2 = 0, compression_2 = 0;
  double shear = 0;  ///< in the plane of 1 and 2
};

/// Linear elastic material in plane stress:
///
///     (σ11, σ22, σ12) = Q (ε11 - α1 T, ε22 - α2 T, 2ε12)      in two perpendicular directions 1, 2
///
/// with the change of temperature T. Units are those of the model: with mm and N, moduli and stresses
/// are in MPa and density in t/mm³.
struct ShellMaterial {
  Mat3 Q = Mat3::Zero();
  double density = 0;
  Vec2 expansion = Vec2::Zero();  ///< thermal expansion α1, α2 per degree
  std::optional<PlyStrength> strength = {};

  /// Isotropic material with Young's modulus E and Poisson's ratio ν: Q = E/(1-ν²) [1 ν 0; ν 1 0; 0
  /// 0 (1-ν)/2]. Throws InputError unless E > 0 and -1 < ν < 1/2.
  static ShellMaterial isotropic(double E, double nu, double density = 0);
  /// Orthotropic material: moduli E1, E2 along the directions 1 and 2, Poisson's ratio ν12 =
  /// -ε22/ε11 under stress along direction 1, shear modulus G12. Q11 = E1/(1-ν12 ν21), Q22 =
  /// E2/(1-ν12 ν21), Q12 = ν12 Q22, Q33 = G12, ν21 = ν12 E2/E1. Throws InputError unless all moduli
  /// are positive and ν12² < E1/E2.
  static ShellMaterial orthotropic(double E1, double E2, double nu12, double G12,
                                   double density = 0);

  /// Stress (11, 22, 12) that prevents the expansion by one degree: Q (α1, α2, 0).
  Vec3 thermal_stress() const { return Q * Vec3(expansion[0], expansion[1], 0); }
};

/// Throws InputError unless Q is symmetric positive definite, the density 0 or more, the expansion
/// finite and every strength above 0.
void require_material(const ShellMaterial& material);

/// Failure criteria of plies in plane stress, f(σ) = 1 at failure, with X, Y the strengths along 1
/// and 2 in tension (t) and compression (c), and S in shear.
enum class FailureCriterion {
  /// σ1²/X² - σ1 σ2/X² + σ2²/Y² + τ²/S², X and Y by the signs of σ1 and σ2 [AzziTsai1965]
  TsaiHill,
  /// (σ1² - σ1 σ2)/(Xt Xc) + σ2²/(Yt Yc) + τ²/S² + σ1 (1/Xt - 1/Xc) + σ2 (1/Yt - 1/Yc) [Hoffman1967]
  Hoffman
};

/// Reserve factor (strength ratio): the factor by which a stress (σ1, σ2, τ12) in the directions of
/// the material can grow until the criterion is met. Above 1: no failure; infinity: never.
double reserve_factor(FailureCriterion criterion, const PlyStrength& strength, const Vec3& stress);

}  // namespace batten
