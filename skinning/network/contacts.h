// Where lines come near each other.
#pragma once

#include <vector>
#include <algorithm>
#include <limits>
#include <numeric>

#include "batten/skinning/network/sampled_curve.h"
#include "batten/core/eigen.h"
#include "batten/core/containers.h"

namespace batten::detail {

/// A place of strand a and one of strand b, near each other.
struct Contact {
  int a = 0, b = 0;
  double ta = 0, tb = 0;  ///< parameters
  double sa = 0, sb = 0;  ///< arc lengths
  double distance = 0;
  int ea = -1, eb = -1;  ///< 0, 1: the start, the end of that strand
};

struct Contacts {
  std::vector<Contact> joined;  ///< within the tolerance
  /// Within five tolerances, but not above 4 % of the size, where the two strands are not joined
  /// nearby.
  std::vector<Contact> near_misses;
};

/// All contacts, in canonical order. Strands that are near each other along an interval have
///
///     at the ends of strands that lie in it    one contact each
///     at the interval's own ends               one each, where they run along each other: when it
///                                              is longer than two curves that only touch could
///                                              make it (3 √(tolerance · size)), or they coincide
///     otherwise                                one, where they are nearest
///
/// Boxes around chords in a tree, Gauss-Newton on both curves from every near pair of chords: about
/// O(n log n) for n chords.
///
/// Throws InputError where more than 100 pairs of chords for each chord (and 100,000) are near: lines
/// that are drawn over each other again and again.
Contacts find_contacts(const std::vector<SampledCurve>& sampled_curves, double tolerance,
                       double size);

/// How far the ends of open lines are from the nearest other line, of each end that is no corner
/// within its line; infinite above `reach`. Ends that run out beyond a contact, by less than
/// `reach`, are as far from the other line as that contact is. O(n log n) for n chords while few are
/// within reach.
std::vector<double> end_gaps(const std::vector<SampledCurve>& sampled_curves, double reach,
                             const std::vector<Contact>& contacts = {});


// Inside of find_contacts: the chords of all strands in a tree of boxes.

// A tree of boxes over the chords of all lines.

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


struct Chord {
  int sampled_curve, segment;
};

/// A point of a strand near a given one.
struct NearPoint {
  int sampled_curve;
  double t;  ///< parameter
  double distance;
};

/// The strands must outlive it.
class ChordTree {
 public:
  explicit ChordTree(const std::vector<SampledCurve>& sampled_curves);

  const Chord& chord(int i) const { return chords_[i]; }
  /// Calls found(i, j), i < j, for chords whose boxes are not farther apart than `reach`.
  template <class Found>
  void for_each_near_pair(double reach, const Found& found) const {
    tree_.for_each_near_pair(reach, found);
  }
  /// The place nearest to p on and around each chord that may come within `reach`, by chord: a
  /// strand is there as often as it has such chords.
  std::vector<NearPoint> near_points(const Vec3& p, double reach) const;

 private:
  const std::vector<SampledCurve>& sampled_curves_;
  std::vector<Chord> chords_;
  AabbTree tree_;
};

}  // namespace batten::detail
