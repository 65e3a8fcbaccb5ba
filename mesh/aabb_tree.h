// The nearest point of a triangle mesh. Internal.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A tree of boxes around triangles, halved at the median of their middles. O(triangles log triangles) once;
/// a search looks at some dozens of boxes, about a microsecond near the surface. It may be asked from several
/// threads.
class AabbTree {
 public:
  explicit AabbTree(const TriangleMesh& mesh);

  struct ClosestPoint {
    int triangle = -1;
    Vec3 at = Vec3::Zero(), weights = Vec3::Zero();  ///< barycentric
    double distance = 0;
  };
  /// Of triangles whose normal has a positive share of `normal`, where it is given; none: no such
  /// triangle. Of several at the same distance the lowest.
  std::optional<ClosestPoint> nearest(const Vec3& p, const std::optional<Vec3>& normal = {}) const;

 private:
  struct Node {
    Vec3 low, high;
    int first = 0, last = 0;  // of order_
    int right = -1;           // the left half is the next node; none: a leaf
    double distance2(const Vec3& p) const {
      return (low - p).cwiseMax(p - high).cwiseMax(0).squaredNorm();
    }
  };
  int build(int first, int last, const std::vector<Vec3>& centroids);

  TriangleMesh mesh_;
  std::vector<int> order_;  // triangles, those of a node side by side
  std::vector<Node> nodes_;
};

}  // namespace batten
