// Edits that go through all frames of a sequence.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/frame_solver.h"
#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/subspace_solver.h"

namespace batten {

/// A frame in which at least one handle is told where to be.
struct SequenceKeyframe {
  int frame = 0;  ///< from 0
  /// One for each handle; none: the handle goes where this frame takes it.
  std::vector<std::optional<HandlePose>> handles;
};

struct SequenceEditOptions {
  FrameOptions frames;
  enum class Start {
    Handles,   ///< the handles' turns, spread
    Subspace,  ///< few vertices of a control mesh around the first frame, following it
    Neighbour  ///< the keyframe before: for keyframes close to each other
  } start = Start::Handles;
  ControlMeshOptions control;  ///< for Subspace
  TrajectoryOptions::Smoothness trajectories = TrajectoryOptions::Smoothness::Smooth;
  KeyframeExtrapolation ends = KeyframeExtrapolation::None;
  InfluenceInterval influence;  ///< frames outside stay as they are, to the last bit
  int iterations_between = 0;   ///< of the alternation, in every frame after its linear step
};

/// Xu et al. 2007, section 5: over all frames k at once
///
///     Σ_k Σ_i ‖L v_i^k - R_i^k δ_i^k‖² + Σ_k Σ_i ‖ΔR_i^k‖² + Σ_k ‖C V^k - U^k‖²               (4)
///
/// solved in the paper's order, each step by its own class:
///   1. control meshes of all frames                    ControlMeshTransfer (Start::Subspace only)
///   2. keyframes by alternation                        FrameSolver::alternate
///   3. rotations of all nodes in all frames            KeyframeWeights, interpolate_logs
///   4. handles in all frames, each moving rigidly      edited (handle_trajectory.h)
///   5. all frames, one linear step each                FrameSolver::reconstruct
///
/// In step 2 only the handles told at a keyframe are held; in step 5 all are. Frames whose keyframes
/// change nothing come back to 1e-14 of the size; without keyframes to the last bit.
///
/// Cost: a factor for each set of handles that are told together and each thread; keyframes and
/// frames in parallel, the same bits on any number of threads. A frame of 10,000 nodes takes 1 to 2
/// ms, a round at a keyframe 2 to 3 ms. Memory beside the sequence: 24 bytes a node and keyframe.
class SequenceEditor {
 public:
  /// Keeps a reference to `sequence`. `mesh`: its first frame (prepare). Throws InputError and
  /// NoSolutionError as FrameSolver.
  SequenceEditor(const MeshSequence& sequence, const TriangleMesh& mesh,
                 FrameConstraints constraints, const SequenceEditOptions& options = {});
  ~SequenceEditor();
  SequenceEditor(SequenceEditor&&) noexcept;
  SequenceEditor& operator=(SequenceEditor&&) noexcept;

  /// Steps 1 to 4. Keyframes in any order. Throws InputError: a frame that is not there or twice, a
  /// keyframe that tells no handle or another number of them, one outside of the influence; what
  /// FrameSolver throws; CancelledError. Then there are no keyframes.
  void set_keyframes(std::vector<SequenceKeyframe> keyframes, const Progress& progress = {});
  /// Motions of each handle in each frame, for step 5 instead of what step 4 interpolates: handles
  /// that are told where to be in all frames do not stray between keyframes. After set_keyframes(),
  /// until the next one. Throws InputError: another number of handles or frames.
  void set_motions(std::vector<std::vector<RigidMotion>> motions);
  /// Step 5 for frames first … last: calls take(frame, positions) in order. Throws what take throws,
  /// CancelledError.
  void frames(int first, int last, const std::function<void(int, const Points&)>& take,
              const Progress& progress = {}) const;
  /// All of them.
  std::vector<Points> frames(const Progress& progress = {}) const;

  /// The keyframes in order, their shapes after step 2, and how the alternation went.
  const std::vector<SequenceKeyframe>& keyframes() const;
  const std::vector<Points>& keyframe_positions() const;
  const std::vector<IterationReport>& keyframe_reports() const;
  /// Of each handle, in the sequence and after step 4.
  const std::vector<Trajectory>& trajectories_before() const;
  const std::vector<Trajectory>& trajectories() const;
  const std::vector<std::string>& notes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
