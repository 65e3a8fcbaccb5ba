// What a shell is made of: material and thickness.
#pragma once

#include <optional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/core/errors.h"

namespace batten {

/// A linear elastic material in plane stress:
///
///     (σ11, σ22, σ12) = Q (ε11, ε22, 2ε12)      in two directions 1 and 2 at right angles.
///
/// Units follow the model's: with mm and N, moduli and stresses are in MPa and density in t/mm³.
struct ShellMaterial {
  Mat3 Q = Mat3::Zero();
  double density = 0;

  /// Q = E/(1-ν²) [1 ν 0; ν 1 0; 0 0 (1-ν)/2]. Throws InputError unless E > 0 and -1 < ν < 1/2.
  static ShellMaterial isotropic(double E, double nu, double density = 0);
  /// Moduli E1, E2 along 1 and 2, ν12 = -ε22/ε11 under stress along 1, shear modulus G12:
  /// Q11 = E1/(1-ν12 ν21), Q22 = E2/(1-ν12 ν21), Q12 = ν12 Q22, Q33 = G12, ν21 = ν12 E2/E1. Throws
  /// InputError unless all moduli are above 0 and ν12² < E1/E2.
  static ShellMaterial orthotropic(double E1, double E2, double nu12, double G12,
                                   double density = 0);
};

/// A material, and how thick it is.
struct ShellSection {
  ShellMaterial material;
  double thickness = 0;
  /// Direction 1 of the material is this one, projected onto the surface; zero: along x_u. Where the
  /// surface is at right angles to it, along x_u too.
  Vec3 along = Vec3::Zero();
  /// What is added to the thickness at the three corners of a triangle, linear between them.
  Vec3 thickness_offset = Vec3::Zero();

  /// The thickness at a place of its triangle.
  double thickness_at(const Vec3& L) const { return thickness + thickness_offset.dot(L); }
};

/// Throws InputError for a thickness that is not above 0 everywhere, or a Q that is not symmetric and positive
/// definite.
void require_section(const ShellSection& section);


// A part of the surface of a shell.

/// A part of the surface of a model, on which something acts, or where something holds it.
struct ShellPart {
  std::vector<int> regions = {};  ///< none: all
  std::optional<Box3> box =
      {};  ///< what lies in it only; its border is met to a 32nd of an element
};

/// A part that holds nothing of the surface.
class EmptyPartError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace batten
