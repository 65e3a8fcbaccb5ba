#include "batten/apps/commands/sequences/prescribed_motion.h"

#include <algorithm>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {

std::vector<std::string> warn_of_fixed_handle_nodes(const SequenceParts& parts,
                                                    const std::vector<int>& handles,
                                                    const std::vector<int>& fixed) {
  const std::set<int> stay(fixed.begin(), fixed.end());
  std::vector<std::string> warnings;
  for (const int h : handles) {
    const std::set<int> nodes(parts.handles[h].vertices.begin(), parts.handles[h].vertices.end());
    const auto count = std::ranges::count_if(nodes, [&](int v) { return stay.contains(v); });
    if (count == 0) continue;
    const std::string name = "the handle '" + parts.handles[h].name + "' has a prescribed motion";
    if (count == isize(nodes)) throw InputError(name + ", but all its nodes are in fixed = […]");
    warnings.push_back(name + ", but " + std::to_string(count) + " of its " +
                       std::to_string(nodes.size()) + " nodes are fixed and do not move");
  }
  return warnings;
}

FrameConstraints constraints_of(const SequenceOperation& step, const SequenceParts& parts,
                                const std::vector<int>& fixed) {
  FrameConstraints constraints;
  constraints.fixed = fixed;
  constraints.handles = parts.handles;
  constraints.features = parts.features;
  constraints.penalty_weight = step.penalty_weight;
  constraints.preserve_volume = step.preserve_volume;
  return constraints;
}

StepResult result_of(const PreparedSequence& from, std::shared_ptr<SequenceEditor> editor) {
  StepResult result;
  result.shells = from.sequence.shells;
  result.times = from.sequence.times;
  result.warnings = editor->notes();
  result.report.keyframes = isize(editor->keyframes());
  for (const auto& r : editor->keyframe_reports()) {
    result.report.iterations = std::max(result.report.iterations, r.iterations);
    if (r.converged) continue;
    ++result.report.unconverged_keyframes;
    result.report.last_change = std::max(result.report.last_change, r.last_change);
  }
  result.frames = [editor](int first, int last, const auto& take, const Progress& progress) {
    editor->frames(first, last, take, progress);
  };
  return result;
}

StepResult apply_prescribed_motion(const SequenceOperation& step, const PreparedSequence& from,
                                   const SequenceParts& parts, const PrescribedMotion& prescribed,
                                   const std::vector<int>& fixed, const Progress& progress) {
  const auto warnings = warn_of_fixed_handle_nodes(parts, prescribed.handles, fixed);
  StepResult result = result_of(
      from, prescribed_motion_editor(from.sequence, from.mesh, constraints_of(step, parts, fixed),
                                     prescribed, step.options, progress));
  result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  return result;
}

FootTracks find_feet(const SequenceScene& scene, const MeshSequence& before,
                     const SequenceParts& parts, const std::vector<LocatedString>& feet,
                     const FootContactSearch& search, std::vector<std::string>& warnings) {
  FootContactOptions options;
  options.max_spread = search.max_spread > 0 ? search.max_spread : 0.01 * size_of(before);
  options.frames = search.frames;
  std::vector<int> handles;
  for (const LocatedString& foot : feet) handles.push_back(parts.handle(scene, foot));
  FootTracks tracks = track_feet(before.frames, parts.handles, handles, options);
  for (size_t f = 0; f < tracks.handles.size(); ++f)
    if (tracks.contacts[f].empty())
      warnings.push_back("'" + tracks.names[f] + "' is never on the ground: no " +
                         std::to_string(options.frames) +
                         " consecutive frames with its centre within " +
                         format_number(options.max_spread) + " " + scene.unit);
  return tracks;
}

void require_contacts(const SequenceScene& scene, const SequenceOperation& step,
                      const FootTracks& tracks) {
  if (std::ranges::all_of(tracks.contacts, [](const auto& list) { return list.empty(); }))
    throw InputError(scene.at(step.location) +
                     "found no foot on the ground in any frame, expected a larger distance or "
                     "fewer min_frames in contact_detection = { distance = …, min_frames = … }");
}

std::vector<SequenceReport::Foot> foot_reports(const SequenceOperation& step,
                                               const FootTracks& tracks, double size) {
  std::vector<SequenceReport::Foot> feet;
  for (size_t f = 0; f < tracks.handles.size(); ++f)
    for (const FootContact& contact : tracks.contacts[f])
      feet.push_back({step.name, tracks.names[f], contact.first + 1, contact.last + 1,
                      foot_skate(tracks.trajectories[f], contact) / size, 0, 1e-3});
  return feet;
}

void add_upright_handles(const SequenceScene& scene, const PreparedSequence& from,
                         const SequenceParts& parts, const std::vector<LocatedString>& names,
                         const Points& shifts, PrescribedMotion& prescribed) {
  for (const LocatedString& name : names) {
    const int h = parts.handle(scene, name);
    if (std::find(prescribed.handles.begin(), prescribed.handles.end(), h) !=
        prescribed.handles.end())
      throw InputError(scene.at(name.location) + "found the foot '" + name.text +
                       "' in 'unrotated', expected another handle");
    add_unrotated_handles(from.sequence.frames, parts.handles, {h}, shifts, prescribed);
  }
}

}  // namespace batten
