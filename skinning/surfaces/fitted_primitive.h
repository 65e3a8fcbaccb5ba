// Recognises whether a finished surface is a plane, cylinder, sphere, cone or torus.
#pragma once

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// The simplest primitive that approximates a surface within a tolerance, with its position.
///
///     primitive   origin                  axis                        lengths and angle
///     plane       a point of the plane    mean normal of the surface
///     cylinder    a point of the axis     along the axis              radius
///     sphere      its centre              (arbitrary)                 radius
///     cone        its apex                from the apex to the surface radius, half_angle
///     torus       its centre              normal to the major circle  major_radius, radius
struct FittedPrimitive {
  enum class Kind { Free, Plane, Cylinder, Sphere, Cone, Torus };
  Kind kind = Kind::Free;
  Vec3 origin = Vec3::Zero();  ///< model units
  Vec3 axis = Vec3::UnitZ();   ///< unit vector
  double radius = 0;  ///< torus: of the tube; cone: the largest one of the surface; model units
  double major_radius = 0;  ///< of a torus; model units
  double half_angle = 0;    ///< of a cone, radians in (0, π/2)
  double deviation = 0;     ///< largest distance of the samples from the primitive; model units

  /// Signed distance of a point in model units, positive outside (plane: on the side of its axis).
  double distance(const Vec3& p) const;
  /// Outward unit normal at the point of the primitive closest to p.
  Vec3 normal(const Vec3& p) const;
};

/// Name of a kind: "plane", "cylinder", "sphere", "cone", "torus"; "" for Kind::Free.
const char* primitive_name(FittedPrimitive::Kind kind);

/// Fits primitives to positions and normals sampled inside the trim, and selects the simplest one.
///
/// The order is plane, cylinder or sphere, cone, torus. The first one whose largest deviation is at
/// most `tolerance` (model units, > 0) is selected, or a later one if its deviation is less than a
/// fifth of that.
///
/// Initial values come from the normals n at points p. The axis a of a cylinder minimises Σ (n·a)²,
/// that of a cone the variance of n·a. Centre and radius R are linear least squares of p - R n. The
/// apex of a cone is the intersection of the tangent planes. The axis of a torus meets all normal
/// lines: it is the linear complex closest to them [PottmannWallner2001]. Levenberg–Marquardt then
/// minimises the sum of squared distances.
///
/// The patch also has to determine the primitive: its normals vary by at least 3° (torus: 30°), and
/// its deviation from a plane is at least 20 times that from the primitive. Otherwise the result is
/// Kind::Free. The result is invariant to units and rigid motions, up to rounding. Radii are known
/// to within the deviation, and are rounded to as few decimals as that permits. Cost: O(samples),
/// that is four per triangle, and the vertices.
FittedPrimitive fit_primitive(const SkinnedRegion& region, double tolerance);

/// The same for positions and unit normals, one row each; zero normal: unknown.
FittedPrimitive fit_primitive(const Points& positions, const Points& normals, double tolerance);

/// Tolerance used in reports, model units: 1e-4 of the model size, but at most 5e-4 of the region's
/// size. The second bound prevents small regions of large models from being recognised as
/// primitives that they only resemble.
double primitive_tolerance(const SkinnedRegion& region, double model_size);

}  // namespace batten
