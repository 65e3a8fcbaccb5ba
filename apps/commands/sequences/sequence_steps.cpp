#include "batten/apps/commands/sequences/sequence_steps.h"

#include <algorithm>
#include <numeric>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/apps/commands/sequences/prescribed_motion.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/mesh/sequence/trajectories/trajectory_filters.h"

namespace batten {

namespace {

/// Six times the enclosed volume of a closed mesh, negative if its faces point inwards; 0 for an
/// open mesh.
double six_times_volume(const TriangleMesh& mesh) {
  if (!mesh.topology().boundary_loops().empty()) return 0;
  const Eigen::RowVector3d middle = mesh.points().colwise().mean();
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles()) {
    const Vec3 p = mesh.points().row(a) - middle, q = mesh.points().row(b) - middle,
               r = mesh.points().row(c) - middle;
    sum += p.dot(q.cross(r));
  }
  return sum;
}

/// The mesh with all faces reversed.
ShellMesh inverted(const ShellMesh& shells) {
  ShellMesh result;
  result.points = shells.points;
  for (int f = 0; f < shells.face_count(); ++f) {
    std::vector<int> face(shells.corners(f).begin(), shells.corners(f).end());
    std::ranges::reverse(face);
    result.add_face(face);
  }
  return result;
}

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
    const auto editor =
        editor_for(step_, from_, parts_, handles, fixed_, first.frame - 1, last.frame - 1);
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
    auto to = tracks.prints;
    std::optional<Terrain> terrain;
    if (!what.terrain.empty()) terrain.emplace(read_terrain(what), scene_.upwards());
    for (size_t f = 0; f < to.size(); ++f)
      for (FootContact& print : to[f]) {
        print = moved({Mat3::Identity(), what.translation}, print);
        if (!terrain) continue;
        const double height = print.at.dot(scene_.upwards()) - what.ground;
        print = projected(print, *terrain, {what.clearance.value_or(height), what.rotations},
                          scene_.at(step_.location) + scene_.handles[tracks.handles[f]].name);
      }
    PrescribedMotion prescribed =
        plant_feet(scene_, step_, tracks, tracks.before, to, sequence().times);
    add_upright_handles(scene_, from_, parts_, what.unrotated,
                        mean_shift(from_, parts_, prescribed), prescribed);
    StepResult result =
        apply_prescribed_motion(step_, from_, parts_, prescribed, fixed_, progress_);
    result.feet = foot_reports(scene_, step_, tracks, size_of(sequence()));
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceOperation::Path& what) const {
    std::vector<std::string> warnings;
    Points centres(sequence().frame_count(), 3);
    for (int k = 0; k < sequence().frame_count(); ++k)
      centres.row(k) = sequence().frames[k].colwise().mean();
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
    std::vector<Trajectory> there;
    std::vector<std::vector<FootContact>> to;
    for (size_t f = 0; f < tracks.handles.size(); ++f) {
      there.push_back(moved(motions, tracks.before[f]));
      to.push_back(averaged(tracks.prints[f], motions));
    }
    PrescribedMotion prescribed = plant_feet(scene_, step_, tracks, there, to, sequence().times);
    // The editor measures rotations from its own first frame, which has rotated with the path.
    for (auto& target_trajectory : prescribed.target_trajectory)
      for (Mat3& rotation : target_trajectory.rotations)
        rotation = rotation * motions.front().rotation.transpose();
    add_upright_handles(scene_, *along, parts_, what.unrotated,
                        Points::Zero(sequence().frame_count(), 3), prescribed);
    StepResult result =
        apply_prescribed_motion(step_, *along, parts_, prescribed, fixed_, progress_);
    keep_alive(result, along);
    result.feet = foot_reports(scene_, step_, tracks, size_of(sequence()));
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
        if (tracks.handles[f] == h) handle.foot_contacts = tracks.prints[f];
      handles.push_back(std::move(handle));
    }
    Trajectory root;
    root.centres.resize(sequence().frame_count(), 3);
    root.rotations.assign(sequence().frame_count(), Mat3::Identity());
    for (int k = 0; k < sequence().frame_count(); ++k)
      root.centres.row(k) = sequence().frames[k].colwise().mean();
    FilterOptions even_ends;
    even_ends.padding = Padding::Odd;  // a walk does not slow down at the end of the frames
    const PrescribedMotion prescribed{
        numbers, filtered(root, handles, filter, even_ends).handles,
        keyframe_mask(sequence().frame_count(), step_.keyframe_interval, {})};
    StepResult result =
        apply_prescribed_motion(step_, from_, parts_, prescribed, fixed_, progress_);
    result.feet = foot_reports(scene_, step_, tracks, size_of(sequence()));
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
    using Align = SequenceOperation::Mix::Align;
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
      other.push_back(resampled(
          trajectory_of(source.frames, same ? parts_.handles[h].vertices : select.of(pair.from)),
          sequence().frame_count()));
    }
    for (size_t p = 0; p < own.size(); ++p) {
      Trajectory target_trajectory = other[p];
      if (what.align == Align::Shift)
        target_trajectory.centres.rowwise() +=
            (own[p].centres - target_trajectory.centres).colwise().mean();
      else if (what.align == Align::Each)
        target_trajectory = aligned(target_trajectory, fitted({other[p]}, {own[p]}));
      else
        target_trajectory = aligned(target_trajectory, fitted(other, own));
      if (what.rotations)
        align_rotations(target_trajectory, own[p]);
      else
        target_trajectory.rotations = own[p].rotations;
      prescribed.target_trajectory.push_back(std::move(target_trajectory));
    }
    prescribed.prescribed = keyframe_mask(sequence().frame_count(), step_.keyframe_interval, {});
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

  /// The similarity that maps the trajectories `from` to the trajectories `to`.
  Similarity fitted(const std::vector<Trajectory>& from, const std::vector<Trajectory>& to) const {
    const auto stacked = [](const std::vector<Trajectory>& all) {
      Trajectory one;
      one.centres.resize(all.front().frame_count() * isize(all), 3);
      for (size_t p = 0; p < all.size(); ++p) {
        one.centres.middleRows(static_cast<long>(p) * all[p].frame_count(), all[p].frame_count()) =
            all[p].centres;
        one.rotations.insert(one.rotations.end(), all[p].rotations.begin(), all[p].rotations.end());
      }
      return one;
    };
    AlignmentOptions options;
    options.about = scene_.upwards();
    return alignment(stacked(from), stacked(to), options);
  }

  // Rotations are relative to the first frame, in which the two handles may be oriented
  // differently; their mean orientation over all frames is aligned instead.
  static void align_rotations(Trajectory& target_trajectory, const Trajectory& own) {
    Mat3 sum = Mat3::Zero();
    for (size_t k = 0; k < own.rotations.size(); ++k)
      sum += target_trajectory.rotations[k].transpose() * own.rotations[k];
    const Mat3 between = nearest_rotation(sum);
    for (Mat3& rotation : target_trajectory.rotations) rotation = rotation * between;
  }

  /// Fits a sequence with other faces to the faces of ours.
  MeshSequence fit_to_source(const SequenceOperation::Morph& what, const MorphOptions& options,
                             const MeshSequence& target, std::vector<std::string>& warnings) const {
    const Points& ours = sequence().frames[options.source.first];
    const Points& theirs = target.frames.at(options.target.first);
    ShellMesh shells = target.shells;
    shells.points = theirs;
    TriangleMesh target_mesh = prepare(shells).mesh;
    Points vertices(from_.mesh.vertex_count(), 3);
    for (int v = 0; v < vertices.rows(); ++v)
      vertices.row(v) = ours.row(from_.mesh.topology().node_of(v));
    const TriangleMesh our_mesh = from_.mesh.with_points(std::move(vertices));
    if (six_times_volume(our_mesh) * six_times_volume(target_mesh) < 0)
      target_mesh = prepare(inverted(shells)).mesh;
    std::vector<LandmarkPair> landmarks;
    for (const auto& l : what.landmarks) {
      int node = 0;
      (ours.rowwise() - l.from.transpose()).rowwise().squaredNorm().minCoeff(&node);
      landmarks.push_back({node, l.to});
    }
    const TargetFit fit = fit_to_target(our_mesh, target_mesh, landmarks, what.fit, progress_);
    const double size = target_mesh.size();
    warnings.push_back("fitted to the target, distances relative to its size: mean " +
                       format_number(fit.mean_distance / size) + ", max " +
                       format_number(fit.largest_distance / size) + ", landmarks " +
                       format_number(fit.landmark_distance / size) + "; inverted triangles " +
                       std::to_string(fit.inverted));
    return transfer_target_motion(sequence().shells, fit.positions, target, target_mesh,
                                  options.target.first);
  }

  TriangleMesh read_terrain(const SequenceOperation::FootContacts& what) const {
    try {
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
