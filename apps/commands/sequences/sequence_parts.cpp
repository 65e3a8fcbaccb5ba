#include "batten/apps/commands/sequences/sequence_parts.h"

#include <algorithm>
#include <stdexcept>

#include "batten/core/containers.h"
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

std::vector<FrameMeasures::Foot> measured_feet(const SequenceParts& parts,
                                               const std::vector<SequenceReport::Foot>& feet) {
  std::vector<FrameMeasures::Foot> measured;
  for (const SequenceReport::Foot& foot : feet) {
    const auto h = std::ranges::find(parts.handles, foot.handle, &Handle::name);
    if (h == parts.handles.end()) throw std::logic_error("a foot that is no handle");
    measured.push_back({h->vertices, foot.first - 1, foot.last - 1});
  }
  return measured;
}

void report_measures(const FrameMeasures& measures, const SequenceParts& parts,
                     const PartDeviation& deviation, std::vector<SequenceReport::Foot> feet,
                     double size, SequenceReport& report) {
  report.second_difference = measures.max_second_difference();
  report.inverted_triangles = measures.inverted_triangles();
  for (size_t h = 0; h < parts.handles.size(); ++h)
    report.handles.push_back(
        {parts.handles[h].name, isize(parts.handles[h].vertices), deviation.handles[h]});
  for (size_t f = 0; f < parts.features.size(); ++f)
    report.features.push_back(
        {parts.features[f].name, isize(parts.features[f].vertices), deviation.features[f]});
  for (int f = 0; f < isize(feet); ++f)
    feet[f].foot_skate = std::max(feet[f].foot_skate, measures.foot_skate(f) / size);
  report.feet = std::move(feet);
}

}  // namespace batten
