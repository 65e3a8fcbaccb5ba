#include "batten/apps/commands/sequences/sequence_parts.h"

#include <algorithm>
#include <stdexcept>

#include "batten/core/errors.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {

int SequenceParts::handle(const SequenceScene& scene, const LocatedString& name) const {
  std::vector<std::string> names;
  for (size_t h = 0; h < handles.size(); ++h) {
    if (handles[h].name == name.text) return static_cast<int>(h);
    names.push_back(handles[h].name);
  }
  throw InputError(scene.at(name.location) + "found the handle '" + name.text + "', expected " +
                   (names.empty() ? "a [[handle]] of the scene, which has none"
                                  : expected_one_of(name.text, names)));
}

namespace {

template <class Part>
void measure_parts(const std::vector<Part>& parts, const Points& before, const Points& after,
                   std::vector<double>& largest) {
  for (size_t k = 0; k < parts.size(); ++k)
    largest[k] =
        std::max(largest[k], fit_similarity(before, after, parts[k].vertices, 1.0).max_error);
}

}  // namespace

void PartDeviation::measure(const SequenceParts& parts, const Points& before, const Points& after) {
  measure_parts(parts.features, before, after, features);
  measure_parts(parts.handles, before, after, handles);
}

void FrameMeasures::add(int frame, const Points& p) {
  last_.push_back(p);
  if (last_.size() > 3) last_.pop_front();
  if (last_.size() == 3 && p.rows() > 0)
    max_second_difference_ = std::max(
        max_second_difference_, (last_[2] - 2 * last_[1] + last_[0]).rowwise().norm().maxCoeff());
  inverted_triangles_ += count_folded_triangles(p);
  for (size_t f = 0; f < feet_.size(); ++f)
    if (frame + 1 >= feet_[f].first && frame + 1 <= feet_[f].last)
      centres_[f].push_back(VertexCombination::mean_of(handle_vertices(feet_[f].handle)).at(p));
}

void FrameMeasures::fill(SequenceReport& report, const PartDeviation& deviation, double size) {
  report.second_difference = max_second_difference_;
  report.inverted_triangles = inverted_triangles_;
  for (size_t h = 0; h < parts_.handles.size(); ++h)
    report.handles.push_back(
        {parts_.handles[h].name, isize(parts_.handles[h].vertices), deviation.handles[h]});
  for (size_t f = 0; f < parts_.features.size(); ++f)
    report.features.push_back(
        {parts_.features[f].name, isize(parts_.features[f].vertices), deviation.features[f]});
  for (size_t f = 0; f < feet_.size(); ++f) {
    Vec3 mean = Vec3::Zero();
    for (const Vec3& c : centres_[f]) mean += c / static_cast<double>(centres_[f].size());
    for (const Vec3& c : centres_[f])
      feet_[f].foot_skate = std::max(feet_[f].foot_skate, (c - mean).norm() / size);
  }
  report.feet = feet_;
}

const std::vector<int>& FrameMeasures::handle_vertices(const std::string& name) const {
  for (const auto& h : parts_.handles)
    if (h.name == name) return h.vertices;
  throw std::logic_error("a foot that is no handle");
}

long FrameMeasures::count_folded_triangles(const Points& p) const {
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
