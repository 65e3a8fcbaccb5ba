// Nearest points of one surface for many points in space.
#pragma once

#include <vector>

#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

/// From the nearest of the surface's vertices and centroids, or from a start that is known,
/// Newton's steps across the elements, down to the nearest point there: of the whole mesh, whether
/// a trim has it inside or not. Surface::closest_point looks everywhere, and takes hundreds of
/// times as long. Keeps a reference to the surface. A few microseconds a point, and O(triangles)
/// for the nearest sample.
class SurfaceProjector {
 public:
  explicit SurfaceProjector(const Surface& surface);

  Surface::Closest nearest(const Vec3& p) const;
  /// The same from a start in the neighbourhood: points of a line, one after the other.
  Surface::Closest nearest(const Vec3& p, const Location& start) const;

 private:
  const Surface& surface_;
  TriangleLocator locator_;
  Points samples_;
  std::vector<Location> where_;
};

}  // namespace batten
