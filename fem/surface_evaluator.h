// Points of a surface at many places. Internal.
#pragma once

#include <vector>

#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

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
