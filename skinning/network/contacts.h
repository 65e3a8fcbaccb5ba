// Finds where sampled curves touch, cross or pass within a tolerance of each other (or themselves).
#pragma once

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/skinning/network/sampled_curve.h"

namespace batten::detail {

/// A pair of nearby points: one on sampled curve `a`, one on sampled curve `b`.
struct Contact {
  int a = 0, b = 0;
  double ta = 0, tb = 0;  ///< curve parameters on a and b
  double sa = 0, sb = 0;  ///< arc lengths from the starts of a and b, model units
  double distance = 0;
  int ea = -1, eb = -1;  ///< 0 or 1: the point is the start or the end of its curve; -1: neither
};

/// Result of find_contacts().
struct Contacts {
  std::vector<Contact> joined;  ///< closer than the tolerance
  /// Pairs within 5 tolerances (at most 4 % of the network size, at least one tolerance) whose
  /// curves are not joined nearby. They are reported, not joined.
  std::vector<Contact> near_misses;
};

/// Finds all contacts between sampled curves, in canonical order (by the curves, then by arc
/// length).
///
/// Two curves that stay close along an interval get the following contacts:
///
///     at curve ends inside the interval   one contact each
///     at the interval's own ends          one contact each, if the curves overlap: the interval is
///                                         longer than two merely tangent curves could make it,
///                                         3 √(tolerance · size), or the curves coincide
///     otherwise                           one contact, at the closest point
///
/// Method: an AABB tree over the chords, then Gauss-Newton on both curve parameters from every pair
/// of nearby chords. Cost: about O(n log n) for n chords.
///
/// `tolerance`: gap tolerance; `size`: diagonal of the bounding box of the network; both in model
/// units. Throws InputError if more than 100 pairs per chord (plus 100,000) are close to each
/// other, that is, if curves are drawn over each other many times.
Contacts find_contacts(const std::vector<SampledCurve>& sampled_curves, double tolerance,
                       double size);

/// Computes the distance of each free curve end to the nearest other input curve.
///
/// One value per end of an open sampled curve; ends that are a corner inside their input curve are
/// skipped. The value is infinite if nothing lies within `reach` (model units). An end that
/// overshoots one of the `contacts` by less than `reach` gets at most the distance of that contact.
/// Cost: O(n log n) for n chords if few of them lie within reach.
std::vector<double> end_gaps(const std::vector<SampledCurve>& sampled_curves, double reach,
                             const std::vector<Contact>& contacts = {});

// Implementation details of find_contacts(): an AABB tree over the chords of all sampled curves.

/// Axis-aligned bounding box; empty (inverted) by default.
struct Aabb {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Aabb& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  /// True if the gap between the boxes is at most `reach` along every axis.
  bool near(const Aabb& other, double reach) const {
    return ((low - other.high).array() <= reach).all() &&
           ((other.low - high).array() <= reach).all();
  }
};

/// AABB tree: boxes are split at the median along the longest side, down to at most four per leaf.
///
/// The set of pairs that is found does not depend on the order of the boxes; the order of the calls
/// does.
class AabbTree {
 public:
  explicit AabbTree(std::vector<Aabb> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!order_.empty()) build(0, isize(order_));
  }

  /// Calls found(i, j), i < j, for every pair of boxes with a gap of at most `reach` along each
  /// axis.
  template <class Found>
  void for_each_near_pair(double reach, const Found& found) const {
    if (!nodes_.empty()) pairs(0, 0, reach, found);
  }
  /// Calls found(i) for every stored box with a gap of at most `reach` to `box` along each axis.
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

/// Chord `segment` of a sampled curve: the line from its sample point x[segment] to x[segment + 1].
struct Chord {
  int sampled_curve, segment;
};

/// A point of a sampled curve that is close to a query point.
struct NearPoint {
  int sampled_curve;
  double t;  ///< curve parameter
  double distance;
};

/// AABB tree over the chords of sampled curves. It keeps a reference: the curves must outlive it.
class ChordTree {
 public:
  explicit ChordTree(const std::vector<SampledCurve>& sampled_curves);

  const Chord& chord(int i) const { return chords_[i]; }
  /// Calls found(i, j), i < j, for chords whose boxes have a gap of at most `reach` along each
  /// axis.
  template <class Found>
  void for_each_near_pair(double reach, const Found& found) const {
    tree_.for_each_near_pair(reach, found);
  }
  /// Computes the point closest to p on the curve near each chord that may come within `reach`.
  ///
  /// One result per chord, in the order of the chords: a curve occurs once for each of its nearby
  /// chords. The distance may exceed `reach`.
  std::vector<NearPoint> near_points(const Vec3& p, double reach) const;

 private:
  const std::vector<SampledCurve>& sampled_curves_;
  std::vector<Chord> chords_;
  AabbTree tree_;
};

}  // namespace batten::detail
