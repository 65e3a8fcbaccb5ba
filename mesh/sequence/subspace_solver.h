// Subspace deformation of a frame by a control mesh, as preview or initial shape, and an
// interactive session.
#pragma once

#include <memory>

#include "batten/mesh/sequence/control_mesh.h"
#include "batten/mesh/sequence/frame_solver.h"

namespace batten {

/// Options of SubspaceSolver.
struct SubspaceOptions {
  int iterations = 8;  ///< ARAP iterations of a solve, at least 1
  /// λ of handles and fixed nodes, relative to the mean weight at a node.
  double penalty_weight = 100;
};

/// Subspace ARAP solver. The energy of FrameSolver (with w_ij = 1) is minimised over the vertices d
/// of a control mesh, with v = W d. W are their mean value coordinates in the frame:
///
///     min_d ½ E(W d) + λ Σ_h |(W d)_h - u_h|²
///
/// The few unknowns move the whole mesh smoothly, so a few iterations suffice where the alternation
/// over all nodes needs hundreds. Handles are only soft constraints and features are not rigid. The
/// result is an initial shape for FrameSolver::alternate(), or a preview while that runs.
///
/// Cost: W (see mean_value_coordinates()) and a dense m×m factorization per frame; an iteration
/// costs two products with W. Memory: W, nodes × m. Sources: [Huang2006]; [Xu2007], eq. 6.
class SubspaceSolver {
 public:
  /// Throws InputError: a control mesh that is not closed, options out of range, no constraints.
  SubspaceSolver(const TriangleMesh& mesh, FrameConstraints constraints, TriangleMesh control,
                 const SubspaceOptions& options = {});
  ~SubspaceSolver();
  SubspaceSolver(SubspaceSolver&&) noexcept;
  SubspaceSolver& operator=(SubspaceSolver&&) noexcept;

  /// Sets the frame to be edited and the control vertices for it. Throws NoSolutionError.
  void set_frame(const Points& frame, const Points& control);
  /// Positions of all nodes for given handle targets. Requires set_frame(). Throws InputError if
  /// the number of targets is wrong.
  const Points& solve(const FrameTargets& targets);
  /// Control vertices of the last solution.
  const Points& control() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// Interactive editing of one frame: a preview at once, refinement on demand.

/// Interactive session for a keyframe. solve_preview() moves the few vertices of a control mesh and
/// with them the whole shape smoothly. refine() continues with the ARAP iteration over all nodes.
/// It removes folds caused by the control mesh and satisfies handles and features exactly.
///
///     FrameSession session(mesh, constraints, control_mesh(mesh));
///     session.set_frame(frame);
///     show(session.solve_preview(targets));                   // at every mouse event
///     while (!session.refine(5)) show(session.positions());   // when the mouse rests
///
/// Cost: set_frame() as SubspaceSolver::set_frame(); solve_preview() 10 to 50 ms for 10,000 nodes;
/// 2 to 3 ms per iteration of refine().
class FrameSession {
 public:
  /// `control`: control mesh around `mesh` in its given shape. Throws like FrameSolver and
  /// SubspaceSolver.
  FrameSession(const TriangleMesh& mesh, FrameConstraints constraints, TriangleMesh control,
               const FrameOptions& frames = {}, const SubspaceOptions& subspace = {});
  ~FrameSession();

  /// Sets the frame to be edited; ControlMeshTransfer moves the control mesh along. Throws
  /// InputError if the number of nodes differs.
  void set_frame(const Points& frame);
  /// Solves in the subspace. Requires set_frame(). Throws InputError and ConflictError.
  const Points& solve_preview(const FrameTargets& targets);
  /// Performs up to `iterations` ARAP iterations. Requires solve_preview(). Returns true if
  /// converged.
  bool refine(int iterations);
  const Points& positions() const;
  const IterationReport& report() const;  ///< of refine()

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
