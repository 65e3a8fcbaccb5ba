// The nearest point of a triangle mesh. Internal.
#pragma once

#include <memory>
#include <optional>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A tree over the boxes of triangles. O(triangles log triangles) once, O(log triangles) a search.
class SurfaceSearch {
 public:
  explicit SurfaceSearch(const TriangleMesh& mesh);
  ~SurfaceSearch();

  struct Found {
    int triangle = -1;
    Vec3 at = Vec3::Zero(), weights = Vec3::Zero();  ///< barycentric
    double distance = 0;
  };
  /// Of triangles whose normal has a positive share of `normal`, where it is given; none: no such
  /// triangle.
  std::optional<Found> nearest(const Vec3& p, const std::optional<Vec3>& normal = {}) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
