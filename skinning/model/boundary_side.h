// A side of a region: boundary curves from one corner to the next, by arc length. Internal.
#pragma once

#include <vector>

#include "batten/fem/hermite_curve.h"

namespace batten {

/// A chain of curves and of their images in (u, v), as a function of the fraction f of its arc
/// length, 0 at its start and 1 at its end.
class BoundarySide {
 public:
  struct Point {
    Vec3 x, x_f;    ///< position and its derivative by f, model units
    Vec2 uv, uv_f;  ///< image and its derivative by f
  };

  /// Adds a curve behind those added before. `pcurve` is over the parameters of `curve`, z = 0.
  void add(HermiteCurve curve, HermiteCurve pcurve);

  double length() const { return lengths_.empty() ? 0 : lengths_.back(); }  ///< model units
  /// The point at a fraction of the length; beyond the ends the side goes on straight.
  /// O(log segments).
  Point at(double f) const;

 private:
  Point on(double length) const;

  // A part of a segment. Arc length is tabulated at its ends.
  struct Part {
    int piece;
    double from, to;  // parameters of the piece's curve
    Vec3 c[4];        // x = c0 + c1 t + c2 t² + c3 t³, t from 0 to 1
    double rates[2];  // dt/ds at both ends, times the length of the part

    Vec3 position(double t) const { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); }
    Vec3 slope(double t) const { return c[1] + t * (2 * c[2] + 3 * t * c[3]); }
    double length_to(double t) const;
  };
  std::vector<HermiteCurve> pcurves_;  // of the pieces
  std::vector<Part> parts_;
  std::vector<double> lengths_;  // arc length at the end of each part
};

}  // namespace batten
