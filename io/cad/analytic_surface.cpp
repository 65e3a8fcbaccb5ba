#include "batten/io/cad/analytic_surface.h"

#include <Geom_BSplineCurve.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <gp_Ax3.hxx>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "batten/core/isize.h"
#include "batten/fem/hermite_curve.h"
#include "batten/io/cad/occ_values.h"

namespace batten {
namespace {

using ShapeKind = FittedPrimitive::Kind;

double nearest_period(double angle, double near) {
  constexpr double whole = 2 * std::numbers::pi;
  return angle + whole * std::round((near - angle) / whole);
}

/// A C1 cubic through points with derivatives, as a B-spline with double knots.
Handle(Geom2d_BSplineCurve)
    hermite_spline(const std::vector<double>& t, const std::vector<Vec2>& uv,
                   const std::vector<Vec2>& slopes) {
  const int n = isize(t);
  TColgp_Array1OfPnt2d poles(1, 2 * n);
  TColStd_Array1OfReal knots(1, n);
  TColStd_Array1OfInteger times(1, n);
  times.Init(2);
  times(1) = times(n) = 4;
  for (int i = 0; i < n; ++i) {
    knots(i + 1) = t[i];
    const double before = i > 0 ? t[i] - t[i - 1] : 0, after = i + 1 < n ? t[i + 1] - t[i] : 0;
    const Vec2 low = uv[i] - before / 3 * slopes[i], high = uv[i] + after / 3 * slopes[i];
    poles(2 * i + 1) = {low.x(), low.y()};
    poles(2 * i + 2) = {high.x(), high.y()};
  }
  return new Geom2d_BSplineCurve(poles, knots, times, 3);
}

}  // namespace

AnalyticSurface::AnalyticSurface(const FittedPrimitive& shape, const Vec3& reference,
                                 const Vec3& middle)
    : shape_(shape), origin_(shape.origin) {
  const Vec3& z = shape.axis;
  x_ = reference - reference.dot(z) * z;
  x_ = x_.norm() > 1e-9 * reference.norm() ? Vec3(x_.normalized()) : Vec3(z.unitOrthogonal());
  y_ = z.cross(x_);
  if (shape.kind == ShapeKind::Cone) {
    const double height = (middle - shape.origin).dot(z);
    origin_ += height * z;
    radius_ = height * std::tan(shape.half_angle);
  }
  if (shape.kind == ShapeKind::Cylinder) origin_ += (middle - shape.origin).dot(z) * z;
  const gp_Ax3 frame(to_occ(origin_), gp_Dir(z.x(), z.y(), z.z()), gp_Dir(x_.x(), x_.y(), x_.z()));
  switch (shape.kind) {
    case ShapeKind::Cylinder:
      geometry_ = new Geom_CylindricalSurface(frame, shape.radius);
      break;
    case ShapeKind::Sphere:
      geometry_ = new Geom_SphericalSurface(frame, shape.radius);
      break;
    case ShapeKind::Cone:
      geometry_ = new Geom_ConicalSurface(frame, shape.half_angle, radius_);
      break;
    case ShapeKind::Torus:
      geometry_ = new Geom_ToroidalSurface(frame, shape.major_radius, shape.radius);
      break;
    default:
      geometry_ = new Geom_Plane(frame);
  }
}

Vec2 AnalyticSurface::periods() const {
  constexpr double whole = 2 * std::numbers::pi;
  if (shape_.kind == ShapeKind::Plane) return {0, 0};
  return {whole, shape_.kind == ShapeKind::Torus ? whole : 0};
}

Vec2 AnalyticSurface::parameters(const Vec3& p, const Vec2& near) const {
  const Vec3 q = p - origin_;
  const double x = q.dot(x_), y = q.dot(y_), h = q.dot(shape_.axis);
  if (shape_.kind == ShapeKind::Plane) return {x, y};
  const double rho = std::hypot(x, y);
  constexpr double rounding = 1e-12;
  const bool on_axis = rho <= rounding * (shape_.radius + std::abs(h));
  const double u = on_axis ? near.x() : nearest_period(std::atan2(y, x), near.x());
  switch (shape_.kind) {
    case ShapeKind::Sphere:
      return {u, std::atan2(h, rho)};
    case ShapeKind::Cone:
      return {u, (rho - radius_) * std::sin(shape_.half_angle) + h * std::cos(shape_.half_angle)};
    case ShapeKind::Torus:
      return {u, nearest_period(std::atan2(h, rho - shape_.major_radius), near.y())};
    default:
      return {u, h};
  }
}

Vec3 AnalyticSurface::position(const Vec2& uv) const {
  return from_occ(geometry_->Value(uv.x(), uv.y()));
}

bool AnalyticSurface::singular(const Vec3& p, double distance) const {
  if (shape_.kind == ShapeKind::Cone) return (p - shape_.origin).norm() <= distance;
  return shape_.kind == ShapeKind::Sphere &&
         (p - shape_.origin).cross(shape_.axis).norm() <= distance;
}

// The derivative of parameters() along a curve; in u 0 on the axis.
Vec2 AnalyticSurface::slopes(const Vec3& p, const Vec3& slope) const {
  const Vec3 q = p - origin_;
  const double x = q.dot(x_), y = q.dot(y_), h = q.dot(shape_.axis);
  const double dx = slope.dot(x_), dy = slope.dot(y_), dh = slope.dot(shape_.axis);
  if (shape_.kind == ShapeKind::Plane) return {dx, dy};
  const double rho = std::hypot(x, y);
  constexpr double beside = 1e-7;
  if (rho <= beside * (shape_.radius + std::abs(h))) {
    const double drho = std::hypot(dx, dy);
    if (shape_.kind == ShapeKind::Sphere) return {0, (h > 0 ? -1 : 1) * drho / shape_.radius};
    return {0, 0};
  }
  const double du = (x * dy - y * dx) / (rho * rho), drho = (x * dx + y * dy) / rho;
  switch (shape_.kind) {
    case ShapeKind::Sphere:
      return {du, (rho * dh - h * drho) / (rho * rho + h * h)};
    case ShapeKind::Cone:
      return {du, drho * std::sin(shape_.half_angle) + dh * std::cos(shape_.half_angle)};
    case ShapeKind::Torus: {
      const double s = rho - shape_.major_radius;
      return {du, (s * dh - h * drho) / (s * s + h * h)};
    }
    default:
      return {du, dh};
  }
}

Handle(Geom2d_BSplineCurve) AnalyticSurface::pcurve(const Geom_Curve& curve, double first,
                                                    double last, bool backwards, double tolerance,
                                                    Vec2& near) const {
  std::vector<double> t;
  if (const auto* spline = dynamic_cast<const Geom_BSplineCurve*>(&curve)) {
    for (int k = 1; k <= spline->NbKnots(); ++k) t.push_back(spline->Knot(k));
    std::erase_if(t, [&](double at) { return at <= first || at >= last; });
  }
  t.insert(t.begin(), first);
  t.push_back(last);
  // Steps of less than half a turn, also on a circle of one piece.
  constexpr int fewest = 8;
  const int pieces_each = (fewest + isize(t) - 2) / (isize(t) - 1);
  std::vector<double> split;
  for (size_t i = 0; i + 1 < t.size(); ++i)
    for (int k = 0; k < pieces_each; ++k)
      split.push_back(t[i] + (t[i + 1] - t[i]) * k / pieces_each);
  split.push_back(last);
  t = std::move(split);
  const auto at = [&](double parameter) { return from_occ(curve.Value(parameter)); };
  std::vector<Vec2> uv, d;
  const auto evaluate = [&] {
    uv.assign(t.size(), Vec2::Zero());
    d.assign(t.size(), Vec2::Zero());
    Vec2 before = near;
    // u of a pole or apex at the beginning is that a little further on.
    const double start = backwards ? last : first, end = backwards ? first : last;
    constexpr double little = 1e-4;
    const double apex = little * (shape_.radius + shape_.major_radius);
    if (singular(at(start), apex)) before = parameters(at(start + little * (end - start)), near);
    for (size_t k = 0; k < t.size(); ++k) {
      const size_t i = backwards ? t.size() - 1 - k : k;
      gp_Pnt p;
      gp_Vec slope;
      curve.D1(t[i], p, slope);
      const bool ends = k == 0 || k + 1 == t.size();
      uv[i] = parameters(from_occ(p), before);
      d[i] = slopes(from_occ(p), from_occ(slope.XYZ()));
      if (ends && singular(from_occ(p), apex)) {
        uv[i].x() = k == 0 ? before.x() : parameters(at(end + little * (start - end)), before).x();
        d[i].x() = 0;
      }
      before = uv[i];
    }
    return before;
  };
  Vec2 after = evaluate();
  constexpr int most_halvings = 6;
  for (int round = 0; round < most_halvings; ++round) {
    std::vector<double> finer;
    for (size_t i = 0; i + 1 < t.size(); ++i) {
      finer.push_back(t[i]);
      const double length = t[i + 1] - t[i];
      bool far = false;
      for (const double s : {0.25, 0.5, 0.75}) {
        const Vec2 cubic = (1 + 2 * s) * (1 - s) * (1 - s) * uv[i] +
                           s * s * (3 - 2 * s) * uv[i + 1] +
                           length * s * (1 - s) * ((1 - s) * d[i] - s * d[i + 1]);
        const Vec2 exact = parameters(at(t[i] + s * length), cubic);
        far = far || (position(cubic) - position(exact)).norm() > tolerance;
      }
      if (far) finer.push_back(t[i] + length / 2);
    }
    finer.push_back(t.back());
    if (finer.size() == t.size()) break;
    t = std::move(finer);
    after = evaluate();
  }
  near = after;
  return hermite_spline(t, uv, d);
}

FittedPrimitive shape_of(const Handle(Geom_Surface) & surface) {
  FittedPrimitive shape;
  const auto take = [&](const gp_Ax3& frame, ShapeKind kind) {
    shape.kind = kind;
    shape.origin = from_occ(frame.Location());
    shape.axis = from_occ(frame.Direction().XYZ());
  };
  if (const auto plane = Handle(Geom_Plane)::DownCast(surface); !plane.IsNull()) {
    take(plane->Position(), ShapeKind::Plane);
  } else if (const auto cylinder = Handle(Geom_CylindricalSurface)::DownCast(surface);
             !cylinder.IsNull()) {
    take(cylinder->Position(), ShapeKind::Cylinder);
    shape.radius = cylinder->Radius();
  } else if (const auto sphere = Handle(Geom_SphericalSurface)::DownCast(surface);
             !sphere.IsNull()) {
    take(sphere->Position(), ShapeKind::Sphere);
    shape.radius = sphere->Radius();
  } else if (const auto cone = Handle(Geom_ConicalSurface)::DownCast(surface); !cone.IsNull()) {
    take(cone->Position(), ShapeKind::Cone);
    shape.half_angle = std::abs(cone->SemiAngle());
    shape.radius = cone->RefRadius();
    shape.origin = from_occ(cone->Apex());
    if (cone->SemiAngle() < 0) shape.axis = -shape.axis;
  } else if (const auto torus = Handle(Geom_ToroidalSurface)::DownCast(surface); !torus.IsNull()) {
    take(torus->Position(), ShapeKind::Torus);
    shape.radius = torus->MinorRadius();
    shape.major_radius = torus->MajorRadius();
  }
  return shape;
}

}  // namespace batten
