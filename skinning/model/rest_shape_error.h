// Element sizes that resolve a region's rest shape. Internal.
#pragma once

#include <memory>

#include "batten/skinning/domains/size_field.h"
#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// How far the elements of a region are from its rest shape.
struct RestShapeError {
  double largest = 0;  ///< model units; 0 where the rest shape is no sweep
  /// Longest edges that resolve it, as far as is known; null where `largest` is within the tolerance.
  std::shared_ptr<const SizeField> size_field;
};

/// Compares the interpolated rest shape with the sweep itself in the middle of each edge, where the
/// error of a cubic is largest. Where it is above the tolerance (model units) edges of length h are to
/// become h (tolerance / 2 error)^(1/4), at least h / 2; elsewhere they may be as long as `before` says,
/// the sizes that the region was meshed with. One rest_dofs().
RestShapeError rest_shape_error(const RegionLayout& region, double tolerance,
                                const SizeField* before = nullptr);

}  // namespace batten
