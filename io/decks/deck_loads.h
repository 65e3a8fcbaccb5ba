// SPDX-License-Identifier: MPL-2.0
// Nodal loads and springs of CalculiX decks of a model.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "batten/io/decks/deck_elements.h"

namespace batten {

/// Force and moment on one node.
struct NodalLoad {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
};
/// Nodal loads equivalent to all loads of a deck but pressures, gravity and centrifugal loads, by
/// 0-based node index.
std::map<int, NodalLoad> deck_forces(const std::vector<const SkinnedRegion*>& regions,
                                     const ModelElements& model, const DeckDiscretization& elements,
                                     const ShellDeck& deck);

/// A spring between a node and a fixed point.
struct NodalSpring {
  int node;
  Vec3 direction;  ///< unit vector
  double stiffness;
};
/// Nodal springs equivalent to the elastic supports of a deck: their stiffness per length and area is
/// distributed like a force.
std::vector<NodalSpring> deck_springs(const std::vector<const SkinnedRegion*>& regions,
                                      const ModelElements& model,
                                      const DeckDiscretization& elements, const ShellDeck& deck);

}  // namespace batten
