// How the boundary of a region lies on an analytic surface: seams, poles, and which way it runs. Internal.
#pragma once

#include <map>
#include <optional>
#include <vector>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>

#include "batten/io/step/face_boundary.h"
#include "batten/skinning/surfaces/fitted_primitive.h"

namespace batten {

// A plane, cylinder, sphere, cone or torus as a surface of OpenCASCADE, and curves in its parameters. Internal.

/// Parameters (u, v) are those of OpenCASCADE and of STEP: of a plane lengths along two axes; of all others u is the
/// angle about the axis, from a reference direction, and v the height (cylinder), the latitude (sphere), the length
/// along the straight lines (cone), or the angle around the tube, from outside (torus).
class AnalyticSurface {
 public:
  /// `shape`: any primitive but FittedPrimitive::Kind::Free. u = 0 in the direction of `reference` from the axis.
  /// `middle`: a point of the surface, where a cone has v = 0.
  AnalyticSurface(const FittedPrimitive& shape, const Vec3& reference, const Vec3& middle);

  const FittedPrimitive& shape() const { return shape_; }
  Handle(Geom_Surface) geometry() const { return geometry_; }
  /// Periods in u and v; 0: none.
  Vec2 periods() const;

  /// Parameters of the nearest point, both angles within half a period of `near`. At an apex or pole u is that of `near`.
  Vec2 parameters(const Vec3& p, const Vec2& near) const;
  Vec3 position(const Vec2& uv) const;
  /// Whether p is the apex of a cone, or a pole of a sphere, within `distance`.
  bool singular(const Vec3& p, double distance) const;

  /// The curve's image in the parameters over [first, last], a C1 cubic B-spline, within `tolerance` of the points nearest
  /// to the curve (model units). It starts within half a period of `near` (ends there when `backwards`, where the curve is
  /// followed from its end), and continues from there; `near` becomes its other end.
  Handle(Geom2d_BSplineCurve) pcurve(const Geom_Curve& curve, double first, double last,
                                     bool backwards, double tolerance, Vec2& near) const;

 private:
  Vec2 slopes(const Vec3& p, const Vec3& slope) const;
  FittedPrimitive shape_;
  Vec3 x_, y_, origin_;  // origin_: where v = 0, on the axis
  double radius_ = 0;    // of a cone at v = 0
  Handle(Geom_Surface) geometry_;
};

/// The primitive that a surface of OpenCASCADE is; Kind::Free for any other.
FittedPrimitive shape_of(const Handle(Geom_Surface) & surface);


/// A region as a face on a plane, cylinder, sphere, cone or torus.
struct AnalyticFace {
  enum class Closing {
    None,  ///< every loop comes back to the parameters that it began with
    AroundU,  ///< two loops run once around in u, in opposite directions: the face closes at a seam of constant u
    AroundV,  ///< the same in v, around the tube of a torus
    Pole      ///< one loop runs around the north pole of a sphere, which the face holds
  };
  AnalyticSurface surface;
  Closing closing = Closing::None;
  double seam = 0;           ///< the parameter (u, or v) of the seam
  bool flipped = false;      ///< whether the region's normal points inwards
  Vec2 near = Vec2::Zero();  ///< about where parameters of loops begin that run around nothing
  std::vector<int>
      winding;  ///< of each loop: how often it runs around, in the direction of its region

  /// The place in a loop that runs around where it meets the seam: the number of the stretch that begins there.
  size_t seam_segment(const FaceLoop& loop) const;
};

/// The regions that are to be analytic faces: what was measured of them.
using MeasuredShapes = std::map<const SkinnedRegion*, FittedPrimitive>;
using AnalyticFaces = std::map<const SkinnedRegion*, AnalyticFace>;

/// Plans the analytic faces of a file, and adds to `plan` where their seams cut lines. Erases regions from `shapes` that
/// cannot be one: a boundary that runs around in another way, that passes a pole, or leaves no place for a seam.
/// O(boundary).
AnalyticFaces analytic_faces(StepPlan& plan, MeasuredShapes& shapes);

}  // namespace batten
