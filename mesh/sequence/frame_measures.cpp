#include "batten/mesh/sequence/frame_measures.h"

#include <algorithm>
#include <utility>

#include "batten/mesh/deform/deform_problem.h"

namespace batten {

FrameMeasures::FrameMeasures(const TriangleMesh& mesh, std::vector<Foot> feet)
    : mesh_(mesh), feet_(std::move(feet)), centres_(feet_.size()) {}

void FrameMeasures::add(int frame, const Points& p) {
  last_.push_back(p);
  if (last_.size() > 3) last_.pop_front();
  if (last_.size() == 3 && p.rows() > 0)
    max_second_difference_ = std::max(
        max_second_difference_, (last_[2] - 2 * last_[1] + last_[0]).rowwise().norm().maxCoeff());
  inverted_triangles_ += count_inverted_triangles(p);
  for (size_t f = 0; f < feet_.size(); ++f)
    if (frame >= feet_[f].first && frame <= feet_[f].last)
      centres_[f].push_back(VertexCombination::mean_of(feet_[f].vertices).at(p));
}

double FrameMeasures::foot_skate(int foot) const {
  const std::vector<Vec3>& centres = centres_[foot];
  Vec3 mean = Vec3::Zero();
  for (const Vec3& c : centres) mean += c / static_cast<double>(centres.size());
  double largest = 0;
  for (const Vec3& c : centres) largest = std::max(largest, (c - mean).norm());
  return largest;
}

long FrameMeasures::count_inverted_triangles(const Points& p) const {
  const MeshTopology& topology = mesh_.topology();
  const auto normal = [&](int t) -> Vec3 {
    const auto& corners = topology.triangles()[t];
    const Vec3 a = p.row(topology.node_of(corners[0])), b = p.row(topology.node_of(corners[1])),
               c = p.row(topology.node_of(corners[2]));
    return (b - a).cross(c - a);
  };
  long count = 0;
  for (int t = 0; t < topology.triangle_count(); ++t) {
    Vec3 around = Vec3::Zero();
    for (int corner = 0; corner < 3; ++corner)
      if (const int other = topology.across(t, corner); other >= 0) around += normal(other);
    count += normal(t).dot(around) < 0;
  }
  return count;
}

}  // namespace batten
