#include "batten/mesh/deform/coupling.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

constexpr double kDependent = 1e-9;  // what is left of a unit row once the others are taken out

}  // namespace

Coupling::Coupling(const SparseCholesky& factor, SparseMatrix U, std::vector<Row> rows)
    : rows_(std::move(rows)), U_(std::move(U)) {
  const auto count = static_cast<long>(rows_.size());
  const MatX UtU = MatX(SparseMatrix(U_.transpose()) * U_);
  // Gram-Schmidt by the rows' inner products: L of the independent ones grows row by row.
  MatX gram(count, count);
  for (long a = 0; a < count; ++a)
    for (long b = 0; b < count; ++b)
      gram(a, b) = rows_[a].direction.dot(rows_[b].direction) * UtU(rows_[a].point, rows_[b].point);
  MatX L = MatX::Zero(count, count);
  std::vector<VecX> shares;
  for (long a = 0; a < count; ++a) {
    const auto rank = static_cast<long>(independent_.size());
    VecX l(rank);
    for (long k = 0; k < rank; ++k) l[k] = gram(a, independent_[k]);
    if (rank > 0) L.topLeftCorner(rank, rank).triangularView<Eigen::Lower>().solveInPlace(l);
    const double left = gram(a, a) - l.squaredNorm();
    if (gram(a, a) > 0 && left > kDependent * gram(a, a)) {
      L.row(rank).head(rank) = l.transpose();
      L(rank, rank) = std::sqrt(left);
      independent_.push_back(static_cast<int>(a));
    } else {
      implied_.push_back(static_cast<int>(a));
    }
  }
  const auto rank = static_cast<long>(independent_.size());
  MatX G(rank, rank), S(rank, rank);
  Z_ = MatX(U_);
  if (Z_.size() > 0) factor.solve_in_place(Z_);
  const MatX UtZ = U_.transpose() * Z_;
  for (long a = 0; a < rank; ++a)
    for (long b = 0; b < rank; ++b) {
      const Row &x = rows_[independent_[a]], &y = rows_[independent_[b]];
      G(a, b) = gram(independent_[a], independent_[b]);
      S(a, b) =
          x.direction.dot(y.direction) * 0.5 * (UtZ(x.point, y.point) + UtZ(y.point, x.point));
    }
  if (rank > 0) {
    gram_.compute(G);
    schur_.compute(S);
    if (gram_.info() != Eigen::Success || schur_.info() != Eigen::Success)
      throw NoSolutionError("the rows of guided points are nearly dependent");
  }
  scratch_.resize(rank);
  implied_by_ = MatX::Zero(static_cast<long>(implied_.size()), rank);
  for (size_t i = 0; i < implied_.size() && rank > 0; ++i) {
    VecX products(rank);
    for (long k = 0; k < rank; ++k) products[k] = gram(implied_[i], independent_[k]);
    implied_by_.row(static_cast<long>(i)) = gram_.solve(products).transpose();
  }
}

double Coupling::contradiction(const VecX& g) const {
  double worst = 0;
  for (size_t i = 0; i < implied_.size(); ++i) {
    double sum = g[implied_[i]];
    for (size_t k = 0; k < independent_.size(); ++k)
      sum -= implied_by_(static_cast<long>(i), static_cast<long>(k)) * g[independent_[k]];
    worst = std::max(worst, std::abs(sum));
  }
  return worst;
}

void Coupling::residual(const Eigen::Ref<const MatX>& y, const VecX& g) const {
  for (long k = 0; k < scratch_.size(); ++k) {
    const Row& row = rows_[independent_[k]];
    Vec3 at = Vec3::Zero();
    for (SparseMatrix::InnerIterator it(U_, row.point); it; ++it)
      at += it.value() * y.row(it.row()).transpose();
    scratch_[k] = row.direction.dot(at) - g[independent_[k]];
  }
}

void Coupling::apply(Eigen::Ref<MatX> y, const VecX& g) const {
  if (independent_.empty()) return;
  residual(y, g);
  schur_.solveInPlace(scratch_);
  for (size_t k = 0; k < independent_.size(); ++k) {
    const Row& row = rows_[independent_[k]];
    const Vec3 step = scratch_[static_cast<long>(k)] * row.direction;
    for (int c = 0; c < 3; ++c)
      if (step[c] != 0) y.col(c) -= step[c] * Z_.col(row.point);
  }
  // The solve left its rounding; along G it is gone in a step, the second one is for safety.
  for (int pass = 0; pass < 2; ++pass) {
    residual(y, g);
    gram_.solveInPlace(scratch_);
    for (size_t k = 0; k < independent_.size(); ++k) {
      const Row& row = rows_[independent_[k]];
      const Vec3 step = scratch_[static_cast<long>(k)] * row.direction;
      for (SparseMatrix::InnerIterator it(U_, row.point); it; ++it)
        y.row(it.row()) -= it.value() * step.transpose();
    }
  }
}

}  // namespace batten
