// The factorization behind SparseCholesky: Batten's numbers over CHOLMOD's pattern, or Eigen's where
// CHOLMOD is absent.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/solvers/symbolic_analysis.h"
#include "batten/core/solvers/supernodal_solve.h"

namespace batten {

/// P A Pᵀ = L Lᵀ as dense blocks. Internal: one of supernodal_factor_cholmod.cpp and
/// supernodal_factor_eigen.cpp is built.
class SupernodalFactor {
 public:
  SupernodalFactor();
  ~SupernodalFactor();

  /// A.rows() > 0. `order` may be empty.
  void analyze(const SparseMatrix& A, const std::vector<int>& order, FactorReuse factor_reuse);

  /// Why it failed, or "".
  std::string factorize(const SparseMatrix& A);

  /// After a successful factorize(). The same until the next analyze().
  SupernodalPattern pattern() const;
  const int* order() const;

  /// The numbers of the last factorize(), which may be overwritten: the next one starts anew.
  double* values();

  static const char* backend();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// The sentence for a pivot that is not positive.
inline std::string not_positive_definite(long unknown) {
  return "the matrix is not positive definite at unknown " + std::to_string(unknown) +
         ": some motion costs no energy (are enough points held, and beta > 0?)";
}

/// A pivot this small against its diagonal entry is rounding: bending problems of 100,000 unknowns
/// stay above 1e-10.
inline constexpr double kSingularPivot = 1e-14;

}  // namespace batten
