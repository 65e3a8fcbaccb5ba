// Sparse Cholesky factor that is computed once and used many times.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A = L Lᵀ of a symmetric positive definite matrix, of which only the lower triangle is read.
///
///     SparseCholesky cholesky;
///     cholesky.analyze(A);          // ordering and pattern: once for one pattern
///     if (!cholesky.factorize(A))   // numbers: again whenever the numbers change
///       throw NoSolutionError(cholesky.message());
///     x = cholesky.solve(b);        // one pair of triangular solves for all columns of b
///
/// CHOLMOD's supernodal factor where CHOLMOD is there, otherwise Eigen's simplicial LDLᵀ (same
/// contract, several times slower on large systems).
/// Movable, not copyable. One thread at a time, solve() included.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Orders the unknowns and finds the pattern of the factor. `order`: unknowns, the first to
  /// eliminate first, when the caller knows a good order (nested dissection of a mesh); otherwise
  /// AMD finds one. Eigen's factor takes AMD in any case. Throws InputError unless A is square and
  /// the order has its size.
  void analyze(const SparseMatrix& A, const std::vector<int>& order = {});

  /// Factors A, whose pattern is the one that was analysed. Returns false when A is not positive
  /// definite; message() then says at which unknown and what that means.
  bool factorize(const SparseMatrix& A);

  /// x with A x = b, for n×k right-hand sides at once. Needs a successful factorize().
  MatX solve(const Eigen::Ref<const MatX>& b) const;

  /// Why the last factorize() failed, or "".
  const std::string& message() const;

  /// Entries of the factor that are stored (zeros of supernodes included): 8 bytes each.
  long factor_entries() const;

  /// "CHOLMOD" or "Eigen".
  static const char* backend();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
