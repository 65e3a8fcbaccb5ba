// What fair = "variation" and fair = "loft" make of lines alone, beside least bending.
#pragma once

#include <vector>

#include "analytic_shapes.h"
#include "bench.h"

namespace batten::bench {

/// Single regions at four meshes: distance to the formula beside least bending and Coons patches.
/// `only`: only of those added shapes whose names hold it; null: all.
void compare_fair(std::vector<AnalyticShape> shapes, const char* only, Checks& checks);
/// Several regions with smooth joins: distance to the formula, and the jump of curvature there.
void compare_joined(Checks& checks);
/// Rings and wings: sections as designers give them.
void compare_sections(Checks& checks);

/// 300 random outlines with holes and ribs: none runs away, every failure says why.
void compare_random(Checks& checks);

}  // namespace batten::bench
