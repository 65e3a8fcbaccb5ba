// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/band_cholesky.h"

#include <algorithm>
#include <cmath>

namespace batten {
namespace {

// Row i of a band matrix, offset such that [j] is the entry (i, j).
template <class Rows>
auto* row_of(Rows& rows, int i, int band) {
  return rows.data() + static_cast<size_t>(i + 1) * band;
}

}  // namespace

void BandCholesky::reset(int n, int band) {
  n_ = n;
  band_ = std::min(band, std::max(n - 1, 0));
  rows_.assign(static_cast<size_t>(n) * (band_ + 1), 0.0);
}

void BandCholesky::add(const BandCholesky& B, double factor) {
  for (size_t k = 0; k < rows_.size(); ++k) rows_[k] += factor * B.rows_[k];
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
  // The diagonal stores the reciprocals of L's diagonal, so that the loops need no divisions.
  for (int i = 0; i < n_; ++i) {
    const int first = std::max(0, i - band_);
    double* const row = row_of(rows_, i, band_);
    double rest = row[i];
    for (int j = first; j < i; ++j) {
      const double* const other = row_of(rows_, j, band_);
      double sum = row[j];
      for (int k = first; k < j; ++k) sum -= row[k] * other[k];
      row[j] = sum * other[j];
      rest -= row[j] * row[j];
    }
    if (!(rest > 0) || !std::isfinite(rest)) return false;
    row[i] = 1 / std::sqrt(rest);
  }
  return true;
}

void BandCholesky::solve(Points& b) const {
  // The three columns are solved together: each one alone is a chain of dependent operations.
  double *const x = b.col(0).data(), *const y = b.col(1).data(), *const z = b.col(2).data();
  for (int i = 0; i < n_; ++i) {
    const double* const row = row_of(rows_, i, band_);
    double p = x[i], q = y[i], r = z[i];
    for (int k = std::max(0, i - band_); k < i; ++k) {
      p -= row[k] * x[k];
      q -= row[k] * y[k];
      r -= row[k] * z[k];
    }
    x[i] = p * row[i];
    y[i] = q * row[i];
    z[i] = r * row[i];
  }
  for (int i = n_ - 1; i >= 0; --i) {
    const double* const row = row_of(rows_, i, band_);
    const double p = x[i] *= row[i], q = y[i] *= row[i], r = z[i] *= row[i];
    for (int k = std::max(0, i - band_); k < i; ++k) {
      x[k] -= row[k] * p;
      y[k] -= row[k] * q;
      z[k] -= row[k] * r;
    }
  }
}

double BandCholesky::trace_of_inverse_times(const BandCholesky& B) const {
  // Z = A⁻¹ inside the band, computed row by row like the factor: L_jj Z_ij = δ_ij / L_jj - Σ_k
  // L_kj Z_ik, k > j.
  std::vector<double> inverse(rows_.size()), column(static_cast<size_t>(band_) + 1);
  double trace = 0;
  for (int j = n_ - 1; j >= 0; --j) {
    const int last = std::min(n_ - 1, j + band_);
    const double diagonal = entry(j, j);  // reciprocal of L_jj
    for (int k = j + 1; k <= last; ++k) column[static_cast<size_t>(k - j)] = entry(k, j);
    const double* const L = column.data() - j;
    for (int i = last; i >= j; --i) {
      double sum = i == j ? diagonal : 0;
      double* const row = row_of(inverse, i, band_);
      // Z_ik is stored in row i up to the diagonal and in row k beyond it.
      for (int k = j + 1; k <= i; ++k) sum -= L[k] * row[k];
      for (int k = std::max(i, j) + 1; k <= last; ++k) sum -= L[k] * row_of(inverse, k, band_)[i];
      row[j] = sum * diagonal;
      trace += (i == j ? 1 : 2) * row[j] * B.entry(i, j);
    }
  }
  return trace;
}

}  // namespace batten
