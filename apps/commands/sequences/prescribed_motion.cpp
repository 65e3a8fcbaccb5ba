#include "batten/apps/commands/sequences/prescribed_motion.h"

#include <algorithm>
#include <set>

#include "batten/core/errors.h"

namespace batten {
namespace {

double max_slip(const Points& centres, int first, int last) {
  const auto rows = centres.middleRows(first, last - first + 1);
  const Eigen::RowVector3d mean = rows.colwise().mean();
  return (rows.rowwise() - mean).rowwise().norm().maxCoeff();
}

}  // namespace

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

std::vector<char> keyframe_mask(int frames, int keyframe_interval,
                                const std::vector<char>& needed) {
  std::vector<char> prescribed(frames, 0);
  for (int k = 0; k < frames; k += keyframe_interval) prescribed[k] = 1;
  if (frames > 0) prescribed.back() = 1;
  for (int k = 0; k < frames && !needed.empty(); ++k)
    if (needed[k] && (k == 0 || k + 1 == frames || !needed[k - 1] || !needed[k + 1]))
      prescribed[k] = 1;
  return prescribed;
}

std::shared_ptr<SequenceEditor> editor_for(const SequenceOperation& step,
                                           const PreparedSequence& from, const SequenceParts& parts,
                                           const std::vector<int>& handles,
                                           const std::vector<int>& fixed, int first_key,
                                           int last_key) {
  FrameConstraints constraints;
  constraints.fixed = fixed;
  for (const int h : handles) constraints.handles.push_back(parts.handles[h]);
  constraints.features = parts.features;
  constraints.penalty_weight = step.penalty_weight;
  constraints.preserve_volume = step.preserve_volume;
  SequenceEditOptions options = step.options;
  // At an end of the sequence with a keyframe, the influence need not fade out.
  if (first_key == 0 && options.influence.from == 0) options.influence.from.reset();
  const int last = from.sequence.frame_count() - 1;
  if (last_key == last && options.influence.to == last) options.influence.to.reset();
  return std::make_shared<SequenceEditor>(from.sequence, from.mesh, std::move(constraints),
                                          options);
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
  const auto editor =
      editor_for(step, from, parts, prescribed.handles, fixed, 0, from.sequence.frame_count() - 1);
  std::vector<std::vector<RigidMotion>> motions;
  for (size_t h = 0; h < prescribed.handles.size(); ++h)
    motions.push_back(
        motions_between(editor->trajectories_before()[h], prescribed.target_trajectory[h]));
  std::vector<SequenceKeyframe> keys;
  for (int k = 0; k < from.sequence.frame_count(); ++k) {
    if (!prescribed.prescribed.empty() && !prescribed.prescribed[k]) continue;
    SequenceKeyframe key{k, {}};
    for (const auto& of_handle : motions) key.handles.push_back(HandlePose{of_handle[k], false});
    keys.push_back(std::move(key));
  }
  editor->set_keyframes(std::move(keys), progress);
  if (!step.penalty_weight)
    editor->set_motions(std::move(motions));  // exact motion between keyframes
  StepResult result = result_of(from, editor);
  result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  return result;
}

FootTracks find_feet(const SequenceScene& scene, const MeshSequence& before,
                     const SequenceParts& parts, const std::vector<LocatedString>& feet,
                     const FootContactSearch& search, std::vector<std::string>& warnings) {
  FootTracks tracks;
  FootContactOptions options;
  options.max_spread = search.max_spread > 0 ? search.max_spread : 0.01 * size_of(before);
  options.frames = search.frames;
  for (const LocatedString& foot : feet) {
    const int h = parts.handle(scene, foot);
    tracks.handles.push_back(h);
    tracks.before.push_back(trajectory_of(before.frames, parts.handles[h].vertices));
    tracks.prints.push_back(detect_foot_contacts(tracks.before.back(), options));
    if (tracks.prints.back().empty())
      warnings.push_back("'" + foot.text + "' is never on the ground: no " +
                         std::to_string(options.frames) +
                         " consecutive frames with its centre within " +
                         format_number(options.max_spread) + " " + scene.unit);
  }
  return tracks;
}

std::vector<SequenceReport::Foot> foot_reports(const SequenceScene& scene,
                                               const SequenceOperation& step,
                                               const FootTracks& tracks, double size) {
  std::vector<SequenceReport::Foot> feet;
  for (size_t f = 0; f < tracks.handles.size(); ++f)
    for (const FootContact& print : tracks.prints[f])
      feet.push_back({step.name, scene.handles[tracks.handles[f]].name, print.first + 1,
                      print.last + 1,
                      max_slip(tracks.before[f].centres, print.first, print.last) / size, 0, 1e-3});
  return feet;
}

PrescribedMotion plant_feet(const SequenceScene& scene, const SequenceOperation& step,
                            const FootTracks& tracks, const std::vector<Trajectory>& moved,
                            const std::vector<std::vector<FootContact>>& to,
                            const std::vector<double>& times) {
  PrescribedMotion prescribed;
  std::vector<char> needed(times.size(), 0);
  TrajectoryOptions options;
  options.smoothness = step.options.trajectories;
  options.times = times;
  for (size_t f = 0; f < tracks.handles.size(); ++f) {
    if (tracks.prints[f].empty()) continue;
    check(to[f], static_cast<int>(times.size()), scene.handles[tracks.handles[f]].name);
    std::vector<HandleKeyframe> keys;
    for (size_t j = 0; j < to[f].size(); ++j) {
      const FootContact &now = tracks.prints[f][j], &then = to[f][j];
      for (int k = now.first; k <= now.last; ++k) {
        needed[k] = 1;
        const Mat3 rotation =
            then.rotation * now.rotation.transpose() * tracks.before[f].rotations[k];
        keys.push_back(
            {k, RigidMotion::about(moved[f].centres.row(k).transpose(),
                                   rotation * moved[f].rotations[k].transpose(), then.at)});
      }
    }
    std::sort(keys.begin(), keys.end(),
              [](const auto& a, const auto& b) { return a.frame < b.frame; });
    prescribed.handles.push_back(tracks.handles[f]);
    prescribed.target_trajectory.push_back(edited(moved[f], keys, options));
  }
  if (prescribed.handles.empty())
    throw InputError(scene.at(step.location) +
                     "found no foot on the ground in any frame, expected a larger distance or "
                     "fewer min_frames in contact_detection = { distance = …, min_frames = … }");
  prescribed.prescribed =
      keyframe_mask(static_cast<int>(times.size()), step.keyframe_interval, needed);
  return prescribed;
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
    Trajectory target_trajectory = trajectory_of(from.sequence.frames, parts.handles[h].vertices);
    target_trajectory.centres += shifts;
    prescribed.handles.push_back(h);
    prescribed.target_trajectory.push_back(std::move(target_trajectory));
  }
}

Points mean_shift(const PreparedSequence& from, const SequenceParts& parts,
                  const PrescribedMotion& prescribed) {
  Points sum = Points::Zero(from.sequence.frame_count(), 3);
  for (size_t h = 0; h < prescribed.handles.size(); ++h) {
    const Trajectory before =
        trajectory_of(from.sequence.frames, parts.handles[prescribed.handles[h]].vertices);
    sum += (prescribed.target_trajectory[h].centres - before.centres) /
           static_cast<double>(prescribed.handles.size());
  }
  return sum;
}

}  // namespace batten
