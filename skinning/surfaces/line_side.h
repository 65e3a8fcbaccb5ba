// The side by which a finished region has a line on its boundary.
#pragma once

#include <optional>
#include <string>

#include "batten/skinning/model/join.h"

namespace batten {

/// Returns the side by which a finished region has a line of this name on its boundary, or nothing
/// when it has none. `region`: JoinSide::region of what is returned.
std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name);

}  // namespace batten
