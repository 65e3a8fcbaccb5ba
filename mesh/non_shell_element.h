// Elements of a deck that are no shells, as far as their nodes go.
#pragma once

#include <string>
#include <vector>

namespace batten {

/// An element of a deck that is no shell, or a connection of nodes, by its nodes. Where the deck
/// leaves a node out (an end to the ground, a middle node), it is not there.
struct NonShellElement {
  enum class Kind {
    Solid,  ///< corners, then middle nodes, in the deck's order
    Beam,   ///< bars and beams too: the ends, then a node that gives its direction, if there is one
    Bush,   ///< springs, dampers, gaps, fasteners: as a beam
    Rigid,  ///< the independent node first
    Interpolation,  ///< the reference node first, which follows the others
    Mass,           ///< one node
    Other           ///< something else
  };
  Kind kind = Kind::Other;
  std::string name;             ///< as the deck calls it: CHEXA, RBE2, C3D8, *MPC, …
  long label = 0;               ///< its number; 0 without one
  std::vector<int> nodes;       ///< indices of the mesh's nodes
  std::vector<double> weights;  ///< Average: one for each node but the first
};

}  // namespace batten
