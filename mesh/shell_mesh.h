// SPDX-License-Identifier: MPL-2.0
// Shell elements as read from files: triangles, quads, polygons and second-order elements. Other
// elements are represented by their nodes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"

namespace batten {

/// Shell elements, stored as nodes and faces, without any checks. Nodes need not belong to a face.
/// Faces may repeat a node (in FE decks, a triangle may be a quad whose last two nodes coincide),
/// be inconsistently oriented, or be duplicated. prepare() resolves these cases.
///
/// A linear face is a polygon, given by its nodes in order. A second-order face is given by its
/// corners, followed by the midside nodes of its edges (first to second corner, second to third,
/// …), like the elements S6 and S8.
class ShellMesh {
 public:
  Points points;  ///< node coordinates, n×3

  /// Appends a face. `nodes`: 0-based node indices; a second-order face must have 6 or 8 nodes.
  void add_face(std::span<const int> nodes, bool second_order = false) {
    nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    start_.push_back(isize(nodes_));
    second_order_.push_back(second_order);
  }

  int node_count() const { return static_cast<int>(points.rows()); }
  int face_count() const { return isize(second_order_); }
  /// Node indices of face f, including midside nodes.
  std::span<const int> face(int f) const {
    return {nodes_.data() + start_[f], static_cast<size_t>(start_[f + 1] - start_[f])};
  }
  /// Node indices of the corners of face f, without midside nodes.
  std::span<const int> corners(int f) const {
    return face(f).first(face(f).size() / (second_order_[f] ? 2 : 1));
  }
  bool second_order(int f) const { return second_order_[f] != 0; }

 private:
  std::vector<int> nodes_, start_ = {0};
  std::vector<char> second_order_;
};

// Elements other than shells.

/// An element of an FE deck that is not a shell (a solid, beam or connector, for example), given by
/// its nodes. `nodes` contains no entry for a node that the deck omits (a grounded end, a midside
/// node).
struct NonShellElement {
  enum class Kind {
    Solid,          ///< solid element: corners, then midside nodes, in the order of the deck
    Beam,           ///< bar or beam: both ends, then the orientation node, if any
    Bush,           ///< spring, damper, gap, fastener: ends, then orientation node, if any
    Rigid,          ///< rigid body element (RBE2, for example); first node: independent node
    Interpolation,  ///< interpolation element (RBE3); first node: dependent reference node
    Mass,           ///< point mass with one node
    Other           ///< any other element type
  };
  Kind kind = Kind::Other;
  std::string name;             ///< element type in the deck: CHEXA, RBE2, C3D8, *MPC, …
  long label = 0;               ///< element number in the deck; 0: no number
  std::vector<int> nodes;       ///< 0-based node indices of the mesh
  std::vector<double> weights;  ///< for Kind::Interpolation: one per node after the first
};

/// A connection of nodes with surfaces that do not share nodes with them: a tie (adhesive), or a spot
/// weld. The nodes follow the closest points of the surfaces.
struct SurfaceTie {
  enum class Kind {
    Tie,  ///< each node follows the closest point of the surface
    Weld  ///< all nodes and the closest face of each side form a rigid body
  };
  Kind kind = Kind::Tie;
  std::string name;        ///< "*TIE GLUE", "CWELD 12"
  std::vector<int> nodes;  ///< nodes that follow; nodes of shells or of other elements
  /// Shell faces that the nodes follow, one list per side of a weld; empty: all faces.
  std::vector<std::vector<int>> sides;
  double reach = 0;  ///< largest distance that is tied; 0: the longest edge of the closest face
};

}  // namespace batten
