// Elements of a deck that are no shells, as far as their nodes go.
#pragma once

#include <string>
#include <vector>

namespace batten {

/// An element that is no shell, or a connection of nodes, by its nodes: indices of the mesh.
struct OtherElement {
  enum class Kind {
    Solid,    ///< corners in the deck's order, then middle nodes
    Beam,     ///< bars, rods, beams
    Bush,     ///< springs, dampers, bushes, fasteners between two nodes
    Rigid,    ///< the independent node first
    Average,  ///< the reference node first: it moves as the mean of the others (RBE3)
    Mass,
    Other
  };
  Kind kind = Kind::Other;
  std::string name;  ///< as the deck calls it: CHEXA, RBE2, C3D8
  long label = 0;
  std::vector<int> nodes;
  std::vector<double> weights;  ///< Average: one for each node but the first
};

}  // namespace batten
