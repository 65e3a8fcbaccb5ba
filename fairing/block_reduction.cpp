#include "batten/fairing/block_reduction.h"

#include "batten/constraints/affine_reduction.h"
#include "batten/core/isize.h"

namespace batten {

BlockReduction::BlockReduction(const ConstraintSet& constraints) {
  const AffineReduction reduction(constraints);
  coupled_ = reduction.coupled();
  d0_ = reduction.d0().reshaped();
  const SparseMatrix& D = reduction.D();
  const int copies = coupled_ ? 1 : 3;
  const int rows = static_cast<int>(D.rows()), columns = static_cast<int>(D.cols());
  std::vector<Triplet> entries;
  entries.reserve(copies * static_cast<size_t>(D.nonZeros()));
  for (int c = 0; c < copies; ++c) {
    for (int j = 0; j < columns; ++j)
      for (SparseMatrix::InnerIterator it(D, j); it; ++it)
        entries.emplace_back(c * rows + static_cast<int>(it.row()), c * columns + j, it.value());
    for (const int dof : reduction.free_dofs()) free_rows_.push_back(c * rows + dof);
  }
  D_.resize(copies * rows, copies * columns);
  D_.setFromTriplets(entries.begin(), entries.end());
}

BlockReduction::BlockReduction(const BlockReduction& all, const Points& start,
                               const std::vector<char>& frozen)
    : coupled_(all.coupled_) {
  const int n = all.dof_count();
  std::vector<char> moves(all.free_count(), 1);
  for (int row = 0; row < 3 * n; ++row)
    if (frozen[row % n])
      for (RowMatrix::InnerIterator it(all.D_, row); it; ++it) moves[it.col()] = 0;
  std::vector<int> number(moves.size());
  for (int f = 0; f < all.free_count(); ++f) {
    number[f] = isize(free_rows_);
    if (moves[f]) free_rows_.push_back(all.free_rows_[f]);
  }
  std::vector<Triplet> entries;
  for (int row = 0; row < 3 * n; ++row)
    for (RowMatrix::InnerIterator it(all.D_, row); it; ++it)
      if (moves[it.col()]) entries.emplace_back(row, number[it.col()], it.value());
  D_.resize(3 * n, isize(free_rows_));
  D_.setFromTriplets(entries.begin(), entries.end());
  const Points nearest = all.expand(all.free_part(start));
  d0_ = nearest.reshaped() - D_ * free_part(nearest);
}

VecX BlockReduction::free_part(const Points& x) const {
  VecX y(free_count());
  for (int f = 0; f < free_count(); ++f)
    y[f] = x(free_rows_[f] % dof_count(), free_rows_[f] / dof_count());
  return y;
}

Points BlockReduction::expand(const VecX& y) const {
  const VecX x = D_ * y + d0_;
  return x.reshaped(dof_count(), 3);
}

}  // namespace batten
