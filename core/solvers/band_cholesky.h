// Cholesky factorization of symmetric positive definite band matrices, as they arise from curves.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Cholesky factorization A = L Lᵀ of a symmetric positive definite matrix with half-bandwidth
/// `band`.
///
/// Cost: O(n band²) for the factorization, O(n band) per solve. For a curve of a hundred segments
/// this takes microseconds; a general sparse solver would spend longer on the ordering alone. An
/// object may be reused for matrices of other sizes.
class BandCholesky {
 public:
  /// Resets A to the zero matrix with n unknowns and half-bandwidth `band`.
  void reset(int n, int band);
  int size() const { return n_; }

  /// Adds `value` to the entry A(i, j), |i - j| ≤ band. Call it before factorize(), and only for
  /// one of (i, j) and (j, i): each off-diagonal pair is stored once.
  void add(int i, int j, double value) { (i >= j ? entry(i, j) : entry(j, i)) += value; }
  /// Adds factor · B to A. B must have the same size and bandwidth; neither matrix may be
  /// factorized.
  void add(const BandCholesky& B, double factor);
  /// Diagonal entry A(i, i). Valid only before factorize().
  double diagonal(int i) const { return entry(i, i); }
  /// Prescribes x_i = value: moves column i to the right-hand side b (n×3). Call it after adding
  /// all entries and before factorize().
  void fix(int i, const Vec3& value, Points& b);

  /// Computes the factorization in place. Returns false if A is not positive definite.
  bool factorize();
  /// Solves A x = b in place: b (n×3) is overwritten by x. Requires factorize().
  void solve(Points& b) const;
  /// Trace of A⁻¹ B. Requires factorize(). B must have the same size and bandwidth and must not be
  /// factorized. The entries of A⁻¹ inside the band are computed by the recursion of
  /// [Takahashi1973]. Cost: O(n band²).
  double trace_of_inverse_times(const BandCholesky& B) const;

 private:
  double& entry(int i, int j) {
    return rows_[static_cast<size_t>(i) * (band_ + 1) + band_ + j - i];
  }
  double entry(int i, int j) const {
    return rows_[static_cast<size_t>(i) * (band_ + 1) + band_ + j - i];
  }
  int n_ = 0, band_ = 0;
  std::vector<double> rows_;  // row i holds columns i - band … i
};

}  // namespace batten
