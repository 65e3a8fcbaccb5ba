// SPDX-License-Identifier: MPL-2.0
// Surfaces of fair = "variation" and fair = "loft" from curves alone, compared with bending energy.
#pragma once

#include <vector>

#include "analytic_shapes.h"
#include "bench.h"

namespace batten::bench {

/// Single faces on four meshes: distance from the exact surface, compared with bending energy and
/// Coons patches. `only`: limits the added shapes to names that contain it; null: all.
void compare_fair(std::vector<AnalyticShape> shapes, const char* only, Checks& checks);
/// Several faces with smooth edges: distance from the exact surface, and the curvature jump there.
void compare_joined(Checks& checks);
/// Annular faces, and wings from the sections that designers use.
void compare_sections(Checks& checks);

/// 300 random outlines with holes and ribs: no solve diverges, and every failure gives a reason.
void compare_random(Checks& checks);

}  // namespace batten::bench
