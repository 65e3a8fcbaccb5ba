// Volume that a closed surface encloses. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/mesh/deform/deform_system.h"

namespace batten {

/// V = 1/6 Σ p_a · (p_b × p_c), of nodes.
double enclosed_volume(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p);
/// ∂V/∂p, nodes × 3.
void volume_gradient(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p,
                     RowPoints& gradient);

}  // namespace batten
