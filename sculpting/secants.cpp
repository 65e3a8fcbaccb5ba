#include "batten/sculpting/secants.h"

#include <cmath>

namespace batten {
namespace {

double dot(const Points& a, const Points& b) {
  return Eigen::Map<const VecX>(a.data(), a.size()).dot(Eigen::Map<const VecX>(b.data(), b.size()));
}

}  // namespace

void Secants::resize(long dofs) {
  count_ = 0;
  has_last_ = false;
  if (f_.rows() == dofs && !df_.empty()) return;
  df_.assign(kDepth, Points(dofs, 3));
  dg_.assign(kDepth, Points(dofs, 3));
  f_.resize(dofs, 3);
  last_f_.resize(dofs, 3);
  last_g_.resize(dofs, 3);
}

void Secants::accelerate(const Points& x, Points& g) {
  f_ = g - x;
  if (has_last_) {
    if (count_ == kDepth) {
      first_ = (first_ + 1) % kDepth;
      --count_;
    }
    for (;;) {
      const auto at = static_cast<size_t>((first_ + count_) % kDepth);
      df_[at] = f_ - last_f_;
      dg_[at] = g - last_g_;
      const double before = std::sqrt(dot(df_[at], df_[at]));
      for (int pass = 0; pass < 2; ++pass)
        for (int k = 0; k < count_; ++k) {
          const auto other = static_cast<size_t>((first_ + k) % kDepth);
          const double share = dot(df_[other], df_[at]);
          df_[at] -= share * df_[other];
          dg_[at] -= share * dg_[other];
        }
      const double length = std::sqrt(dot(df_[at], df_[at]));
      // Where little is left, the older pairs' errors would be blown up: they are of other loads,
      // and the oldest goes.
      constexpr double new_enough = 0.3;
      if (length > new_enough * before) {
        df_[at] /= length;
        dg_[at] /= length;
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
  for (int k = 0; k < count_; ++k) {
    const auto at = static_cast<size_t>((first_ + k) % kDepth);
    g -= dot(df_[at], f_) * dg_[at];
  }
}

}  // namespace batten
