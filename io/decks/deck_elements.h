// SPDX-License-Identifier: MPL-2.0
// Elements of CalculiX decks of a model.
#pragma once

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/decks/shell_deck.h"
#include "batten/skinning/facets/model_elements.h"

namespace batten {

/// Elements of one type, built on the nodes of six-node triangles and additional nodes if the type
/// needs them.
struct DeckDiscretization {
  std::vector<Vec3> positions;  ///< positions of the nodes; those of the triangles come first
  std::vector<std::vector<std::vector<int>>> by_region;  ///< nodes of each element, by face
  /// S8R: the node halfway between a triangle corner (first) and the midpoint of its edge (second).
  std::map<std::pair<int, int>, int> quarters;

  /// The end nodes of a curve's edges, then the nodes in between, each once.
  std::vector<int> nodes_on(const std::vector<std::array<int, 3>>& edges) const;
  /// Unit tangents of a curve at its nodes; at a corner, that of one side.
  std::map<int, Vec3> tangents(const ModelElements& model, const std::string& line) const;
};
/// The node nearest to a point.
int nearest_node(const std::vector<Vec3>& positions, const Vec3& p);
/// Builds the elements of a deck from six-node triangles.
DeckDiscretization deck_elements(const std::vector<const SkinnedRegion*>& regions,
                                 const ModelElements& model, ShellDeck::Element element);

}  // namespace batten
