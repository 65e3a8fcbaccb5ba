// Shell elements as files hold them: triangles, quads, polygons, second-order elements.
#pragma once

#include <span>
#include <vector>
#include <string>

#include "batten/core/eigen.h"
#include "batten/core/containers.h"

namespace batten {

/// Shell elements: nodes and faces, nothing checked. Nodes may belong to no face; faces may repeat
/// a node (a quad whose last two nodes are one is how FE decks write a triangle), be wound either
/// way, lie double: prepare() looks into that.
///
/// A linear face is a polygon: its nodes in order. A second-order face lists its corners, then the
/// middle nodes of the edges 12, 23, …, as S6 and S8 do.
class ShellMesh {
 public:
  Points points;  ///< n×3

  /// Appends a face; `second_order` needs 6 or 8 nodes.
  void add_face(std::span<const int> nodes, bool second_order = false) {
    nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    start_.push_back(isize(nodes_));
    second_order_.push_back(second_order);
  }

  int node_count() const { return static_cast<int>(points.rows()); }
  int face_count() const { return isize(second_order_); }
  /// All nodes of a face.
  std::span<const int> face(int f) const {
    return {nodes_.data() + start_[f], static_cast<size_t>(start_[f + 1] - start_[f])};
  }
  /// The corners of a face.
  std::span<const int> corners(int f) const {
    return face(f).first(face(f).size() / (second_order_[f] ? 2 : 1));
  }
  bool second_order(int f) const { return second_order_[f] != 0; }

 private:
  std::vector<int> nodes_, start_ = {0};
  std::vector<char> second_order_;
};


// Elements of a deck that are no shells, as far as their nodes go.

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
