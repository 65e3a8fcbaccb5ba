#include "batten/apps/commands/sequences/sequence_steps.h"

#include <algorithm>
#include <numeric>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/apps/commands/sequences/told_handles.h"
#include "batten/core/each_once.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/mesh/rotation_of_faces.h"
#include "batten/mesh/sequence/trajectory_alignment.h"
#include "batten/mesh/sequence/trajectory_filters.h"
#include "batten/mesh/sequence/travel.h"

namespace batten {

namespace {

/// Of what a closed mesh encloses; below 0 where its faces look inwards; 0 of an open one.
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

/// All faces the other way round.
ShellMesh turned_over(const ShellMesh& shells) {
  ShellMesh result;
  result.points = shells.points;
  for (int f = 0; f < shells.face_count(); ++f) {
    std::vector<int> face(shells.corners(f).begin(), shells.corners(f).end());
    std::ranges::reverse(face);
    result.add_face(face);
  }
  return result;
}

/// One step; what all kinds of them need.
class Step {
 public:
  Step(const SequenceScene& scene, const SequenceStep& step, const PreparedSequence& from,
       const SequenceParts& parts, const VerticesOf& vertices_of, const ReadFrames& read,
       const Progress& progress)
      : scene_(scene),
        step_(step),
        from_(from),
        parts_(parts),
        read_(read),
        progress_(progress),
        fixed_(vertices_of(step.fixed)) {}

  StepResult operator()(const SequenceStep::Keyframes& what) const {
    std::vector<int> handles, moved;
    for (const auto& key : what.keys)
      for (const auto& move : key.moves) {
        const int h = parts_.handle(scene_, move.handle);
        if (std::find(handles.begin(), handles.end(), h) == handles.end()) handles.push_back(h);
        if (!move.translate.isZero(0) || move.degrees != 0) moved.push_back(h);
      }
    auto warnings = fixed_in_handles(parts_, each_once(std::move(moved)), fixed_);
    const auto [first, last] = std::ranges::minmax(what.keys, {}, &KeyframeRule::frame);
    const auto editor =
        editor_for(step_, from_, parts_, handles, fixed_, first.frame - 1, last.frame - 1);
    std::vector<SequenceKeyframe> keys;
    for (const KeyframeRule& rule : what.keys) {
      SequenceKeyframe key{rule.frame - 1, {}};
      if (rule.frame > sequence().frame_count())
        throw InputError(scene_.at(rule.place) + "found frame " + std::to_string(rule.frame) +
                         ", expected one of 1 to " + std::to_string(sequence().frame_count()));
      key.handles.resize(handles.size());
      for (const auto& move : rule.moves) {
        const auto h = static_cast<size_t>(
            std::find(handles.begin(), handles.end(), parts_.handle(scene_, move.handle)) -
            handles.begin());
        const Vec3 centre = editor->trajectories_before()[h].centres.row(key.frame).transpose();
        const Vec3 about = move.about.value_or(centre);
        key.handles[h] = HandlePlace{
            RigidMotion::about(
                about,
                Eigen::AngleAxisd(move.degrees * EIGEN_PI / 180, move.axis).toRotationMatrix(),
                about + move.translate),
            move.turns_freely};
      }
      keys.push_back(std::move(key));
    }
    if (handles.size() == 1 && fixed_.empty())
      warnings.push_back(
          "one handle is told and nothing is fixed: all that hangs on it just goes along");
    editor->set_keyframes(std::move(keys), progress_);
    StepResult result = result_of(from_, editor);
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceStep::Travel& what) const {
    std::vector<std::vector<int>> feet;
    for (const auto& foot : what.feet)
      feet.push_back(parts_.handles[parts_.handle(scene_, foot)].vertices);
    const double speed = what.speed
                             ? *what.speed
                             : stance_speed(sequence().frames, feet, what.along, scene_.upwards());
    require_room(static_cast<double>(what.cycles) * sequence().frame_count());
    return kept_as_it_is(std::make_shared<PreparedSequence>(
        PreparedSequence{travelled(sequence(), what.cycles, what.along, speed), from_.mesh}));
  }

