// SPDX-License-Identifier: MPL-2.0
// Shell sections: material or plies, and thickness; parts of a shell surface.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "batten/analysis/laminate.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {

/// Section of a shell: one material, or a laminate, and the thickness.
struct ShellSection {
  ShellMaterial material;  ///< not used if there is a laminate
  double thickness = 0;
  /// Vector whose projection onto the surface is direction 1 of the section. If it is zero or
  /// perpendicular to the surface, direction 1 is the derivative of the surface by u.
  Vec3 along = Vec3::Zero();
  /// Offsets added to `thickness` at the three vertices of a triangle, linear in between. Plies
  /// become thicker or thinner in proportion.
  Vec3 thickness_offset = Vec3::Zero();
  /// Plies, with the sum of their thicknesses in `thickness`; null: homogeneous.
  std::shared_ptr<const Laminate> laminate = {};
  /// Height of the middle of the shell above its reference surface (the surface of the model), divided
  /// by the thickness: 0.5 if the surface is the bottom of the shell, -0.5 if it is the top.
  double offset = 0;

  /// A section of plies.
  static ShellSection of_plies(std::vector<Ply> plies, const Vec3& along);

  /// Thickness at the barycentric coordinates L of the triangle.
  double thickness_at(const Vec3& L) const { return thickness + thickness_offset.dot(L); }

  SectionIntegrals integrals() const {
    return laminate ? laminate->integrals() : SectionIntegrals::homogeneous(material);
  }
  /// See SectionIntegrals::compliance().
  Eigen::Matrix<double, 6, 6> compliance() const {
    return laminate ? laminate->compliance() : integrals().compliance();
  }
  double density() const { return laminate ? laminate->integrals().density : material.density; }
  /// Membrane stiffness A11 t and bending stiffness D11 t³ along direction 1, per length.
  double membrane_stiffness() const {
    return (laminate ? laminate->integrals().A(0, 0) : material.Q(0, 0)) * thickness;
  }
  double bending_stiffness() const {
    return (laminate ? laminate->integrals().D(0, 0) : material.Q(0, 0) / 12) * thickness *
           thickness * thickness;
  }

  /// A ply of the section; a homogeneous section is one ply.
  struct PlyView {
    const ShellMaterial& material;
    double bottom, top;  ///< heights above the middle, relative to the thickness: -1/2 … 1/2
    double angle;        ///< Ply::angle
  };
  int ply_count() const { return laminate ? static_cast<int>(laminate->plies().size()) : 1; }
  PlyView ply(int k) const;
  /// True if a material of the section has strengths.
  bool has_strength() const;
};

/// Throws InputError unless the thickness is above 0 everywhere and the material valid
/// (require_material()).
void require_section(const ShellSection& section);

/// Change of the temperature of a shell from its stress-free state, at the vertices of its mesh, linear
/// in between.
struct ShellTemperature {
  VecX middle;      ///< degrees; empty: no change
  VecX difference;  ///< top minus bottom, linear through the thickness
  bool empty() const { return middle.size() == 0; }
};

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
