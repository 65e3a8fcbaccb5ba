// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/sequence_editor.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/frame_solver.h"

namespace batten {

// Frame solvers for several threads.

/// A pool of equal solvers: one for each thread that needs one at the same time.
class SolverPool {
 public:
  SolverPool(const TriangleMesh& mesh, FrameConstraints constraints, const FrameOptions& options)
      : mesh_(&mesh), constraints_(std::move(constraints)), options_(options) {
    free_.push_back(std::make_unique<FrameSolver>(mesh, constraints_, options_));
    notes_ = free_.front()->notes();
  }
  /// Runs `use` with a solver borrowed exclusively from the pool.
  template <class Use>
  void with(const Use& use) {
    std::unique_ptr<FrameSolver> solver;
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        solver = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!solver) solver = std::make_unique<FrameSolver>(*mesh_, constraints_, options_);
    use(*solver);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(solver));
  }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  const TriangleMesh* mesh_;
  FrameConstraints constraints_;
  FrameOptions options_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<FrameSolver>> free_;
  std::vector<std::string> notes_;
};

namespace {

/// Length of a chain of keyframes that start from each other (Start::Neighbour).
constexpr int kChunkLength = 8;
/// Number of frames solved before they are passed to the callback; more would only use memory.
constexpr int kBatchSize = 16;

std::string frame_name(int frame) { return "frame " + std::to_string(frame + 1); }

}  // namespace

struct SequenceEditor::Data {
  Data(const MeshSequence& s, const TriangleMesh& m, FrameConstraints given,
       const SequenceEditOptions& opts)
      : sequence(&s),
        mesh(m),
        constraints(std::move(given)),
        options(opts),
        full_pool(mesh, constraints, options.frames) {
    for (const Handle& h : constraints.handles)
      before.push_back(trajectory_of(sequence->frames, h.vertices));
    after = before;
  }

