// Which places of lines are one node, and the pieces between nodes.
#pragma once

#include <vector>

#include "batten/skinning/network/contacts.h"
#include "batten/skinning/network/network_edge.h"
#include "batten/skinning/network/network_topology.h"

namespace batten::detail {

/// Ends, contacts and corners become nodes, the nearest first: two nodes become one where all
/// places then lie within the tolerance of the new one, which is the mean of the places inside of
/// lines and at their corners where there are any, of ends otherwise. What is repaired, left out
/// and found is added to `diagnostics`.
NetworkTopology make_nodes(const SampledCurves& sampled_curves, const Contacts& contacts,
                           double tolerance, const std::vector<CharacterLine>& lines,
                           std::vector<NetworkDiagnostic>& diagnostics);

}  // namespace batten::detail
