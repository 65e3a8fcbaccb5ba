// How far a surface is from the blend of its boundary curves.
#pragma once

#include <optional>

#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// Largest distance of a region from its rest shape (rest_shape.h), and what it is compared with.
struct RestShapeDeviation {
  double distance = 0;  ///< between the two at vertices of the mesh, model units
  Vec3 at = Vec3::Zero();
  /// Distance between the sides: the shorter side of the rectangle with the rest shape's area and perimeter.
  double across = 0;
  /// Depth of the sections: of the boundary curves that bend, the least distance by which one leaves its
  /// chord (a closed one: its centre). 0 where none bends by more than 1e-2 of the size.
  double depth = 0;

  /// Above a tenth of the distance between the sides, or half of the depth, a surface is another one
  /// than its boundary curves mean: a film, or sections that get thinner in between.
  bool is_large() const { return distance > 0.1 * across || (depth > 0 && distance > 0.5 * depth); }
};

/// Nothing where the region has no rest shape. Costs one rest_dofs().
std::optional<RestShapeDeviation> rest_shape_deviation(const RegionLayout& layout,
                                                       const SkinnedRegion& made);

}  // namespace batten
