// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/sequences/sequence_steps.h"

#include <algorithm>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/mesh/sequence/foot_plants.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/prescribed_motion.h"
#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/mesh/sequence/trajectories/trajectory_filters.h"

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

// Handles with prescribed trajectories.

/// Warnings about handles with some fixed nodes, which stay fixed. Throws InputError if all nodes
/// of a handle are fixed, since it cannot follow its motion.
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

/// The constraints of a step: all handles and features of the scene.
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

/// The frames of an editor whose keyframes are set.
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

/// The frames of a step whose handles follow a prescribed motion.
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

/// Detects the contacts of feet. `warnings` receives remarks.
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

/// Throws InputError if no foot is on the ground in any frame.
void require_contacts(const SequenceScene& scene, const SequenceOperation& step,
                      const FootTracks& tracks) {
  if (std::ranges::all_of(tracks.contacts, [](const auto& list) { return list.empty(); }))
    throw InputError(scene.at(step.location) +
                     "found no foot on the ground in any frame, expected a larger distance or "
                     "fewer min_frames in contact_detection = { distance = …, min_frames = … }");
}

/// Report entries of feet. The remaining foot skate is measured later, on the finished frames.
std::vector<SequenceReport::Foot> foot_reports(const SequenceOperation& step,
                                               const FootTracks& tracks, double size) {
  std::vector<SequenceReport::Foot> feet;
  for (size_t f = 0; f < tracks.handles.size(); ++f)
    for (const FootContact& contact : tracks.contacts[f])
      feet.push_back({step.name, tracks.names[f], contact.first + 1, contact.last + 1,
                      foot_skate(tracks.trajectories[f], contact) / size, 0, 1e-3});
  return feet;
}

/// Adds the handles of the key `unrotated`; see add_unrotated_handles().
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

// Execution of steps.

/// Performs one step; holds the data that all kinds of steps need.
class StepRunner {
 public:
  StepRunner(const SequenceScene& scene, const SequenceOperation& step,
             const PreparedSequence& from, const SequenceParts& parts,
             const VertexFinder& vertices_of, const FrameReader& read, const Progress& progress)
      : scene_(scene),
        step_(step),
        from_(from),
        parts_(parts),
        read_(read),
        progress_(progress),
        fixed_(vertices_of(step.fixed)) {}

  StepResult operator()(const SequenceOperation::Keyframes& what) const {
    std::vector<int> handles, moved;
    for (const auto& key : what.keys)
      for (const auto& move : key.moves) {
        const int h = parts_.handle(scene_, move.handle);
        if (std::find(handles.begin(), handles.end(), h) == handles.end()) handles.push_back(h);
        if (!move.translate.isZero(0) || move.degrees != 0) moved.push_back(h);
      }
    auto warnings = warn_of_fixed_handle_nodes(parts_, sorted_unique(std::move(moved)), fixed_);
    const auto [first, last] = std::ranges::minmax(what.keys, {}, &KeyframeSpec::frame);
    FrameConstraints constraints = constraints_of(step_, parts_, fixed_);
    constraints.handles.clear();
    for (const int h : handles) constraints.handles.push_back(parts_.handles[h]);
    SequenceEditOptions options = step_.options;
    open_influence_at_ends(options.influence, sequence().frame_count(), first.frame - 1,
                           last.frame - 1);
    const auto editor =
        std::make_shared<SequenceEditor>(sequence(), from_.mesh, std::move(constraints), options);
    std::vector<SequenceKeyframe> keys;
    for (const KeyframeSpec& rule : what.keys) {
      SequenceKeyframe key{rule.frame - 1, {}};
      if (rule.frame > sequence().frame_count())
        throw InputError(scene_.at(rule.location) + "found frame " + std::to_string(rule.frame) +
                         ", expected one of 1 to " + std::to_string(sequence().frame_count()));
      key.handles.resize(handles.size());
      for (const auto& move : rule.moves) {
        const auto h = static_cast<size_t>(
            std::find(handles.begin(), handles.end(), parts_.handle(scene_, move.handle)) -
            handles.begin());
        const Vec3 centre = editor->trajectories_before()[h].centres.row(key.frame).transpose();
        const Vec3 about = move.about.value_or(centre);
        key.handles[h] = HandlePose{
            RigidMotion::about(
                about,
                Eigen::AngleAxisd(move.degrees * EIGEN_PI / 180, move.axis).toRotationMatrix(),
                about + move.translate),
            move.free_rotation};
      }
      keys.push_back(std::move(key));
    }
    if (handles.size() == 1 && fixed_.empty())
      warnings.push_back(
          "a single handle is prescribed and nothing is fixed, so that everything connected to it "
          "moves rigidly with it");
    editor->set_keyframes(std::move(keys), progress_);
    StepResult result = result_of(from_, editor);
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceOperation::RootMotion& what) const {
    std::vector<std::vector<int>> feet;
    for (const auto& foot : what.feet)
      feet.push_back(parts_.handles[parts_.handle(scene_, foot)].vertices);
    const double speed = what.speed
                             ? *what.speed
                             : stance_speed(sequence().frames, feet, what.along, scene_.upwards());
    require_frame_memory(static_cast<double>(what.cycles) * sequence().frame_count());
    return precomputed_result(std::make_shared<PreparedSequence>(PreparedSequence{
        with_root_motion(sequence(), what.cycles, what.along, speed), from_.mesh}));
  }

