// Sparse Cholesky factor that is computed once and used many times.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>
#include <functional>

#include "batten/core/eigen.h"
#include "batten/core/solvers/symbolic_analysis.h"

namespace batten {

/// A = L Lᵀ of a symmetric positive definite matrix, of which only the lower triangle is read.
///
///     SparseCholesky cholesky;
///     cholesky.analyze(A);          // ordering and pattern: once for one pattern
///     if (!cholesky.factorize(A))   // numbers: again whenever the numbers change
///       throw NoSolutionError(cholesky.message());
///     x = b;
///     cholesky.solve_in_place(x);   // one pair of triangular solves for all columns of b
///
/// CHOLMOD orders the unknowns and finds the supernodes where it is there, and the numbers are
/// Batten's own; otherwise the factor is Eigen's, which takes several times as long from 10,000
/// unknowns on. The solve is Batten's own over either: limited by memory, on several cores when the
/// factor has more than 500,000 entries in a tree with branches. Factor and solve have the same bits
/// on one thread as on many (docs/theory/solver.md).
///
/// Memory: the factor once, 8 bytes an entry, and 8 an entry of A (over Eigen: 20 bytes an entry).
/// Movable, not copyable; what was moved from can be assigned to or destroyed. One thread at a
/// time, solves included; different objects in different threads do not meet.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Orders the unknowns and finds the pattern of the factor. Throws InputError unless A is square,
  /// and for a factor that memory cannot hold (available_memory; over CHOLMOD).
  void analyze(const SparseMatrix& A, FactorReuse factor_reuse = FactorReuse::once);
  /// The same in a given order: unknowns, the first to eliminate first (nested dissection of a
  /// mesh). An empty order: AMD. Throws InputError unless it names every unknown once.
  void analyze(const SparseMatrix& A, const std::vector<int>& order);
  /// Whether A has the pattern that was analysed: factorize() takes it. O(entries).
  bool has_pattern_of(const SparseMatrix& A) const;
  /// The order that was found or given, of use for another matrix of the same pattern; needs a
  /// successful factorize().
  std::vector<int> order() const;

  /// Factors A, whose pattern is the one that was analysed (otherwise InputError). Over CHOLMOD's
  /// pattern it uses several cores, and a second time allocates next to nothing. Returns false
  /// when A is not positive definite; message() then says at which unknown and what that means.
  bool factorize(const SparseMatrix& A);

  /// b, n×k, becomes x with A x = b. Needs a successful factorize(), otherwise NoSolutionError;
  /// InputError when b has other than n rows. Allocates nothing, but for the first solve of all,
  /// which starts the threads, and the first of more than four columns. Eight columns take
  /// 1.1 to 1.3 times as long as four, and one as long as four.
  void solve_in_place(Eigen::Ref<MatX> b) const;
  MatX solve(const Eigen::Ref<const MatX>& b) const;

  /// The part of the factor that a solve has to visit when b is zero outside the rows `nonzero` and
  /// only the rows `wanted` of x are needed; no list: all rows. Make it once, use it in every
  /// solve: making it costs a fraction of a solve.
  ///
  /// By linearity a right-hand side that changes in few rows is such a case: x changes by the
  /// solution for the change of b. Forward, the solve visits the elimination tree from the rows
  /// `nonzero` to the root, backward from the root to the rows `wanted`: half the work when one of
  /// the two is a small region, almost nothing when both are. SolveSubset::entries tells how much of
  /// the 2 factor_entries() is left. Source: Gilbert, Peierls 1988.
  SolveSubset subset(const std::optional<std::vector<int>>& nonzero,
                     const std::optional<std::vector<int>>& wanted) const;
  /// Solves through that part: x may be read outside the rows `wanted`, but holds nothing
  /// meaningful there. The rows `wanted` equal those of a full solve in every digit. InputError
  /// when the part was made for another analysis.
  void solve_in_place(const SolveSubset& subset, Eigen::Ref<MatX> b) const;

  /// Why the last factorize() failed, or "".
  const std::string& message() const;

  /// Entries of the factor that a solve reads, twice (zeros of supernodes included).
  long factor_entries() const;

  /// "CHOLMOD" or "Eigen".
  static const char* backend();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// One correction step for a least-squares problem min |A x - b|² that was solved by its normal
/// equations, AᵀA x = Aᵀb with `normal` the factor of AᵀA:
///
///     x += (AᵀA)⁻¹ Aᵀ (b - A x)
///
/// The normal equations square the condition number: x is then wrong by about 1e-16 cond(A)². The
/// residual b - A x, unlike Aᵀb - AᵀA x, has lost nothing to the product AᵀA, and one step with it
/// gives the accuracy of an orthogonal factorization (Björck 1987, corrected seminormal equations).
/// For systems that move at every event of a mouse: offered for the moment it is released. Costs
/// one solve and two products with A.
///
/// A: m×n, b: m×k, x: n×k (otherwise InputError). Returns the largest change of an entry of x over
/// the largest entry of x.
double refine_least_squares(const SparseCholesky& normal, const SparseMatrix& A,
                            const Eigen::Ref<const MatX>& b, Eigen::Ref<MatX> x);


// A factor that another program part keeps in place of SparseCholesky.

/// Factors a symmetric positive definite matrix and solves with it, where SparseCholesky does not:
/// on several machines (docs/distributed.md).
class LinearSolverBackend {
 public:
  virtual ~LinearSolverBackend() = default;
  /// A: the lower triangle. Throws NoSolutionError when A is not positive definite.
  virtual void factorize(const SparseMatrix& A) = 0;
  /// b, n×k, becomes x with A x = b.
  virtual void solve_in_place(Eigen::Ref<MatX> b) const = 0;
};

/// Makes one for each system; empty: SparseCholesky.
using BackendFactory = std::function<std::unique_ptr<LinearSolverBackend>()>;

}  // namespace batten
