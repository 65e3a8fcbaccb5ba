#include "batten/skinning/network/chord_tree.h"

#include <algorithm>

#include "batten/skinning/network/curve_distance.h"

namespace batten::detail {
namespace {

std::vector<Chord> chords_of(const std::vector<SampledCurve>& sampled_curves) {
  std::vector<Chord> chords;
  for (int k = 0; k < isize(sampled_curves); ++k)
    for (int i = 0; i < sampled_curves[k].segments(); ++i) chords.push_back({k, i});
  return chords;
}

AabbTree tree_of(const std::vector<SampledCurve>& sampled_curves,
                 const std::vector<Chord>& chords) {
  std::vector<Aabb> boxes;
  for (const Chord& c : chords) {
    const SampledCurve& sampled_curve = sampled_curves[c.sampled_curve];
    const Vec3 sag = Vec3::Constant(sampled_curve.sag[c.segment]);
    Aabb box;
    for (const Vec3& p : {sampled_curve.x[c.segment], sampled_curve.x[c.segment + 1]})
      box.add({p - sag, p + sag});
    boxes.push_back(box);
  }
  return AabbTree(std::move(boxes));
}

// The parameter of a strand's point nearest to p on and around one of its chords.
double closest_parameter_near(const SampledCurve& sampled_curve, int segment, const Vec3& p) {
  const Vec3 chord = sampled_curve.x[segment + 1] - sampled_curve.x[segment];
  const double along = std::clamp(
      (p - sampled_curve.x[segment]).dot(chord) / std::max(chord.squaredNorm(), 1e-300), 0.0, 1.0);
  const auto range = bracket(sampled_curve, segment);
  return sampled_curve.closest_parameter(
      p,
      sampled_curve.t[segment] + along * (sampled_curve.t[segment + 1] - sampled_curve.t[segment]),
      range[0], range[1]);
}

}  // namespace

ChordTree::ChordTree(const std::vector<SampledCurve>& sampled_curves)
    : sampled_curves_(sampled_curves),
      chords_(chords_of(sampled_curves)),
      tree_(tree_of(sampled_curves, chords_)) {}

std::vector<NearPoint> ChordTree::near_points(const Vec3& p, double reach) const {
  std::vector<int> near;
  tree_.for_each_near_box({p, p}, reach, [&](int i) { near.push_back(i); });
  std::sort(near.begin(), near.end());
  std::vector<NearPoint> points;
  for (const int i : near) {
    const SampledCurve& sampled_curve = sampled_curves_[chords_[i].sampled_curve];
    const double t = closest_parameter_near(sampled_curve, chords_[i].segment, p);
    points.push_back({chords_[i].sampled_curve, t, (sampled_curve.point(t) - p).norm()});
  }
  return points;
}

}  // namespace batten::detail
