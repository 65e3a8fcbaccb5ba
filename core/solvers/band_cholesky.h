// SPDX-License-Identifier: MPL-2.0
// Cholesky factorization of symmetric positive definite band matrices, as they arise from curves.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Cholesky factorization A = L Lᵀ of a symmetric positive definite n×n matrix A with
/// half-bandwidth `band`.
///
/// Cost: O(n band²) for the factorization, O(n band) per solve. For a curve of a hundred segments
/// this takes microseconds; a general sparse solver would spend longer on the ordering alone. An
/// object may be reused for matrices of other sizes.
class BandCholesky {
 public:
  /// Resets to a zero n×n matrix with half-bandwidth `band` (largest |i - j| of an entry (i, j)).
  void reset(int n, int band);
  int size() const { return n_; }

  /// Adds `value` to the matrix entry (i, j); |i - j| must be at most the half-bandwidth. Call it
  /// before factorize(), and only for one of (i, j) and (j, i), which are stored as one entry.
  void add(int i, int j, double value) { (i >= j ? entry(i, j) : entry(j, i)) += value; }
  /// Adds factor · B to this matrix. B must have the same size and bandwidth as this matrix. Call
  /// it before either matrix is factorized.
  void add(const BandCholesky& B, double factor);
  /// Diagonal entry (i, i) of the matrix. Valid only before factorize().
  double diagonal(int i) const { return entry(i, i); }
  /// Prescribes the unknown x_i = value of the system A x = b: moves column i of the matrix A to
  /// the right-hand side b (n×3). Call it after adding all entries and before factorize().
  void fix(int i, const Vec3& value, Points& b);

  /// Factors the matrix in place (Cholesky). Returns false if it is not positive definite.
  bool factorize();
  /// Solves A x = b in place for the matrix A factored by factorize(): b (n×3) is overwritten by x.
  void solve(Points& b) const;
  /// Trace of A⁻¹ B for the factorized matrix A. Requires factorize(). B must have the same size
  /// and half-bandwidth `band` as A and must not be factorized. The entries of A⁻¹ inside the band
  /// are computed by the recursion of [Takahashi1973]. Cost: O(n band²).
  double trace_of_inverse_times(const BandCholesky& B) const;

 private:
  double& entry(int i, int j) {
    return rows_[static_cast<size_t>(i) * (band_ + 1) + band_ + j - i];
  }
  double entry(int i, int j) const {
    return rows_[static_cast<size_t>(i) * (band_ + 1) + band_ + j - i];
  }
  int n_ = 0, band_ = 0;
  std::vector<double> rows_;  // row i of the matrix: its columns i - band_ … i
};

}  // namespace batten
