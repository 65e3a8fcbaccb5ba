// SPDX-License-Identifier: MPL-2.0
// The smooth rotation field of a mesh deformation.
#pragma once

#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/deform/deform_system.h"

namespace batten {

/// The rotation field that rotates the curvature vectors. The logarithms of the rotations are
/// harmonic and linear in the handle rotations. The weights of each handle are therefore computed
/// once, and an edit needs no solve.
class RotationField {
 public:
  RotationField(const DeformSystem& system, long handles);

  /// Computes the weights with one factorization. Throws NoSolutionError.
  void solve_weights(const DeformSystem& system, const TriangleMesh& mesh);

  /// Logarithms for an edit (dofs × 3), Σ weights · handle rotations. Does not allocate. Throws
  /// ConflictError if redundant rows contradict each other.
  void evaluate(const DeformSystem& system, const DeformEdit& edit, Points& logs);

  /// Modifies the logs of evaluate(): given dofs, and all that rotate with them, get prescribed
  /// values, and the rest is harmonic in between. Costs one factorization per set of dofs. Values
  /// from handles and fixed vertices are unchanged. Throws NoSolutionError.
  void prescribe(const DeformSystem& system, const TriangleMesh& mesh,
                 const std::vector<std::pair<int, Vec3>>& given, Points& logs);

  /// Rates of the logarithms for rates of the handle rotations (handles × 3).
  Points rates(const MatX& handle_rates) const { return weights_ * handle_rates; }
  /// Transpose of rates(): handles × 3.
  MatX transposed_rates(const Points& logs) const { return weights_.transpose() * logs; }

  /// True if no handle rotated in the last edit.
  bool is_identity() const { return handle_rotations_.isZero(0); }

 private:
  void factorize_free(const DeformSystem& system, const TriangleMesh& mesh,
                      std::vector<int> prescribed);

  AffineReduction reduction_;
  MatX weights_;           // dofs × handles
  MatX handle_rotations_;  // handles × 3
  MatX rhs_;               // right-hand sides of the rows
  // Data of prescribe(): the unknown of each dof (rotations are only equated), or -1; the prescribed
  // unknowns; the index of each unknown among the others, or -1 minus its index in prescribed_; the
  // factor of the Laplacian of the others, and its negative coupling with the prescribed ones.
  std::vector<int> unknown_of_dof_, prescribed_, index_;
  SparseMatrix coupling_;
  SparseCholesky free_factor_;
  MatX change_, load_;
};

}  // namespace batten
