// Nearest points of one surface for many points in space.
#pragma once

#include <vector>

#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

/// Finds nearest points by Newton's steps across the elements, which begin at the nearest of the
/// surface's vertices and centroids or at a start that is known. Points are those of the whole
/// mesh, whether a trim has them inside or not. Surface::closest_point looks everywhere, and takes
/// hundreds of times as long. Keeps a reference to the surface. A few microseconds a point, and
/// O(triangles) for the nearest sample.
class SurfaceProjector {
 public:
  explicit SurfaceProjector(const Surface& surface);

  Surface::ClosestPoint nearest(const Vec3& p) const;
  /// The nearest point from a start in the neighbourhood, as for points of a line in their order.
  Surface::ClosestPoint nearest(const Vec3& p, const Location& start) const;

 private:
  const Surface& surface_;
  TriangleLocator locator_;
  Points samples_;
  std::vector<Location> where_;
};


// Points of a surface at many places. Internal.

/// The places and positions of a surface, as it was when this was made: of HCT triangles by the Bézier
/// ordinates of their three cubics, 90 numbers a triangle, which Surface::position() makes anew at each place.
class SurfaceEvaluator {
 public:
  explicit SurfaceEvaluator(Surface surface);

  const Surface& surface() const { return surface_; }
  /// As TriangleLocator::locate().
  Location locate(const Vec2& uv) const { return locator_.locate(uv); }
  Vec3 position(const Location& where) const;
  Vec3 position(const Vec2& uv) const { return position(locate(uv)); }

 private:
  Surface surface_;
  TriangleLocator locator_;
  std::vector<Eigen::Matrix<double, 3, 10>> cubics_;  // three of each triangle; none of Z12
};

}  // namespace batten
