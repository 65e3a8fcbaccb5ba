// Keyframe edits that are propagated through all frames of a sequence.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/frame_solver.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/subspace_solver.h"
#include "batten/mesh/sequence/trajectories/handle_trajectory.h"

namespace batten {

/// A keyframe: a frame in which the pose of at least one handle is prescribed.
struct SequenceKeyframe {
  int frame = 0;  ///< 0-based
  /// One per handle. Empty: the handle is unconstrained in this keyframe and moves with the
  /// solution.
  std::vector<std::optional<HandlePose>> handles;
};

/// Options of SequenceEditor.
struct SequenceEditOptions {
  FrameOptions frames;
  enum class Start {
    Handles,  ///< start from the interpolated rotations of the handles
    /// Start from a subspace solution with a control mesh around the first frame that follows the
    /// frames.
    Subspace,
    Neighbour  ///< start from the previous keyframe; for keyframes close to each other
  } start = Start::Handles;
  ControlMeshOptions control;  ///< for Start::Subspace
  TrajectoryOptions::Smoothness trajectories = TrajectoryOptions::Smoothness::Smooth;
  KeyframeExtrapolation ends = KeyframeExtrapolation::None;
  InfluenceInterval influence;  ///< frames outside it remain bit-identical
  int iterations_between = 0;   ///< ARAP iterations in every frame after its linear step
};

/// Keyframe editing of mesh sequences [Xu2007], section 5. Over all frames k, it minimises
///
///     Σ_k Σ_i ‖L v_i^k - R_i^k δ_i^k‖² + Σ_k Σ_i ‖ΔR_i^k‖² + Σ_k ‖C V^k - U^k‖²               (4)
///
/// in the order of the paper; each step has its own class or function:
///   1. control meshes of all frames                    ControlMeshTransfer (Start::Subspace only)
///   2. keyframes by alternation                        FrameSolver::alternate
///   3. rotations of all nodes in all frames            KeyframeWeights, interpolate_logs
///   4. handles in all frames, each moving rigidly      edited (handle_trajectory.h)
///   5. all frames, one linear step each                FrameSolver::reconstruct
///
/// In step 2 only the handles prescribed at a keyframe are constrained, in step 5 all of them.
/// Frames whose keyframes change nothing are reproduced to 1e-14 of the size; without keyframes
/// they are bit-identical.
///
/// Cost: one factorization per set of handles that occur together in keyframes, and per thread.
/// Keyframes and frames are processed in parallel, with bit-identical results for any number of
/// threads. For 10,000 nodes a frame takes 1 to 2 ms, an iteration at a keyframe 2 to 3 ms. Memory
/// besides the sequence: 24 bytes per node and keyframe.
class SequenceEditor {
 public:
  /// Keeps a reference to `sequence`. `mesh`: its first frame, converted by prepare(). Throws
  /// InputError and NoSolutionError like FrameSolver.
  SequenceEditor(const MeshSequence& sequence, const TriangleMesh& mesh,
                 FrameConstraints constraints, const SequenceEditOptions& options = {});
  ~SequenceEditor();
  SequenceEditor(SequenceEditor&&) noexcept;
  SequenceEditor& operator=(SequenceEditor&&) noexcept;

  /// Performs steps 1 to 4. The keyframes may be in any order. Throws InputError (a frame out of
  /// range or repeated; a keyframe with no prescribed handle or a wrong number of handles; a
  /// keyframe outside the influence interval), whatever FrameSolver throws, and CancelledError.
  /// After an exception there are no keyframes.
  void set_keyframes(std::vector<SequenceKeyframe> keyframes, const Progress& progress = {});
  /// Replaces the interpolated handle motions of step 4 by given ones, per handle and frame.
  /// Handles whose poses are known in all frames then do not deviate between keyframes. Call it
  /// after set_keyframes(), whose next call discards the motions. Throws InputError if the number
  /// of handles or frames differs.
  void set_motions(std::vector<std::vector<RigidMotion>> motions);
  /// Performs step 5 for frames `first` … `last` and calls take(frame, positions) in order. Throws
  /// InputError for frames out of range, whatever `take` throws, and CancelledError.
  void frames(int first, int last, const std::function<void(int, const Points&)>& take,
              const Progress& progress = {}) const;
  /// Performs step 5 for all frames.
  std::vector<Points> frames(const Progress& progress = {}) const;

  /// The keyframes, sorted by frame.
  const std::vector<SequenceKeyframe>& keyframes() const;
  /// Node positions at the keyframes after step 2.
  const std::vector<Points>& keyframe_positions() const;
  /// Convergence of step 2 at the keyframes.
  const std::vector<IterationReport>& keyframe_reports() const;
  /// Trajectory of each handle in the original sequence.
  const std::vector<Trajectory>& trajectories_before() const;
  /// Trajectory of each handle after step 4.
  const std::vector<Trajectory>& trajectories() const;
  /// Notes in plain sentences about parts of the mesh without constraints.
  const std::vector<std::string>& notes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
