// Anderson acceleration of fixed-point iterations.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Anderson acceleration of a fixed-point iteration x ← g(x) of n×3 values.
///
/// It keeps the differences Δf, Δg of up to six successive iterates, f = g(x) - x, with the Δf made
/// orthonormal as they come, and proposes the combination that would leave the smallest f if g were
/// affine:
///
///     x_next = g - Σ_k (Δf_k · f) Δg_k
///
/// f may be restricted to a sample of the dofs (the positions of vertices, say), which costs less and
/// gives positions and derivatives one scale. The oldest difference is dropped when a seventh comes, and
/// when less than `independence` of the newest one is linearly independent of the others. The differences
/// may be kept from one right-hand side to the next one: while the operator hardly changes they remain valid,
/// and a drag converges in two iterations instead of eight.
///
/// Nothing guarantees that x_next is better than g: where that matters, the caller compares energies.
/// Costs O(n) per iterate and difference; memory is allocated in resize() only.
/// Reference: [Anderson1965], [WalkerNi2011].
class AndersonAccelerator {
 public:
  /// `independence`: between 0 and 1. Large values (0.3) suit differences that stem from other right-hand
  /// sides, whose errors would be amplified; small ones (1e-5) a single iteration.
  explicit AndersonAccelerator(double independence = 0.3) : independence_(independence) {}

  /// Reserves memory for iterates of `rows` rows and drops all differences. `sample`: rows at which f is
  /// measured; empty: all.
  void resize(long rows, std::vector<int> sample = {});
  /// Drops all differences and the last iterate.
  void reset() { count_ = 0, has_last_ = false; }
  /// Drops the differences, but keeps the last iterate.
  void clear() { count_ = 0; }
  /// Begins another iteration: no difference is formed with the iterate before.
  void begin() { has_last_ = false; }

  /// Adds an iterate x and g = g(x), both rows×3.
  void add_iterate(const Eigen::Ref<const Points>& x, const Eigen::Ref<const Points>& g);
  /// Turns g, the one that was added last, into x_next.
  void extrapolate(Eigen::Ref<Points> g) const;
  /// Adds an iterate and sets `next` to x_next. Returns false, and leaves `next` alone, without any
  /// difference, that is for the first iterate after reset().
  template <class Matrix>
  bool accelerate(const Matrix& x, const Matrix& g, Matrix& next) {
    add_iterate(x, g);
    if (count_ == 0) return false;
    next = g;
    extrapolate(next);
    return true;
  }

 private:
  static constexpr int kDepth = 6;
  size_t slot(int k) const { return static_cast<size_t>((first_ + k) % kDepth); }
  void subtract_combination(const double* coefficients, Eigen::Ref<Points> from) const;

  double independence_;
  std::vector<int> sample_;
  std::vector<Points> df_, dg_;  // newest at slot(count_ - 1)
  Points f_, last_f_, last_g_;
  int first_ = 0, count_ = 0;
  bool has_last_ = false;
};

}  // namespace batten
