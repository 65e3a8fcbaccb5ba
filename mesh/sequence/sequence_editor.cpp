#include "batten/mesh/sequence/sequence_editor.h"

#include <algorithm>
#include <map>

#include "batten/core/chunks.h"
#include "batten/core/errors.h"
#include "batten/core/rotations.h"
#include "batten/mesh/deform/similarity.h"
#include "batten/mesh/sequence/solver_pool.h"

namespace batten {
namespace {

/// Keyframes of a run that start from each other.
constexpr int kRun = 8;
/// Frames that are solved before they are handed on: more would only take memory.
constexpr int kAhead = 16;

std::string frame_name(int frame) { return "frame " + std::to_string(frame + 1); }

}  // namespace

struct SequenceEditor::Data {
  Data(const MeshSequence& s, const TriangleMesh& m, FrameHolds given,
       const SequenceEditOptions& opts)
      : sequence(&s),
        mesh(m),
        holds(std::move(given)),
        options(opts),
        all(mesh, holds, options.frames) {
    for (const Handle& h : holds.handles)
      before.push_back(trajectory_of(sequence->frames, h.vertices));
    after = before;
  }

  void forget() {
    keyframes.clear();
    positions.clear();
    reports.clear();
    after = before;
  }

  void check_keyframes() const {
    const int last = sequence->frame_count() - 1;
    for (size_t k = 0; k < keyframes.size(); ++k) {
      const auto& key = keyframes[k];
      if (key.frame < 0 || key.frame > last)
        throw InputError("a keyframe at " + frame_name(key.frame) + ", and the sequence has " +
                         std::to_string(last + 1) + " frames");
      if (k > 0 && keyframes[k - 1].frame == key.frame)
        throw InputError(frame_name(key.frame) + " is a keyframe twice");
      if (key.handles.size() != holds.handles.size())
        throw InputError("the keyframe at " + frame_name(key.frame) + " tells " +
                         std::to_string(key.handles.size()) + " handles, expected " +
                         std::to_string(holds.handles.size()));
      if (std::none_of(key.handles.begin(), key.handles.end(),
                       [](const auto& place) { return place.has_value(); }))
        throw InputError("the keyframe at " + frame_name(key.frame) + " tells no handle");
    }
  }

  /// The solver whose handles are those that a keyframe tells.
  SolverPool& pool_for(const std::vector<char>& told) {
    if (std::all_of(told.begin(), told.end(), [](char t) { return t != 0; })) return all;
    auto& pool = some[told];
    if (!pool) {
      FrameHolds part = holds;
      part.handles.clear();
      for (size_t h = 0; h < told.size(); ++h)
        if (told[h]) part.handles.push_back(holds.handles[h]);
      pool = std::make_unique<SolverPool>(mesh, std::move(part), options.frames);
    }
    return *pool;
  }

  static std::vector<char> told_at(const SequenceKeyframe& key) {
    std::vector<char> told;
    for (const auto& place : key.handles) told.push_back(place.has_value());
    return told;
  }

  static FramePlaces places_at(const SequenceKeyframe& key) {
    FramePlaces places;
    for (const auto& place : key.handles)
      if (place) places.handles.push_back(*place);
    return places;
  }

  void solve_keyframes(const Progress& progress) {
    const int count = count_of(keyframes);
    turns.assign(count, {});
    positions.assign(count, Points());
    reports.assign(count, {});
    std::vector<SolverPool*> pools;
    for (const auto& key : keyframes) pools.push_back(&pool_for(told_at(key)));
    const int run = options.start == SequenceEditOptions::Start::Neighbour ? kRun : 1;
    const int runs = (count + run - 1) / run;
    for (int first = 0; first < runs; first += kAhead) {
      progress.at("keyframes", static_cast<double>(first) / runs);
      const int last = std::min(runs, first + kAhead);
      parallel_parts(last - first, [&](int r) {
        const int from = (first + r) * run;
        for (int k = from; k < std::min(count, from + run); ++k)
          pools[k]->with([&](FrameSolver& solver) { solve_keyframe(solver, k, k > from); });
      });
    }
  }

