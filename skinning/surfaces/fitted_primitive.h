// SPDX-License-Identifier: MPL-2.0
// Recognises whether a finished surface is a plane, cylinder, sphere, cone or torus.
#pragma once

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// The simplest primitive that approximates a surface within a tolerance, with its position.
///
///     primitive   origin                  axis                        lengths and angle
///     plane       a point of the plane    mean normal of the surface
///     cylinder    a point of the axis     along the axis              radius
///     sphere      centre                  (arbitrary)                 radius
///     cone        apex                    from apex to surface        radius, half_angle
///     torus       centre                  normal to the major circle  major_radius, radius
struct FittedPrimitive {
  enum class Kind { Free, Plane, Cylinder, Sphere, Cone, Torus };
  Kind kind = Kind::Free;
  Vec3 origin = Vec3::Zero();  ///< centre, apex, or point of plane or axis; model units
  Vec3 axis = Vec3::UnitZ();   ///< unit vector along the axis; normal of a plane
  /// Radius, model units. Torus: of the tube. Cone: the largest on the surface.
  double radius = 0;
  /// Radius of the major circle of a torus, the centre line of its tube, model units.
  double major_radius = 0;
  double half_angle = 0;  ///< angle between axis and surface of a cone, radians, in (0, π/2)
  /// Largest distance of the points sampled on the surface from the primitive, model units.
  double deviation = 0;

  /// Signed distance of p from the primitive, model units. It is positive outside of the primitive
  /// (plane: on the side to which the axis points).
  double distance(const Vec3& p) const;
  /// Outward unit normal of the primitive at its point closest to p.
  Vec3 normal(const Vec3& p) const;
};

/// Name of a kind of primitive: "plane", "cylinder", "sphere", "cone", "torus"; "" for Kind::Free.
const char* primitive_name(FittedPrimitive::Kind kind);

/// Fits primitives to the surface of a face and selects the simplest one within a tolerance.
///
/// Primitives are tried in the order plane, cylinder or sphere, cone, torus. The first one whose
/// largest deviation is at most `tolerance` (model units, > 0) is selected, or a later one if its
/// deviation is less than a fifth of that of the first.
///
/// Initial values come from the normals n at points p. The axis a of a cylinder minimises Σ (n·a)²,
/// that of a cone the variance of n·a. Centre and radius R are linear least squares of p - R n. The
/// apex of a cone is the intersection of the tangent planes. The axis of a torus meets all normal
/// lines: it is the linear complex closest to them [PottmannWallner2001]. Levenberg–Marquardt then
/// minimises the sum of squared distances.
///
/// The surface must be curved enough to determine the primitive: its normals must vary by at least
/// 3° (torus: 30°), and its deviation from a plane must be at least 20 times its deviation from the
/// primitive. Otherwise the result is Kind::Free. The result is invariant to units and rigid
/// motions, up to rounding. Radii are known to within the deviation, and are rounded to as few
/// decimals as that permits. Cost: O(samples); the samples are the positions and normals at the
/// vertices and at four points per triangle, inside the trimmed domain.
FittedPrimitive fit_primitive(const SkinnedRegion& region, double tolerance);

/// Fits a primitive to points and their unit normals, one point per row, by the method that
/// fit_primitive() uses for the samples of a face. A zero row in `normals` means that the normal is
/// unknown.
FittedPrimitive fit_primitive(const Points& positions, const Points& normals, double tolerance);

/// Largest distance from a face at which reports accept a primitive (fit_primitive()), model units:
/// 1e-4 of the model size, but at most 5e-4 of the face's size. This bound prevents small faces of
/// large models from being recognised as primitives that they only resemble.
double primitive_tolerance(const SkinnedRegion& region, double model_size);

}  // namespace batten