  StepResult operator()(const SequenceStep::Footprints& what) const {
    std::vector<std::string> warnings;
    const FootTracks tracks =
        find_feet(scene_, sequence(), parts_, what.feet, what.search, warnings);
    auto to = tracks.prints;
    std::optional<Terrain> terrain;
    if (!what.terrain.empty()) terrain.emplace(read_terrain(what), scene_.upwards());
    for (size_t f = 0; f < to.size(); ++f)
      for (Footprint& print : to[f]) {
        print = moved({Mat3::Identity(), what.shift}, print);
        if (!terrain) continue;
        const double height = print.at.dot(scene_.upwards()) - what.ground;
        print = projected(print, *terrain, {what.clearance.value_or(height), what.turns},
                          scene_.at(step_.place) + scene_.handles[tracks.handles[f]].name);
      }
    ToldHandles told = planted(scene_, step_, tracks, tracks.before, to, sequence().times);
    add_upright(scene_, from_, parts_, what.upright, mean_shift(from_, parts_, told), told);
    StepResult result = follow_told(step_, from_, parts_, told, fixed_, progress_);
    result.feet = feet_of(scene_, step_, tracks, size_of(sequence()));
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceStep::Path& what) const {
    std::vector<std::string> warnings;
    Points centres(sequence().frame_count(), 3);
    for (int k = 0; k < sequence().frame_count(); ++k)
      centres.row(k) = sequence().frames[k].colwise().mean();
    const double way = (centres.rowwise() - centres.row(0)).rowwise().norm().maxCoeff();
    if (way < 0.1 * size_of(sequence()))
      warnings.push_back("the mesh goes no farther than " + number(way) + " " + scene_.unit +
                         " from where it starts: what moves on the spot has no path; a step of the "
                         "kind 'travel' before this one gives it one");
    const FittedPath old = fit_path(centres, {scene_.upwards(), what.spans});
    const auto motions =
        path_motions(old, GroundPath::through(what.through, scene_.upwards()), what.lengths);
    auto along = std::make_shared<PreparedSequence>(from_);
    for (size_t k = 0; k < motions.size(); ++k)
      along->sequence.frames[k] = moved(motions[k], along->sequence.frames[k]);
    if (what.feet.empty()) {
      StepResult result = kept_as_it_is(along);
      result.warnings = std::move(warnings);
      return result;
    }
    const FootTracks tracks =
        find_feet(scene_, sequence(), parts_, what.feet, what.search, warnings);
    std::vector<Trajectory> there;
    std::vector<std::vector<Footprint>> to;
    for (size_t f = 0; f < tracks.handles.size(); ++f) {
      there.push_back(moved(motions, tracks.before[f]));
      to.push_back(averaged(tracks.prints[f], motions));
    }
    ToldHandles told = planted(scene_, step_, tracks, there, to, sequence().times);
    // The editor measures turns from its own first frame, which has turned with the path.
    for (auto& wanted : told.wanted)
      for (Mat3& turn : wanted.turns) turn = turn * motions.front().turn.transpose();
    add_upright(scene_, *along, parts_, what.upright, Points::Zero(sequence().frame_count(), 3),
                told);
    StepResult result = follow_told(step_, *along, parts_, told, fixed_, progress_);
    keep_alive(result, along);
    result.feet = feet_of(scene_, step_, tracks, size_of(sequence()));
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceStep::Filter& what) const {
    using Kind = SequenceStep::Filter::Kind;
    const SignalFilter filter = what.kind == Kind::Low ? SignalFilter::low_pass(what.sigma)
                                : what.kind == Kind::High
                                    ? SignalFilter::high_pass(what.sigma)
                                    : SignalFilter::cartoon(what.sigma, what.amount);
    std::vector<std::string> warnings;
    std::vector<int> numbers;
    for (const auto& name : what.handles) numbers.push_back(parts_.handle(scene_, name));
    for (const auto& foot : what.feet)
      if (std::find(numbers.begin(), numbers.end(), parts_.handle(scene_, foot)) == numbers.end())
        throw InputError(scene_.at(foot.place) + "found the foot '" + foot.text +
                         "', expected one of the step's handles");
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
        if (tracks.handles[f] == h) handle.footprints = tracks.prints[f];
      handles.push_back(std::move(handle));
    }
    Trajectory root;
    root.centres.resize(sequence().frame_count(), 3);
    root.turns.assign(sequence().frame_count(), Mat3::Identity());
    for (int k = 0; k < sequence().frame_count(); ++k)
      root.centres.row(k) = sequence().frames[k].colwise().mean();
    FilterOptions even_ends;
    even_ends.padding = Padding::Turned;  // a walk does not slow down where the frames end
    const ToldHandles told{numbers, filtered(root, handles, filter, even_ends).handles,
                           told_frames(sequence().frame_count(), step_.every, {})};
    StepResult result = follow_told(step_, from_, parts_, told, fixed_, progress_);
    result.feet = feet_of(scene_, step_, tracks, size_of(sequence()));
    for (auto& foot : result.feet)  // they are where they were
      foot.promised = std::max(foot.promised, 1.001 * foot.slip_before);
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return result;
  }

