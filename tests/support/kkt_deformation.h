// SPDX-License-Identifier: MPL-2.0
// KKT reference implementation of the deformer, in a separate file: it shares only the problem's
// matrices.
#pragma once

#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/tests/support/kkt_solver.h"

namespace batten {

/// The same edit by the saddle point system [AᵀA Cᵀ; C 0] (eq. 4), all vertices. Slow: a sparse LU.
inline Points deform_by_kkt(FormFeatureDeformer& deformer, const DeformEdit& edit) {
  const FormFeatureDeformer::ProblemMatrices s = deformer.problem_matrices(edit);
  if (s.vertices.empty()) return deformer.positions();
  const SparseMatrix A = s.A;
  const SparseMatrix transposed = A.transpose();
  const SparseMatrix normal = transposed * A;
  const SparseMatrix lower = normal.triangularView<Eigen::Lower>();
  const Points x = solve_kkt(s.constraints, lower, Points(transposed * s.b));
  Points all = deformer.positions();
  for (size_t k = 0; k < s.vertices.size(); ++k)
    all.row(s.vertices[k]) = x.row(static_cast<long>(k)) + s.origin.transpose();
  return all;
}

}  // namespace batten
