// Lines from their segments.
#pragma once

#include <vector>

#include "batten/io/lines/named_points.h"

namespace batten {

/// Chains lines of two points into the lines that they are segments of, as programs write them that
/// know edges only (`l 1 2`, `l 2 3`, …). Two segments of one name are joined where they alone have
/// a point and the line turns by less than 60 degrees there: the sides of a hexagon stay six lines.
/// Points are the same where their coordinates are. A chain lies where its first segment lay in the
/// list, runs as that one does, and repeats its first point when it is closed. All other lines
/// are as given. O(n log n).
std::vector<NamedPoints> chain_segments(std::vector<NamedPoints> lines);

}  // namespace batten
