// The ground of a sequence: which point of a mesh is above or below a place, and its normal.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A triangle mesh seen from above. Triangles may be given either way round, may be steep, and may
/// lie above each other; upright ones are not seen.
class Terrain {
 public:
  /// Throws InputError on an `up` that is no direction and on a mesh without triangles to be seen.
  /// O(triangles) and a grid of about as many cells.
  explicit Terrain(TriangleMesh mesh, const Vec3& up = Vec3::UnitZ());

  struct SurfacePoint {
    Vec3 at;
    Vec3 normal;  ///< unit, upwards; vertex normals (means by area) interpolated
  };
  /// The highest point of the mesh on the line p + t · up; none where there is no mesh. The few
  /// triangles of one cell are looked at.
  std::optional<SurfacePoint> surface_point(const Vec3& p) const;
  const Vec3& up() const { return up_; }

 private:
  Vec2 to_plane(const Vec3& p) const { return {p.dot(across_[0]), p.dot(across_[1])}; }
  int cell(double x, int axis) const;
  TriangleMesh mesh_;
  Vec3 up_, across_[2];
  Points normals_;  // of the nodes
  Vec2 low_, step_;
  int cells_ = 1;                  // along each axis
  std::vector<int> start_, list_;  // triangles of each cell
};

}  // namespace batten
