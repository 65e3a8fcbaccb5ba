// SPDX-License-Identifier: MPL-2.0
// Curves defined by a few numbers (arcs, ellipses, helices, rectangles, NURBS), and transformed
// copies.
#pragma once

#include <memory>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// A plane with an orthonormal basis; angles are measured from x towards y.
struct CurvePlane {
  Vec3 centre = Vec3::Zero(), x = Vec3::UnitX(), y = Vec3::UnitY();
  Vec3 normal() const { return x.cross(y); }
};
/// Makes the plane through `centre` with the given normal.
///
/// x is the projection of `along` onto the plane; y is x rotated by +90° about the normal. Throws
/// InputError for a normal of length zero or one that is parallel to `along`.
CurvePlane curve_plane(const Vec3& centre, const Vec3& normal, const Vec3& along);

/// Circular arc from a through b to c, made by ellipse_arc(). Throws InputError if the points are
/// collinear.
std::shared_ptr<const InputCurve> arc_through(const Vec3& a, const Vec3& b, const Vec3& c);
/// Elliptical arc centre + a cos t x + b sin t y, with the centre, x and y of `plane`, for t
/// between the angles `from` and `to`, radians.
///
/// If `to` < `from`, the arc runs backwards; if the angles are 2π apart, it is closed. Circular
/// arcs (a = b) are cubics that deviate from the circle by 1e-8 of the radius, and their parameter
/// is arc length to the same accuracy. For other ellipses, the parameter is |t| times the larger
/// radius. Throws InputError for a radius that is not above 0 and for angles that are equal or more
/// than 2π apart.
std::shared_ptr<const InputCurve> ellipse_arc(const CurvePlane& plane, double a, double b,
                                              double from, double to);
/// Helix centre + radius (cos t x + sin t y) + pitch t / 2π normal, with the centre, x, y and
/// normal of `plane`, from t = 0 over `turns` turns.
///
/// A negative pitch makes the helix left-handed. The parameter of the curve is arc length. Throws
/// InputError for a radius or a number of turns that is not above 0.
std::shared_ptr<const InputCurve> helix(const CurvePlane& plane, double radius, double pitch,
                                        double turns);
/// Closed rectangle around the centre of `plane`, `width` along its x and `height` along its y.
///
/// It starts at the midpoint of its lower side and runs counter-clockwise about the normal. If
/// `radius` > 0, the corners are rounded with tangent arcs. Throws InputError for a side that is
/// not above 0, and for a radius below 0 or above half of a side.
std::shared_ptr<const InputCurve> rectangle(const CurvePlane& plane, double width, double height,
                                            double radius);
/// NURBS curve Σ N_i(t) w_i p_i / Σ N_i(t) w_i of degree 1 to 9, with weights w_i and poles p_i.
///
/// The number of knots is the number of poles + degree + 1. Empty `knots`: clamped and uniform over
/// [0, 1]. Empty `weights`: all 1. Throws InputError for a wrong number of knots or weights, for
/// descending knots, for more than `degree` equal inner knots, and for a weight that is not above
/// 0.
std::shared_ptr<const InputCurve> nurbs_curve(int degree, const std::vector<Vec3>& poles,
                                              const std::vector<double>& weights,
                                              const std::vector<double>& knots);

/// Concatenates curves, each of which must begin where the previous one ends. Throws InputError if
/// `curves` is empty.
std::shared_ptr<const InputCurve> concatenated(
    std::vector<std::shared_ptr<const InputCurve>> curves);

/// Affine map x ↦ A x + b.
struct AffineTransform {
  Mat3 A = Mat3::Identity();
  Vec3 b = Vec3::Zero();
  Vec3 operator()(const Vec3& x) const;
  /// Composition that applies this map first, then `next`.
  AffineTransform then(const AffineTransform& next) const;
};
/// Reflection in the plane through `point` with the given normal, as an affine map.
/// rotation_about() and scaling_about() create rotations and uniform scalings (`factor` above 0).
/// The functions throw InputError if the normal or the axis has length zero.
AffineTransform reflection_in(const Vec3& point, const Vec3& normal);
AffineTransform rotation_about(const Vec3& point, const Vec3& axis, double radians);
AffineTransform scaling_about(const Vec3& point, double factor);
/// A transformed copy of the curve, over the same parameter.
std::shared_ptr<const InputCurve> transformed(std::shared_ptr<const InputCurve> curve,
                                              const AffineTransform& transform);

}  // namespace batten
