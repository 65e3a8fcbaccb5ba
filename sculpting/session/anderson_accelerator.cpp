#include "batten/sculpting/session/anderson_accelerator.h"

#include <algorithm>
#include <cmath>

namespace batten {
namespace {

double dot(const Points& a, const Points& b) {
  return Eigen::Map<const VecX>(a.data(), a.size()).dot(Eigen::Map<const VecX>(b.data(), b.size()));
}

}  // namespace

void AndersonAccelerator::resize(long dofs, std::vector<int> sample) {
  count_ = 0;
  has_last_ = false;
  sample_ = std::move(sample);
  const auto seen = static_cast<long>(sample_.size());
  if (last_g_.rows() == dofs && f_.rows() == seen && !df_.empty()) return;
  df_.assign(kDepth, Points(seen, 3));
  dg_.assign(kDepth, Points(dofs, 3));
  f_.resize(seen, 3);
  last_f_.resize(seen, 3);
  last_g_.resize(dofs, 3);
}

// from -= Σ shares_k dg_k, a stretch that stays in the cache at a time.
void AndersonAccelerator::subtract_combination(const double* coefficients, Points& from) const {
  constexpr long stretch = 2048;
  double* to = from.data();
  for (long begin = 0; begin < from.size(); begin += stretch) {
    const long end = std::min(from.size(), begin + stretch);
    for (int k = 0; k < count_; ++k) {
      const double s = coefficients[k];
      const double* dg = dg_[slot(k)].data();
      for (long i = begin; i < end; ++i) to[i] -= s * dg[i];
    }
  }
}

void AndersonAccelerator::add_iterate(const Points& x, const Points& g) {
  for (int c = 0; c < 3; ++c)
    for (size_t i = 0; i < sample_.size(); ++i)
      f_(static_cast<long>(i), c) = g(sample_[i], c) - x(sample_[i], c);
  double coefficients[kDepth];
  if (has_last_) {
    if (count_ == kDepth) {
      first_ = (first_ + 1) % kDepth;
      --count_;
    }
    for (;;) {
      Points& df = df_[slot(count_)];
      df = f_ - last_f_;
      const double before = std::sqrt(dot(df, df));
      std::fill(coefficients, coefficients + kDepth, 0);
      for (int pass = 0; pass < 2; ++pass)
        for (int k = 0; k < count_; ++k) {
          const double coefficient = dot(df_[slot(k)], df);
          df -= coefficient * df_[slot(k)];
          coefficients[k] += coefficient;
        }
      const double length = std::sqrt(dot(df, df));
      // Where little is left, the older pairs' errors would be blown up: they are of other loads,
      // and the oldest goes.
      constexpr double new_enough = 0.3;
      if (length > new_enough * before) {
        Points& dg = dg_[slot(count_)];
        dg = g - last_g_;
        subtract_combination(coefficients, dg);
        df /= length;
        dg /= length;
        ++count_;
        break;
      }
      if (count_ == 0) break;
      first_ = (first_ + 1) % kDepth;
      --count_;
    }
  }
  last_f_ = f_;
  last_g_ = g;
  has_last_ = true;
}

void AndersonAccelerator::extrapolate(Points& g) const {
  double coefficients[kDepth];
  for (int k = 0; k < count_; ++k) coefficients[k] = dot(df_[slot(k)], last_f_);
  subtract_combination(coefficients, g);
}

}  // namespace batten
