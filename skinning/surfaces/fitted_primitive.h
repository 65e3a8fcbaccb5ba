// Measures whether a finished surface is a plane, cylinder, sphere, cone or torus.
#pragma once

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// The simplest primitive that a surface is within a tolerance, and its frame in space.
///
///     primitive   origin                  axis                        lengths and angle
///     plane       a point of it           the surface's mean normal
///     cylinder    a point of the axis     along the axis              radius
///     sphere      its centre              (any)                       radius
///     cone        its apex                from the apex to the surface radius, half_angle
///     torus       its centre              normal to the major circle  major_radius, radius
struct FittedPrimitive {
  enum class Kind { Free, Plane, Cylinder, Sphere, Cone, Torus };
  Kind kind = Kind::Free;
  Vec3 origin = Vec3::Zero();  ///< model units
  Vec3 axis = Vec3::UnitZ();   ///< unit vector
  double radius = 0;  ///< of a torus that of its tube, of a cone the surface's largest; model units
  double major_radius = 0;  ///< of a torus; model units
  double half_angle = 0;    ///< of a cone, radians in (0, π/2)
  double deviation = 0;     ///< largest distance of the samples from the primitive; model units

  /// Signed distance of a point, positive on the outer side (of a plane: on the side of its axis). Model units.
  double distance(const Vec3& p) const;
  /// Unit normal at the primitive's point nearest to p, pointing to the outer side.
  Vec3 normal(const Vec3& p) const;
};

/// The word for a kind: "plane", "cylinder", "sphere", "cone", "torus"; "" for Kind::Free.
const char* primitive_name(FittedPrimitive::Kind kind);

/// Fits primitives to sampled positions and normals inside the trim, and takes the first one, in the order plane,
/// cylinder or sphere, cone, torus, whose largest deviation is at most `tolerance` (model units, > 0); a later one if
/// its deviation is less than a fifth.
///
/// Initial values come from the normals: the axis of a cylinder is the direction with the least Σ (n·a)², that of a
/// cone the one with the least variance of n·a, centre and radius are linear least squares of
/// p - R n, a cone's apex is where the tangent planes meet, a torus's axis is the line that all normal lines meet:
/// the linear complex nearest to them (Pottmann & Wallner, Computational Line Geometry, 2001). Levenberg-Marquardt steps then minimise the sum of squared distances.
///
/// A primitive also has to be determined by the patch: its normals turn by at least 3 degrees (a torus: 30), and the
/// patch is off its plane by at least 20 times of what it is off the primitive. Otherwise Kind::Free. The result does
/// not depend on the unit, nor on a rigid motion, but for rounding. Radii are known to within the deviation: they get as
/// few decimals as that allows. O(samples): four a triangle, and the vertices.
FittedPrimitive fit_primitive(const SkinnedRegion& region, double tolerance);

/// Same for positions and unit normals (zero: none there), one row each.
FittedPrimitive fit_primitive(const Points& positions, const Points& normals, double tolerance);

/// The tolerance of reports: 1e-4 of the model's size, but at most 5e-4 of the region's, so that small regions of large
/// models are not taken for primitives that they only resemble. Model units.
double primitive_tolerance(const SkinnedRegion& region, double model_size);

}  // namespace batten
