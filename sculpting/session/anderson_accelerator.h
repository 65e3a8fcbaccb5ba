// Acceleration of a fixed point x = g(x) whose operator is nearly the same from call to call.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Anderson's method with the pairs (Δf, Δg), f = g - x, of successive iterates, Δf made
/// orthonormal as they come:
///
///     x_next = g - Σ_k (Δf_k · f) Δg_k
///
/// f is taken at a sample of the dofs (the positions of vertices), which is as good for a sixth of
/// the work. Pairs are kept from one answer to the next: when the load changes a little, they still
/// say how the surface gives way, and a drag converges in two iterations instead of eight. Six
/// pairs are kept; the oldest goes when a seventh comes, or when the newest is nearly a combination
/// of the others. Memory is allocated in resize() only. Source: Anderson 1965; Walker, Ni 2011.
class AndersonAccelerator {
 public:
  /// Makes room for x of so many dofs and forgets all pairs. `sample`: dofs at which f is taken.
  void resize(long dofs, std::vector<int> sample);
  void clear() { count_ = 0; }
  /// Begins another iteration: no pair is made with the iterate before.
  void begin() { has_last_ = false; }
  /// Takes the pair of this iterate and the one before it. x and g = g(x) are n×3.
  void add_iterate(const Points& x, const Points& g);
  /// Turns g, the one that was learnt last, into the next guess x_next.
  void extrapolate(Points& g) const;

 private:
  static constexpr int kDepth = 6;
  size_t slot(int k) const { return static_cast<size_t>((first_ + k) % kDepth); }
  void subtract_combination(const double* coefficients, Points& from) const;
  std::vector<int> sample_;
  std::vector<Points> df_, dg_;  // newest at slot(count_ - 1)
  Points f_, last_f_, last_g_;
  int first_ = 0, count_ = 0;
  bool has_last_ = false;
};

}  // namespace batten
