// What a region is made of, except its shape.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/skinning/region/region.h"

namespace batten {

/// A corner of the domain's outline. It has a place, and an interior angle (degrees) in the domain
/// and another one between the lines in space.
struct DomainCorner {
  Vec2 uv;
  double domain_degrees, line_degrees;
};

/// All that a region has except its shape.
struct RegionParts {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const Trim> trim;  ///< null when no embedded line bounds the region
  std::vector<LineRun> runs;
  std::vector<EmbeddedLine> embedded;
  std::vector<std::vector<BoundaryPiece>> boundary;
  std::vector<DomainCorner> corners;  ///< counter-clockwise
  std::vector<std::string> warnings;
};

}  // namespace batten