  StepResult operator()(const SequenceStep::Mix& what) const {
    const MeshSequence source = read_(what.source);
    const PreparedMesh prepared = prepare(source.shells);
    SceneSelections selections = scene_;
    selections.selections = what.selections;
    selections.cuts.clear();
    const MeshFile file = MeshFile::counted_from_1(source.shells);
    VertexSelector select(selections, file, prepared.mesh);
    ToldHandles told;
    using Align = SequenceStep::Mix::Align;
    std::vector<Trajectory> own, other;
    for (const auto& pair : what.pairs) {
      const int h = parts_.handle(scene_, pair.handle);
      const bool same = pair.from.text.empty();
      if (same && source.node_count() != sequence().node_count())
        throw InputError(scene_.at(pair.from.place) + "found a source of " +
                         std::to_string(source.node_count()) + " nodes, expected from = … or " +
                         std::to_string(sequence().node_count()) + " nodes as here");
      told.handles.push_back(h);
      own.push_back(trajectory_of(sequence().frames, parts_.handles[h].vertices));
      other.push_back(resampled(
          trajectory_of(source.frames, same ? parts_.handles[h].vertices : select.of(pair.from)),
          sequence().frame_count()));
    }
    for (size_t p = 0; p < own.size(); ++p) {
      Trajectory wanted = other[p];
      if (what.align == Align::Shift)
        wanted.centres.rowwise() += (own[p].centres - wanted.centres).colwise().mean();
      else if (what.align == Align::Each)
        wanted = aligned(wanted, fitted({other[p]}, {own[p]}));
      else
        wanted = aligned(wanted, fitted(other, own));
      if (what.turns)
        turn_as(wanted, own[p]);
      else
        wanted.turns = own[p].turns;
      told.wanted.push_back(std::move(wanted));
    }
    told.told = told_frames(sequence().frame_count(), step_.every, {});
    return follow_told(step_, from_, parts_, told, fixed_, progress_);
  }

  StepResult operator()(const SequenceStep::Morph& what) const {
    MeshSequence target = read_(what.target);
    MorphOptions options = what.options;
    options.up = scene_.upwards();
    if (options.source.last < 0) options.source.last = sequence().frame_count() - 1;
    if (options.target.last < 0) options.target.last = target.frame_count() - 1;
    check(options.source, sequence(), "source");
    check(options.target, target, "target");
    require_room(options.frames);
    StepResult result;
    if (!what.landmarks.empty()) target = taken_on(what, options, target, result.warnings);
    auto made = std::make_shared<PreparedSequence>(
        PreparedSequence{morph(sequence(), target, from_.mesh, options, progress_), from_.mesh});
    auto warnings = std::move(result.warnings);
    result = kept_as_it_is(made);
    result.warnings = std::move(warnings);
    return result;
  }

