// Finds the nearest places of a whole model for many points in space.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// It has one SurfaceProjector for each region, made when it is needed; regions that are too far
/// away to matter are passed over by their boxes. It keeps copies of the regions' surfaces, and may be
/// asked from several threads.
class ModelProjector {
 public:
  /// `dofs` are those of a shape on the layout.
  ModelProjector(const ModelLayout& layout, const Points& dofs);

  struct Nearest {
    ModelPoint at;
    Location where;  ///< place in the mesh of its region
    double distance = 0;
    bool inside = true;  ///< the place lies inside of the region's trim
  };
  /// Returns the nearest place on the meshes of all regions, whether it lies inside of their trims
  /// or not. A place inside of a region's trim goes before all that lie outside.
  Nearest nearest(const Vec3& p) const;
  /// Returns the nearest place inside of a trim. Where the nearest one lies outside,
  /// Surface::closest_point() looks again, which takes longer.
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
