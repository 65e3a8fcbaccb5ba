// Whether two arms that meet at a point are nearer to noisy points than a smooth curve. Internal.
#pragma once

#include <array>
#include <map>

#include "batten/core/eigen.h"

namespace batten {

class CornerLikelihoodTest {
 public:
  /// With χ² the sum of squared distances across the curve over the noise squared: by how much
  /// that of the best smooth curve (a polynomial in the points' number, up to the third degree
  /// beside straight arms, to the fifth beside parabolic ones) is above that of two arms that meet
  /// at point `corner` (a row of `points`), over max(1, χ²/dof) of the latter and times the turn
  /// over 50 degrees (0.7 to 2): noise seldom makes sharp turns.
  /// Where they turn by more than 75 degrees, distances along the curve count too, over those along
  /// the arms: a curve that turns so far on the spot is slow there, and points are not. 0 where the arms meet at
  /// `least_turn` degrees or less, are no good fit themselves, or gain no more than `least`; -1
  /// where parabolic arms fit so badly that longer ones will too.
  /// `noise` > 0. Remembers the matrices of each size: later calls cost O(points).
  double gain(const Points& points, int corner, double noise, double least_turn, double least = 0);

 private:
  struct Shape {
    MatX values, slopes, inverse;  // inverseᵀ points: the coefficients of least squares
  };
  struct Fit {
    double chi = 0;    // across the curve
    double along = 0;  // squares along it, likewise over the noise squared
    Points coefficients;
  };
  // Polynomials up to `degree`; with arms ≥ 0, on both sides of that point.
  const Shape& shape(int count, int corner, int degree);
  static Fit fit(const Shape& shape, const Points& points, double noise);
  // What arms can do and no polynomial up to 2 degree + 1 can: an orthonormal basis, one column a
  // function, and by how much they lower χ², distances along the curve included.
  const MatX& kinks(int count, int corner, int degree);
  double max_gain(const Points& points, int corner, int degree, double noise);

  std::map<std::array<int, 3>, Shape> shapes_;
  std::map<std::array<int, 3>, MatX> kinks_;
  std::map<int, MatX> polynomials_;  // orthonormal, up to the fifth degree, by count
};

}  // namespace batten
