#include "batten/constraints/coupling.h"

#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/memory.h"

namespace batten {
Coupling::Coupling(const SparseCholesky& factor, SparseMatrix U, std::vector<Row> rows,
                   double dependent)
    : rows_(std::move(rows)), U_(std::move(U)) {
  prepare(factor, nullptr, {}, dependent);
}

Coupling::Coupling(const SparseCholesky& factor, SparseMatrix U, std::vector<Row> rows,
                   const Coupling& older, const std::vector<int>& known, double dependent)
    : rows_(std::move(rows)), U_(std::move(U)) {
  prepare(factor, &older, known, dependent);
}

void Coupling::prepare(const SparseCholesky& factor, const Coupling* older,
                       const std::vector<int>& known, double dependent) {
  const std::vector<VecX> implied_by = orthogonalise(dependent);
  solve_points(factor, older, known);
  form_schur_complement();
  const auto soft = static_cast<long>(soft_.size());
  scratch_.resize(S_.rows());
  roots_.resize(soft);
  set_stiffness(VecX::Zero(soft));
  express_implied(implied_by);
}

// The hard rows, each over its size, as columns; x, y, z of an unknown lie side by side. Rows along a
// line then make a band.
SparseMatrix Coupling::hard_rows(const std::vector<int>& hard) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t k = 0; k < hard.size(); ++k) {
    const Row& row = rows_[hard[k]];
    const double scale = row.size > 0 ? 1 / row.size : 1;
    row.terms([&](int point, const Vec3& n) {
      for (SparseMatrix::InnerIterator it(U_, point); it; ++it)
        for (int c = 0; c < 3; ++c)
          if (n[c] != 0)
            entries.emplace_back(3 * it.row() + c, static_cast<int>(k), scale * it.value() * n[c]);
    });
  }
  // Eigen's QR reads beyond a matrix that is wider than high (3.4.0): zeros make it high.
  const auto count = static_cast<long>(hard.size());
  SparseMatrix G(std::max<long>(3 * U_.rows(), count), count);
  G.setFromTriplets(entries.begin(), entries.end());
  return G;
}

std::vector<VecX> Coupling::orthogonalise(double dependent) {
  std::vector<int> hard;
  for (int a = 0; a < rows(); ++a) (rows_[a].soft ? soft_ : hard).push_back(a);
  R_.resize(0, 0);
  if (hard.empty()) return {};
  Eigen::SparseQR<SparseMatrix, Eigen::NaturalOrdering<int>> qr;
  qr.setPivotThreshold(dependent);
  qr.compute(hard_rows(hard));
  if (qr.info() != Eigen::Success)
    throw NoSolutionError("the rows of guided points cannot be reduced");
  // Columns of R: those that are independent of the ones before, then the rest.
  Eigen::RowVectorXi order(static_cast<long>(hard.size()));
  for (size_t k = 0; k < hard.size(); ++k) order[static_cast<long>(k)] = hard[k];
  order = order * qr.colsPermutation();
  const long rank = qr.rank();
  R_.setZero(rank, rank);
  std::vector<VecX> implied_by;
  for (long k = 0; k < order.size(); ++k) {
    VecX shares = VecX::Zero(rank);
    for (Eigen::SparseMatrix<double>::InnerIterator it(qr.matrixR(), k); it; ++it)
      if (it.row() < rank) shares[it.row()] = it.value() * rows_[order[k]].size;
    if (k < rank) {
      R_.row(k) = shares.transpose();
      independent_.push_back(order[k]);
    } else {
      implied_.push_back(order[k]);
      implied_by.push_back(std::move(shares));
    }
  }
  return implied_by;
}

void Coupling::solve_points(const SparseCholesky& factor, const Coupling* older,
                            const std::vector<int>& known) {
  require_memory(8.0 * static_cast<double>(U_.rows()) * static_cast<double>(U_.cols()),
                 "holding a shape at " + std::to_string(points()) + " places beside its lines");
  Z_.resize(U_.rows(), U_.cols());
  std::vector<long> unknown;
  for (long k = 0; k < U_.cols(); ++k)
    if (older && known[k] >= 0)
      Z_.col(k) = older->Z_.col(known[k]);
    else
      unknown.push_back(k);
  if (U_.rows() == 0) return;
  // Block by block: a copy of all would be as large as Z.
  constexpr size_t at_once = 256;
  for (size_t first = 0; first < unknown.size(); first += at_once) {
    const auto count = static_cast<long>(std::min(at_once, unknown.size() - first));
    MatX solved(U_.rows(), count);
    for (long i = 0; i < count; ++i) solved.col(i) = U_.col(unknown[first + i]);
    factor.solve_in_place(solved);
    for (long i = 0; i < count; ++i) Z_.col(unknown[first + i]) = solved.col(i);
  }
}

