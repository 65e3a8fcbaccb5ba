// SPDX-License-Identifier: MPL-2.0
// Closest-point queries on all faces of a model.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Finds closest points on a model; efficient for many queries. Each face has a SurfaceProjector,
/// which is built when the face is first searched. Bounding boxes exclude faces that are too far
/// away. The object contains copies of the surfaces. Queries are thread-safe.
///
/// Cost: O(triangles) for the construction; per query, that of SurfaceProjector::nearest() in each
/// face that the boxes do not exclude.
class ModelProjector {
 public:
  /// Prepares queries for one shape of a model. `dofs`: the shape on `layout`, n×3, absolute
  /// coordinates in model units.
  ModelProjector(const ModelLayout& layout, const Points& dofs);

  /// Result of a closest-point query; `distance` in model units.
  struct Nearest {
    ModelPoint at;
    Location where;  ///< location of the point in the mesh of its face
    double distance = 0;
    bool inside = true;  ///< true: the point is inside the trimmed domain of its face
  };
  /// Finds the point of all faces closest to `p` (model units), inside or outside of their trimmed
  /// domains. A point inside takes precedence over all points outside.
  Nearest nearest(const Vec3& p) const;
  /// Finds the point closest to `p` (model units) inside the trimmed domains of all faces, so that
  /// Nearest::inside is true. If nearest() finds a point outside, Surface::closest_point() is
  /// called, which is slower.
  Nearest nearest_inside(const Vec3& p) const;
  /// The surface of a face, in the shape that was passed to the constructor. `region`: index of the
  /// face in the layout.
  const Surface& surface(int region) const { return regions_[region].surface; }

 private:
  struct Region {
    Surface surface;
    Box3 box;
    mutable std::unique_ptr<SurfaceProjector> projector;
    double distance_to_box(const Vec3& p) const;
  };
  Nearest in_region(int r, const Vec3& p) const;
  std::vector<Region> regions_;
  mutable std::vector<std::once_flag> projectors_made_;
};

}  // namespace batten
