// SPDX-License-Identifier: MPL-2.0
// Anderson acceleration of fixed-point iterations.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Anderson acceleration of a fixed-point iteration x ← g(x) of n×3 values.
///
/// With the residual f = g(x) - x, it stores the differences Δf, Δg of up to `depth` successive
/// iterates. Each new Δf is orthonormalised against the stored ones. The accelerator proposes the
/// combination that would minimise |f| if g were affine:
///
///     x_next = g - Σ_k (Δf_k · f) Δg_k
///
/// f may be restricted to a sample of the dofs, for example the positions of vertices. This costs
/// less and avoids mixing the different scales of positions and derivatives. The oldest difference
/// is dropped when there are more than `depth`. The oldest difference is also dropped if less than the
/// fraction `independence` of the newest Δf is linearly independent of the stored ones.
///
/// The differences may be kept when the right-hand side changes: they remain valid while the
/// operator hardly changes. An interactive drag then converges in two iterations instead of eight.
///
/// x_next is not guaranteed to be better than g: if that matters, the caller must compare energies.
/// Cost: O(n) per iterate and stored difference; only resize() allocates memory. Reference:
/// [Anderson1965], [WalkerNi2011].
class AndersonAccelerator {
 public:
  /// `independence`: fraction between 0 and 1. If less than this fraction of a new residual
  /// difference is linearly independent of the stored residual differences, the oldest one is
  /// dropped. Use a large value (0.3) if stored differences are kept when the right-hand side
  /// changes, because a small value would amplify their errors. Otherwise use 0.1 or less. `depth`:
  /// largest number of stored differences, at least 1.
  explicit AndersonAccelerator(double independence = 0.3, int depth = 6)
      : independence_(independence), depth_(depth), R_(MatX::Zero(depth, depth)) {}

  /// Allocates memory for n×3 iterates x, with n = `rows`, and drops all stored iterates. `sample`:
  /// rows at which the residual g(x) - x of the fixed-point map g is measured; empty: all rows.
  void resize(long rows, std::vector<int> sample = {});
  /// Drops the last iterate and all stored differences of successive iterates.
  void reset() { count_ = 0, has_last_ = false; }
  /// Drops all stored differences of successive iterates but keeps the last iterate.
  void clear() { count_ = 0; }
  /// Starts a new fixed-point iteration: the next iterate forms no difference with the last one.
  /// Stored differences of earlier iterates are kept.
  void begin() { has_last_ = false; }

  /// Adds an iterate x and its image g = g(x) under the fixed-point map. Both have three columns
  /// and as many rows as passed to resize().
  void add_iterate(const Eigen::Ref<const Points>& x, const Eigen::Ref<const Points>& g);
  /// Replaces `g`, which must be the image passed to the last add_iterate(), by the accelerated
  /// iterate, the combination of stored iterates that would minimise the residual if the
  /// fixed-point map were affine.
  void extrapolate(Eigen::Ref<Points> g);
  /// Adds an iterate `x` with its image `g` under the fixed-point map and writes the accelerated
  /// iterate to `next`. Returns false and leaves `next` unchanged if no difference is stored yet
  /// (first iterate after reset()).
  template <class Matrix>
  bool accelerate(const Matrix& x, const Matrix& g, Matrix& next) {
    add_iterate(x, g);
    if (count_ == 0) return false;
    next = g;
    extrapolate(next);
    return true;
  }

 private:
  void drop_oldest();
  void subtract_combination(const double* coefficients, Eigen::Ref<Points> from) const;

  double independence_;
  int depth_;
  std::vector<int> sample_;
  // Q of the residual differences ΔF = Q R, and image differences ΔG R⁻¹; oldest first.
  std::vector<Points> df_, dg_;
  MatX R_;  // R of ΔF = Q R
  Points f_, last_f_, last_g_;
  std::vector<double> coefficients_;  // of extrapolate()
  int count_ = 0;
  bool has_last_ = false;
};

}  // namespace batten
