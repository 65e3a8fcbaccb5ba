// Shell elements as files hold them: triangles, quads, polygons, second-order elements.
#pragma once

#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/isize.h"

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

}  // namespace batten
