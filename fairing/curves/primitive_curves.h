// Curves that a few numbers describe: arcs, ellipses, helices, rectangles, splines by their poles,
// and copies of curves.
#pragma once

#include <memory>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// A plane with two perpendicular unit directions; angles go from x to y.
struct CurvePlane {
  Vec3 centre = Vec3::Zero(), x = Vec3::UnitX(), y = Vec3::UnitY();
  Vec3 normal() const { return x.cross(y); }
};
/// The plane through `centre` with this normal, seen from its tip: x is the part of `along` in the
/// plane, y a quarter turn to the left of it. Throws InputError: a normal of length zero, `along`
/// parallel to it.
CurvePlane curve_plane(const Vec3& centre, const Vec3& normal, const Vec3& along);

/// The circular arc from a over b to c, as ellipse_arc() makes it. Throws InputError when they are on a line.
std::shared_ptr<const InputCurve> arc_through(const Vec3& a, const Vec3& b, const Vec3& c);
/// centre + a cos t x + b sin t y for t between two angles in radians, backwards when `to` < `from`;
/// closed when they are 2π apart. Circular arcs are cubics that are off the circle by 1e-8 of the
/// radius, and u is the length to as much; of others u is |t| times the larger radius. Throws InputError: a
/// radius that is not above 0, angles that are equal or more than 2π apart.
std::shared_ptr<const InputCurve> ellipse_arc(const CurvePlane& plane, double a, double b,
                                              double from, double to);
/// centre + radius (cos t x + sin t y) + pitch t / 2π normal, from t = 0 over `turns` turns; a
/// negative pitch makes it left-handed. u is the length. Throws InputError: a radius or a number of
/// turns that is not above 0.
std::shared_ptr<const InputCurve> helix(const CurvePlane& plane, double radius, double pitch,
                                        double turns);
/// The closed rectangle of this width along x and height along y around the centre, from the middle
/// of its lower side to the left around the normal. `radius` > 0: with arcs at its corners, along
/// which the direction goes on. Throws InputError: a side that is not above 0, a radius below 0 or
/// above half of a side.
std::shared_ptr<const InputCurve> rectangle(const CurvePlane& plane, double width, double height,
                                            double radius);
/// The B-spline Σ N_i(t) w_i p_i / Σ N_i(t) w_i of this degree, 1 to 9, over the knots, as many as
/// poles, degree and one more. Without knots they are clamped and even, [0, 1]; without weights
/// these are 1. Throws InputError: numbers of knots or weights that do not fit, knots that descend
/// or of which more than `degree` inner ones are equal, a weight that is not above 0.
std::shared_ptr<const InputCurve> nurbs_curve(int degree, const std::vector<Vec3>& poles,
                                              const std::vector<double>& weights,
                                              const std::vector<double>& knots);

/// Curves one after the other, each beginning where the one before ends. Throws InputError where
/// there are none.
std::shared_ptr<const InputCurve> concatenated(
    std::vector<std::shared_ptr<const InputCurve>> curves);

/// x ↦ A x + b.
struct AffineTransform {
  Mat3 A = Mat3::Identity();
  Vec3 b = Vec3::Zero();
  Vec3 operator()(const Vec3& x) const { return A * x + b; }
  /// This one, then another.
  AffineTransform then(const AffineTransform& next) const {
    return {next.A * A, next.A * b + next.b};
  }
};
/// Throws InputError when the length of the normal or the axis is zero; factor above 0.
AffineTransform reflection_in(const Vec3& point, const Vec3& normal);
AffineTransform rotation_about(const Vec3& point, const Vec3& axis, double radians);
AffineTransform scaling_about(const Vec3& point, double factor);
/// The curve at another place, over the same parameter.
std::shared_ptr<const InputCurve> transformed(std::shared_ptr<const InputCurve> curve,
                                              const AffineTransform& transform);

}  // namespace batten
