// Fixed points in fewer rounds. Internal.
#pragma once

#include <deque>

#include "batten/core/dense.h"
#include "batten/core/eigen.h"

namespace batten {

/// Anderson's acceleration of rounds x → G(x) that converge slowly: of the last few rounds the combination
/// with Σ γ = 1 is taken whose residual G(x) - x is least in the norm of `mass`, columns together. Rows that all
/// G(x) keep are kept. Source: Walker and Ni 2011, "Anderson acceleration for fixed-point iterations", (4.1).
class AndersonAccelerator {
 public:
  explicit AndersonAccelerator(const SparseMatrix& mass) : mass_(mass) {}

  /// The next x, from x and G(x).
  Points next(const Points& x, const Points& g) {
    constexpr size_t most = 6;
    const Points residual = g - x;
    if (last_residual_.size() > 0) {
      residuals_.push_back(residual - last_residual_);
      steps_.push_back(g - last_g_);
      if (residuals_.size() > most) {
        residuals_.pop_front();
        steps_.pop_front();
      }
    }
    last_residual_ = residual;
    last_g_ = g;
    const long n = static_cast<long>(residuals_.size());
    if (n == 0) return g;
    MatX A(n, n);
    VecX b(n);
    for (long i = 0; i < n; ++i) {
      const Points weighted = mass_.selfadjointView<Eigen::Lower>() * residuals_[i];
      for (long j = 0; j < n; ++j) A(i, j) = weighted.cwiseProduct(residuals_[j]).sum();
      b[i] = weighted.cwiseProduct(residual).sum();
    }
    A.diagonal() *= 1 + 1e-10;
    const VecX gamma = least_squares(A, b);
    Points result = g;
    for (long i = 0; i < n; ++i) result -= gamma[i] * steps_[i];
    return result;
  }

 private:
  const SparseMatrix& mass_;
  std::deque<Points> residuals_, steps_;
  Points last_residual_ = Points(0, 3), last_g_;
};

}  // namespace batten