  StepResult operator()(const SequenceOperation::FootContacts& what) const {
    std::vector<std::string> warnings;
    const FootTracks tracks =
        find_feet(scene_, sequence(), parts_, what.feet, what.search, warnings);
    std::optional<Terrain> terrain;
    if (!what.terrain.empty()) terrain.emplace(read_terrain(what), scene_.upwards());
    const auto to = placed_contacts(tracks, {what.translation, terrain ? &*terrain : nullptr,
                                             what.clearance, what.ground, what.rotations});
    require_contacts(scene_, step_, tracks);
    PrescribedMotion prescribed =
        plant_feet(tracks, tracks.trajectories, to, sequence().times, plant_options());
    add_upright_handles(scene_, from_, parts_, what.unrotated,
                        mean_shift(sequence().frames, parts_.handles, prescribed), prescribed);
    StepResult result =
        apply_prescribed_motion(step_, from_, parts_, prescribed, fixed_, progress_);
    result.feet = foot_reports(step_, tracks, size_of(sequence()));
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceOperation::Path& what) const {
    std::vector<std::string> warnings;
    const Points centres = root_trajectory(sequence().frames).centres;
    const double distance = (centres.rowwise() - centres.row(0)).rowwise().norm().maxCoeff();
    if (distance < 0.1 * size_of(sequence()))
      warnings.push_back("the mesh stays within " + format_number(distance) + " " + scene_.unit +
                         " of its start and has no path; add an operation of type \"root_motion\" "
                         "before this one");
    const FittedPath old = fit_path(centres, {scene_.upwards(), what.spans});
    const auto motions =
        path_motions(old, GroundPath::through(what.through, scene_.upwards()), what.lengths);
    auto along = std::make_shared<PreparedSequence>(from_);
    for (size_t k = 0; k < motions.size(); ++k)
      along->sequence.frames[k] = moved(motions[k], along->sequence.frames[k]);
    if (what.feet.empty()) {
      StepResult result = precomputed_result(along);
      result.warnings = std::move(warnings);
      return result;
    }
    const FootTracks tracks =
        find_feet(scene_, sequence(), parts_, what.feet, what.search, warnings);
    require_contacts(scene_, step_, tracks);
    PrescribedMotion prescribed =
        plant_feet_along(tracks, motions, sequence().times, plant_options());
    add_upright_handles(scene_, *along, parts_, what.unrotated,
                        Points::Zero(sequence().frame_count(), 3), prescribed);
    StepResult result =
        apply_prescribed_motion(step_, *along, parts_, prescribed, fixed_, progress_);
    keep_alive(result, along);
    result.feet = foot_reports(step_, tracks, size_of(sequence()));
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceOperation::Filter& what) const {
    using Kind = SequenceOperation::Filter::Kind;
    const SignalFilter filter = what.kind == Kind::Low ? SignalFilter::low_pass(what.sigma)
                                : what.kind == Kind::High
                                    ? SignalFilter::high_pass(what.sigma)
                                    : SignalFilter::cartoon(what.sigma, what.amount);
    std::vector<std::string> warnings;
    std::vector<int> numbers;
    for (const auto& name : what.handles) numbers.push_back(parts_.handle(scene_, name));
    for (const auto& foot : what.feet)
      if (std::find(numbers.begin(), numbers.end(), parts_.handle(scene_, foot)) == numbers.end())
        throw InputError(scene_.at(foot.location) + "found the foot '" + foot.text +
                         "', expected one of the operation's handles");
    const FootTracks tracks =
        find_feet(scene_, sequence(), parts_, what.feet, what.search, warnings);
    std::vector<FilteredHandle> handles;
    for (const int h : numbers) {
      FilteredHandle handle{parts_.handles[h].name,
                            trajectory_of(sequence().frames, parts_.handles[h].vertices),
                            -1,
                            {}};
      const auto parent = std::find(numbers.begin(), numbers.end(), parts_.parents[h]);
      if (parent != numbers.end()) handle.parent = static_cast<int>(parent - numbers.begin());
      for (size_t f = 0; f < tracks.handles.size(); ++f)
        if (tracks.handles[f] == h) handle.foot_contacts = tracks.contacts[f];
      handles.push_back(std::move(handle));
    }
    FilterOptions even_ends;
    even_ends.padding = Padding::Odd;  // a walk does not slow down at the end of the frames
    const Trajectory root = root_trajectory(sequence().frames);
    const PrescribedMotion prescribed{
        numbers, filtered(root, handles, filter, even_ends).handles,
        keyframe_mask(sequence().frame_count(), step_.keyframe_interval, {})};
    StepResult result =
        apply_prescribed_motion(step_, from_, parts_, prescribed, fixed_, progress_);
    result.feet = foot_reports(step_, tracks, size_of(sequence()));
    for (auto& foot : result.feet)  // the existing foot skate is tolerated
      foot.max_foot_skate = std::max(foot.max_foot_skate, 1.001 * foot.foot_skate_before);
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceOperation::Mix& what) const {
    const MeshSequence source = read_(what.source);
    const PreparedMesh prepared = prepare(source.shells);
    SceneSelections selections = scene_;
    selections.selections = what.selections;
    selections.cuts.clear();
    const MeshFile file = MeshFile::from_shells(source.shells);
    VertexSelector select(selections, file, prepared.mesh);
    PrescribedMotion prescribed;
    std::vector<Trajectory> own, other;
    for (const auto& pair : what.pairs) {
      const int h = parts_.handle(scene_, pair.handle);
      const bool same = pair.from.text.empty();
      if (same && source.node_count() != sequence().node_count())
        throw InputError(scene_.at(pair.from.location) + "found a source with " +
                         std::to_string(source.node_count()) + " nodes, expected from = … or " +
                         std::to_string(sequence().node_count()) +
                         " nodes, as many as in this sequence");
      prescribed.handles.push_back(h);
      own.push_back(trajectory_of(sequence().frames, parts_.handles[h].vertices));
      other.push_back(
          trajectory_of(source.frames, same ? parts_.handles[h].vertices : select.of(pair.from)));
    }
    prescribed.targets = transferred(other, own, {what.align, scene_.upwards(), what.rotations});
    prescribed.is_keyframe = keyframe_mask(sequence().frame_count(), step_.keyframe_interval, {});
    return apply_prescribed_motion(step_, from_, parts_, prescribed, fixed_, progress_);
  }

