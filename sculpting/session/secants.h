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
/// f is taken at a sample of the dofs (the positions of vertices), which tells as much for a sixth
/// of the work. Pairs outlive the iteration that made them: when the load changes a little, they
/// still tell how the surface answers, and a drag converges in two iterations instead of eight. The
/// oldest makes room for the newest, and goes when the newest is nearly a combination of the
/// others. Allocates at resize() only. Source: Anderson 1965; Walker, Ni 2011.
class Secants {
 public:
  /// `sample`: dofs at which f is taken.
  void resize(long dofs, std::vector<int> sample);
  void clear() { count_ = 0; }
  /// No pair is made with the iterate before: another iteration begins.
  void begin() { has_last_ = false; }
  /// Takes the pair of this iterate and the one before. x, g = g(x): n×3.
  void learn(const Points& x, const Points& g);
  /// The g that was learnt last becomes the next guess.
  void guess(Points& g) const;

 private:
  static constexpr int kDepth = 6;
  size_t slot(int k) const { return static_cast<size_t>((first_ + k) % kDepth); }
  void take_out(const double* shares, Points& from) const;
  std::vector<int> sample_;
  std::vector<Points> df_, dg_;  // newest at slot(count_ - 1)
  Points f_, last_f_, last_g_;
  int first_ = 0, count_ = 0;
  bool has_last_ = false;
};

}  // namespace batten
