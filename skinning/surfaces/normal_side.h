// The side to which the normals of a surface point.
//
// Batten's rule, for every model: normals point
//
//   1. outwards of a closed surface (the enclosed volume is positive);
//   2. of an open one to its convex side, on which more of its own curvature bulges: the total
//      mean curvature, with what is concentrated in creases,
//
//          M = ½ ∫ div n dA + ½ ∫ θ ds        (a sphere of radius R with outward normals: 4 π R)
//
//      is positive. This decides where |M| > 0.01 √A, A being the area: a shallow dome decides by
//      itself as soon as its rise is 0.3 % of its radius;
//   3. up the z axis, else x, else y, where the area vector ∫ n dA has a component of more than
//      0.05 A there (plates, hypars, helicoids, saddles);
//   4. away from the centroid, or so that the first of the nine moments ∫ (x - c)_i n_j dA, taken
//      over i, j = z, x, y, that is above 1e-3 A^1.5 is positive (catenoids).
//
// It depends on the shape in space alone, not on the order, the direction or the parametrization
// of the curves. M, the volume and the moments change their sign with the normals, so that nothing
// else enters; a surface that none of these tells apart has two sides that are alike.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

struct SkinnedRegion;

/// Integrals over an oriented surface. Those with an odd power of the normal change their sign when
/// the surface is turned over.
struct SideIntegrals {
  double area = 0;
  double curvature = 0;                               ///< M of rule 2, model units
  Vec3 area_vector = Vec3::Zero();                    ///< ∫ n dA
  Vec3 first = Vec3::Zero();                          ///< ∫ x dA
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();  ///< ∫ x nᵀ dA

  /// Adds a facet, counter-clockwise seen from its normal, without its curvature.
  void add_facet(const Vec3& a, const Vec3& b, const Vec3& c);
  /// Adds another surface, turned over where `flip` is set.
  void add(const SideIntegrals& other, bool flip = false);
  /// Moments about the centroid.
  Eigen::Matrix3d central_moments() const;
};

/// Where the normals of a surface point.
struct NormalSide {
  enum class Rule { Volume, Curvature, Axis, Moment, None };
  Rule rule = Rule::None;    ///< the first of the four that decides
  bool agrees = true;        ///< the normals point as the rule says; otherwise to the other side
  Vec3 mean = Vec3::Zero();  ///< mean of the unit normals over the area
  /// In words: "outwards", "to the convex side", "along +z", … ("inwards" and "to the concave side"
  /// where the rule is not followed).
  std::string text() const;
};

/// Applies the rule. `closed`: the surface has no boundary.
NormalSide normal_side(const SideIntegrals& integrals, bool closed);

/// Returns the integrals over finished regions whose normals agree, creases along lines of the same
/// name included. O(elements).
SideIntegrals side_integrals(const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
