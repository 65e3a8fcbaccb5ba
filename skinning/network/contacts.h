// SPDX-License-Identifier: MPL-2.0
// Finds where sampled curves touch, cross or pass within a tolerance of each other (or themselves).
#pragma once

#include <vector>

#include "batten/core/box_tree.h"
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
/// Method: a BoxTree over the chords, then Gauss-Newton on both curve parameters from every pair
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
/// Cost: O(n log n) for n chords.
std::vector<double> end_gaps(const std::vector<SampledCurve>& sampled_curves, double reach,
                             const std::vector<Contact>& contacts = {});

// Implementation details of find_contacts(): a tree over the chords of all sampled curves.

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

/// BoxTree over the chords of sampled curves. It keeps a reference: the curves must outlive it.
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
  /// Distance of a point from the nearest input curve other than `except`; infinite if there is
  /// none. O(log n).
  double distance(const Vec3& p, int except) const;

 private:
  const std::vector<SampledCurve>& sampled_curves_;
  std::vector<Chord> chords_;
  BoxTree<3> tree_;
};

}  // namespace batten::detail