  void solve_keyframe(FrameSolver& solver, int k, bool has_neighbour) {
    const Points& frame = sequence->frames[keyframes[k].frame];
    const FramePlaces places = places_at(keyframes[k]);
    if (has_neighbour) {
      solver.reconstruct(frame, places, turns[k - 1], options.frames.most_rounds);
    } else if (!starts.empty()) {
      solver.alternate(frame, places, starts[k]);
    } else {
      solver.alternate(frame, places);
    }
    turns[k] = solver.result().turns;
    positions[k] = solver.result().positions;
    reports[k] = solver.report();
  }

  // Step 1 and the subspace solutions: one frame after the other, for W is large.
  void start_from_control_mesh(const Progress& progress) {
    starts.clear();
    if (options.start != SequenceEditOptions::Start::Subspace) return;
    const TriangleMesh control = control_mesh(mesh, options.control);
    const Points& first = sequence->frames.front();
    const ControlFollower follower(mesh, control.points(), mean_value_coordinates(control, first));
    std::map<std::vector<char>, std::unique_ptr<SubspaceSolver>> solvers;
    for (size_t k = 0; k < keyframes.size(); ++k) {
      progress.at("control meshes", static_cast<double>(k) / static_cast<double>(keyframes.size()));
      const auto told = told_at(keyframes[k]);
      auto& solver = solvers[told];
      if (!solver) {
        FrameHolds part = holds;
        part.handles.clear();
        for (size_t h = 0; h < told.size(); ++h)
          if (told[h]) part.handles.push_back(holds.handles[h]);
        solver = std::make_unique<SubspaceSolver>(mesh, std::move(part), control);
      }
      const Points& frame = sequence->frames[keyframes[k].frame];
      solver->set_frame(frame, follower.at(frame));
      starts.push_back(solver->solve(places_at(keyframes[k])));
    }
  }

  void follow_handles() {
    TrajectoryOptions trajectory;
    trajectory.smoothness = options.trajectories;
    trajectory.influence = options.influence;
    trajectory.ends = options.ends;
    trajectory.times = sequence->times;
    motions.clear();
    for (size_t h = 0; h < holds.handles.size(); ++h) {
      std::vector<HandleKeyframe> keys;
      for (size_t k = 0; k < keyframes.size(); ++k)
        keys.push_back({keyframes[k].frame, motion_at(k, h)});
      after[h] = edited(before[h], keys, trajectory);
      motions.push_back(motions_between(before[h], after[h]));
    }
  }

  // As it was told, or where the keyframe took it.
  RigidMotion motion_at(size_t k, size_t h) const {
    const auto& place = keyframes[k].handles[h];
    if (place && !place->turns_freely && !holds.softness) return place->motion;
    const Similarity s = fit_similarity(sequence->frames[keyframes[k].frame], positions[k],
                                        holds.handles[h].vertices, 1.0);
    return {s.R, s.shift};
  }

  void follow_turns() {
    std::vector<int> at;
    for (const auto& key : keyframes) at.push_back(key.frame);
    weights = KeyframeWeights::of_frames(sequence->times, at, options.ends, options.influence);
    // Rotations are of nodes; where sheets meet the topology has more vertices than these.
    const MeshTopology& topology = mesh.topology();
    logs = topology.node_count() == topology.vertex_count() ? followed_logs(turns, topology)
                                                            : followed_logs(turns);
    turns.clear();
  }

  bool unchanged(int frame) const {
    const auto& [from, to] = options.influence;
    return keyframes.empty() || (from && frame <= *from) || (to && frame >= *to);
  }

  void solve_frame(FrameSolver& solver, int frame, Points& result) const {
    Points log;
    interpolate_logs(weights->row(frame), logs, log);
    std::vector<Mat3> R(log.rows());
    for (long v = 0; v < log.rows(); ++v) R[v] = rotation_matrix(log.row(v).transpose());
    FramePlaces places;
    for (const auto& of_handle : motions) places.handles.push_back({of_handle[frame], false});
    solver.reconstruct(sequence->frames[frame], places, R, options.rounds_between);
    result = solver.result().positions;
  }

