// Closest-point queries on all regions of a model.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Finds closest points on a model, for many queries. It has one SurfaceProjector per region, built
/// on first use. Bounding boxes exclude regions that are too far away. It keeps copies of the
/// regions' surfaces, and its queries are thread-safe.
class ModelProjector {
 public:
  /// `dofs`: a shape on the layout, absolute coordinates.
  ModelProjector(const ModelLayout& layout, const Points& dofs);

  /// Result of a closest-point query; `distance` in model units.
  struct Nearest {
    ModelPoint at;
    Location where;  ///< location in the mesh of its region
    double distance = 0;
    bool inside = true;  ///< true if the point is inside the region's trim
  };
  /// Finds the closest point on the meshes of all regions, inside or outside of their trims. A
  /// point inside of a trim takes precedence over all points outside.
  Nearest nearest(const Vec3& p) const;
  /// Finds the closest point inside of the trims. If the closest one of all is outside, it falls
  /// back on Surface::closest_point(), which is slower.
  Nearest nearest_inside(const Vec3& p) const;
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
