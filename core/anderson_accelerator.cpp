// SPDX-License-Identifier: MPL-2.0
#include "batten/core/anderson_accelerator.h"

#include <algorithm>
#include <cmath>

namespace batten {
namespace {

double dot(const Points& a, const Points& b) {
  return Eigen::Map<const VecX>(a.data(), a.size()).dot(Eigen::Map<const VecX>(b.data(), b.size()));
}

}  // namespace

void AndersonAccelerator::resize(long rows, std::vector<int> sample) {
  reset();
  sample_ = std::move(sample);
  const long sampled = sample_.empty() ? rows : static_cast<long>(sample_.size());
  if (last_g_.rows() == rows && f_.rows() == sampled && !df_.empty()) return;
  df_.assign(static_cast<size_t>(depth_), Points(sampled, 3));
  dg_.assign(static_cast<size_t>(depth_), Points(rows, 3));
  coefficients_.assign(static_cast<size_t>(depth_), 0);
  f_.resize(sampled, 3);
  last_f_.resize(sampled, 3);
  last_g_.resize(rows, 3);
}

// from -= Σ coefficients_k dg_k, in blocks that fit in the cache.
void AndersonAccelerator::subtract_combination(const double* coefficients,
                                               Eigen::Ref<Points> from) const {
  constexpr long block = 2048;
  for (int c = 0; c < 3; ++c)
    for (long begin = 0; begin < from.rows(); begin += block) {
      const long size = std::min(from.rows() - begin, block);
      for (int k = 0; k < count_; ++k)
        from.col(c).segment(begin, size) -= coefficients[k] * dg_[k].col(c).segment(begin, size);
    }
}

void AndersonAccelerator::add_iterate(const Eigen::Ref<const Points>& x,
                                      const Eigen::Ref<const Points>& g) {
  if (sample_.empty()) f_ = g - x;
  for (int c = 0; c < 3; ++c)
    for (size_t i = 0; i < sample_.size(); ++i)
      f_(static_cast<long>(i), c) = g(sample_[i], c) - x(sample_[i], c);
  if (has_last_) {
    if (count_ == depth_) drop_oldest();
    for (;;) {
      Points& df = df_[count_];
      df = f_ - last_f_;
      const double before = std::sqrt(dot(df, df));
      auto coefficients = R_.col(count_);
      coefficients.setZero();
      for (int pass = 0; pass < 2; ++pass)  // the second pass makes them orthogonal to rounding
        for (int k = 0; k < count_; ++k) {
          const double coefficient = dot(df_[k], df);
          df -= coefficient * df_[k];
          coefficients[k] += coefficient;
        }
      const double length = std::sqrt(dot(df, df));
      if (length > independence_ * before) {
        Points& dg = dg_[count_];
        dg = g - last_g_;
        subtract_combination(coefficients.data(), dg);
        df /= length;
        dg /= length;
        coefficients[count_++] = length;
        break;
      }
      if (count_ == 0) break;
      drop_oldest();
    }
  }
  last_f_ = f_;
  last_g_ = g;
  has_last_ = true;
}

// Deletes the first column of ΔF = Q R, with Q in df_ and ΔG R⁻¹ in dg_: Givens rotations of adjacent
// rows make the other columns of R triangular again, and turn the columns of Q and ΔG R⁻¹ likewise.
void AndersonAccelerator::drop_oldest() {
  for (int i = 0; i + 1 < count_; ++i) {
    const double r = std::hypot(R_(i, i + 1), R_(i + 1, i + 1));
    const double c = R_(i, i + 1) / r, s = R_(i + 1, i + 1) / r;
    for (int j = i + 1; j < count_; ++j) {
      const double a = R_(i, j), b = R_(i + 1, j);
      R_(i, j) = c * a + s * b;
      R_(i + 1, j) = c * b - s * a;
    }
    for (std::vector<Points>* columns : {&df_, &dg_}) {
      Points &x = (*columns)[i], &y = (*columns)[i + 1];
      for (long k = 0; k < x.size(); ++k) {
        const double a = x.data()[k], b = y.data()[k];
        x.data()[k] = c * a + s * b;
        y.data()[k] = c * b - s * a;
      }
    }
  }
  --count_;
  for (int j = 0; j < count_; ++j) R_.col(j) = R_.col(j + 1);
}

void AndersonAccelerator::extrapolate(Eigen::Ref<Points> g) {
  for (int k = 0; k < count_; ++k) coefficients_[k] = dot(df_[k], last_f_);
  subtract_combination(coefficients_.data(), g);
}

}  // namespace batten
