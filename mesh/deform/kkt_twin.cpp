// The saddle point twin, apart from the deformer so that they share only the statement.
#include "batten/constraints/affine_reduction.h"
#include "batten/mesh/deform/form_feature_deformer.h"

namespace batten {

Points deform_by_kkt(FormFeatureDeformer& deformer, const DeformEdit& edit) {
  const FormFeatureDeformer::Statement s = deformer.statement(edit);
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
