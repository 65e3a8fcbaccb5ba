// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/sparse_cholesky.h"

#include <cstdint>
#include <utility>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/core/log.h"
#include "batten/core/op_counter.h"
#include "batten/core/solvers/supernodal_solve.h"

namespace batten {
namespace {

// Hash of the positions of all entries, which distinguishes sparsity patterns.
std::uint64_t pattern_hash(const SparseMatrix& A) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a applied to integers
  const auto add = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  for (int c = 0; c < A.outerSize(); ++c) {
    poll_every<4096>(c);
    for (SparseMatrix::InnerIterator e(A, c); e; ++e) add(static_cast<std::uint64_t>(e.row()));
    add(~std::uint64_t{0});
  }
  return hash;
}

}  // namespace

struct SparseCholesky::Data {
  explicit Data(CholeskyLibrary library) : factor(make_supernodal_factor(library)) {}

  std::unique_ptr<SupernodalFactor> factor;
  SupernodalSolve solve;
  long n = -1;  // rows of the analysed matrix; -1: none
  long matrix_entries = 0;
  std::uint64_t pattern = 0;
  bool factored = false;
  std::string message;

  void analyze(const SparseMatrix& A, const std::vector<int>& order, FactorReuse factor_reuse) {
    if (A.rows() != A.cols())
      throw InputError("Cholesky factorization: found a " + std::to_string(A.rows()) + " by " +
                       std::to_string(A.cols()) + " matrix, expected a square one");
    n = -1;
    factored = false;
    solve = {};  // invalid until there is a new factor
    count(OpCounter::Analysis);
    update_progress("ordering", 0);
    if (A.rows() > 0) factor->analyze(A, order, factor_reuse);
    pattern = pattern_hash(A);
    matrix_entries = A.nonZeros();
    n = A.rows();
    update_progress("ordering", 1);
  }
  void require_solvable(const Eigen::Ref<const MatX>& b) const {
    if (!factored) throw NoSolutionError("solve() without a factor: call factorize() first");
    if (b.rows() != n)
      throw InputError("found right-hand sides with " + std::to_string(b.rows()) +
                       " rows, expected " + std::to_string(n) + ", one for each unknown");
  }
};

SparseCholesky::SparseCholesky() : SparseCholesky(cholesky_libraries().front()) {}
SparseCholesky::SparseCholesky(CholeskyLibrary library) : data_(std::make_unique<Data>(library)) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyze(const SparseMatrix& A, FactorReuse factor_reuse) {
  data_->analyze(A, {}, factor_reuse);
}

void SparseCholesky::analyze(const SparseMatrix& A, const std::vector<int>& order) {
  if (!order.empty()) {
    std::vector<char> named(A.rows(), 0);
    if (static_cast<long>(order.size()) != A.rows())
      throw InputError("found an elimination order of " + std::to_string(order.size()) +
                       " unknowns, expected " + std::to_string(A.rows()));
    for (const int unknown : order)
      if (unknown < 0 || unknown >= A.rows() || std::exchange(named[unknown], 1))
        throw InputError(
            "elimination order: unknown " + std::to_string(unknown) +
            (unknown < 0 || unknown >= A.rows() ? " does not exist" : " occurs twice"));
  }
  data_->analyze(A, order, FactorReuse::once);
}

bool SparseCholesky::has_pattern_of(const SparseMatrix& A) const {
  return A.rows() == data_->n && A.cols() == data_->n && pattern_hash(A) == data_->pattern;
}

bool SparseCholesky::factorize(const SparseMatrix& A) {
  Data& d = *data_;
  if (d.n < 0) analyze(A);
  if (!has_pattern_of(A))
    throw InputError("factorize: the matrix (" + std::to_string(A.rows()) + " by " +
                     std::to_string(A.cols()) + ", " + std::to_string(A.nonZeros()) +
                     " entries) does not have the analysed sparsity pattern: call analyze() first");
  d.message.clear();
  d.factored = d.n == 0;
  if (d.factored) return true;
  count(OpCounter::Factorization);
  update_progress("factorization", 0);
  d.message = d.factor->factorize(A);
  if (!d.message.empty()) return false;
  if (d.solve.entries() == 0) d.solve = SupernodalSolve(d.factor->pattern(), d.factor->order());
  d.solve.pack(d.factor->values());
  update_progress("factorization", 1);
  log(LogLevel::Debug, [&] {
    return "factorization of " + std::to_string(d.n) + " unknowns with " +
           std::to_string(d.solve.entries()) + " entries";
  });
  d.factored = true;
  return true;
}

void SparseCholesky::solve_in_place(Eigen::Ref<MatX> b) const {
  data_->require_solvable(b);
  count(OpCounter::Solve);
  data_->solve.solve(b);
}

MatX SparseCholesky::solve(const Eigen::Ref<const MatX>& b) const {
  MatX x = b;
  solve_in_place(x);
  return x;
}

SolveSubset SparseCholesky::subset(const std::optional<std::vector<int>>& nonzero,
                                   const std::optional<std::vector<int>>& wanted) const {
  if (!data_->factored)
    throw NoSolutionError("solve subset without a factor: call factorize() first");
  return data_->solve.subset(nonzero, wanted);
}

void SparseCholesky::solve_in_place(const SolveSubset& subset, Eigen::Ref<MatX> b) const {
  data_->require_solvable(b);
  count(OpCounter::Solve);
  data_->solve.solve(subset, b);
}

std::vector<int> SparseCholesky::order() const {
  if (data_->n < 0)
    throw NoSolutionError("elimination order without a symbolic analysis: call analyze() first");
  if (data_->n == 0) return {};
  return {data_->factor->order(), data_->factor->order() + data_->n};
}

bool SparseCholesky::is_factored() const { return data_->factored; }

const std::string& SparseCholesky::message() const { return data_->message; }

long SparseCholesky::factor_entries() const { return data_->solve.entries(); }

size_t SparseCholesky::bytes() const {
  if (!data_->factored || data_->n == 0) return 0;
  const SupernodalPattern L = data_->factor->pattern();
  const auto size = [](long count) { return static_cast<size_t>(count); };
  // Values; rows in the pattern, in updates and in solves; positions of the entries of A; orders
  // and work vectors of the unknowns.
  return 8 * size(L.value_starts[L.count]) + 20 * size(L.row_starts[L.count]) +
         8 * size(data_->matrix_entries) + 100 * size(data_->n);
}

double refine_least_squares(const SparseCholesky& normal, const SparseMatrix& A,
                            const Eigen::Ref<const MatX>& b, Eigen::Ref<MatX> x) {
  if (A.rows() != b.rows() || A.cols() != x.rows() || b.cols() != x.cols())
    throw InputError("least-squares refinement: sizes do not match: A is " +
                     std::to_string(A.rows()) + " by " + std::to_string(A.cols()) + ", b " +
                     std::to_string(b.rows()) + " by " + std::to_string(b.cols()) + ", x " +
                     std::to_string(x.rows()) + " by " + std::to_string(x.cols()));
  if (x.size() == 0) return 0;
  MatX change = A.transpose() * (b - A * x);
  normal.solve_in_place(change);
  x += change;
  const double size = x.cwiseAbs().maxCoeff();
  return size > 0 ? change.cwiseAbs().maxCoeff() / size : 0;
}

}  // namespace batten
