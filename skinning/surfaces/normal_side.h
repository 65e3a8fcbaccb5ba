// SPDX-License-Identifier: MPL-2.0
// Chooses the side of a surface to which its normals point.
//
// The same rules apply to every model. Normals point
//
//   1. outwards if the surface is closed (the enclosed volume is positive);
//   2. to the convex side of an open surface, that is, the side for which the total mean curvature,
//      including the curvature concentrated in creases,
//
//         M = ½ ∫ div n dA + ½ ∫ θ ds        (a sphere of radius R with outward normals: 4 π R)
//
//      is positive. The rule applies if |M| > 0.01 √A, where A is the area: a shallow dome
//      satisfies it as soon as its rise is 0.3 % of its radius;
//   3. along the first of the axes +z, +x and +y for which the area vector ∫ n dA has a component
//      with a magnitude above 0.05 A (plates, hypars, helicoids, saddles);
//   4. away from the centroid on average or, if that is undecided, such that the first of the nine
//      moments ∫ (x - c)_i n_j dA (order i, j = z, x, y) with a magnitude above 1e-3 A^1.5 is
//      positive (catenoids).
//
// The result depends only on the shape in space, not on the order, direction or parametrisation of
// the curves: M, the volume, the area vector and the moments change sign with the normals.
// If no rule applies, the two sides of the surface are equivalent.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

struct SkinnedRegion;

/// Integrals over an oriented surface, from which the side of its normals is determined. The
/// integrals that contain the normal change sign if the orientation is reversed.
struct SideIntegrals {
  double area = 0;  ///< area of the surface, model units²
  /// Total mean curvature ½ ∫ div n dA + ½ ∫ θ ds with the unit normal n and the angle θ of the
  /// normals at creases, model units.
  double curvature = 0;
  Vec3 area_vector = Vec3::Zero();                    ///< ∫ n dA with the unit normal n
  Vec3 first = Vec3::Zero();                          ///< first moment ∫ x dA of the positions x
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();  ///< ∫ x nᵀ dA of positions and unit normals

  /// Adds the integrals over the triangle abc; `curvature` is not changed. The triangle is
  /// counter-clockwise seen from the tip of its normal.
  void add_facet(const Vec3& a, const Vec3& b, const Vec3& c);
  /// Adds the integrals over another surface. `flip`: reverses its orientation first.
  void add(const SideIntegrals& other, bool flip = false);
  /// Moments ∫ (x - c) nᵀ dA of positions x and unit normals n about the centroid c of the surface.
  Eigen::Matrix3d central_moments() const;
};

/// Direction of the normals of a surface, and the rule for the side to which they should point.
struct NormalSide {
  enum class Rule { Volume, Curvature, Axis, Moment, None };
  Rule rule = Rule::None;    ///< first applicable rule, in the order Volume to Moment
  bool agrees = true;        ///< false: normals point opposite to the rule
  Vec3 mean = Vec3::Zero();  ///< area-weighted mean of the unit normals
  /// Direction of the normals in words, for messages: "outwards" (Volume), "to the convex side"
  /// (Curvature) or, for example, "along +z" (Axis); "inwards" and "to the concave side" if the
  /// normals are opposite to the rule; "to one of two equivalent sides" for the rules Moment and
  /// None.
  std::string text() const;
};

/// Tests whether the normals of a surface point outwards if it is closed, otherwise to the convex
/// side or to the side that the further rules of normal_side.h define. `closed`: true if the
/// surface has no boundary.
NormalSide normal_side(const SideIntegrals& integrals, bool closed);

/// Computes the integrals over several faces, including the curvature of the creases along shared
/// curves. The faces must be consistently oriented; curves of the same name are shared. Cost:
/// O(elements).
SideIntegrals side_integrals(const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