 private:
  const MeshSequence& sequence() const { return from_.sequence; }

  void require_room(double frames) const {
    require_memory(
        24.0 * sequence().node_count() * frames,
        number(frames) + " frames of " + std::to_string(sequence().node_count()) + " nodes");
  }

  /// The similarity that lays all these trajectories over those.
  Similarity fitted(const std::vector<Trajectory>& from, const std::vector<Trajectory>& to) const {
    const auto stacked = [](const std::vector<Trajectory>& all) {
      Trajectory one;
      one.centres.resize(all.front().frame_count() * count_of(all), 3);
      for (size_t p = 0; p < all.size(); ++p) {
        one.centres.middleRows(static_cast<long>(p) * all[p].frame_count(), all[p].frame_count()) =
            all[p].centres;
        one.turns.insert(one.turns.end(), all[p].turns.begin(), all[p].turns.end());
      }
      return one;
    };
    AlignmentOptions options;
    options.about = scene_.upwards();
    return alignment(stacked(from), stacked(to), options);
  }

  // Turns count from the first frame, in which the two handles need not stand alike: in the mean over
  // the frames they do.
  static void turn_as(Trajectory& wanted, const Trajectory& own) {
    Mat3 sum = Mat3::Zero();
    for (size_t k = 0; k < own.turns.size(); ++k) sum += wanted.turns[k].transpose() * own.turns[k];
    const Mat3 between = rotation_part(sum);
    for (Mat3& turn : wanted.turns) turn = turn * between;
  }

  /// A sequence with other faces as one with ours.
  MeshSequence taken_on(const SequenceStep::Morph& what, const MorphOptions& options,
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
      target_mesh = prepare(turned_over(shells)).mesh;
    std::vector<LandmarkPair> landmarks;
    for (const auto& l : what.landmarks) {
      int node = 0;
      (ours.rowwise() - l.from.transpose()).rowwise().squaredNorm().minCoeff(&node);
      landmarks.push_back({node, l.to});
    }
    const TargetFit fit = fit_to_target(our_mesh, target_mesh, landmarks, what.fit, progress_);
    const double size = target_mesh.size();
    warnings.push_back("fitted to the target: nodes " + number(fit.mean_distance / size) +
                       " of its size from it in the mean, " + number(fit.largest_distance / size) +
                       " at most; landmarks " + number(fit.landmark_distance / size) +
                       "; triangles turned over " + std::to_string(fit.turned_over));
    return followed_target(sequence().shells, fit.positions, target, target_mesh,
                           options.target.first);
  }

  TriangleMesh read_terrain(const SequenceStep::Footprints& what) const {
    try {
      return prepare(MeshFile::read(what.terrain).shells()).mesh;
    } catch (const InputError& e) {
      throw InputError(scene_.at(what.terrain_place) + e.what());
    }
  }

  static StepResult kept_as_it_is(const std::shared_ptr<PreparedSequence>& made) {
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
  const SequenceStep& step_;
  const PreparedSequence& from_;
  const SequenceParts& parts_;
  const ReadFrames& read_;
  const Progress& progress_;
  std::vector<int> fixed_;
};

}  // namespace

StepResult do_step(const SequenceScene& scene, const SequenceStep& step,
                   const PreparedSequence& from, const SequenceParts& parts,
                   const VerticesOf& vertices_of, const ReadFrames& read,
                   const Progress& progress) {
  const Step doing(scene, step, from, parts, vertices_of, read, progress);
  StepResult result = std::visit(doing, step.what);
  static const char* const kinds[] = {"keyframes", "travel", "footprints", "path",
                                      "filter",    "mix",    "morph"};
  result.report.name = step.name;
  result.report.kind = kinds[step.what.index()];
  result.report.frames = count_of(result.times);
  return result;
}

}  // namespace batten
