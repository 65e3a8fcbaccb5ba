// Springs that hold a shell.
#pragma once

#include <optional>
#include <string>

#include "batten/analysis/models/shell_loads.h"
#include "batten/analysis/models/shell_springs.h"

namespace batten {

/// Springs that hold a shell at a place, per length of a line or per area of a part.
struct ElasticSupport {
  std::string name;
  std::optional<ShellLocation> position;  ///< of a point; else
  std::string line;  ///< of a line, as far as it lies in the part's box; "": an area
  ShellPart part;
  Vec3 stiffness = Vec3::Zero();  ///< along x, y, z: force over displacement, or per length or area
  double normal = 0;              ///< of an area: along its normal (an elastic foundation)
};

/// Adds its springs. Throws InputError: no such line or region, stiffness below 0 or none, a part that
/// holds nothing.
void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, ShellSprings& springs);

}  // namespace batten
