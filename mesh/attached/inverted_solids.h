// Solid elements that a change of shape turned inside out.
#pragma once

#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/non_shell_element.h"

namespace batten {

/// Indices of the solids with a corner whose Jacobian (the volume that its three edges span) has
/// another sign `after` than `before`, or none: tetrahedra, pyramids (but for the tip), wedges and
/// hexahedra with their corners first. Corners without volume before do not count. O(elements).
std::vector<int> inverted_solids(std::span<const NonShellElement> elements, const Points& before,
                                 const Points& after);

/// Whether the element is a solid whose corners are known by the number of its nodes.
int corner_count(const NonShellElement& solid);

}  // namespace batten
