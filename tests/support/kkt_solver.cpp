// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/kkt_solver.h"

#include <Eigen/SparseLU>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {

Points solve_kkt(const ConstraintSet& set, const SparseMatrix& K, const Points& F) {
  // x, y and z are one system each unless a constraint couples them; then they are stacked.
  const int n = set.dof_count();
  const int copies = set.coupled() ? 3 : 1;
  const auto rows = isize(set.constraints());
  const int size = copies * (n + rows) + isize(set.coupled_constraints());
  std::vector<Triplet> entries;
  MatX rhs(size, set.coupled() ? 1 : 3);
  const auto both = [&](int i, int j, double v) {
    entries.emplace_back(i, j, v);
    if (i != j) entries.emplace_back(j, i, v);
  };
  int row = copies * n;
  const bool stacked = K.cols() == 3 * n && set.coupled();
  for (int c = 0; c < copies; ++c) {
    for (int j = 0; j < K.outerSize() && !(stacked && c > 0); ++j)
      for (SparseMatrix::InnerIterator it(K, j); it; ++it)
        if (it.row() >= j) both(c * n + static_cast<int>(it.row()), c * n + j, it.value());
    for (const auto& r : set.constraints()) {
      for (const auto& e : r.entries) both(row, c * n + e.dof, e.coefficient);
      if (set.coupled())
        rhs(row, 0) = r.value[c];
      else
        rhs.row(row) = r.value;
      ++row;
    }
  }
  if (set.coupled())
    rhs.topRows(3 * n) = Eigen::Map<const VecX>(F.data(), F.size());
  else
    rhs.topRows(n) = F;
  for (const auto& r : set.coupled_constraints()) {
    for (const auto& e : r.entries)
      for (int c = 0; c < 3; ++c)
        if (e.coefficient[c] != 0) both(row, c * n + e.dof, e.coefficient[c]);
    rhs(row++, 0) = r.value;
  }
  SparseMatrix A(size, size);
  A.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<SparseMatrix> lu(A);
  if (lu.info() != Eigen::Success)
    throw NoSolutionError("the saddle point system is singular: " + lu.lastErrorMessage());
  MatX x = lu.solve(rhs);
  // Positions and multipliers differ by orders of magnitude: one step of refinement.
  x += lu.solve(MatX(rhs - A * x));
  if (!set.coupled()) return x.topRows(n);
  return Eigen::Map<const Points>(x.data(), n, 3);
}

}  // namespace batten
