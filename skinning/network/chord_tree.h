// Inside of find_contacts: the chords of all strands in a tree of boxes.
#pragma once

#include <vector>

#include "batten/skinning/network/aabb_tree.h"
#include "batten/skinning/network/sampled_curve.h"

namespace batten::detail {

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
