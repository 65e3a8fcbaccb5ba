#include "batten/apps/commands/sequences/told_handles.h"

#include <algorithm>
#include <set>

#include "batten/core/errors.h"

namespace batten {
namespace {

double slip_of(const Points& centres, int first, int last) {
  const auto rows = centres.middleRows(first, last - first + 1);
  const Eigen::RowVector3d mean = rows.colwise().mean();
  return (rows.rowwise() - mean).rowwise().norm().maxCoeff();
}

}  // namespace

std::vector<std::string> fixed_in_handles(const SequenceParts& parts,
                                          const std::vector<int>& handles,
                                          const std::vector<int>& fixed) {
  const std::set<int> stay(fixed.begin(), fixed.end());
  std::vector<std::string> warnings;
  for (const int h : handles) {
    const std::set<int> nodes(parts.handles[h].vertices.begin(), parts.handles[h].vertices.end());
    const auto count = std::ranges::count_if(nodes, [&](int v) { return stay.contains(v); });
    if (count == 0) continue;
    const std::string name = "the handle '" + parts.handles[h].name + "' is told to move, and ";
    if (count == count_of(nodes)) throw InputError(name + "all its nodes are in fixed = […]");
    warnings.push_back(name + std::to_string(count) + " of its " + std::to_string(nodes.size()) +
                       " nodes are fixed: these stay");
  }
  return warnings;
}

std::vector<char> told_frames(int frames, int every, const std::vector<char>& needed) {
  std::vector<char> told(frames, 0);
  for (int k = 0; k < frames; k += every) told[k] = 1;
  if (frames > 0) told.back() = 1;
  for (int k = 0; k < frames && !needed.empty(); ++k)
    if (needed[k] && (k == 0 || k + 1 == frames || !needed[k - 1] || !needed[k + 1])) told[k] = 1;
  return told;
}

std::shared_ptr<SequenceEditor> editor_for(const SequenceStep& step, const PreparedSequence& from,
                                           const SequenceParts& parts,
                                           const std::vector<int>& handles,
                                           const std::vector<int>& fixed, int first_key,
                                           int last_key) {
  FrameHolds holds;
  holds.fixed = fixed;
  for (const int h : handles) holds.handles.push_back(parts.handles[h]);
  holds.features = parts.features;
  holds.softness = step.softness;
  holds.keeps_volume = step.keeps_volume;
  SequenceEditOptions options = step.options;
  // Where the sequence ends at a keyframe there is nothing to come back to.
  if (first_key == 0 && options.influence.from == 0) options.influence.from.reset();
  const int last = from.sequence.frame_count() - 1;
  if (last_key == last && options.influence.to == last) options.influence.to.reset();
  return std::make_shared<SequenceEditor>(from.sequence, from.mesh, std::move(holds), options);
}

StepResult result_of(const PreparedSequence& from, std::shared_ptr<SequenceEditor> editor) {
  StepResult result;
  result.shells = from.sequence.shells;
  result.times = from.sequence.times;
  result.warnings = editor->notes();
  result.report.keyframes = count_of(editor->keyframes());
  for (const auto& r : editor->keyframe_reports()) {
    result.report.rounds = std::max(result.report.rounds, r.rounds);
    if (r.converged) continue;
    ++result.report.not_at_rest;
    result.report.last_change = std::max(result.report.last_change, r.last_change);
  }
  result.frames = [editor](int first, int last, const auto& take, const Progress& progress) {
    editor->frames(first, last, take, progress);
  };
  return result;
}

StepResult follow_told(const SequenceStep& step, const PreparedSequence& from,
                       const SequenceParts& parts, const ToldHandles& told,
                       const std::vector<int>& fixed, const Progress& progress) {
  const auto warnings = fixed_in_handles(parts, told.handles, fixed);
  const auto editor =
      editor_for(step, from, parts, told.handles, fixed, 0, from.sequence.frame_count() - 1);
  std::vector<std::vector<RigidMotion>> motions;
  for (size_t h = 0; h < told.handles.size(); ++h)
    motions.push_back(motions_between(editor->trajectories_before()[h], told.wanted[h]));
  std::vector<SequenceKeyframe> keys;
  for (int k = 0; k < from.sequence.frame_count(); ++k) {
    if (!told.told.empty() && !told.told[k]) continue;
    SequenceKeyframe key{k, {}};
    for (const auto& of_handle : motions) key.handles.push_back(HandlePlace{of_handle[k], false});
    keys.push_back(std::move(key));
  }
  editor->set_keyframes(std::move(keys), progress);
  if (!step.softness) editor->set_motions(std::move(motions));  // they do not stray in between
  StepResult result = result_of(from, editor);
  result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  return result;
}

FootTracks find_feet(const SequenceScene& scene, const MeshSequence& before,
                     const SequenceParts& parts, const std::vector<PlacedWord>& feet,
                     const FootprintSearch& search, std::vector<std::string>& warnings) {
  FootTracks tracks;
  FootprintOptions options;
  options.within = search.within > 0 ? search.within : 0.01 * size_of(before);
  options.frames = search.frames;
  for (const PlacedWord& foot : feet) {
    const int h = parts.handle(scene, foot);
    tracks.handles.push_back(h);
    tracks.before.push_back(trajectory_of(before.frames, parts.handles[h].vertices));
    tracks.prints.push_back(find_footprints(tracks.before.back(), options));
    if (tracks.prints.back().empty())
      warnings.push_back("'" + foot.text + "' stands still nowhere: no " +
                         std::to_string(options.frames) + " frames within " +
                         number(options.within) + " " + scene.unit);
  }
  return tracks;
}

std::vector<SequenceReport::Foot> feet_of(const SequenceScene& scene, const SequenceStep& step,
                                          const FootTracks& tracks, double size) {
  std::vector<SequenceReport::Foot> feet;
  for (size_t f = 0; f < tracks.handles.size(); ++f)
    for (const Footprint& print : tracks.prints[f])
      feet.push_back({step.name, scene.handles[tracks.handles[f]].name, print.first + 1,
                      print.last + 1,
                      slip_of(tracks.before[f].centres, print.first, print.last) / size, 0, 1e-3});
  return feet;
}

ToldHandles planted(const SequenceScene& scene, const SequenceStep& step, const FootTracks& tracks,
                    const std::vector<Trajectory>& moved,
                    const std::vector<std::vector<Footprint>>& to,
                    const std::vector<double>& times) {
  ToldHandles told;
  std::vector<char> needed(times.size(), 0);
  TrajectoryOptions options;
  options.smoothness = step.options.trajectories;
  options.times = times;
  for (size_t f = 0; f < tracks.handles.size(); ++f) {
    if (tracks.prints[f].empty()) continue;
    check(to[f], static_cast<int>(times.size()), scene.handles[tracks.handles[f]].name);
    std::vector<HandleKeyframe> keys;
    for (size_t j = 0; j < to[f].size(); ++j) {
      const Footprint &now = tracks.prints[f][j], &then = to[f][j];
      for (int k = now.first; k <= now.last; ++k) {
        needed[k] = 1;
        const Mat3 turn = then.turn * now.turn.transpose() * tracks.before[f].turns[k];
        keys.push_back({k, RigidMotion::about(moved[f].centres.row(k).transpose(),
                                              turn * moved[f].turns[k].transpose(), then.at)});
      }
    }
    std::sort(keys.begin(), keys.end(),
              [](const auto& a, const auto& b) { return a.frame < b.frame; });
    told.handles.push_back(tracks.handles[f]);
    told.wanted.push_back(edited(moved[f], keys, options));
  }
  if (told.handles.empty())
    throw InputError(scene.at(step.place) +
                     "no foot stands still anywhere: found = { within = …, "
                     "frames = … } says what counts");
  told.told = told_frames(static_cast<int>(times.size()), step.every, needed);
  return told;
}

void add_upright(const SequenceScene& scene, const PreparedSequence& from,
                 const SequenceParts& parts, const std::vector<PlacedWord>& names,
                 const Points& shifts, ToldHandles& told) {
  for (const PlacedWord& name : names) {
    const int h = parts.handle(scene, name);
    if (std::find(told.handles.begin(), told.handles.end(), h) != told.handles.end())
      throw InputError(scene.at(name.place) + "found '" + name.text +
                       "' as a foot too, expected another handle");
    Trajectory wanted = trajectory_of(from.sequence.frames, parts.handles[h].vertices);
    wanted.centres += shifts;
    told.handles.push_back(h);
    told.wanted.push_back(std::move(wanted));
  }
}

Points mean_shift(const PreparedSequence& from, const SequenceParts& parts,
                  const ToldHandles& told) {
  Points sum = Points::Zero(from.sequence.frame_count(), 3);
  for (size_t h = 0; h < told.handles.size(); ++h) {
    const Trajectory before =
        trajectory_of(from.sequence.frames, parts.handles[told.handles[h]].vertices);
    sum += (told.wanted[h].centres - before.centres) / static_cast<double>(told.handles.size());
  }
  return sum;
}

}  // namespace batten
