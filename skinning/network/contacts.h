// Where lines come near each other.
#pragma once

#include <vector>

#include "batten/skinning/network/sampled_curve.h"

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

}  // namespace batten::detail
