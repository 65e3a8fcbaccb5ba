#include "batten/core/band_cholesky.h"

#include <algorithm>
#include <cmath>

namespace batten {

void BandCholesky::reset(int n, int band) {
  n_ = n;
  band_ = std::min(band, std::max(n - 1, 0));
  rows_.assign(static_cast<size_t>(n) * (band_ + 1), 0.0);
}

void BandCholesky::fix(int i, const Vec3& value, Points& b) {
  const int first = std::max(0, i - band_), last = std::min(n_ - 1, i + band_);
  for (int j = first; j <= last; ++j) {
    double& a = j < i ? entry(i, j) : entry(j, i);
    if (j != i) b.row(j) -= a * value.transpose();
    a = 0;
  }
  entry(i, i) = 1;
  b.row(i) = value;
}

bool BandCholesky::factorize() {
  for (int i = 0; i < n_; ++i) {
    const int first = std::max(0, i - band_);
    for (int j = first; j <= i; ++j) {
      double sum = entry(i, j);
      for (int k = std::max(first, j - band_); k < j; ++k) sum -= entry(i, k) * entry(j, k);
      if (j < i) {
        entry(i, j) = sum / entry(j, j);
      } else {
        if (!(sum > 0) || !std::isfinite(sum)) return false;
        entry(i, i) = std::sqrt(sum);
      }
    }
  }
  return true;
}

void BandCholesky::solve(Points& b) const {
  for (int c = 0; c < 3; ++c) {
    double* x = b.col(c).data();
    for (int i = 0; i < n_; ++i) {
      double sum = x[i];
      for (int k = std::max(0, i - band_); k < i; ++k) sum -= entry(i, k) * x[k];
      x[i] = sum / entry(i, i);
    }
    for (int i = n_ - 1; i >= 0; --i) {
      x[i] /= entry(i, i);
      for (int k = std::max(0, i - band_); k < i; ++k) x[k] -= entry(i, k) * x[i];
    }
  }
}

VecX BandCholesky::inverse_diagonal() const {
  // Z = A⁻¹ inside the band, row by row as the factor: L_jj Z_ij = δ_ij / L_jj - Σ_k L_kj Z_ik, k >
  // j.
  std::vector<double> inverse(rows_.size(), 0.0);
  const auto z = [&](int i, int j) -> double& {
    if (i < j) std::swap(i, j);
    return inverse[static_cast<size_t>(i) * (band_ + 1) + band_ + j - i];
  };
  VecX diagonal(n_);
  for (int j = n_ - 1; j >= 0; --j) {
    const int last = std::min(n_ - 1, j + band_);
    for (int i = last; i >= j; --i) {
      double sum = i == j ? 1 / entry(j, j) : 0;
      for (int k = j + 1; k <= last; ++k) sum -= entry(k, j) * z(i, k);
      z(i, j) = sum / entry(j, j);
    }
    diagonal[j] = z(j, j);
  }
  return diagonal;
}

}  // namespace batten
