// Elements and nodal forces of decks of CalculiX. Internal: not installed.
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "batten/io/decks/shell_deck.h"
#include "batten/skinning/facets/model_elements.h"

namespace batten {

/// Elements of one type on the nodes of six-node triangles, and on more where the type needs them.
struct DeckDiscretization {
  std::vector<Vec3> positions;  ///< of the nodes: those of the triangles come first
  std::vector<std::vector<std::vector<int>>> by_region;  ///< nodes of each element of each region
  /// S8R: the node in the middle between a corner of a triangle and the middle of its edge.
  std::map<std::pair<int, int>, int> quarters;

  /// The ends of a line's edges, then the nodes between them, each once.
  std::vector<int> nodes_on(const std::vector<std::array<int, 3>>& edges) const;
};
DeckDiscretization deck_elements(const std::vector<const SkinnedRegion*>& regions,
                                 const ModelElements& model, ShellDeck::Element element);

/// Area, line and point forces on the nodes, from 0.
std::map<int, Vec3> deck_forces(const std::vector<const SkinnedRegion*>& regions,
                                const ModelElements& model, const ShellDeck& deck);

}  // namespace batten
