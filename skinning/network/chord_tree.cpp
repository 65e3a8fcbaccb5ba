#include "batten/skinning/network/chord_tree.h"

#include <algorithm>

#include "batten/skinning/network/strand_distance.h"

namespace batten::netting {
namespace {

std::vector<Chord> chords_of(const std::vector<Strand>& strands) {
  std::vector<Chord> chords;
  for (int k = 0; k < count_of(strands); ++k)
    for (int i = 0; i < strands[k].segments(); ++i) chords.push_back({k, i});
  return chords;
}

BoxTree tree_of(const std::vector<Strand>& strands, const std::vector<Chord>& chords) {
  std::vector<Box> boxes;
  for (const Chord& c : chords) {
    const Strand& strand = strands[c.strand];
    const Vec3 sag = Vec3::Constant(strand.sag[c.segment]);
    Box box;
    for (const Vec3& p : {strand.x[c.segment], strand.x[c.segment + 1]})
      box.add({p - sag, p + sag});
    boxes.push_back(box);
  }
  return BoxTree(std::move(boxes));
}

// The parameter of a strand's point nearest to p on and around one of its chords.
double foot_near(const Strand& strand, int segment, const Vec3& p) {
  const Vec3 chord = strand.x[segment + 1] - strand.x[segment];
  const double along = std::clamp(
      (p - strand.x[segment]).dot(chord) / std::max(chord.squaredNorm(), 1e-300), 0.0, 1.0);
  const auto range = bracket(strand, segment);
  return strand.foot(p, strand.t[segment] + along * (strand.t[segment + 1] - strand.t[segment]),
                     range[0], range[1]);
}

}  // namespace

ChordTree::ChordTree(const std::vector<Strand>& strands)
    : strands_(strands), chords_(chords_of(strands)), tree_(tree_of(strands, chords_)) {}

std::vector<NearPlace> ChordTree::near_point(const Vec3& p, double reach) const {
  std::vector<int> near;
  tree_.near_box({p, p}, reach, [&](int i) { near.push_back(i); });
  std::sort(near.begin(), near.end());
  std::vector<NearPlace> places;
  for (const int i : near) {
    const Strand& strand = strands_[chords_[i].strand];
    const double t = foot_near(strand, chords_[i].segment, p);
    places.push_back({chords_[i].strand, t, (strand.point(t) - p).norm()});
  }
  return places;
}

}  // namespace batten::netting
