// SPDX-License-Identifier: MPL-2.0
// Model faces as faces on analytic surfaces (plane, cylinder, sphere, cone, torus): surface
// parameters, pcurves, seams and poles.
#pragma once

#include <Geom2d_BSplineCurve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <map>
#include <optional>
#include <vector>

#include "batten/io/cad/cad_primitive.h"
#include "batten/io/step/face_boundary.h"
#include "batten/skinning/surfaces/fitted_primitive.h"

namespace batten {

// Analytic surfaces and curves in their parameters.

/// A plane, cylinder, sphere, cone or torus as an OpenCASCADE surface. Its parameters (u, v) are
/// those of OpenCASCADE and STEP. For a plane, they are lengths along two axes. For all others, u
/// is the angle about the axis, counted from a reference direction. v is the height (cylinder), the
/// latitude (sphere), the length along the rulings (cone), or the angle around the tube, 0 on its
/// outside (torus).
class AnalyticSurface {
 public:
  /// `shape`: any primitive except FittedPrimitive::Kind::Free. `reference`: direction of u = 0,
  /// seen from the axis. `middle`: a point of the surface; on a cone, v = 0 there.
  AnalyticSurface(const FittedPrimitive& shape, const Vec3& reference, const Vec3& middle);

  const FittedPrimitive& shape() const { return shape_; }
  Handle(Geom_Surface) geometry() const { return geometry_; }
  /// Periods in u and v; 0 if the direction is not periodic.
  Vec2 periods() const;

  /// Parameters of the closest point. Each periodic parameter lies within half a period of `near`.
  /// On the axis (apex, pole) u is that of `near`.
  Vec2 parameters(const Vec3& p, const Vec2& near) const;
  /// The point at the given parameters.
  Vec3 position(const Vec2& uv) const;
  /// True if p is within `distance` of the apex of a cone or of a pole of a sphere.
  bool singular(const Vec3& p, double distance) const;

  /// The pcurve of `curve` over [first, last]: a C1 cubic B-spline. It is refined until it deviates
  /// by at most `tolerance` (model units) from the closest points to `curve`. It starts within half
  /// a period of `near` and is continuous from there. If `backwards`, the curve is followed from
  /// its end, and the pcurve ends there instead. `near` is updated to the other end.
  Handle(Geom2d_BSplineCurve) pcurve(const Geom_Curve& curve, double first, double last,
                                     bool backwards, double tolerance, Vec2& near) const;

 private:
  Vec2 slopes(const Vec3& p, const Vec3& slope) const;
  FittedPrimitive shape_;
  Vec3 x_, y_, origin_;  // origin_: point of the axis where v = 0
  double radius_ = 0;    // of a cone at v = 0
  Handle(Geom_Surface) geometry_;
};

/// A model face as a face on a plane, cylinder, sphere, cone or torus.
struct AnalyticFace {
  /// How the boundary loops wind around the surface.
  enum class Closing {
    None,     ///< no loop winds around: each returns to its start parameters
    AroundU,  ///< two loops wind once around in u, in opposite directions; the seam has constant u
    AroundV,  ///< the same in v, around the tube of a torus
    Pole      ///< one loop winds around the north pole of a sphere, which lies inside the face
  };
  AnalyticSurface surface;
  Closing closing = Closing::None;
  double seam = 0;           ///< u (AroundV: v) of the seam
  bool flipped = false;      ///< true if the model face's normal is opposite to that of the surface
  Vec2 near = Vec2::Zero();  ///< parameters near which loops that do not wind around are placed
  /// Winding number of each loop, in the direction in which the model face traverses it.
  std::vector<int> winding;

  /// For a loop that winds around: the index of the segment that starts at the seam.
  size_t seam_segment(const FaceLoop& loop) const;
};

/// Primitives fitted to the model faces that are candidates for analytic faces.
using MeasuredShapes = std::map<const SkinnedRegion*, FittedPrimitive>;
/// The analytic face of each model face that gets one.
using AnalyticFaces = std::map<const SkinnedRegion*, AnalyticFace>;

/// Plans the analytic faces of a file. Adds cuts to `plan` where their seams intersect curves.
/// Removes from `shapes` each model face that cannot be an analytic face: its boundary winds around
/// in an unsupported manner, passes too close to a pole, or leaves no position for a seam.
/// O(boundary).
AnalyticFaces analytic_faces(StepPlan& plan, MeasuredShapes& shapes);

}  // namespace batten
