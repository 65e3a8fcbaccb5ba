// How the boundary of a region lies on an analytic surface: seams, poles, and which way it runs. Internal.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "batten/io/cad/analytic_surface.h"
#include "batten/io/cad/face_boundary.h"

namespace batten {

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
