// Which places of lines are one node, and the pieces between nodes.
#pragma once

#include <vector>

#include "batten/skinning/network/network.h"
#include "batten/skinning/network/network_contacts.h"

namespace batten::netting {

/// A piece of a strand between two nodes.
struct Cut {
  int strand = 0;
  double s0 = 0, s1 = 0;  ///< arc lengths; s1 above the strand's length: across its seam
  std::array<int, 2> nodes{};
  std::vector<int> shared;  ///< lines that ran along it, whose piece was left out
};

struct NodesAndCuts {
  std::vector<Vec3> nodes;  ///< positions
  std::vector<Cut> cuts;    ///< by strand, along it

  /// Number of ends of cuts at each node.
  std::vector<int> degrees() const;
};

/// Ends, contacts and corners become nodes, the nearest first: two nodes become one where all
/// places then lie within the tolerance of the new one, which is the mean of the places inside of
/// lines and at their corners where there are any, of ends otherwise. What is repaired, left out
/// and found is added to `findings`.
NodesAndCuts make_nodes(const Strands& strands, const Contacts& contacts, double tolerance,
                        const std::vector<CharacterLine>& lines,
                        std::vector<NetworkFinding>& findings);

}  // namespace batten::netting
