// Cholesky factor of a matrix whose entries lie near the diagonal: curves.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A = L Lᵀ, symmetric positive definite, entries up to `band` places below the diagonal. O(n
/// band²) to factor, O(n band) a solve: microseconds for a curve of a hundred segments, where a
/// general sparse factor spends longer on its order. One object may be used again for another size.
class BandCholesky {
 public:
  /// Begins a matrix of n unknowns with all entries zero.
  void reset(int n, int band);
  int size() const { return n_; }

  /// A(i, j) += value, for |i - j| ≤ band. Before factorize() only.
  void add(int i, int j, double value) { (i >= j ? entry(i, j) : entry(j, i)) += value; }
  /// A += factor B, of the same size and band, not factored either.
  void add(const BandCholesky& B, double factor);
  /// A(i, i), before factorize().
  double diagonal(int i) const { return entry(i, i); }
  /// x_i = value from now on: moves column i to the right-hand side b (n×3). Before factorize()
  /// only, after everything was added.
  void fix(int i, const Vec3& value, Points& b);

  /// Factors A. Returns false when A is not positive definite.
  bool factorize();
  /// b becomes x with A x = b.
  void solve(Points& b) const;
  /// trace(A⁻¹ B), B of the same size and band, not factored: by the recursion of Takahashi, Fagan,
  /// Chin 1973 on the entries of the inverse inside the band. O(n band²).
  double trace_of_inverse_times(const BandCholesky& B) const;

 private:
  double& entry(int i, int j) {
    return rows_[static_cast<size_t>(i) * (band_ + 1) + band_ + j - i];
  }
  double entry(int i, int j) const {
    return rows_[static_cast<size_t>(i) * (band_ + 1) + band_ + j - i];
  }
  int n_ = 0, band_ = 0;
  std::vector<double> rows_;  // row i: columns i - band … i
};

}  // namespace batten
