// SPDX-License-Identifier: MPL-2.0
// Spatial index: a tree of axis-aligned boxes for closest-point and overlap queries.
#pragma once

#include <algorithm>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"

namespace batten {

/// Bounding-volume hierarchy over n axis-aligned boxes in the plane (Dim = 2) or in space (Dim =
/// 3). It indexes elements that are scattered in space, such as triangles of a mesh, chords of
/// curves or facets of a model.
///
/// The tree stores boxes only; the caller defines the elements and their distances from points. A
/// query passes the indices of all elements that cannot be excluded by their boxes to a callback,
/// which carries out the exact test. Callbacks are template parameters and are inlined.
///
///     BoxTree<3> tree(boxes);                                   // box i belongs to element i
///     const auto [element, distance2] = tree.nearest(p, [&](int i) { return distance2(i, p); });
///     tree.for_each_near(box, reach, [&](int i) { … });         // elements near a box or a point
///     tree.for_each_near_pair(reach, [&](int i, int j) { … });  // elements near each other
///
/// A node is split at the median of the keys (by default the box centres) of its elements, along
/// the longest side of its box, until it contains at most four elements. The depth is therefore at
/// most log2(n), for any distribution of the elements.
///
/// The elements and pairs that a query finds, and the result of nearest(), do not depend on the
/// structure of the tree, but the order of the callbacks does. Sort the indices if your result
/// depends on their order, for example if it is a sum.
///
/// A tree is immutable. Its queries are thread-safe and allocate no memory.
/// Memory: about 120 bytes per element for Dim = 3.
///
/// For point location in a parametric mesh, TriangleLocator is faster: O(1) per point. Reference:
/// [Ericson2005], chapter 6.
template <int Dim>
class BoxTree {
 public:
  using Point = Eigen::Matrix<double, Dim, 1>;
  using Box = Eigen::AlignedBox<double, Dim>;

  /// Constructs an empty tree, whose queries find no element.
  BoxTree() = default;
  /// Builds a tree over the elements 0 … n - 1. Cost: O(n log n); parallel.
  ///
  /// `boxes`: one box per element. A box may be degenerate, for example a point. An element whose
  /// box is empty (Box()) is never found. `keys`: one position per element, by which nodes are
  /// split; empty: the centres of the boxes. Other keys, for example centroids, change the cost of
  /// queries, not the elements that they find. Throws InputError if a coordinate is infinite or not
  /// a number, or if the number of keys is neither 0 nor n.
  explicit BoxTree(const std::vector<Box>& boxes, const std::vector<Point>& keys = {});

  /// Number of elements whose boxes are not empty.
  int size() const { return isize(order_); }

  /// Result of a search for the closest element.
  struct Nearest {
    int element = -1;              ///< index of the element; -1: no element was found
    double distance2 = kInfinity;  ///< squared distance returned by the callback for this element
  };
  /// Finds the element that is closest to the point p. Ties go to the lowest index.
  ///
  /// `distance2(i)`: squared distance of element i from p. If it is infinite or not a number, the
  /// element is skipped; a callback can thus exclude elements. The value must not be smaller than
  /// the squared distance of the element's box from p, except by rounding errors. If p has a
  /// coordinate that is not a number and the callback propagates it, no element is found.
  ///
  /// Cost: O(log n) calls if few elements are about equally near, for example if p is near a
  /// surface; O(n) at worst, for example at the centre of a sphere.
  template <class Distance2>
  Nearest nearest(const Point& p, const Distance2& distance2) const;

  /// Calls found(i) for each element i whose box has a gap of at most `reach` to `box` along each
  /// axis.
  ///
  /// `reach`: finite, 0 or more; 0 finds the boxes that overlap or touch `box`. For a query at a
  /// point p, pass Box(p). The gap is measured along each axis separately, so the Euclidean
  /// distance between the boxes may be up to √Dim · reach. Cost: O(log n + elements found) for
  /// elements of similar sizes.
  template <class Found>
  void for_each_near(const Box& box, double reach, const Found& found) const {
    if (!nodes_.empty()) visit_near(0, box, reach, found);
  }

  /// Calls found(i, j), i < j, once for each pair of elements whose boxes have a gap of at most
  /// `reach` along each axis. Cost: O(n + pairs found) for elements of similar sizes.
  template <class Found>
  void for_each_near_pair(double reach, const Found& found) const {
    if (!nodes_.empty()) visit_pairs(0, 0, reach, found);
  }

  /// Independent part of a search for pairs of nearby elements: the pairs of one element below the
  /// tree node `a` and one element below the tree node `b`.
  struct NodePair {
    int a, b;
  };
  /// Divides a search for pairs of nearby elements into independent parts for several threads.
  ///
  /// `reach`: maximum gap between two boxes along each axis. `size`: maximum number of elements
  /// below each of the two tree nodes whose pairs form a part. The parts do not depend on the
  /// number of threads. Each pair of elements belongs to exactly one part.
  std::vector<NodePair> pair_parts(double reach, int size) const {
    std::vector<NodePair> parts;
    if (!nodes_.empty()) divide_pairs(0, 0, reach, size, parts);
    return parts;
  }
  /// Calls found(i, j), i < j, for each pair of nearby elements in one part from pair_parts().
  /// `reach`: the value passed to pair_parts().
  template <class Found>
  void for_each_near_pair(const NodePair& part, double reach, const Found& found) const {
    visit_pairs(part.a, part.b, reach, found);
  }

