// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/schur_complement_constraints.h"

#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"

namespace batten {
SchurComplementConstraints::SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                                                       std::vector<Constraint> constraints,
                                                       double dependent)
    : constraints_(std::move(constraints)), U_(std::move(U)) {
  prepare(factor, nullptr, {}, dependent);
}

SchurComplementConstraints::SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                                                       std::vector<Constraint> constraints,
                                                       const SchurComplementConstraints& previous,
                                                       const std::vector<int>& reused_columns,
                                                       double dependent)
    : constraints_(std::move(constraints)), U_(std::move(U)) {
  prepare(factor, &previous, reused_columns, dependent);
}

void SchurComplementConstraints::prepare(const SparseCholesky& factor,
                                         const SchurComplementConstraints* previous,
                                         const std::vector<int>& reused_columns, double dependent) {
  throw_if_cancelled();
  const std::vector<VecX> redundant_coefficients = orthogonalise(dependent);
  solve_points(factor, previous, reused_columns);
  form_schur_complement();
  const auto soft = static_cast<long>(soft_.size());
  scratch_.resize(S_.rows());
  multipliers_ = VecX::Zero(S_.rows());
  roots_.resize(soft);
  set_stiffness(VecX::Zero(soft));
  express_redundant(redundant_coefficients);
}

// Hard constraints, each divided by its size, as columns. The x, y, z coefficients of an unknown
// are adjacent, so that constraints along a curve form a band matrix.
SparseMatrix SchurComplementConstraints::hard_constraint_matrix(
    const std::vector<int>& hard) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t k = 0; k < hard.size(); ++k) {
    const Constraint& row = constraints_[hard[k]];
    const double scale = row.size > 0 ? 1 / row.size : 1;
    row.terms([&](int point, const Vec3& n) {
      for (SparseMatrix::InnerIterator it(U_, point); it; ++it)
        for (int c = 0; c < 3; ++c)
          if (n[c] != 0)
            entries.emplace_back(3 * it.row() + c, static_cast<int>(k), scale * it.value() * n[c]);
    });
  }
  // Eigen's SparseQR (3.4.0) reads out of bounds if the matrix is wider than high; zero rows avoid
  // this.
  const auto count = static_cast<long>(hard.size());
  SparseMatrix G(std::max<long>(3 * U_.rows(), count), count);
  G.setFromTriplets(entries.begin(), entries.end());
  return G;
}

std::vector<VecX> SchurComplementConstraints::orthogonalise(double dependent) {
  std::vector<int> hard;
  for (int a = 0; a < constraint_count(); ++a) (constraints_[a].soft ? soft_ : hard).push_back(a);
  R_.resize(0, 0);
  if (hard.empty()) return {};
  Eigen::SparseQR<SparseMatrix, Eigen::NaturalOrdering<int>> qr;
  qr.setPivotThreshold(dependent);
  qr.compute(hard_constraint_matrix(hard));
  if (qr.info() != Eigen::Success)
    throw NoSolutionError("the equations of the point constraints cannot be factorized");
  // SparseQR permutes columns: independent ones first, then the remaining ones.
  Eigen::RowVectorXi order(static_cast<long>(hard.size()));
  for (size_t k = 0; k < hard.size(); ++k) order[static_cast<long>(k)] = hard[k];
  order = order * qr.colsPermutation();
  const long rank = qr.rank();
  R_.setZero(rank, rank);
  std::vector<VecX> redundant_coefficients;
  for (long k = 0; k < order.size(); ++k) {
    VecX coefficients = VecX::Zero(rank);
    for (Eigen::SparseMatrix<double>::InnerIterator it(qr.matrixR(), k); it; ++it)
      if (it.row() < rank) coefficients[it.row()] = it.value() * constraints_[order[k]].size;
    if (k < rank) {
      R_.row(k) = coefficients.transpose();
      independent_.push_back(order[k]);
    } else {
      redundant_.push_back(order[k]);
      redundant_coefficients.push_back(std::move(coefficients));
    }
  }
  return redundant_coefficients;
}

