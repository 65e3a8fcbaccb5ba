// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/sequences/sequence_edits.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "batten/mesh/rotation_fitting.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

template <class Part>
void add_part_deviation(const std::vector<Part>& parts, const Points& before, const Points& after,
                        std::vector<double>& largest) {
  for (size_t k = 0; k < parts.size(); ++k)
    largest[k] =
        std::max(largest[k], fit_similarity(before, after, parts[k].vertices, 1.0).max_error);
}

/// The nodes and frames of planted feet, for FrameMeasures.
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

template <class Part>
std::vector<SequenceReport::Handle> part_reports(const std::vector<Part>& parts,
                                                 const std::vector<double>& deviation) {
  std::vector<SequenceReport::Handle> reports;
  for (size_t k = 0; k < parts.size(); ++k)
    reports.push_back({parts[k].name, isize(parts[k].vertices), deviation[k]});
  return reports;
}

/// True if each frame after a step corresponds to the input frame with the same number. Exceptions:
/// root motion, which deforms nothing, and a morph, which deforms everything.
bool keeps_frames(const SequenceOperation& step) {
  return !std::holds_alternative<SequenceOperation::RootMotion>(step.what) &&
         !std::holds_alternative<SequenceOperation::Morph>(step.what);
}

}  // namespace

SequenceEdits::SequenceEdits(const SequenceScene& scene, MeshSequence input, SequenceReport& report)
    : scene_(scene),
      report_(report),
      input_(std::make_shared<const PreparedSequence>(
          prepared_sequence(std::move(input), scene.at(scene.source.location), report.warnings))),
      current_(input_),
      file_(MeshFile::from_shells(input_->sequence.shells)),
      select_(scene, file_, input_->mesh) {
  const MeshSequence& s = input_->sequence;
  report.name = scene.name;
  report.unit = scene.unit;
  report.file = scene.source.path.filename().string();
  report.frames_before = s.frame_count();
  report.nodes = s.node_count();
  report.faces = s.shells.face_count();
  report.size = size_of(s);
}

void SequenceEdits::find_parts() {
  parts_ = find_sequence_parts(scene_, select_);
  deviation_ = {std::vector<double>(parts_.features.size(), 0),
                std::vector<double>(parts_.handles.size(), 0)};
}

void SequenceEdits::add_deviation(const Points& before, const Points& after) {
  add_part_deviation(parts_.features, before, after, deviation_.features);
  add_part_deviation(parts_.handles, before, after, deviation_.handles);
}

void SequenceEdits::apply(const FrameReader& read, const Progress& progress) {
  last_ = unchanged_result(current_);
  for (size_t k = 0; k < scene_.steps.size(); ++k) {
    if (k > 0) {
      const auto before = std::exchange(current_, collect_frames(last_, input_->mesh, progress));
      for (size_t f = 0; keeps_frames(scene_.steps[k - 1]) && f < before->sequence.frames.size();
           ++f)
        add_deviation(before->sequence.frames[f], current_->sequence.frames[f]);
    }
    const auto start = std::chrono::steady_clock::now();
    last_ = run_step(scene_, scene_.steps[k], *current_, parts_, select_, read, progress);
    last_.report.seconds = seconds_since(start);
    report_.steps.push_back(last_.report);
    add_warnings();
  }
}

void SequenceEdits::add_warnings() {
  const SequenceReport::Step& step = last_.report;
  for (const auto& w : last_.warnings) report_.warnings.push_back(step.name + ": " + w);
  for (const auto& foot : last_.feet)
    if (foot.foot_skate_before > 0.05)
      report_.warnings.push_back(step.name + ": the foot '" + foot.handle +
                                 "' is planted in frames " + std::to_string(foot.first) + " to " +
                                 std::to_string(foot.last) + ", but moves there by " +
                                 format_number(foot.foot_skate_before) +
                                 " of the size: use a smaller distance in contact_detection = { "
                                 "distance = … }");
  if (step.unconverged_keyframes > 0)
    report_.warnings.push_back(
        step.name + ": " + std::to_string(step.unconverged_keyframes) + " of " +
        std::to_string(step.keyframes) + " keyframes did not converge in " +
        std::to_string(step.iterations) + " iterations: the last change was " +
        format_number(step.last_change) + " of the size; allow more with iterations = …");
}

void SequenceEdits::make_frames(int first, int last,
                                const std::function<void(int, const Points&)>& take,
                                const Progress& progress) const {
  if (scene_.steps.empty())
    last_.frames(first, last, take, progress);
  else
    with_step_context(scene_, scene_.steps.back(),
                      [&] { last_.frames(first, last, take, progress); });
}

void SequenceEdits::measure(int frame, const Points& points) {
  if (!measures_) measures_.emplace(input_->mesh, measured_feet(parts_, last_.feet));
  measures_->add(frame, points);
  if (!scene_.steps.empty() && keeps_frames(scene_.steps.back()))
    add_deviation(current_->sequence.frames[static_cast<size_t>(frame)], points);
}

void SequenceEdits::finish_measures() {
  if (!measures_) measures_.emplace(input_->mesh);
  report_.second_difference = measures_->max_second_difference();
  report_.inverted_triangles = measures_->inverted_triangles();
  report_.handles = part_reports(parts_.handles, deviation_.handles);
  report_.features = part_reports(parts_.features, deviation_.features);
  report_.feet = last_.feet;
  for (int f = 0; f < isize(report_.feet); ++f) {
    SequenceReport::Foot& foot = report_.feet[static_cast<size_t>(f)];
    foot.foot_skate = std::max(foot.foot_skate, measures_->foot_skate(f) / report_.size);
  }
  FrameMeasures before(input_->mesh);
  for (int k = 0; k < report_.frames_before; ++k)
    before.add(k, input_->sequence.frames[static_cast<size_t>(k)]);
  report_.second_difference_before = before.max_second_difference();
  report_.inverted_triangles_before = before.inverted_triangles();
}

std::vector<FailedCheck> SequenceEdits::failed_checks() const {
  std::vector<FailedCheck> failed;
  for (const auto& f : report_.features)
    if (!(f.max_rigid_error <= 1e-10))
      failed.push_back({"features." + f.name, "is deformed by " + format_number(f.max_rigid_error) +
                                                  " of its size, expected at most 1e-10"});
  for (const auto& f : report_.feet)
    if (!(f.foot_skate <= f.max_foot_skate))
      failed.push_back({"foot_plants." + f.handle,
                        "slips by " + format_number(f.foot_skate) + " of the size in frames " +
                            std::to_string(f.first) + " to " + std::to_string(f.last) +
                            ", expected at most " + format_number(f.max_foot_skate)});
  return failed;
}

}  // namespace batten
