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
  df_.assign(kDepth, Points(sampled, 3));
  dg_.assign(kDepth, Points(rows, 3));
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
        from.col(c).segment(begin, size) -=
            coefficients[k] * dg_[slot(k)].col(c).segment(begin, size);
    }
}

void AndersonAccelerator::add_iterate(const Eigen::Ref<const Points>& x,
                                      const Eigen::Ref<const Points>& g) {
  if (sample_.empty()) f_ = g - x;
  for (int c = 0; c < 3; ++c)
    for (size_t i = 0; i < sample_.size(); ++i)
      f_(static_cast<long>(i), c) = g(sample_[i], c) - x(sample_[i], c);
  double coefficients[kDepth];
  const auto drop_oldest = [&] {
    first_ = (first_ + 1) % kDepth;
    --count_;
  };
  if (has_last_) {
    if (count_ == kDepth) drop_oldest();
    for (;;) {
      Points& df = df_[slot(count_)];
      df = f_ - last_f_;
      const double before = std::sqrt(dot(df, df));
      std::fill(coefficients, coefficients + kDepth, 0);
      for (int pass = 0; pass < 2; ++pass)  // the second pass makes them orthogonal to rounding
        for (int k = 0; k < count_; ++k) {
          const double coefficient = dot(df_[slot(k)], df);
          df -= coefficient * df_[slot(k)];
          coefficients[k] += coefficient;
        }
      const double length = std::sqrt(dot(df, df));
      if (length > independence_ * before) {
        Points& dg = dg_[slot(count_)];
        dg = g - last_g_;
        subtract_combination(coefficients, dg);
        df /= length;
        dg /= length;
        ++count_;
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

void AndersonAccelerator::extrapolate(Eigen::Ref<Points> g) const {
  double coefficients[kDepth];
  for (int k = 0; k < count_; ++k) coefficients[k] = dot(df_[slot(k)], last_f_);
  subtract_combination(coefficients, g);
}

}  // namespace batten