  void clear() {
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
        throw InputError("found a keyframe at " + frame_name(key.frame) + ", expected 1 to " +
                         std::to_string(last + 1));
      if (k > 0 && keyframes[k - 1].frame == key.frame)
        throw InputError("found two keyframes at " + frame_name(key.frame) + ", expected one");
      if (key.handles.size() != constraints.handles.size())
        throw InputError("the keyframe at " + frame_name(key.frame) + " prescribes " +
                         std::to_string(key.handles.size()) + " handles, expected " +
                         std::to_string(constraints.handles.size()));
      if (std::none_of(key.handles.begin(), key.handles.end(),
                       [](const auto& pose) { return pose.has_value(); }))
        throw InputError("the keyframe at " + frame_name(key.frame) +
                         " prescribes no handle, expected one or more");
    }
  }

  /// The solvers for the set of handles that a keyframe prescribes.
  SolverPool& pool_for(const std::vector<char>& keyframed) {
    if (std::all_of(keyframed.begin(), keyframed.end(), [](char t) { return t != 0; }))
      return full_pool;
    auto& pool = partial_pools[keyframed];
    if (!pool) {
      FrameConstraints part = constraints;
      part.handles.clear();
      for (size_t h = 0; h < keyframed.size(); ++h)
        if (keyframed[h]) part.handles.push_back(constraints.handles[h]);
      pool = std::make_unique<SolverPool>(mesh, std::move(part), options.frames);
    }
    return *pool;
  }

  static std::vector<char> keyframe_mask(const SequenceKeyframe& key) {
    std::vector<char> keyframed;
    for (const auto& pose : key.handles) keyframed.push_back(pose.has_value());
    return keyframed;
  }

  static FrameTargets targets_at(const SequenceKeyframe& key) {
    FrameTargets targets;
    for (const auto& pose : key.handles)
      if (pose) targets.handles.push_back(*pose);
    return targets;
  }

  void solve_keyframes(const Progress& progress) {
    const int count = isize(keyframes);
    rotations.assign(count, {});
    positions.assign(count, Points());
    reports.assign(count, {});
    std::vector<SolverPool*> pools;
    for (const auto& key : keyframes) pools.push_back(&pool_for(keyframe_mask(key)));
    const int chunk_length =
        options.start == SequenceEditOptions::Start::Neighbour ? kChunkLength : 1;
    const int chunk_count = (count + chunk_length - 1) / chunk_length;
    for (int first = 0; first < chunk_count; first += kBatchSize) {
      progress.update("keyframes", static_cast<double>(first) / chunk_count);
      const int last = std::min(chunk_count, first + kBatchSize);
      parallel_for(last - first, [&](int r) {
        const int from = (first + r) * chunk_length;
        for (int k = from; k < std::min(count, from + chunk_length); ++k)
          pools[k]->with([&](FrameSolver& solver) { solve_keyframe(solver, k, k > from); });
      });
    }
  }

  void solve_keyframe(FrameSolver& solver, int k, bool has_neighbour) {
    const Points& frame = sequence->frames[keyframes[k].frame];
    const FrameTargets targets = targets_at(keyframes[k]);
    if (has_neighbour) {
      solver.reconstruct(frame, targets, rotations[k - 1], options.frames.max_iterations);
    } else if (!starts.empty()) {
      solver.alternate(frame, targets, starts[k]);
    } else {
      solver.alternate(frame, targets);
    }
    rotations[k] = solver.result().rotations;
    positions[k] = solver.result().positions;
    reports[k] = solver.report();
  }

  // Step 1 and the subspace solutions. Frames are processed one by one, since W is large.
  void start_from_control_mesh(const Progress& progress) {
    starts.clear();
    if (options.start != SequenceEditOptions::Start::Subspace) return;
    const TriangleMesh control = control_mesh(mesh, options.control);
    const Points& first = sequence->frames.front();
    const ControlMeshTransfer transfer(mesh, control.points(),
                                       mean_value_coordinates(control, first));
    std::map<std::vector<char>, std::unique_ptr<SubspaceSolver>> solvers;
    for (size_t k = 0; k < keyframes.size(); ++k) {
      progress.update("control meshes",
                      static_cast<double>(k) / static_cast<double>(keyframes.size()));
      const auto keyframed = keyframe_mask(keyframes[k]);
      auto& solver = solvers[keyframed];
      if (!solver) {
        FrameConstraints part = constraints;
        part.handles.clear();
        for (size_t h = 0; h < keyframed.size(); ++h)
          if (keyframed[h]) part.handles.push_back(constraints.handles[h]);
        solver = std::make_unique<SubspaceSolver>(mesh, std::move(part), control);
      }
      const Points& frame = sequence->frames[keyframes[k].frame];
      solver->set_frame(frame, transfer.at(frame));
      starts.push_back(solver->solve(targets_at(keyframes[k])));
    }
  }

  void interpolate_handles() {
    TrajectoryOptions trajectory;
    trajectory.smoothness = options.trajectories;
    trajectory.influence = options.influence;
    trajectory.ends = options.ends;
    trajectory.times = sequence->times;
    motions.clear();
    for (size_t h = 0; h < constraints.handles.size(); ++h) {
      std::vector<HandleKeyframe> keys;
      for (size_t k = 0; k < keyframes.size(); ++k)
        keys.push_back({keyframes[k].frame, motion_at(k, h)});
      after[h] = edited(before[h], keys, trajectory);
      motions.push_back(motions_between(before[h], after[h]));
    }
  }

  // The prescribed motion of a handle, or the fitted one if it is not prescribed exactly.
  RigidMotion motion_at(size_t k, size_t h) const {
    const auto& pose = keyframes[k].handles[h];
    if (pose && !pose->free_rotation && !constraints.penalty_weight) return pose->motion;
    const Similarity s = fit_similarity(sequence->frames[keyframes[k].frame], positions[k],
                                        constraints.handles[h].vertices, 1.0);
    return {s.R, s.translation};
  }

  void interpolate_rotations() {
    std::vector<int> at;
    for (const auto& key : keyframes) at.push_back(key.frame);
    weights = KeyframeWeights::of_frames(sequence->times, at, options.ends, options.influence);
    // Rotations are per node; if patches meet, the topology has more vertices than nodes.
    const MeshTopology& topology = mesh.topology();
    logs = topology.node_count() == topology.vertex_count() ? unwrapped_logs(rotations, topology)
                                                            : unwrapped_logs(rotations);
    rotations.clear();
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
    FrameTargets targets;
    for (const auto& of_handle : motions) targets.handles.push_back({of_handle[frame], false});
    solver.reconstruct(sequence->frames[frame], targets, R, options.iterations_between);
    result = solver.result().positions;
  }

  const MeshSequence* sequence;
  const TriangleMesh mesh;
  FrameConstraints constraints;
  SequenceEditOptions options;
  mutable SolverPool full_pool;
  std::map<std::vector<char>, std::unique_ptr<SolverPool>> partial_pools;
  std::vector<SequenceKeyframe> keyframes;
  std::vector<std::vector<Mat3>> rotations;  // of keyframes, until their logarithms are computed
  std::vector<Points> positions, starts, logs;
  std::vector<IterationReport> reports;
  std::optional<KeyframeWeights> weights;
  std::vector<Trajectory> before, after;
  std::vector<std::vector<RigidMotion>> motions;  // per handle, per frame
};

