// SPDX-License-Identifier: MPL-2.0
// Subspace deformation of a frame by a control mesh, for previews and initial shapes, and
// interactive sessions for a frame.
#pragma once

#include <memory>

#include "batten/mesh/sequence/control_mesh.h"
#include "batten/mesh/sequence/frame_solver.h"

namespace batten {

/// Options of SubspaceSolver.
struct SubspaceOptions {
  int iterations = 8;  ///< number of ARAP iterations per solve, at least 1
  /// Penalty weight of handles and fixed nodes, which are soft constraints, relative to the mean
  /// number of edges at a node.
  double penalty_weight = 100;
};

/// Subspace ARAP solver. The unknowns are the m vertices d of a control mesh. They move the nodes
/// of the frame to v = W d, where W are the mean value coordinates of the nodes. The solver
/// minimises
///
///     min_d ½ E(W d) + λ Σ_h |(W d)_h - u_h|²
///
/// where E is the ARAP energy of FrameSolver with uniform edge weights, λ is the penalty weight,
/// and u_h is the target of a handle node or fixed node h. Since the few unknowns move the whole
/// mesh smoothly, a few iterations suffice, while FrameSolver may need hundreds. Handles are only
/// soft constraints, and features are not rigid. The result is an initial shape for
/// FrameSolver::alternate(), or a preview during that iteration.
///
/// Cost: mean_value_coordinates() and a dense m×m factorization per frame; two products with W per
/// iteration. Memory: W, nodes × m. References: [Huang2006]; [Xu2007], eq. 6.
class SubspaceSolver {
 public:
  /// Creates a solver for the frames of a sequence. `control`: closed mesh that encloses `mesh`.
  /// Throws InputError if the control mesh is not closed, an option is out of range, or there are
  /// no constraints.
  SubspaceSolver(const TriangleMesh& mesh, FrameConstraints constraints, TriangleMesh control,
                 const SubspaceOptions& options = {});
  ~SubspaceSolver();
  SubspaceSolver(SubspaceSolver&&) noexcept;
  SubspaceSolver& operator=(SubspaceSolver&&) noexcept;

  /// Sets the node positions of the frame to be edited (nodes × 3), and the positions of the
  /// control vertices in this frame. Throws NoSolutionError if the factorization fails.
  void set_frame(const Points& frame, const Points& control);
  /// Computes the positions of all nodes for given handle poses. Requires set_frame(). Throws
  /// InputError if the number of handle poses is wrong.
  const Points& solve(const FrameTargets& targets);
  /// Positions of the control mesh's vertices in the last solution.
  const Points& control() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// Interactive editing of one frame: immediate preview, refinement on demand.

/// Interactive session for editing one frame. solve_preview() deforms the frame smoothly by a
/// control mesh (SubspaceSolver). refine() continues with the ARAP iteration over all nodes
/// (FrameSolver), which removes folds caused by the control mesh and satisfies handles and features
/// exactly.
///
///     FrameSession session(mesh, constraints, control_mesh(mesh));
///     session.set_frame(frame);
///     show(session.solve_preview(targets));                   // at every mouse event
///     while (!session.refine(5)) show(session.positions());   // when the mouse rests
///
/// Cost: set_frame() costs as much as SubspaceSolver::set_frame(). For 10,000 nodes,
/// solve_preview() takes 10 to 50 ms, an iteration of refine() 2 to 3 ms.
class FrameSession {
 public:
  /// `control`: control mesh that encloses `mesh`, see control_mesh(). Throws the exceptions of the
  /// constructors of FrameSolver and SubspaceSolver.
  FrameSession(const TriangleMesh& mesh, FrameConstraints constraints, TriangleMesh control,
               const FrameOptions& frames = {}, const SubspaceOptions& subspace = {});
  ~FrameSession();

  /// Sets the node positions of the frame to be edited (nodes × 3), and transfers the control mesh
  /// to it by ControlMeshTransfer. Throws InputError if the number of nodes is wrong.
  void set_frame(const Points& frame);
  /// Computes the node positions by the subspace solver. Requires set_frame(). Throws InputError
  /// and ConflictError like FrameSolver::alternate().
  const Points& solve_preview(const FrameTargets& targets);
  /// Performs at most `iterations` ARAP iterations over all nodes. Requires solve_preview().
  /// Returns true if the iteration has converged.
  bool refine(int iterations);
  const Points& positions() const;
  const IterationReport& report() const;  ///< convergence data of refine()

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