  StepResult operator()(const SequenceOperation::Morph& what) const {
    MeshSequence target = read_(what.target);
    MorphOptions options = what.options;
    options.up = scene_.upwards();
    if (options.source.last < 0) options.source.last = sequence().frame_count() - 1;
    if (options.target.last < 0) options.target.last = target.frame_count() - 1;
    check(options.source, sequence(), "source");
    check(options.target, target, "target");
    require_frame_memory(options.frames);
    StepResult result;
    if (!what.landmarks.empty()) target = fit_to_source(what, options, target, result.warnings);
    auto made = std::make_shared<PreparedSequence>(
        PreparedSequence{morph(sequence(), target, from_.mesh, options, progress_), from_.mesh});
    auto warnings = std::move(result.warnings);
    result = precomputed_result(made);
    result.warnings = std::move(warnings);
    return result;
  }

 private:
  const MeshSequence& sequence() const { return from_.sequence; }

  void require_frame_memory(double frames) const {
    require_memory(
        24.0 * sequence().node_count() * frames,
        format_number(frames) + " frames of " + std::to_string(sequence().node_count()) + " nodes");
  }

  FootPlantOptions plant_options() const {
    return {step_.options.trajectories, step_.keyframe_interval};
  }

  /// Fits a sequence with other faces to the faces of ours.
  MeshSequence fit_to_source(const SequenceOperation::Morph& what, const MorphOptions& options,
                             const MeshSequence& target, std::vector<std::string>& warnings) const {
    RegisteredTarget registered =
        registered_target(sequence(), from_.mesh, options.source.first, target,
                          options.target.first, what.landmarks, what.fit, progress_);
    const TargetFit& fit = registered.fit;
    const double size = registered.target_size;
    warnings.push_back("fitted to the target, distances relative to its size: mean " +
                       format_number(fit.mean_distance / size) + ", max " +
                       format_number(fit.largest_distance / size) + ", landmarks " +
                       format_number(fit.landmark_distance / size) + "; inverted triangles " +
                       std::to_string(fit.inverted));
    return std::move(registered.sequence);
  }

  TriangleMesh read_terrain(const SequenceOperation::FootContacts& what) const {
    try {
      if (what.terrain_in_memory) return prepare(*what.terrain_in_memory).mesh;
      return prepare(MeshFile::read(what.terrain).shells()).mesh;
    } catch (const InputError& e) {
      throw InputError(scene_.at(what.terrain_location) + e.what());
    }
  }

