// Curves of cubic pieces over increasing knots. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A C1 curve by its values and slopes at knots; beyond its ends it goes straight on.
class PiecewiseCubic {
 public:
  PiecewiseCubic() = default;
  PiecewiseCubic(std::vector<double> knots, Points values, Points slopes)
      : knots_(std::move(knots)), values_(std::move(values)), slopes_(std::move(slopes)) {}

  /// How an interpolating curve ends.
  enum class Ends {
    Natural,  ///< without curvature
    Flat      ///< with slope zero
  };
  /// The curve through one value a knot of least ∫ |x''|² du, which is C2. O(knots).
  static PiecewiseCubic through(std::vector<double> knots, const Points& values, Ends ends);
  /// The C2 curve of `spans` even pieces over [u_first, u_last] that comes nearest to values at u
  /// in the least-squares sense: uniform cubic B-splines. `u` ascends, at least once in every piece
  /// and spans + 3 times in all, first < last. O(values + spans).
  static PiecewiseCubic fitted(const std::vector<double>& u, const Points& values, int spans);

  const std::vector<double>& knots() const { return knots_; }
  Vec3 at(double u) const;
  Vec3 slope(double u) const;

 private:
  int piece(double u) const;
  std::vector<double> knots_;
  Points values_, slopes_;
};

}  // namespace batten
