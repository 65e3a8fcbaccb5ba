// Shell elements as read from files: triangles, quads, polygons and second-order elements. Also
// other elements by their nodes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"

namespace batten {

/// Shell elements as nodes and faces, without any checks. Nodes may belong to no face. Faces may
/// repeat a node (FE decks write a triangle as a quad whose last two nodes coincide), be
/// inconsistently oriented, or be duplicated. prepare() resolves all of that.
///
/// A linear face is a polygon: its nodes in order. A second-order face lists its corners, then the
/// midside nodes of the edges 12, 23, …, like the elements S6 and S8.
class ShellMesh {
 public:
  Points points;  ///< node coordinates, n×3

  /// Appends a face. `second_order` requires 6 or 8 nodes.
  void add_face(std::span<const int> nodes, bool second_order = false) {
    nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    start_.push_back(isize(nodes_));
    second_order_.push_back(second_order);
  }

  int node_count() const { return static_cast<int>(points.rows()); }
  int face_count() const { return isize(second_order_); }
  /// All nodes of a face, midside nodes included.
  std::span<const int> face(int f) const {
    return {nodes_.data() + start_[f], static_cast<size_t>(start_[f + 1] - start_[f])};
  }
  /// The corner nodes of a face.
  std::span<const int> corners(int f) const {
    return face(f).first(face(f).size() / (second_order_[f] ? 2 : 1));
  }
  bool second_order(int f) const { return second_order_[f] != 0; }

 private:
  std::vector<int> nodes_, start_ = {0};
  std::vector<char> second_order_;
};

// Elements other than shells.

/// An element of a deck that is not a shell, or a connector, by its nodes. Nodes that the deck
/// omits (a grounded end, a midside node) are omitted here too.
struct NonShellElement {
  enum class Kind {
    Solid,          ///< corners, then midside nodes, in the order of the deck
    Beam,           ///< bars and beams: both ends, then the orientation node, if there is one
    Bush,           ///< springs, dampers, gaps, fasteners: the same nodes as Beam
    Rigid,          ///< rigid body element (RBE2, say); the independent node comes first
    Interpolation,  ///< interpolation (RBE3) element; the dependent reference node comes first
    Mass,           ///< point mass: one node
    Other           ///< any other element
  };
  Kind kind = Kind::Other;
  std::string name;             ///< name in the deck: CHEXA, RBE2, C3D8, *MPC, …
  long label = 0;               ///< element number; 0 if it has none
  std::vector<int> nodes;       ///< indices of nodes of the mesh
  std::vector<double> weights;  ///< Interpolation: one per node except the first
};

}  // namespace batten