void SchurComplementConstraints::solve_points(const SparseCholesky& factor,
                                              const SchurComplementConstraints* previous,
                                              const std::vector<int>& reused_columns) {
  require_memory(
      8.0 * static_cast<double>(U_.rows()) * static_cast<double>(U_.cols()),
      "constraining the surface at " + std::to_string(points()) + " points beside its curves");
  Z_.resize(U_.rows(), U_.cols());
  std::vector<long> unknown;
  for (long k = 0; k < U_.cols(); ++k)
    if (previous && reused_columns[k] >= 0)
      Z_.col(k) = previous->Z_.col(reused_columns[k]);
    else
      unknown.push_back(k);
  if (U_.rows() == 0) return;
  // In blocks: a copy of all columns would be as large as Z.
  constexpr size_t kSolveColumns = 256;
  for (size_t first = 0; first < unknown.size(); first += kSolveColumns) {
    throw_if_cancelled();
    const auto count = static_cast<long>(std::min(kSolveColumns, unknown.size() - first));
    MatX solved(U_.rows(), count);
    for (long i = 0; i < count; ++i) solved.col(i) = U_.col(unknown[first + i]);
    factor.solve_in_place(solved);
    for (long i = 0; i < count; ++i) Z_.col(unknown[first + i]) = solved.col(i);
  }
}

void SchurComplementConstraints::form_schur_complement() {
  const auto rank = static_cast<long>(independent_.size());
  const auto soft = static_cast<long>(soft_.size());
  throw_if_cancelled();
  const MatX UtZ = U_.transpose() * Z_;
  std::vector<int> order = independent_;
  order.insert(order.end(), soft_.begin(), soft_.end());
  S_.resize(rank + soft, rank + soft);
  for (long a = 0; a < rank + soft; ++a) {
    poll_every<16>(a);
    for (long b = 0; b < rank + soft; ++b) {
      const Constraint &x = constraints_[order[a]], &y = constraints_[order[b]];
      double sum = 0;
      x.terms([&](int p, const Vec3& n) {
        y.terms([&](int q, const Vec3& m) { sum += n.dot(m) * 0.5 * (UtZ(p, q) + UtZ(q, p)); });
      });
      S_(a, b) = sum;
    }
  }
  if (rank == 0) return;
  const auto lower = R_.triangularView<Eigen::Lower>();
  lower.solveInPlace(S_.topRows(rank));
  S_.transposeInPlace();
  lower.solveInPlace(S_.topRows(rank));
}

void SchurComplementConstraints::express_redundant(
    const std::vector<VecX>& redundant_coefficients) {
  const auto rank = static_cast<long>(independent_.size());
  // A constraint with coefficients a with respect to Q equals a · R⁻¹ times the independent
  // constraints.
  redundant_coefficients_ = MatX::Zero(static_cast<long>(redundant_.size()), rank);
  for (size_t i = 0; i < redundant_.size(); ++i) {
    VecX coefficients = VecX::Zero(rank);
    coefficients.head(redundant_coefficients[i].size()) = redundant_coefficients[i];
    if (rank > 0) R_.transpose().triangularView<Eigen::Upper>().solveInPlace(coefficients);
    redundant_coefficients_.row(static_cast<long>(i)) = coefficients.transpose();
  }
}

void SchurComplementConstraints::set_stiffness(const VecX& stiffness) {
  const auto soft = static_cast<long>(soft_.size());
  if (stiffness.size() != soft)
    throw InputError("found " + std::to_string(stiffness.size()) + " stiffnesses for " +
                     std::to_string(soft) + " springs, expected one for each");
  for (long k = 0; k < soft; ++k) {
    if (!(stiffness[k] >= 0) || !std::isfinite(stiffness[k]))
      throw InputError("found the spring stiffness " + format_number(stiffness[k]) +
                       ", expected 0 or more");
    roots_[k] = std::sqrt(stiffness[k]);
  }
  if (S_.size() == 0) return;
  scaled_ = S_;
  scaled_.bottomRows(soft).array().colwise() *= roots_.array();
  scaled_.rightCols(soft).array().rowwise() *= roots_.transpose().array();
  scaled_.diagonal().tail(soft).array() += 1;
  schur_.compute(scaled_);
  if (schur_.info() != Eigen::Success)
    throw NoSolutionError("the equations of the point constraints are nearly linearly dependent");
}

