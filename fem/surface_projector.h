// Fast closest-point projection of many points onto a surface.
#pragma once

#include <vector>

#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

/// Projects points in space onto a surface by Newton's method across elements. It starts at the
/// nearest of the surface's vertices and centroids, or at a known location nearby.
///
/// Points of the whole mesh are candidates, whether inside of a trim or not.
/// Surface::closest_point() searches everywhere and takes hundreds of times as long. Keeps a
/// reference to the surface. Cost: a few microseconds per point, plus O(triangles) to find the
/// nearest sample.
class SurfaceProjector {
 public:
  explicit SurfaceProjector(const Surface& surface);

  /// Nearest point to p, starting from the nearest sample.
  Surface::ClosestPoint nearest(const Vec3& p) const;
  /// Nearest point to p, starting from a known location nearby, for example that of the previous
  /// point on a curve.
  Surface::ClosestPoint nearest(const Vec3& p, const Location& start) const;

 private:
  const Surface& surface_;
  TriangleLocator locator_;
  Points samples_;
  std::vector<Location> where_;
};

// Fast evaluation of a fixed surface.

/// Copy of a surface prepared for many evaluations. For HCT triangles it stores the Bézier
/// ordinates of their three cubics, 90 numbers per triangle, which Surface::position() recomputes
/// at each point.
class SurfaceEvaluator {
 public:
  explicit SurfaceEvaluator(Surface surface);

  const Surface& surface() const { return surface_; }
  /// Like TriangleLocator::locate().
  Location locate(const Vec2& uv) const { return locator_.locate(uv); }
  Vec3 position(const Location& where) const;
  Vec3 position(const Vec2& uv) const { return position(locate(uv)); }

 private:
  Surface surface_;
  TriangleLocator locator_;
  std::vector<Eigen::Matrix<double, 3, 10>> cubics_;  // three per triangle; empty for Z12
};

}  // namespace batten
