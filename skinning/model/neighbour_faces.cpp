// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/neighbour_faces.h"

#include <set>

namespace batten {

void find_outer_boundaries(std::vector<NeighbourOpening>& openings) {
  constexpr double sheet = 320, sheet_with_hole = 180;  // degrees
  std::set<int> with_hole;
  for (const NeighbourOpening& opening : openings)
    if (opening.turning_deg < -sheet_with_hole) with_hole.insert(opening.component);
  for (NeighbourOpening& opening : openings)
    opening.outer_boundary =
        opening.turning_deg > (with_hole.count(opening.component) ? sheet_with_hole : sheet);
}

}  // namespace batten
