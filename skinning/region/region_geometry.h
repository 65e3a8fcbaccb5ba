// What a region is made of, except its shape.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// A corner of the domain's outline. It has a place, and an interior angle (degrees) in the domain
/// and another one between the lines in space.
struct DomainCorner {
  Vec2 uv;
  double domain_angle_deg, line_angle_deg;
};

/// All that a region has except its shape.
struct RegionGeometry {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const Trim> trim;  ///< null when no embedded line bounds the region
  std::vector<EdgeAlignedLine> edge_aligned;
  std::vector<EmbeddedLine> embedded;
  std::vector<std::vector<BoundarySegment>> boundary;
  std::vector<DomainCorner> corners;  ///< counter-clockwise
  std::vector<std::string> warnings;
};

}  // namespace batten
