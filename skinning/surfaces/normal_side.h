// Chooses the side of a surface to which its normals point.
//
// The same rules apply to every model. Normals point
//
//   1. outwards if the surface is closed (the enclosed volume is positive);
//   2. to the convex side of an open surface, that is, to the side on which more of its curvature
//      bulges. The total mean curvature, including the curvature concentrated in creases,
//
//         M = ½ ∫ div n dA + ½ ∫ θ ds        (a sphere of radius R with outward normals: 4 π R)
//
//      is positive. The rule applies if |M| > 0.01 √A, where A is the area: a shallow dome
//      satisfies it as soon as its rise is 0.3 % of its radius;
//   3. along the z axis, else x, else y, if the area vector ∫ n dA has a component of more than
//      0.05 A there (plates, hypars, helicoids, saddles);
//   4. away from the centroid, or else such that the first of the nine moments ∫ (x - c)_i n_j dA
//      (order i, j = z, x, y) with a magnitude above 1e-3 A^1.5 is positive (catenoids).
//
// The result depends only on the shape in space, not on the order, direction or parametrisation of
// the curves. M, the volume and the moments change sign with the normals, so nothing else matters.
// If no rule applies, the two sides of the surface are equivalent.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

struct SkinnedRegion;

/// Integrals over an oriented surface. Those with an odd power of the normal change sign when the
/// orientation is reversed.
struct SideIntegrals {
  double area = 0;
  double curvature = 0;                               ///< M of rule 2, model units
  Vec3 area_vector = Vec3::Zero();                    ///< ∫ n dA
  Vec3 first = Vec3::Zero();                          ///< ∫ x dA
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();  ///< ∫ x nᵀ dA

  /// Adds a facet, counter-clockwise as seen from its normal, without its curvature.
  void add_facet(const Vec3& a, const Vec3& b, const Vec3& c);
  /// Adds the integrals of another surface, with reversed orientation if `flip` is set.
  void add(const SideIntegrals& other, bool flip = false);
  /// Moments ∫ (x - c) nᵀ dA about the centroid c.
  Eigen::Matrix3d central_moments() const;
};

/// Direction of the normals of a surface, and the rule that determines it.
struct NormalSide {
  enum class Rule { Volume, Curvature, Axis, Moment, None };
  Rule rule = Rule::None;    ///< the first rule that applies
  bool agrees = true;        ///< true: the normals follow the rule; false: they are opposite to it
  Vec3 mean = Vec3::Zero();  ///< area-weighted mean of the unit normals
  /// Description for messages: "outwards", "to the convex side", "along +z", … ("inwards" and "to
  /// the concave side" if the normals are opposite to the rule).
  std::string text() const;
};

/// Applies the rules to the integrals of a surface. `closed`: the surface has no boundary.
NormalSide normal_side(const SideIntegrals& integrals, bool closed);

/// Integrals over consistently oriented regions, including the creases along shared lines, which
/// are identified by name. Cost: O(elements).
SideIntegrals side_integrals(const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
