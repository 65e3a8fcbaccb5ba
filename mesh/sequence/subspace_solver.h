// A first shape of a frame from a few control vertices.
#pragma once

#include <memory>

#include "batten/mesh/sequence/control_mesh.h"
#include "batten/mesh/sequence/frame_solver.h"

namespace batten {

struct SubspaceOptions {
  int iterations = 8;
  double penalty_weight = 100;  ///< λ of handles and fixed nodes, in the mean weight at a node
};

/// The energy of FrameSolver (w_ij = 1), minimised over the vertices d of a control mesh with v = W
/// d, W their mean value coordinates in the frame:
///
///     min_d ½ E(W d) + λ Σ_h |(W d)_h - u_h|²
///
/// Few unknowns move the whole mesh smoothly, so a few rounds get where the alternation over all
/// nodes needs hundreds. Handles are only drawn to their places, features are not rigid: a start for
/// FrameSolver::alternate, or a shape to be shown while that runs.
///
/// Cost: W (mean_value_coordinates) and a dense m×m factor a frame; a round is two products with W.
/// Memory: W, nodes × m. Source: Huang et al. 2006; Xu et al. 2007, eq. 6.
class SubspaceSolver {
 public:
  /// Throws InputError: a control mesh that is not closed, options out of range, nothing held.
  SubspaceSolver(const TriangleMesh& mesh, FrameConstraints constraints, TriangleMesh control,
                 const SubspaceOptions& options = {});
  ~SubspaceSolver();
  SubspaceSolver(SubspaceSolver&&) noexcept;
  SubspaceSolver& operator=(SubspaceSolver&&) noexcept;

  /// The frame that is edited, and the control vertices there. NoSolutionError.
  void set_frame(const Points& frame, const Points& control);
  /// All nodes for these places. Needs a frame. Throws InputError on another number of places.
  const Points& solve(const FrameTargets& targets);
  /// Control vertices of the last answer.
  const Points& control() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};


// One frame edited live: an answer at once, better ones on demand.

/// A keyframe under the mouse. solve_preview() moves few vertices of a control mesh and so the whole shape
/// smoothly; refine() goes on from there with the alternation over all nodes, which repairs what the
/// control mesh folded, and holds handles and features exactly.
///
///     FrameSession session(mesh, holds, control_mesh(mesh));
///     session.set_frame(frame);
///     show(session.solve_preview(places));            // at every event of the mouse
///     while (!session.refine(5)) show(session.positions());   // when it rests
///
/// Cost: set_frame() as SubspaceSolver's; solve_preview() 10 to 50 ms on 10,000 nodes; a round of refine() 2
/// to 3 ms.
class FrameSession {
 public:
  /// `control`: around `mesh`, in its own shape. Throws as FrameSolver and SubspaceSolver.
  FrameSession(const TriangleMesh& mesh, FrameConstraints constraints, TriangleMesh control,
               const FrameOptions& frames = {}, const SubspaceOptions& subspace = {});
  ~FrameSession();

  /// The control mesh goes along as ControlMeshTransfer says. Throws InputError on another number of
  /// nodes.
  void set_frame(const Points& frame);
  /// Needs a frame. Throws InputError, ConflictError.
  const Points& solve_preview(const FrameTargets& targets);
  /// Needs an answer. Returns whether the shape is at rest.
  bool refine(int iterations);
  const Points& positions() const;
  const IterationReport& report() const;  ///< of the refinement

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
