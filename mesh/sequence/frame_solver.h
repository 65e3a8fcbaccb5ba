// As-rigid-as-possible (ARAP) deformation of one frame of a sequence.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/sequence/frame_constraints.h"

namespace batten {

struct FrameSolverData;

/// ARAP deformation of single frames. Let p be the positions of a frame and v those after the edit.
/// The energy
///
///     E = Σ_i Σ_{j∈N(i)} w_ij |(v_j - v_i) - R_i (p_j - p_i)|²  (+ λ Σ_{handles} |v_h - u_h|²)
///
/// is minimised by local/global alternation. The local step fits the rotations,
/// R_i = nearest_rotation(Σ_j w_ij (v_j - v_i)(p_j - p_i)ᵀ). The global step solves a linear system
/// for the positions. Its matrix depends only on w_ij and on the set of constrained nodes, so it is
/// factored once for all iterations and frames. E never increases. Iterates are combined by
/// Anderson acceleration if that lowers E. One-rings consist of edges between nodes, so patches
/// that meet are connected and non-manifold edges do no harm.
///
/// A feature is one rigid part. Its rotation is the exact minimum over all edges that leave it, and
/// its centre gives three unknowns. Handles with free rotation find their rotation in the same way.
/// Features that share nodes are one part. Features that share nodes with a handle move with it;
/// those with a fixed node stay. Parts of the mesh without constraints stay.
///
/// `preserve_volume`: after each global step, one Lagrange multiplier along the volume gradient is
/// determined by Newton's method. E may increase until the volume is reached.
///
/// Cost: one factorization at construction; 2 to 3 ms per iteration for 10,000 nodes. Memory: the
/// factor, some 50 numbers per node. A solver must not be used by several threads at once; it uses
/// several threads itself. Sources: [Xu2007], eq. 1 to 3; [SorkineAlexa2007].
class FrameSolver {
 public:
  /// `mesh`: connectivity, and positions for cotangent weights. Throws InputError (see check() in
  /// deform_problem.h; a penalty weight not above 0; volume preservation for a surface that is not
  /// closed) or NoSolutionError (the factorization fails).
  FrameSolver(const TriangleMesh& mesh, FrameConstraints constraints,
              const FrameOptions& options = {});
  ~FrameSolver();
  FrameSolver(FrameSolver&&) noexcept;
  FrameSolver& operator=(FrameSolver&&) noexcept;

  /// Iterates to convergence; the result is in result(). The initial shape is the frame with
  /// interpolated handle rotations (their logarithms are harmonic). Throws InputError (missing or
  /// non-finite numbers, a wrong number of points) or ConflictError (two handles prescribe
  /// different positions of a node).
  void alternate(const Points& frame, const FrameTargets& targets);
  /// The same from initial positions, such as those of a neighbouring frame, of a coarser solution,
  /// or of the drag so far.
  void alternate(const Points& frame, const FrameTargets& targets, const Points& start);
  /// Continues from the current shape for at most `iterations` iterations, for example to display
  /// shapes during a drag. Throws InputError before the first alternate() or reconstruct(). Returns
  /// true if the iteration has converged.
  bool iterate(int iterations);
  /// First performs a global step with the given rotations, one per node, without a local step; then
  /// `iterations` full iterations. Parts with free rotation start with the mean rotation of their
  /// nodes.
  void reconstruct(const Points& frame, const FrameTargets& targets,
                   const std::vector<Mat3>& rotations, int iterations = 0);

  const FrameShape& result() const;
  const IterationReport& report() const;
  int unknowns() const;  ///< number of unknowns per coordinate
  /// Number of nonzeros of the Cholesky factor.
  long factor_entries() const;
  /// Notes in plain sentences about parts of the mesh without constraints.
  const std::vector<std::string>& notes() const;

 private:
  std::unique_ptr<FrameSolverData> data_;
};

}  // namespace batten