void Coupling::form_schur_complement() {
  const auto rank = static_cast<long>(independent_.size());
  const auto soft = static_cast<long>(soft_.size());
  const MatX UtZ = U_.transpose() * Z_;
  std::vector<int> order = independent_;
  order.insert(order.end(), soft_.begin(), soft_.end());
  S_.resize(rank + soft, rank + soft);
  for (long a = 0; a < rank + soft; ++a)
    for (long b = 0; b < rank + soft; ++b) {
      const Row &x = rows_[order[a]], &y = rows_[order[b]];
      double sum = 0;
      x.terms([&](int p, const Vec3& n) {
        y.terms([&](int q, const Vec3& m) { sum += n.dot(m) * 0.5 * (UtZ(p, q) + UtZ(q, p)); });
      });
      S_(a, b) = sum;
    }
  if (rank == 0) return;
  const auto lower = R_.triangularView<Eigen::Lower>();
  lower.solveInPlace(S_.topRows(rank));
  S_.transposeInPlace();
  lower.solveInPlace(S_.topRows(rank));
}

void Coupling::express_implied(const std::vector<VecX>& implied_by) {
  const auto rank = static_cast<long>(independent_.size());
  // A row that is shares · Q is shares · R⁻¹ times the independent rows.
  implied_by_ = MatX::Zero(static_cast<long>(implied_.size()), rank);
  for (size_t i = 0; i < implied_.size(); ++i) {
    VecX shares = VecX::Zero(rank);
    shares.head(implied_by[i].size()) = implied_by[i];
    if (rank > 0) R_.transpose().triangularView<Eigen::Upper>().solveInPlace(shares);
    implied_by_.row(static_cast<long>(i)) = shares.transpose();
  }
}

void Coupling::set_stiffness(const VecX& stiffness) {
  const auto soft = static_cast<long>(soft_.size());
  if (stiffness.size() != soft)
    throw InputError(std::to_string(stiffness.size()) + " stiffnesses for " + std::to_string(soft) +
                     " springs");
  for (long k = 0; k < soft; ++k) {
    if (!(stiffness[k] >= 0) || !std::isfinite(stiffness[k]))
      throw InputError("a spring of stiffness " + number(stiffness[k]) +
                       ": it must not be below 0");
    roots_[k] = std::sqrt(stiffness[k]);
  }
  if (S_.size() == 0) return;
  scaled_ = S_;
  scaled_.bottomRows(soft).array().colwise() *= roots_.array();
  scaled_.rightCols(soft).array().rowwise() *= roots_.transpose().array();
  scaled_.diagonal().tail(soft).array() += 1;
  schur_.compute(scaled_);
  if (schur_.info() != Eigen::Success)
    throw NoSolutionError("the rows of guided points are nearly dependent");
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

double Coupling::at(const Row& row, const Eigen::Ref<const MatX>& y) const {
  double total = 0;
  row.terms([&](int point, const Vec3& n) {
    Vec3 sum = Vec3::Zero();
    for (SparseMatrix::InnerIterator it(U_, point); it; ++it)
      sum += it.value() * y.row(it.row()).transpose();
    total += n.dot(sum);
  });
  return total;
}

void Coupling::residual_of_hard(const Eigen::Ref<const MatX>& y, const VecX& g) const {
  for (size_t k = 0; k < independent_.size(); ++k)
    scratch_[static_cast<long>(k)] = at(rows_[independent_[k]], y) - g[independent_[k]];
}

void Coupling::apply(Eigen::Ref<MatX> y, const VecX& g) const {
  const auto rank = static_cast<long>(independent_.size());
  const auto soft = static_cast<long>(soft_.size());
  if (rank + soft == 0) return;
  const auto lower = R_.triangularView<Eigen::Lower>();
  const auto upper = R_.transpose().triangularView<Eigen::Upper>();
  auto hard_part = scratch_.head(rank);
  residual_of_hard(y, g);
  lower.solveInPlace(hard_part);
  for (long k = 0; k < soft; ++k) {
    const int row = soft_[k];
    scratch_[rank + k] = roots_[k] * (at(rows_[row], y) - g[row]);
  }
  schur_.solveInPlace(scratch_);
  upper.solveInPlace(hard_part);
  scratch_.tail(soft).array() *= roots_.array();
  for (long k = 0; k < rank + soft; ++k) {
    const Row& row = rows_[k < rank ? independent_[k] : soft_[k - rank]];
    row.terms([&](int point, const Vec3& n) {
      for (int c = 0; c < 3; ++c)
        if (const double step = scratch_[k] * n[c]; step != 0) y.col(c) -= step * Z_.col(point);
    });
  }
  project(y, g);
}

void Coupling::project(Eigen::Ref<MatX> y, const VecX& g) const {
  const auto rank = static_cast<long>(independent_.size());
  if (rank == 0) return;
  const auto lower = R_.triangularView<Eigen::Lower>();
  const auto upper = R_.transpose().triangularView<Eigen::Upper>();
  auto hard_part = scratch_.head(rank);
  // Rounding is gone in a step, the second one is for safety.
  for (int pass = 0; pass < 2; ++pass) {
    residual_of_hard(y, g);
    lower.solveInPlace(hard_part);
    upper.solveInPlace(hard_part);
    for (size_t k = 0; k < independent_.size(); ++k) {
      const Row& row = rows_[independent_[k]];
      row.terms([&](int point, const Vec3& n) {
        const Vec3 step = scratch_[static_cast<long>(k)] * n;
        for (SparseMatrix::InnerIterator it(U_, point); it; ++it)
          y.row(it.row()) -= it.value() * step.transpose();
      });
    }
  }
}

size_t Coupling::bytes() const {
  return sizeof(double) * static_cast<size_t>(Z_.size() + 3 * S_.size() + R_.size());
}

}  // namespace batten
