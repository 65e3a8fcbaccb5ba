// SPDX-License-Identifier: MPL-2.0
#include "batten/core/box_tree.h"

#include <string>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"

namespace batten {

template <int Dim>
struct BoxTree<Dim>::Building {
  const std::vector<Box>& boxes;
  const std::vector<Point>& keys;
  std::vector<int>& order;
  std::vector<Node>& nodes;

  // Number of nodes of a tree over `count` elements. Of p nodes at one level, all have q = count / p
  // elements, except count % p, which have one more.
  static int node_count(int count) {
    int level = 1;
    while (count / level > kLeafSize) level *= 2;
    const int leaves = level + (count / level == kLeafSize ? count % level : 0);
    return 2 * leaves - 1;
  }

  // Fills in one node and divides its elements. Returns where the second half begins; -1: a leaf.
  int divide(int node, int first, int last) const {
    Box box;
    for (int k = first; k < last; ++k) box.extend(boxes[order[k]]);
    nodes[node] = {box.min(), box.max(), first, last};
    if (last - first <= kLeafSize) return -1;
    int axis = 0;
    (box.max() - box.min()).maxCoeff(&axis);
    const int middle = first + (last - first) / 2;
    // Equal keys are ordered by index, so that the tree is the same on all platforms.
    std::nth_element(
        order.begin() + first, order.begin() + middle, order.begin() + last, [&](int i, int j) {
          return keys[i][axis] != keys[j][axis] ? keys[i][axis] < keys[j][axis] : i < j;
        });
    nodes[node].right = node + 1 + node_count(middle - first);
    return middle;
  }

  struct Subtree {
    int node, first, last;
  };
  // Builds a subtree, except for its own subtrees of at most `size` elements, which it appends to
  // `later`.
  void build(const Subtree& tree, int size, std::vector<Subtree>& later) const {
    if (tree.last - tree.first <= size) return later.push_back(tree);
    const int middle = divide(tree.node, tree.first, tree.last);
    if (middle < 0) return;
    build({tree.node + 1, tree.first, middle}, size, later);
    build({nodes[tree.node].right, middle, tree.last}, size, later);
  }
};

template <int Dim>
BoxTree<Dim>::BoxTree(const std::vector<Box>& boxes, const std::vector<Point>& keys) {
  if (!keys.empty() && keys.size() != boxes.size())
    throw InputError("box tree: found " + std::to_string(keys.size()) + " keys, expected " +
                     std::to_string(boxes.size()));
  std::vector<Point> sums;
  for (int i = 0; i < isize(boxes); ++i) {
    const Point low = boxes[i].min(), high = boxes[i].max();
    if (keys.empty()) sums.push_back(low + high);
    if (!low.allFinite() || !high.allFinite() || !(keys.empty() ? sums : keys)[i].allFinite())
      throw InputError("box tree: found a coordinate of element " + std::to_string(i) +
                       " that is not finite");
    if (!boxes[i].isEmpty()) order_.push_back(i);
  }
  if (order_.empty()) return;
  const int count = isize(order_);
  nodes_.resize(Building::node_count(count));
  const Building building{boxes, keys.empty() ? sums : keys, order_, nodes_};
  constexpr int kSerial = 4096;  // elements of a subtree that one thread builds
  std::vector<typename Building::Subtree> subtrees;
  building.build({0, 0, count}, kSerial, subtrees);
  parallel_for(isize(subtrees), [&](int part) {
    std::vector<typename Building::Subtree> nothing;
    building.build(subtrees[part], 0, nothing);
  });
  boxes_.reserve(order_.size());
  for (const int i : order_) boxes_.push_back(boxes[i]);
}

template <int Dim>
void BoxTree<Dim>::divide_pairs(int a, int b, double reach, int size,
                                std::vector<NodePair>& parts) const {
  const Node &na = nodes_[a], &nb = nodes_[b];
  if (!near(na.low, na.high, nb.low, nb.high, reach)) return;
  if ((na.count() <= size && nb.count() <= size) || (na.leaf() && nb.leaf()))
    parts.push_back({a, b});
  else
    visit_children(a, b, [&](int c, int d) { divide_pairs(c, d, reach, size, parts); });
}

template class BoxTree<2>;
template class BoxTree<3>;

}  // namespace batten
