// Inside of FormFeatureDeformer: the smooth field of rotations that curvature turns with.
#pragma once

#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/mesh/deform/deform_system.h"

namespace batten {

/// The logarithms of the rotations are harmonic, and linear in the turns of the handles: each
/// handle's weight is solved for once, and an edit costs no solve.
class RotationField {
 public:
  RotationField(const DeformSystem& system, long handles);

  /// Finds the weights: one factor. Throws NoSolutionError.
  void solve_weights(const DeformSystem& system, const TriangleMesh& mesh);

  /// The logarithms of an edit (dofs × 3), Σ weights · turns. Allocates nothing. Throws
  /// ConflictError when rows that are implied by others are contradicted.
  void evaluate(const DeformSystem& system, const DeformEdit& edit, Points& logs);

  /// Changes logs of evaluate() so that given dofs have their own, with all that turns as they do, and
  /// the rest is harmonic between: one factor for one set of dofs. What handles and fixed vertices say
  /// stays. Throws NoSolutionError.
  void prescribe(const DeformSystem& system, const TriangleMesh& mesh,
                 const std::vector<std::pair<int, Vec3>>& given, Points& logs);

  /// Whether no handle turned in the last edit.
  bool is_identity() const { return handle_rotations_.isZero(0); }

 private:
  void factorize_free(const DeformSystem& system, const TriangleMesh& mesh,
                      std::vector<char> prescribed);

  AffineReduction reduction_;
  MatX weights_;           // dofs × handles
  MatX handle_rotations_;  // handles × 3
  MatX rhs_;               // right-hand sides of the rows
  // What passes through given logarithms: which free unknowns are told, the numbers of the others, the
  // reduced Laplacian, the factor of its rest.
  std::vector<char> prescribed_;
  std::vector<int> free_index_;
  SparseMatrix reduced_;
  SparseCholesky free_factor_;
};

}  // namespace batten
