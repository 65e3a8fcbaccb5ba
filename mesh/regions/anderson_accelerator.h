// Fewer rounds for fixed points that are approached slowly. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Anderson's mixing for y = g(y): from the last rounds the combination of their steps is taken that
/// would leave the smallest residual g(y) - y if g were linear,
///
///     y⁺ = g - Σ_j θ_j Δg_j,   min_θ |f - Σ_j θ_j Δf_j|,   f = g(y) - y
///
/// Nothing says that y⁺ is better than g: the caller compares energies. Sums are taken in one order.
/// Source: Anderson 1965; Walker and Ni 2011; Peng et al. 2018 (for alternations, with the check).
class AndersonAccelerator {
 public:
  static constexpr int kMemory = 6;

  explicit AndersonAccelerator(long rows);
  /// Forgets all rounds.
  void reset() { history_size_ = 0; }
  /// One round: y and g(y). Returns whether `accelerated` holds y⁺; not in the first round after reset().
  /// Allocates nothing.
  bool accelerate(const MatX& y, const MatX& g, MatX& accelerated);

 private:
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMemory, kMemory>;
  long history_size_ = 0;
  MatX f_, g_;                         // of the last round
  std::vector<MatX> step_f_, step_g_;  // Δf, Δg in a ring
  Eigen::Matrix<double, kMemory, kMemory> products_;
};

}  // namespace batten
