// SPDX-License-Identifier: MPL-2.0
// Keyframe editing of mesh sequences: edits of single frames are propagated to all frames.
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
  /// Pose of each handle in this frame; an empty entry means that the handle is unconstrained.
  std::vector<std::optional<HandlePose>> handles;
};

/// Options of SequenceEditor.
struct SequenceEditOptions {
  FrameOptions frames;
  enum class Start {
    Handles,  ///< iterations start from interpolated handle rotations
    /// Iterations start from the solution of a SubspaceSolver. The control mesh is created for the
    /// first frame and transferred to the keyframes.
    Subspace,
    Neighbour  ///< iterations start from the previous keyframe; for closely spaced keyframes
  } start = Start::Handles;
  ControlMeshOptions control;  ///< control mesh for Start::Subspace
  TrajectoryOptions::Smoothness trajectories = TrajectoryOptions::Smoothness::Smooth;
  KeyframeExtrapolation ends = KeyframeExtrapolation::None;
  InfluenceInterval influence;  ///< frames outside this interval remain bit-identical
  int iterations_between = 0;   ///< number of ARAP iterations in every frame after its linear solve
};

/// Editor for mesh sequences by keyframes [Xu2007], section 5. It minimises the sum over all frames
/// k
///
///     Σ_k Σ_i ‖L v_i^k - R_i^k δ_i^k‖² + Σ_k Σ_i ‖ΔR_i^k‖² + Σ_k ‖C V^k - U^k‖²               (4)
///
/// where L is the graph Laplacian, v_i^k are the positions of node i in the edited frame k, R_i^k
/// its rotations, δ_i^k its Laplacian vectors in the original frame, ΔR_i^k the differences of
/// rotations in time, and C V^k = U^k the handle constraints. The minimisation follows the steps of
/// the paper, each of which is implemented by a class or function:
///   1. control meshes of all frames                    ControlMeshTransfer (Start::Subspace only)
///   2. shapes of the keyframes by iteration            FrameSolver::alternate
///   3. rotations of all nodes in all frames            KeyframeWeights, interpolate_logs
///   4. rigid motions of handles in all frames          edited (handle_trajectory.h)
///   5. all frames, one linear step each                FrameSolver::reconstruct
///
/// In step 2 only the handles prescribed in the keyframe are constrained, in step 5 all handles. If
/// the keyframes change nothing, the frames are reproduced to 1e-14 of the mesh size; without
/// keyframes the result is bit-identical to the input.
///
/// Cost: one factorization per thread and per set of handles that are prescribed in the same
/// keyframe. Keyframes and frames are processed in parallel, with bit-identical results for any
/// number of threads. For 10,000 nodes a frame takes 1 to 2 ms, an iteration at a keyframe 2 to 3
/// ms. Additional memory: 24 bytes per node and keyframe.
class SequenceEditor {
 public:
  /// Creates an editor without keyframes. Keeps a reference to `sequence`. `mesh`: first frame of
  /// the sequence, converted by prepare(). Throws InputError and NoSolutionError like the
  /// constructor of FrameSolver.
  SequenceEditor(const MeshSequence& sequence, const TriangleMesh& mesh,
                 FrameConstraints constraints, const SequenceEditOptions& options = {});
  ~SequenceEditor();
  SequenceEditor(SequenceEditor&&) noexcept;
  SequenceEditor& operator=(SequenceEditor&&) noexcept;

  /// Sets the keyframes, in any order, and computes their shapes and the motions of handles in all
  /// frames (steps 1 to 4 of the class comment). Throws InputError if a frame is out of range or
  /// repeated, a keyframe prescribes no handle or has a wrong number of entries, or a keyframe is
  /// outside the influence interval. Throws the exceptions of FrameSolver, and CancelledError.
  /// After an exception, the editor has no keyframes.
  void set_keyframes(std::vector<SequenceKeyframe> keyframes, const Progress& progress = {});
  /// Replaces the handle motions that were interpolated between keyframes, so that handles with
  /// known poses in all frames do not deviate from them between keyframes. `motions`: one motion
  /// per frame for each handle. Call this function after set_keyframes(); the next call of
  /// set_keyframes() discards the motions. Throws InputError if the number of handles or frames is
  /// wrong.
  void set_motions(std::vector<std::vector<RigidMotion>> motions);
  /// Computes the node positions of the edited frames `first` … `last` (0-based), and calls
  /// take(frame, positions) for each of these frames in ascending order. Throws InputError if a
  /// frame is out of range, the exceptions of `take`, and CancelledError.
  void frames(int first, int last, const std::function<void(int, const Points&)>& take,
              const Progress& progress = {}) const;
  /// Computes the node positions of all edited frames.
  std::vector<Points> frames(const Progress& progress = {}) const;

  /// The keyframes, sorted by frame.
  const std::vector<SequenceKeyframe>& keyframes() const;
  /// Computed node positions of each keyframe, sorted by frame.
  const std::vector<Points>& keyframe_positions() const;
  /// Convergence data of the iteration at each keyframe, sorted by frame.
  const std::vector<IterationReport>& keyframe_reports() const;
  /// Trajectory of each handle in the original sequence.
  const std::vector<Trajectory>& trajectories_before() const;
  /// Trajectory of each handle in the edited sequence.
  const std::vector<Trajectory>& trajectories() const;
  /// Messages for the user about parts of the mesh that do not move, because they have no
  /// constraints.
  const std::vector<std::string>& notes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
