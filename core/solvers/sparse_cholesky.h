// SPDX-License-Identifier: MPL-2.0
// Sparse Cholesky solver whose factor is computed once and used for many solves.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/solvers/linear_solver_backend.h"

namespace batten {

/// Sparse Cholesky factorization A = L Lᵀ of a symmetric positive definite matrix; only the lower
/// triangle of A is read.
///
///     SparseCholesky cholesky;
///     cholesky.analyze(A);          // symbolic: once per sparsity pattern
///     if (!cholesky.factorize(A))   // numeric: again whenever the values change
///       throw NoSolutionError(cholesky.message());
///     x = b;
///     cholesky.solve_in_place(x);   // one pair of triangular solves for all columns of b
///
/// With CholeskyLibrary::Cholmod, CHOLMOD provides the ordering and the supernodes, and Batten
/// computes the numeric values. With CholeskyLibrary::Eigen, Eigen computes the factor, which takes
/// several times as long for 10,000 unknowns or more. The default is CHOLMOD if the build contains
/// it. Batten's own triangular solves are used in both cases. They are limited by memory bandwidth
/// and run on several cores if the factor has more than 500,000 entries and its elimination tree
/// has branches. Factors and solutions are bit-identical for any number of threads
/// (docs/theory/solver.md).
///
/// analyze(), factorize() and the solves poll the current ProgressScope (cancellation.h) and report
/// the stages "ordering" and "factorization" to it. After CancelledError, the object is as it would
/// be after a call that failed: it needs analyze() or factorize() again, and solutions in place are
/// undefined.
///
/// Memory: 8 bytes per entry of the factor and 8 per entry of A; with Eigen, 20 bytes per entry of
/// the factor. Movable, not copyable; a moved-from object can only be assigned to or destroyed. Not
/// thread-safe, not even for solves; different objects may be used in different threads.
class SparseCholesky final : public LinearSolverBackend {
 public:
  /// Uses the default library of the build.
  SparseCholesky();
  /// Uses the given library. Throws InputError if this build does not contain it.
  explicit SparseCholesky(CholeskyLibrary library);
  ~SparseCholesky() override;
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Symbolic analysis of the matrix A: orders the unknowns and computes the sparsity pattern of
  /// the Cholesky factor. `factor_reuse` selects the ordering. Throws InputError if A is not square
  /// or if memory cannot hold the factor (see available_memory(); checked with CHOLMOD only).
  void analyze(const SparseMatrix& A, FactorReuse factor_reuse = FactorReuse::once);
  /// Symbolic analysis of the matrix A with a given elimination order, for example a nested
  /// dissection of the mesh: `order` lists the unknowns, first eliminated first. An empty order
  /// selects AMD. Throws InputError if `order` is not a permutation of all unknowns.
  void analyze(const SparseMatrix& A, const std::vector<int>& order) override;
  /// Whether A has the analysed sparsity pattern, so that factorize() accepts A. O(entries of A).
  bool has_pattern_of(const SparseMatrix& A) const override;
  /// Elimination order used by the last symbolic analysis, computed or given: lists the unknowns,
  /// first eliminated first. It can be reused for another matrix with the same pattern. Throws
  /// NoSolutionError before a symbolic analysis.
  std::vector<int> order() const;

  /// Numeric factorization of the matrix A. Calls analyze(A) first if no matrix was analysed yet.
  /// Throws InputError if the pattern differs from the analysed one. With CholeskyLibrary::Cholmod
  /// it uses several cores, and later calls allocate next to nothing. Returns false if A is not
  /// positive definite; message() names the unknown and the probable cause.
  bool factorize(const SparseMatrix& A) override;
  /// Whether the last factorize() has succeeded, so that systems can be solved.
  bool is_factored() const;

  /// Solves A x = b in place for the factorized n×n matrix A: b (n×k) is overwritten by x. Throws
  /// NoSolutionError without a successful factorize(), InputError if b does not have n rows.
  /// Allocates memory only for the first solve in the program, which starts the threads, and the
  /// first solve with more than four columns. One column takes as long as four; eight take 1.1 to
  /// 1.3 times as long.
  void solve_in_place(Eigen::Ref<MatX> b) const override;
  /// Solution of A x = b for the factorized matrix A and all columns of b. Like solve_in_place(),
  /// but allocates the result.
  MatX solve(const Eigen::Ref<const MatX>& b) const;

  /// Computes the part of the factor that a partial solve of A x = b must visit, if b is zero
  /// outside of the rows `nonzero` and only the rows `wanted` of x are needed. std::nullopt means
  /// all rows. Compute the subset once and reuse it: computing it costs a fraction of a solve.
  ///
  /// By linearity, a partial solve also suffices if b changes in few rows only: the change of x is
  /// the solution for the change of b. The forward solve visits the elimination tree from the rows
  /// `nonzero` to the root, the backward solve from the root to the rows `wanted`. This is half the
  /// work if one of the two row sets is a small region of the mesh, and almost nothing if both are.
  /// SolveSubset::entries gives the remaining work (full solve: 2 factor_entries()). Throws
  /// NoSolutionError without a successful factorize(). Reference: [GilbertPeierls1988].
  SolveSubset subset(const std::optional<std::vector<int>>& nonzero,
                     const std::optional<std::vector<int>>& wanted) const;
  /// Partial solve of A x = b in place, restricted to the part `subset` of the factor. b must be
  /// zero outside of the rows `nonzero` that were passed to subset(). The rows `wanted` of x are
  /// bit-identical to those of a full solve; the values of the other rows are undefined. Throws
  /// InputError if the subset belongs to another analysis.
  void solve_in_place(const SolveSubset& subset, Eigen::Ref<MatX> b) const;

  /// Reason why the last factorize() failed; empty if it succeeded.
  const std::string& message() const override;

  /// Number of entries of the Cholesky factor, including explicit zeros in supernodes. A solve
  /// reads each entry twice.
  long factor_entries() const;
  /// Memory of the factor and of its analysis, bytes.
  size_t bytes() const;

  /// Name of the default library of the build: "CHOLMOD" or "Eigen".
  static const char* backend() { return library_name(cholesky_libraries().front()); }

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Improves the solution of a least-squares problem min |A x - b|² that was solved by its normal
/// equations AᵀA x = Aᵀb, by one correction step:
///
///     x += (AᵀA)⁻¹ Aᵀ (b - A x)
///
/// The normal equations square the condition number: the error of x is about 1e-16 cond(A)². The
/// residual b - A x, unlike Aᵀb - AᵀA x, is not affected by the rounding errors of AᵀA. One step
/// with it gives the accuracy of an orthogonal factorization (corrected seminormal equations,
/// [Bjorck1987]). In interactive programs, call it when the mouse button is released. Cost: one
/// solve and two products with A.
///
/// `normal`: factor of AᵀA. A: m×n, b: m×k, x: n×k; throws InputError for other shapes. Returns the
/// largest change of an entry of x, divided by the largest entry of x.
double refine_least_squares(const SparseCholesky& normal, const SparseMatrix& A,
                            const Eigen::Ref<const MatX>& b, Eigen::Ref<MatX> x);

}  // namespace batten
