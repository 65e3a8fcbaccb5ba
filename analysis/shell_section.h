// SPDX-License-Identifier: MPL-2.0
// Shell sections: material and thickness, and parts of a shell surface.
#pragma once

#include <optional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {

/// Linear elastic material in plane stress:
///
///     (σ11, σ22, σ12) = Q (ε11, ε22, 2ε12)      in two perpendicular directions 1 and 2.
///
/// Units are those of the model: with mm and N, moduli and stresses are in MPa and density in
/// t/mm³.
struct ShellMaterial {
  Mat3 Q = Mat3::Zero();
  double density = 0;

  /// Isotropic material with Young's modulus E and Poisson's ratio ν: Q = E/(1-ν²) [1 ν 0; ν 1 0; 0
  /// 0 (1-ν)/2]. Throws InputError unless E > 0 and -1 < ν < 1/2.
  static ShellMaterial isotropic(double E, double nu, double density = 0);
  /// Orthotropic material: moduli E1, E2 along the directions 1 and 2, Poisson's ratio ν12 =
  /// -ε22/ε11 under stress along direction 1, shear modulus G12. Q11 = E1/(1-ν12 ν21), Q22 =
  /// E2/(1-ν12 ν21), Q12 = ν12 Q22, Q33 = G12, ν21 = ν12 E2/E1. Throws InputError unless all moduli
  /// are positive and ν12² < E1/E2.
  static ShellMaterial orthotropic(double E1, double E2, double nu12, double G12,
                                   double density = 0);
};

/// Material and thickness of a shell.
struct ShellSection {
  ShellMaterial material;
  double thickness = 0;
  /// Vector whose projection onto the surface is direction 1 of the material. If it is zero or
  /// perpendicular to the surface, direction 1 is the derivative of the surface by u.
  Vec3 along = Vec3::Zero();
  /// Offsets added to `thickness` at the three vertices of a triangle, linear in between.
  Vec3 thickness_offset = Vec3::Zero();

  /// Thickness at the barycentric coordinates L of the triangle.
  double thickness_at(const Vec3& L) const { return thickness + thickness_offset.dot(L); }
};

/// Throws InputError unless the thickness is above 0 everywhere and material.Q symmetric positive
/// definite.
void require_section(const ShellSection& section);

// Parts of a shell surface.

/// Part of the surface of a model, to which a load or support is applied.
struct ShellPart {
  std::vector<int> regions = {};  ///< region indices; empty: all regions
  std::optional<Box3> box =
      {};  ///< restricts the part to a box, resolved to 1/32 of an element; unset: no box
};

/// Thrown if a ShellPart contains no point of the surface.
class EmptyPartError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace batten
