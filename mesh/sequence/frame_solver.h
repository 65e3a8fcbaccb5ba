// SPDX-License-Identifier: MPL-2.0
// As-rigid-as-possible (ARAP) deformation of one frame of a sequence.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/mesh/regions/local_global_iteration.h"
#include "batten/mesh/sequence/frame_constraints.h"

namespace batten {

struct FrameSolverData;

/// ARAP deformation of single frames of a sequence. Let p_i be the node positions of a frame and
/// v_i the positions after the edit. The energy
///
///     E = Σ_i Σ_{j∈N(i)} w_ij |(v_j - v_i) - R_i (p_j - p_i)|²  (+ λ Σ_{handles} |v_h - u_h|²)
///
/// is minimised by LocalGlobalIteration. N(i) is the one-ring of node i, w_ij are the weights of
/// FrameOptions, λ is the penalty weight and u_h the target of a handle node. The local step fits
/// the rotations, R_i = nearest_rotation(Σ_j w_ij (v_j - v_i)(p_j - p_i)ᵀ). The global step solves
/// a linear system for the positions. Its matrix depends only on w_ij and on the set of constrained
/// nodes, so it is factored once for all iterations and frames. E never increases. One-rings
/// consist of edges between nodes, so patches that meet are connected and non-manifold edges do no
/// harm.
///
/// A feature moves as one rigid body. Its rotation minimises the energy of all edges between the
/// feature and other nodes, and its centre adds three unknowns. The rotations of handles with free
/// rotation are computed in the same way. Features that share nodes move as one body. Features that
/// share nodes with a handle move with the handle, and features with a fixed node do not move.
/// Parts of the mesh without constraints do not move.
///
/// If FrameConstraints::preserve_volume is set, Newton's method determines one Lagrange multiplier
/// along the volume gradient after each global step. E may increase until the volume is reached.
///
/// Cost: one factorization at construction; 2 to 3 ms per iteration for 10,000 nodes. Memory: the
/// factor and about 50 numbers per node. A solver is not thread-safe; it uses several threads
/// itself. References: [Xu2007], eq. 1 to 3; [SorkineAlexa2007].
class FrameSolver {
 public:
  /// Sets up and factors the linear system. `mesh`: provides the connectivity, and the positions
  /// for cotangent weights. Throws InputError if check() rejects the constraints
  /// (deform_problem.h), the penalty weight is not above 0, or the volume of a surface that is not
  /// closed must be preserved. Throws NoSolutionError if the factorization fails.
  FrameSolver(const TriangleMesh& mesh, FrameConstraints constraints,
              const FrameOptions& options = {});
  ~FrameSolver();
  FrameSolver(FrameSolver&&) noexcept;
  FrameSolver& operator=(FrameSolver&&) noexcept;

  /// Computes the edited shape of a frame by iteration to convergence; see result(). The initial
  /// rotations interpolate the rotation vectors of the handles harmonically. Throws InputError if
  /// numbers are missing or not finite or the number of points is wrong, and ConflictError if two
  /// handles prescribe different positions of a node.
  void alternate(const Points& frame, const FrameTargets& targets);
  /// Computes the edited shape of a frame by iteration, starting from given node positions `start`
  /// (nodes × 3), for example the solution of a neighbouring frame or the previous shape of a drag.
  void alternate(const Points& frame, const FrameTargets& targets, const Points& start);
  /// Continues from the current shape with at most `iterations` iterations, for example to display
  /// intermediate shapes. Returns true if the iteration has converged. Throws InputError if neither
  /// alternate() nor reconstruct() has been called before.
  bool iterate(int iterations);
  /// Reconstructs the shape of a frame from given rotations, one per node, by one linear solve for
  /// the positions, and then performs `iterations` iterations. Features and handles with free
  /// rotation start with the mean rotation of their nodes.
  void reconstruct(const Points& frame, const FrameTargets& targets,
                   const std::vector<Mat3>& rotations, int iterations = 0);

  const FrameShape& result() const;
  const IterationReport& report() const;
  int unknowns() const;  ///< number of unknowns of the linear system per coordinate
  /// Number of nonzeros of the Cholesky factor of the system matrix.
  long factor_entries() const;
  /// Messages for the user about parts of the mesh that do not move, because they have no
  /// constraints.
  const std::vector<std::string>& notes() const;

 private:
  std::unique_ptr<FrameSolverData> data_;
};

}  // namespace batten
