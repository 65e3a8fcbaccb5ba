// The part of a surface that a scene means.
#pragma once

#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/sculpting/loads/loads.h"

namespace batten {

/// Where a load or weight acts: everywhere, `near` a line, or as painted; in the named regions.
struct SceneArea {
  Area area;                           ///< the area without its regions
  LocatedString line;                  ///< name of the line of `near`
  std::vector<LocatedString> regions;  ///< names of regions; none: all regions
};

/// Reads `near` and `radius`, `paint`, `regions`. Throws InputError with the place.
SceneArea read_area(const TomlTable& table);

}  // namespace batten