 private:
  static constexpr int kLeafSize = 4;  // maximum number of elements per leaf
  // Bound on the tree depth; an int can be halved only 31 times.
  static constexpr int kDeepest = 64;

  struct Node {
    Point low, high;
    int first, last;  // range of the node's elements in order_
    int right = -1;   // right child node; -1: leaf. The left child is the next node

    bool leaf() const { return right < 0; }
    int count() const { return last - first; }
    double distance2(const Point& p) const {
      return (low - p).cwiseMax(p - high).cwiseMax(0).squaredNorm();
    }
  };

  static bool near(const Point& low, const Point& high, const Point& other_low,
                   const Point& other_high, double reach) {
    return ((low - other_high).array() <= reach).all() &&
           ((other_low - high).array() <= reach).all();
  }

  struct Building;  // data used while the tree is built

  template <class Found>
  void visit_near(int node, const Box& box, double reach, const Found& found) const;
  template <class Found>
  void visit_pairs(int a, int b, double reach, const Found& found) const;
  void divide_pairs(int a, int b, double reach, int size, std::vector<NodePair>& parts) const;
  // Calls visit(c, d) for each pair of child nodes into which the pair of nodes (a, b) is divided.
  // At least one of a and b must not be a leaf.
  template <class Visit>
  void visit_children(int a, int b, const Visit& visit) const;

  std::vector<int> order_;  // element indices, contiguous for each node
  std::vector<Box> boxes_;  // boxes_[k] is the box of element order_[k]
  std::vector<Node> nodes_;
};

extern template class BoxTree<2>;
extern template class BoxTree<3>;

template <int Dim>
template <class Distance2>
typename BoxTree<Dim>::Nearest BoxTree<Dim>::nearest(const Point& p,
                                                     const Distance2& distance2) const {
  Nearest best;
  if (nodes_.empty()) return best;
  // Depth first, nearer child first; boxes farther than the best element are skipped when popped.
  struct Visit {
    double distance2;
    int node;
  };
  Visit later[kDeepest];
  int count = 0;
  later[count++] = {nodes_[0].distance2(p), 0};
  while (count > 0) {
    const Visit visit = later[--count];
    if (visit.distance2 > best.distance2) continue;
    const Node& node = nodes_[visit.node];
    if (node.leaf()) {
      for (int k = node.first; k < node.last; ++k) {
        const int i = order_[k];
        const double d2 = distance2(i);
        // The comparisons are false for NaN, and for the first element at infinity.
        if (d2 < best.distance2 || (d2 == best.distance2 && i < best.element)) best = {i, d2};
      }
      continue;
    }
    const Visit left{nodes_[visit.node + 1].distance2(p), visit.node + 1},
        right{nodes_[node.right].distance2(p), node.right};
    const bool left_first = left.distance2 <= right.distance2;
    later[count++] = left_first ? right : left;
    later[count++] = left_first ? left : right;
  }
  return best;
}

template <int Dim>
template <class Found>
void BoxTree<Dim>::visit_near(int node, const Box& box, double reach, const Found& found) const {
  const Node& n = nodes_[node];
  if (!near(n.low, n.high, box.min(), box.max(), reach)) return;
  if (!n.leaf()) {
    visit_near(node + 1, box, reach, found);
    visit_near(n.right, box, reach, found);
    return;
  }
  for (int k = n.first; k < n.last; ++k)
    if (near(boxes_[k].min(), boxes_[k].max(), box.min(), box.max(), reach)) found(order_[k]);
}

template <int Dim>
template <class Visit>
void BoxTree<Dim>::visit_children(int a, int b, const Visit& visit) const {
  const Node &na = nodes_[a], &nb = nodes_[b];
  if (a == b) {
    visit(a + 1, a + 1);
    visit(na.right, na.right);
    visit(a + 1, na.right);
  } else if (nb.leaf() || (!na.leaf() && na.count() >= nb.count())) {
    visit(a + 1, b);
    visit(na.right, b);
  } else {
    visit(a, b + 1);
    visit(a, nb.right);
  }
}

template <int Dim>
template <class Found>
void BoxTree<Dim>::visit_pairs(int a, int b, double reach, const Found& found) const {
  const Node &na = nodes_[a], &nb = nodes_[b];
  if (!near(na.low, na.high, nb.low, nb.high, reach)) return;
  if (!na.leaf() || !nb.leaf()) {
    visit_children(a, b, [&](int c, int d) { visit_pairs(c, d, reach, found); });
    return;
  }
  for (int k = na.first; k < na.last; ++k)
    for (int l = a == b ? k + 1 : nb.first; l < nb.last; ++l)
      if (near(boxes_[k].min(), boxes_[k].max(), boxes_[l].min(), boxes_[l].max(), reach))
        found(std::min(order_[k], order_[l]), std::max(order_[k], order_[l]));
}

}  // namespace batten