  const MeshSequence* sequence;
  const TriangleMesh mesh;
  FrameHolds holds;
  SequenceEditOptions options;
  mutable SolverPool all;
  std::map<std::vector<char>, std::unique_ptr<SolverPool>> some;
  std::vector<SequenceKeyframe> keyframes;
  std::vector<std::vector<Mat3>> turns;  // of keyframes, until their logarithms are known
  std::vector<Points> positions, starts, logs;
  std::vector<EstimateReport> reports;
  std::optional<KeyframeWeights> weights;
  std::vector<Trajectory> before, after;
  std::vector<std::vector<RigidMotion>> motions;  // of each handle, of each frame
};

SequenceEditor::SequenceEditor(const MeshSequence& sequence, const TriangleMesh& mesh,
                               FrameHolds holds, const SequenceEditOptions& options)
    : data_(std::make_unique<Data>(sequence, mesh, std::move(holds), options)) {}
SequenceEditor::~SequenceEditor() = default;
SequenceEditor::SequenceEditor(SequenceEditor&&) noexcept = default;
SequenceEditor& SequenceEditor::operator=(SequenceEditor&&) noexcept = default;

void SequenceEditor::set_keyframes(std::vector<SequenceKeyframe> keyframes,
                                   const Progress& progress) {
  Data& d = *data_;
  std::sort(keyframes.begin(), keyframes.end(),
            [](const auto& a, const auto& b) { return a.frame < b.frame; });
  d.forget();
  if (keyframes.empty()) return;
  d.keyframes = std::move(keyframes);
  try {
    d.check_keyframes();
    d.start_from_control_mesh(progress);
    d.solve_keyframes(progress);
    d.follow_handles();
    d.follow_turns();
  } catch (...) {
    d.forget();
    throw;
  }
}

void SequenceEditor::set_motions(std::vector<std::vector<RigidMotion>> motions) {
  Data& d = *data_;
  if (motions.size() != d.motions.size())
    throw InputError("motions of " + std::to_string(motions.size()) + " handles, expected " +
                     std::to_string(d.motions.size()));
  for (const auto& of_handle : motions)
    if (count_of(of_handle) != d.sequence->frame_count())
      throw InputError("motions in " + std::to_string(of_handle.size()) + " frames, expected " +
                       std::to_string(d.sequence->frame_count()));
  d.motions = std::move(motions);
  for (size_t h = 0; h < d.motions.size(); ++h)
    for (int k = 0; k < d.sequence->frame_count(); ++k) {
      const RigidMotion& motion = d.motions[h][k];
      d.after[h].centres.row(k) = motion(d.before[h].centres.row(k).transpose()).transpose();
      d.after[h].turns[k] = motion.turn * d.before[h].turns[k];
    }
}

void SequenceEditor::frames(int first, int last,
                            const std::function<void(int, const Points&)>& take,
                            const Progress& progress) const {
  const Data& d = *data_;
  if (first < 0 || last >= d.sequence->frame_count() || first > last)
    throw InputError("frames " + std::to_string(first + 1) + " to " + std::to_string(last + 1) +
                     ", and the sequence has " + std::to_string(d.sequence->frame_count()));
  std::vector<Points> ahead(kAhead);
  for (int from = first; from <= last; from += kAhead) {
    progress.at("frames", static_cast<double>(from - first) / (last - first + 1));
    const int count = std::min(kAhead, last + 1 - from);
    parallel_parts(count, [&](int k) {
      if (d.unchanged(from + k))
        ahead[k] = d.sequence->frames[from + k];
      else
        d.all.with([&](FrameSolver& solver) { d.solve_frame(solver, from + k, ahead[k]); });
    });
    for (int k = 0; k < count; ++k) take(from + k, ahead[k]);
  }
}

std::vector<Points> SequenceEditor::frames(const Progress& progress) const {
  std::vector<Points> result;
  frames(
      0, data_->sequence->frame_count() - 1, [&](int, const Points& p) { result.push_back(p); },
      progress);
  return result;
}

const std::vector<SequenceKeyframe>& SequenceEditor::keyframes() const { return data_->keyframes; }
const std::vector<Points>& SequenceEditor::keyframe_positions() const { return data_->positions; }
const std::vector<EstimateReport>& SequenceEditor::keyframe_reports() const {
  return data_->reports;
}
const std::vector<Trajectory>& SequenceEditor::trajectories_before() const { return data_->before; }
const std::vector<Trajectory>& SequenceEditor::trajectories() const { return data_->after; }
const std::vector<std::string>& SequenceEditor::notes() const { return data_->all.notes(); }

}  // namespace batten
