// Supernodal factorization behind SparseCholesky: numeric factorization by Batten on CHOLMOD's
// pattern, or by Eigen if CHOLMOD is not available.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/solvers/supernodal_solve.h"
#include "batten/core/solvers/symbolic_analysis.h"

namespace batten {

/// Factorization P A Pᵀ = L Lᵀ in dense supernodal blocks. Implementation detail of SparseCholesky:
/// either supernodal_factor_cholmod.cpp or supernodal_factor_eigen.cpp is compiled.
class SupernodalFactor {
 public:
  SupernodalFactor();
  ~SupernodalFactor();

  /// Symbolic analysis of A, which must have at least one row. `order`: elimination order, or empty
  /// for an automatic one.
  void analyze(const SparseMatrix& A, const std::vector<int>& order, FactorReuse factor_reuse);

  /// Numeric factorization. Returns the error message, or "" on success.
  std::string factorize(const SparseMatrix& A);

  /// Pattern of the factor and elimination order. Valid after a successful factorize(), unchanged
  /// until the next analyze().
  SupernodalPattern pattern() const;
  const int* order() const;

  /// Values of the last factorize(). The caller may overwrite them: the next factorize() recomputes
  /// all of them.
  double* values();

  static const char* backend();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Error message for a pivot that is not positive; `unknown`: index of the unknown.
inline std::string not_positive_definite(long unknown) {
  return "the matrix is not positive definite (pivot of unknown " + std::to_string(unknown) +
         "): a motion is not constrained; fix more points, or use beta > 0";
}

/// Relative pivot threshold: a pivot below this fraction of its diagonal entry is rounding error.
/// Bending problems with 100,000 unknowns stay above 1e-10.
inline constexpr double kSingularPivot = 1e-14;

}  // namespace batten
