// A side of a region: boundary curves from one corner to the next, by arc length. Internal.
#pragma once

#include <vector>

#include "batten/fem/curve.h"

namespace batten {

/// A chain of curves and of their images in (u, v), as a function of the fraction f of its arc
/// length, 0 at its start and 1 at its end.
class BoundarySide {
 public:
  struct Point {
    Vec3 x, x_f;    ///< position and its derivative by f, model units
    Vec2 uv, uv_f;  ///< image and its derivative by f
  };

  /// Adds a curve behind those added before. `image` is over the parameters of `curve`, z = 0.
  void add(HermiteCurve curve, HermiteCurve image);

  double length() const { return lengths_.empty() ? 0 : lengths_.back(); }  ///< model units
  /// The point at a fraction of the length; beyond the ends the side goes on straight.
  /// O(log segments).
  Point at(double f) const;

 private:
  Point on(double length) const;

  struct Piece {
    HermiteCurve curve, image;
  };
  // Arc length is tabulated at a few parameters of each segment.
  struct Knot {
    int piece;
    double from, to;  // parameters of the piece's curve
  };
  std::vector<Piece> pieces_;
  std::vector<Knot> knots_;
  std::vector<double> lengths_;  // arc length at the end of each knot's interval
};

}  // namespace batten
