// The saddle point twin of the reduction, apart from it so that they share no code.
#include <Eigen/SparseLU>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/errors.h"

namespace batten {

Points solve_kkt(const ConstraintSet& set, const SparseMatrix& K, const Points& F) {
  const int n = set.dof_count();
  const int rows =
      3 * static_cast<int>(set.rows().size()) + static_cast<int>(set.coupled_rows().size());
  std::vector<Triplet> entries;
  VecX right(3 * n + rows);
  const auto both = [&](int i, int j, double v) {
    entries.emplace_back(i, j, v);
    if (i != j) entries.emplace_back(j, i, v);
  };
  for (int c = 0; c < 3; ++c) {
    right.segment(c * n, n) = F.col(c);
    for (int j = 0; j < K.outerSize(); ++j)
      for (SparseMatrix::InnerIterator it(K, j); it; ++it)
        if (it.row() >= j) both(c * n + static_cast<int>(it.row()), c * n + j, it.value());
  }
  int row = 3 * n;
  for (const auto& r : set.rows())
    for (int c = 0; c < 3; ++c, ++row) {
      for (const auto& e : r.entries) both(row, c * n + e.dof, e.coefficient);
      right[row] = r.value[c];
    }
  for (const auto& r : set.coupled_rows()) {
    for (const auto& e : r.entries)
      for (int c = 0; c < 3; ++c)
        if (e.coefficient[c] != 0) both(row, c * n + e.dof, e.coefficient[c]);
    right[row++] = r.value;
  }
  SparseMatrix A(3 * n + rows, 3 * n + rows);
  A.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<SparseMatrix> lu(A);
  if (lu.info() != Eigen::Success)
    throw NoSolutionError("the saddle point system is singular: " + lu.lastErrorMessage());
  const VecX x = lu.solve(right);
  return Eigen::Map<const Points>(x.data(), n, 3);
}

}  // namespace batten
