// Which places of lines are one node, and the pieces between nodes.
#pragma once

#include <vector>

#include "batten/skinning/network/arcs.h"
#include "batten/skinning/network/cuts.h"
#include "batten/skinning/network/network_contacts.h"

namespace batten::netting {

/// Ends, contacts and corners become nodes, the nearest first: two nodes become one where all
/// places then lie within the tolerance of the new one, which is the mean of the places inside of
/// lines and at their corners where there are any, of ends otherwise. What is repaired, left out
/// and found is added to `findings`.
NodesAndCuts make_nodes(const Strands& strands, const Contacts& contacts, double tolerance,
                        const std::vector<CharacterLine>& lines,
                        std::vector<NetworkFinding>& findings);

}  // namespace batten::netting
