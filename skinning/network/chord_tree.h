// Inside of find_contacts: the chords of all strands in a tree of boxes.
#pragma once

#include <vector>

#include "batten/skinning/network/network_boxes.h"
#include "batten/skinning/network/network_lines.h"

namespace batten::netting {

struct Chord {
  int strand, segment;
};

/// A point of a strand near a given one.
struct NearPlace {
  int strand;
  double t;  ///< parameter
  double distance;
};

/// The strands must outlive it.
class ChordTree {
 public:
  explicit ChordTree(const std::vector<Strand>& strands);

  const Chord& chord(int i) const { return chords_[i]; }
  /// Calls found(i, j), i < j, for chords whose boxes are not farther apart than `reach`.
  template <class Found>
  void near_pairs(double reach, const Found& found) const {
    tree_.near_pairs(reach, found);
  }
  /// The place nearest to p on and around each chord that may come within `reach`, by chord: a
  /// strand is there as often as it has such chords.
  std::vector<NearPlace> near_point(const Vec3& p, double reach) const;

 private:
  const std::vector<Strand>& strands_;
  std::vector<Chord> chords_;
  BoxTree tree_;
};

}  // namespace batten::netting