std::pair<double, int> SchurComplementConstraints::contradiction(const VecX& g) const {
  std::pair<double, int> worst{0, redundant_.empty() ? -1 : redundant_[0]};
  for (size_t i = 0; i < redundant_.size(); ++i) {
    double sum = g[redundant_[i]];
    for (size_t k = 0; k < independent_.size(); ++k)
      sum -=
          redundant_coefficients_(static_cast<long>(i), static_cast<long>(k)) * g[independent_[k]];
    if (std::abs(sum) > worst.first) worst = {std::abs(sum), redundant_[i]};
  }
  return worst;
}

double SchurComplementConstraints::evaluate(const Constraint& row,
                                            const Eigen::Ref<const MatX>& y) const {
  double total = 0;
  row.terms([&](int point, const Vec3& n) {
    Vec3 sum = Vec3::Zero();
    for (SparseMatrix::InnerIterator it(U_, point); it; ++it)
      sum += it.value() * y.row(it.row()).transpose();
    total += n.dot(sum);
  });
  return total;
}

void SchurComplementConstraints::residual_of_hard(const Eigen::Ref<const MatX>& y,
                                                  const VecX& g) const {
  for (size_t k = 0; k < independent_.size(); ++k)
    scratch_[static_cast<long>(k)] =
        evaluate(constraints_[independent_[k]], y) - g[independent_[k]];
}

void SchurComplementConstraints::apply(Eigen::Ref<MatX> y, const VecX& g) const {
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
    scratch_[rank + k] = roots_[k] * (evaluate(constraints_[row], y) - g[row]);
  }
  schur_.solveInPlace(scratch_);
  upper.solveInPlace(hard_part);
  scratch_.tail(soft).array() *= roots_.array();
  multipliers_ = scratch_;
  for (long k = 0; k < rank + soft; ++k) {
    const Constraint& row = constraints_[k < rank ? independent_[k] : soft_[k - rank]];
    row.terms([&](int point, const Vec3& n) {
      for (int c = 0; c < 3; ++c)
        if (const double step = scratch_[k] * n[c]; step != 0) y.col(c) -= step * Z_.col(point);
    });
  }
  project(y, g);
}

void SchurComplementConstraints::add_multipliers(Eigen::Ref<VecX> sum) const {
  const auto rank = static_cast<long>(independent_.size());
  for (long k = 0; k < multipliers_.size(); ++k)
    sum[k < rank ? independent_[k] : soft_[k - rank]] += multipliers_[k];
}

void SchurComplementConstraints::project(Eigen::Ref<MatX> y, const VecX& g) const {
  const auto rank = static_cast<long>(independent_.size());
  if (rank == 0) return;
  const auto lower = R_.triangularView<Eigen::Lower>();
  const auto upper = R_.transpose().triangularView<Eigen::Upper>();
  auto hard_part = scratch_.head(rank);
  // One pass removes all but rounding errors; the second one is for safety.
  for (int pass = 0; pass < 2; ++pass) {
    residual_of_hard(y, g);
    lower.solveInPlace(hard_part);
    upper.solveInPlace(hard_part);
    for (size_t k = 0; k < independent_.size(); ++k) {
      const Constraint& row = constraints_[independent_[k]];
      row.terms([&](int point, const Vec3& n) {
        const Vec3 step = scratch_[static_cast<long>(k)] * n;
        for (SparseMatrix::InnerIterator it(U_, point); it; ++it)
          y.row(it.row()) -= it.value() * step.transpose();
      });
    }
  }
}

size_t SchurComplementConstraints::bytes() const {
  return sizeof(double) * static_cast<size_t>(Z_.size() + 3 * S_.size() + R_.size());
}

}  // namespace batten
