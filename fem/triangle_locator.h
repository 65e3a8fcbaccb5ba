// Which triangle of a parametric mesh holds a point.
#pragma once

#include <array>
#include <vector>

#include "batten/fem/parametric_mesh.h"

namespace batten {

/// Finds triangles by buckets over a mesh: O(1) a point. Keeps a reference to the mesh. On a mesh
/// that is periodic in u, triangles lie where shape() places them.
class TriangleLocator {
 public:
  explicit TriangleLocator(const ParametricMesh& mesh);

  /// The triangle that holds (u, v) and the barycentric coordinates in it. Outside of the mesh: the
  /// nearest point of it. On an edge or vertex: the triangle of lowest number. u comes around where
  /// the mesh is periodic.
  Location locate(const Vec2& uv) const;
  /// Triangles whose box meets a box, ascending; u does not come around.
  std::vector<int> near(const Vec2& low, const Vec2& high) const;

 private:
  struct Found {
    Location where;
    double distance;  // 0 inside
  };
  // The nearest point of a triangle within `nearest`; where.triangle is -1 when there is none.
  Found search(const Vec2& uv, double nearest) const;
  // Whether a triangle is clearly not the one.
  bool misses(int triangle, const Vec2& uv) const;
  double distance_to_bucket(int row, int column, const Vec2& uv) const;
  int column(double u) const;
  int row(double v) const;
  const ParametricMesh& mesh_;
  Vec2 low_;
  double cell_ = 1;
  int columns_ = 1, rows_ = 1;
  std::vector<int> start_, triangles_;        // of each bucket
  std::vector<std::array<Vec2, 3>> corners_;  // of each triangle
};

}  // namespace batten
