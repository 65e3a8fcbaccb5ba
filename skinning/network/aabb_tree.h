// A tree of boxes over the chords of all lines.
#pragma once

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/isize.h"

namespace batten::detail {

struct Aabb {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Aabb& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  bool near(const Aabb& other, double reach) const {
    return ((low - other.high).array() <= reach).all() &&
           ((other.low - high).array() <= reach).all();
  }
};

/// Halved at the median along the longest side, four boxes a leaf. Which pairs are found does not
/// depend on the order of the boxes, the order in which they are found does.
class AabbTree {
 public:
  explicit AabbTree(std::vector<Aabb> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!order_.empty()) build(0, isize(order_));
  }

  /// Calls found(i, j), i < j, for boxes not farther apart than `reach` along any axis.
  template <class Found>
  void for_each_near_pair(double reach, const Found& found) const {
    if (!nodes_.empty()) pairs(0, 0, reach, found);
  }
  /// Calls found(i) for boxes near the given one.
  template <class Found>
  void for_each_near_box(const Aabb& box, double reach, const Found& found) const {
    if (!nodes_.empty()) for_each_near_box(0, box, reach, found);
  }

 private:
  struct Node {
    Aabb box;
    int begin, end, left = -1, right = -1;
  };

  int build(int begin, int end) {
    const int here = isize(nodes_);
    nodes_.push_back({{}, begin, end});
    Aabb box;
    for (int k = begin; k < end; ++k) box.add(boxes_[order_[k]]);
    nodes_[here].box = box;
    constexpr int kLeaf = 4;
    if (end - begin <= kLeaf) return here;
    int axis = 0;
    (box.high - box.low).maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](int i, int j) {
                       const double a = boxes_[i].low[axis] + boxes_[i].high[axis],
                                    b = boxes_[j].low[axis] + boxes_[j].high[axis];
                       return a != b ? a < b : i < j;
                     });
    const int left = build(begin, middle), right = build(middle, end);
    nodes_[here].left = left;
    nodes_[here].right = right;
    return here;
  }

  template <class Found>
  void pairs(int a, int b, double reach, const Found& found) const {
    const Node &na = nodes_[a], &nb = nodes_[b];
    if (!na.box.near(nb.box, reach)) return;
    if (na.left < 0 && nb.left < 0) {
      for (int i = na.begin; i < na.end; ++i)
        for (int j = a == b ? i + 1 : nb.begin; j < nb.end; ++j) {
          const int p = std::min(order_[i], order_[j]), q = std::max(order_[i], order_[j]);
          if (boxes_[p].near(boxes_[q], reach)) found(p, q);
        }
    } else if (a == b) {
      pairs(na.left, na.left, reach, found);
      pairs(na.right, na.right, reach, found);
      pairs(na.left, na.right, reach, found);
    } else if (nb.left < 0 || (na.left >= 0 && na.end - na.begin >= nb.end - nb.begin)) {
      pairs(na.left, b, reach, found);
      pairs(na.right, b, reach, found);
    } else {
      pairs(a, nb.left, reach, found);
      pairs(a, nb.right, reach, found);
    }
  }

  template <class Found>
  void for_each_near_box(int node, const Aabb& box, double reach, const Found& found) const {
    const Node& n = nodes_[node];
    if (!n.box.near(box, reach)) return;
    if (n.left >= 0) {
      for_each_near_box(n.left, box, reach, found);
      for_each_near_box(n.right, box, reach, found);
      return;
    }
    for (int k = n.begin; k < n.end; ++k)
      if (boxes_[order_[k]].near(box, reach)) found(order_[k]);
  }

  std::vector<Aabb> boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace batten::detail