SequenceEditor::SequenceEditor(const MeshSequence& sequence, const TriangleMesh& mesh,
                               FrameConstraints constraints, const SequenceEditOptions& options)
    : data_(std::make_unique<Data>(sequence, mesh, std::move(constraints), options)) {}
SequenceEditor::~SequenceEditor() = default;
SequenceEditor::SequenceEditor(SequenceEditor&&) noexcept = default;
SequenceEditor& SequenceEditor::operator=(SequenceEditor&&) noexcept = default;

void SequenceEditor::set_keyframes(std::vector<SequenceKeyframe> keyframes,
                                   const Progress& progress) {
  Data& d = *data_;
  std::sort(keyframes.begin(), keyframes.end(),
            [](const auto& a, const auto& b) { return a.frame < b.frame; });
  d.clear();
  if (keyframes.empty()) return;
  d.keyframes = std::move(keyframes);
  try {
    d.check_keyframes();
    d.start_from_control_mesh(progress);
    d.solve_keyframes(progress);
    d.interpolate_handles();
    d.interpolate_rotations();
  } catch (...) {
    d.clear();
    throw;
  }
}

void SequenceEditor::set_motions(std::vector<std::vector<RigidMotion>> motions) {
  Data& d = *data_;
  if (motions.size() != d.motions.size())
    throw InputError("found motions of " + std::to_string(motions.size()) + " handles, expected " +
                     std::to_string(d.motions.size()));
  for (const auto& of_handle : motions)
    if (isize(of_handle) != d.sequence->frame_count())
      throw InputError("found motions in " + std::to_string(of_handle.size()) +
                       " frames, expected " + std::to_string(d.sequence->frame_count()));
  d.motions = std::move(motions);
  for (size_t h = 0; h < d.motions.size(); ++h)
    for (int k = 0; k < d.sequence->frame_count(); ++k) {
      const RigidMotion& motion = d.motions[h][k];
      d.after[h].centres.row(k) = motion(d.before[h].centres.row(k).transpose()).transpose();
      d.after[h].rotations[k] = motion.rotation * d.before[h].rotations[k];
    }
}

void SequenceEditor::frames(int first, int last,
                            const std::function<void(int, const Points&)>& take,
                            const Progress& progress) const {
  const Data& d = *data_;
  if (first < 0 || last >= d.sequence->frame_count() || first > last)
    throw InputError("found frames " + std::to_string(first + 1) + " to " +
                     std::to_string(last + 1) + ", expected frames of 1 to " +
                     std::to_string(d.sequence->frame_count()));
  std::vector<Points> batch(kBatchSize);
  for (int from = first; from <= last; from += kBatchSize) {
    progress.update("frames", static_cast<double>(from - first) / (last - first + 1));
    const int count = std::min(kBatchSize, last + 1 - from);
    parallel_for(count, [&](int k) {
      if (d.unchanged(from + k))
        batch[k] = d.sequence->frames[from + k];
      else
        d.full_pool.with([&](FrameSolver& solver) { d.solve_frame(solver, from + k, batch[k]); });
    });
    for (int k = 0; k < count; ++k) take(from + k, batch[k]);
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
const std::vector<IterationReport>& SequenceEditor::keyframe_reports() const {
  return data_->reports;
}
const std::vector<Trajectory>& SequenceEditor::trajectories_before() const { return data_->before; }
const std::vector<Trajectory>& SequenceEditor::trajectories() const { return data_->after; }
const std::vector<std::string>& SequenceEditor::notes() const { return data_->full_pool.notes(); }

}  // namespace batten