  static StepResult precomputed_result(const std::shared_ptr<PreparedSequence>& made) {
    StepResult result;
    result.shells = made->sequence.shells;
    result.times = made->sequence.times;
    result.frames = [made](int first, int last, const auto& take, const Progress&) {
      for (int k = first; k <= last; ++k) take(k, made->sequence.frames[k]);
    };
    return result;
  }

  static void keep_alive(StepResult& result, const std::shared_ptr<PreparedSequence>& made) {
    result.frames = [made, frames = result.frames](int first, int last, const auto& take,
                                                   const Progress& progress) {
      frames(first, last, take, progress);
    };
  }

  const SequenceScene& scene_;
  const SequenceOperation& step_;
  const PreparedSequence& from_;
  const SequenceParts& parts_;
  const FrameReader& read_;
  const Progress& progress_;
  std::vector<int> fixed_;
};

}  // namespace

StepResult apply_step(const SequenceScene& scene, const SequenceOperation& step,
                      const PreparedSequence& from, const SequenceParts& parts,
                      const VertexFinder& vertices_of, const FrameReader& read,
                      const Progress& progress) {
  const StepRunner runner(scene, step, from, parts, vertices_of, read, progress);
  StepResult result = std::visit(runner, step.what);
  static const char* const kinds[] = {"keyframes", "root_motion", "foot_plants", "path",
                                      "filter",    "mix",         "morph"};
  result.report.name = step.name;
  result.report.kind = kinds[step.what.index()];
  result.report.frames = isize(result.times);
  return result;
}

PreparedSequence prepared_sequence(MeshSequence sequence, const std::string& where,
                                   std::vector<std::string>& notes) {
  try {
    PreparedMesh prepared = prepare(sequence.shells);
    notes.insert(notes.end(), prepared.notes.begin(), prepared.notes.end());
    return {std::move(sequence), std::move(prepared.mesh)};
  } catch (const InputError& e) {
    throw InputError(where + e.what());
  }
}

SequenceParts find_sequence_parts(const SequenceScene& scene, VertexSelector& select) {
  SequenceParts parts;
  for (const auto& h : scene.handles) {
    parts.handles.push_back({h.name, select.of(h.vertices)});
    if (parts.handles.back().vertices.empty())
      throw InputError(scene.at(h.location) + "found the handle '" + h.name +
                       "' without nodes, expected at least one node");
  }
  for (const auto& h : scene.handles)
    parts.parents.push_back(h.parent.text.empty() ? -1 : parts.handle(scene, h.parent));
  for (const FeatureSpec& rule : scene.features) {
    if (!rule.name.empty()) {
      parts.features.push_back({rule.name, select.of(rule.vertices), rule.kind});
      continue;
    }
    for (const LocatedString& word : rule.vertices)
      for (const LocatedString& name : select.matching(word))
        parts.features.push_back({name.text, select.of(name), rule.kind});
  }
  return parts;
}

StepResult unchanged_result(std::shared_ptr<const PreparedSequence> s) {
  StepResult result;
  result.shells = s->sequence.shells;
  result.times = s->sequence.times;
  result.frames = [s](int first, int last, const auto& take, const Progress&) {
    for (int k = first; k <= last; ++k) take(k, s->sequence.frames[k]);
  };
  return result;
}

StepResult run_step(const SequenceScene& scene, const SequenceOperation& step,
                    const PreparedSequence& from, const SequenceParts& parts,
                    VertexSelector& select, const FrameReader& read, const Progress& progress) {
  const VertexFinder vertices_of = [&](const std::vector<LocatedString>& names) {
    return select.of(names);
  };
  return with_step_context(scene, step, [&] {
    return apply_step(scene, step, from, parts, vertices_of, read, progress);
  });
}

std::shared_ptr<const PreparedSequence> collect_frames(const StepResult& result,
                                                       const TriangleMesh& mesh,
                                                       const Progress& progress) {
  MeshSequence sequence;
  sequence.shells = result.shells;
  sequence.times = result.times;
  result.frames(
      0, isize(result.times) - 1, [&](int, const Points& p) { sequence.frames.push_back(p); },
      progress);
  sequence.shells.points = sequence.frames.front();
  const MeshTopology& topology = mesh.topology();
  Points vertices(topology.vertex_count(), 3);
  for (int v = 0; v < topology.vertex_count(); ++v)
    vertices.row(v) = sequence.frames.front().row(topology.node_of(v));
  return std::make_shared<const PreparedSequence>(
      PreparedSequence{std::move(sequence), mesh.with_points(std::move(vertices))});
}

}  // namespace batten
