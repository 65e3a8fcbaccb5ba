#include "batten/mesh/deform/coupling.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

constexpr double kDependent = 1e-9;  // what is left of a row once the others are taken out

}  // namespace

Coupling::Coupling(const SparseCholesky& factor, SparseMatrix U, std::vector<Row> rows)
    : rows_(std::move(rows)), U_(std::move(U)) {
  const auto count = static_cast<long>(rows_.size());
  // The rows on the unknowns that any of them touches, x, y, z side by side.
  std::vector<int> place(U_.rows(), -1);
  long touched = 0;
  for (long k = 0; k < U_.cols(); ++k)
    for (SparseMatrix::InnerIterator it(U_, k); it; ++it)
      if (place[it.row()] < 0) place[it.row()] = static_cast<int>(touched++);
  MatX Q(3 * touched, count);  // orthonormal columns
  R_ = MatX::Zero(count, count);
  std::vector<VecX> implied_by;
  for (long a = 0; a < count; ++a) {
    VecX row = VecX::Zero(3 * touched);
    for (SparseMatrix::InnerIterator it(U_, rows_[a].point); it; ++it)
      for (int c = 0; c < 3; ++c)
        row[c * touched + place[it.row()]] += it.value() * rows_[a].direction[c];
    const auto rank = static_cast<long>(independent_.size());
    VecX shares = VecX::Zero(rank);
    for (int pass = 0; pass < 2; ++pass) {  // twice is enough (Kahan, Parlett)
      const VecX more = Q.leftCols(rank).transpose() * row;
      row -= Q.leftCols(rank) * more;
      shares += more;
    }
    if (row.norm() > kDependent * rows_[a].size) {
      R_.row(rank).head(rank) = shares.transpose();
      R_(rank, rank) = row.norm();
      Q.col(rank) = row / row.norm();
      independent_.push_back(static_cast<int>(a));
    } else {
      implied_.push_back(static_cast<int>(a));
      implied_by.push_back(shares);
    }
  }
  const auto rank = static_cast<long>(independent_.size());
  R_.conservativeResize(rank, rank);
  Z_ = MatX(U_);
  if (Z_.size() > 0) factor.solve_in_place(Z_);
  const MatX UtZ = U_.transpose() * Z_;
  MatX S(rank, rank);
  for (long a = 0; a < rank; ++a)
    for (long b = 0; b < rank; ++b) {
      const Row &x = rows_[independent_[a]], &y = rows_[independent_[b]];
      S(a, b) =
          x.direction.dot(y.direction) * 0.5 * (UtZ(x.point, y.point) + UtZ(y.point, x.point));
    }
  const auto lower = R_.triangularView<Eigen::Lower>();
  if (rank > 0) {
    lower.solveInPlace(S);
    S.transposeInPlace();
    lower.solveInPlace(S);
  }
  schur_.compute(S);
  if (schur_.info() != Eigen::Success)
    throw NoSolutionError("the rows of guided points are nearly dependent");
  scratch_.resize(rank);
  // A row that is shares · Q is shares · R⁻¹ times the independent rows.
  implied_by_ = MatX::Zero(static_cast<long>(implied_.size()), rank);
  for (size_t i = 0; i < implied_.size(); ++i) {
    VecX shares = VecX::Zero(rank);
    shares.head(implied_by[i].size()) = implied_by[i];
    if (rank > 0) R_.transpose().triangularView<Eigen::Upper>().solveInPlace(shares);
    implied_by_.row(static_cast<long>(i)) = shares.transpose();
  }
}

std::pair<double, int> Coupling::contradiction(const VecX& g) const {
  std::pair<double, int> worst{0, implied_.empty() ? -1 : implied_[0]};
  for (size_t i = 0; i < implied_.size(); ++i) {
    double sum = g[implied_[i]];
    for (size_t k = 0; k < independent_.size(); ++k)
      sum -= implied_by_(static_cast<long>(i), static_cast<long>(k)) * g[independent_[k]];
    if (std::abs(sum) > worst.first) worst = {std::abs(sum), implied_[i]};
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
  const auto lower = R_.triangularView<Eigen::Lower>();
  const auto upper = R_.transpose().triangularView<Eigen::Upper>();
  residual(y, g);
  lower.solveInPlace(scratch_);
  schur_.solveInPlace(scratch_);
  upper.solveInPlace(scratch_);
  for (size_t k = 0; k < independent_.size(); ++k) {
    const Row& row = rows_[independent_[k]];
    const Vec3 step = scratch_[static_cast<long>(k)] * row.direction;
    for (int c = 0; c < 3; ++c)
      if (step[c] != 0) y.col(c) -= step[c] * Z_.col(row.point);
  }
  // The solve left its rounding; along G it is gone in a step, the second one is for safety.
  for (int pass = 0; pass < 2; ++pass) {
    residual(y, g);
    lower.solveInPlace(scratch_);
    upper.solveInPlace(scratch_);
    for (size_t k = 0; k < independent_.size(); ++k) {
      const Row& row = rows_[independent_[k]];
      const Vec3 step = scratch_[static_cast<long>(k)] * row.direction;
      for (SparseMatrix::InnerIterator it(U_, row.point); it; ++it)
        y.row(it.row()) -= it.value() * step.transpose();
    }
  }
}

}  // namespace batten
