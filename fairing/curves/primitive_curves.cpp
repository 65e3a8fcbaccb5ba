// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/primitive_curves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

using std::numbers::pi;

void require_positive(const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(std::string("found the ") + what + " " + format_number(value) +
                     ", expected a number above 0");
}

class CompositeCurve final : public InputCurve {
 public:
  explicit CompositeCurve(std::vector<std::shared_ptr<const InputCurve>> curves)
      : curves_(std::move(curves)) {
    for (const auto& c : curves_) ends_.push_back(ends_.back() + c->end() - c->start());
  }
  double start() const override { return 0; }
  double end() const override { return ends_.back(); }
  Vec3 evaluate(double t, int order) const override {
    const auto inner = ends_.begin() + 1;  // the ends of all curves but the last
    const auto k = static_cast<size_t>(std::upper_bound(inner, ends_.end() - 1, t) - inner);
    return curves_[k]->evaluate(curves_[k]->start() + t - ends_[k], order);
  }
  std::vector<double> breaks() const override {
    std::vector<double> all{0};
    for (size_t k = 0; k < curves_.size(); ++k) {
      const std::vector<double> own = curves_[k]->breaks();
      for (size_t i = 1; i + 1 < own.size(); ++i)
        all.push_back(ends_[k] + own[i] - curves_[k]->start());
      all.push_back(ends_[k + 1]);
    }
    return all;
  }
  bool piecewise_cubic() const override {
    return std::all_of(curves_.begin(), curves_.end(),
                       [](const auto& c) { return c->piecewise_cubic(); });
  }

 private:
  std::vector<std::shared_ptr<const InputCurve>> curves_;
  std::vector<double> ends_{0};
};

class TransformedCurve final : public InputCurve {
 public:
  TransformedCurve(std::shared_ptr<const InputCurve> curve, const AffineTransform& transform)
      : curve_(std::move(curve)), transform_(transform) {}
  double start() const override { return curve_->start(); }
  double end() const override { return curve_->end(); }
  Vec3 evaluate(double t, int order) const override {
    const Vec3 x = curve_->evaluate(t, order);
    return order == 0 ? transform_(x) : Vec3(transform_.A * x);
  }
  std::vector<double> breaks() const override { return curve_->breaks(); }
  std::vector<double> corners() const override { return curve_->corners(); }
  bool piecewise_cubic() const override { return curve_->piecewise_cubic(); }

 private:
  std::shared_ptr<const InputCurve> curve_;
  AffineTransform transform_;
};

// Cubics of at most 15 degrees with unit end slopes: off the circle by 1e-8 of its radius.
std::shared_ptr<const InputCurve> circle_arc(const CurvePlane& plane, double radius, double from,
                                             double to) {
  const double sweep = to - from;
  const bool closed = std::abs(sweep) > 2 * pi * (1 - 1e-12);
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(sweep) * 12 / pi - 1e-9)));
  const double step = sweep / pieces;
  std::vector<double> u;
  for (int i = 0; i <= pieces; ++i) u.push_back(i * 4 * std::tan(std::abs(step) / 4) * radius);
  const int nodes = closed ? pieces : pieces + 1;
  Points dofs(2 * nodes, 3);
  for (int i = 0; i < nodes; ++i) {
    const double t = from + i * step, sign = sweep > 0 ? 1 : -1;
    dofs.row(2 * i) = plane.centre + radius * (std::cos(t) * plane.x + std::sin(t) * plane.y);
    dofs.row(2 * i + 1) = sign * (std::cos(t) * plane.y - std::sin(t) * plane.x);
  }
  return curve_from_hermite(HermiteCurve(CurveMesh(u, closed), std::move(dofs)));
}

std::shared_ptr<const InputCurve> straight(const Vec3& a, const Vec3& b) {
  const double length = (b - a).norm();
  Points x(2, 3), slope(2, 3);
  x << a.transpose(), b.transpose();
  slope.rowwise() = (b - a).transpose() / length;
  return curve_from_hermite(HermiteCurve({0, length}, x, slope));
}

}  // namespace

CurvePlane curve_plane(const Vec3& centre, const Vec3& normal, const Vec3& along) {
  if (!(normal.norm() > 0)) throw InputError("found a normal of length zero, expected a direction");
  const Vec3 n = normal.normalized(), part = along - along.dot(n) * n;
  if (!(part.norm() > 1e-9 * along.norm()))
    throw InputError("found an x direction parallel to the normal, expected a different direction");
  const Vec3 x = part.normalized();
  return {centre, x, n.cross(x)};
}

std::shared_ptr<const InputCurve> ellipse_arc(const CurvePlane& plane, double a, double b,
                                              double from, double to) {
  require_positive("radius", a);
  require_positive("radius", b);
  const double sweep = to - from;
  if (!(std::abs(sweep) > 0) || std::abs(sweep) > 2 * pi * (1 + 1e-12))
    throw InputError("found an arc from " + format_number(from * 180 / pi) + " to " +
                     format_number(to * 180 / pi) +
                     " degrees, expected two different angles that are at most 360 apart");
  if (a == b) return circle_arc(plane, a, from, to);
  const double r = std::max(a, b), sign = sweep > 0 ? 1 : -1;
  return curve_from_formula(0, std::abs(sweep) * r, [=](double u, int order) -> Vec3 {
    const double t = from + sign * u / r, rate = std::pow(sign / r, order);
    const double c = std::cos(t + order * pi / 2), s = std::sin(t + order * pi / 2);
    const Vec3 d = rate * (a * c * plane.x + b * s * plane.y);
    return order == 0 ? Vec3(plane.centre + d) : d;
  });
}

std::shared_ptr<const InputCurve> arc_through(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
  if (!(normal.norm() > 1e-9 * ab.norm() * ac.norm()))
    throw InputError("found three collinear points, " + format_point(a) + ", " + format_point(b) +
                     " and " + format_point(c) + ", expected three points of an arc");
  const Vec3 centre =
      a + (normal.cross(ab) * ac.squaredNorm() + ac.cross(normal) * ab.squaredNorm()) /
              (2 * normal.squaredNorm());
  const CurvePlane plane = curve_plane(centre, normal, a - centre);
  double to = std::atan2((c - centre).dot(plane.y), (c - centre).dot(plane.x));
  if (to <= 0) to += 2 * pi;
  const double radius = (a - centre).norm();
  return ellipse_arc(plane, radius, radius, 0, to);
}

std::shared_ptr<const InputCurve> helix(const CurvePlane& plane, double radius, double pitch,
                                        double turns) {
  require_positive("radius", radius);
  require_positive("number of turns", turns);
  const double rise = pitch / (2 * pi), speed = std::hypot(radius, rise);
  return curve_from_formula(0, 2 * pi * turns * speed, [=](double u, int order) -> Vec3 {
    const double t = u / speed, rate = std::pow(speed, -order);
    const double c = std::cos(t + order * pi / 2), s = std::sin(t + order * pi / 2);
    Vec3 d = rate * radius * (c * plane.x + s * plane.y);
    if (order < 2) d += (order == 0 ? rise * t : rise / speed) * plane.normal();
    return order == 0 ? Vec3(plane.centre + d) : d;
  });
}

std::shared_ptr<const InputCurve> rectangle(const CurvePlane& plane, double width, double height,
                                            double radius) {
  require_positive("width", width);
  require_positive("height", height);
  if (!(radius >= 0) || radius > 0.5 * std::min(width, height))
    throw InputError("found the radius " + format_number(radius) + ", expected 0 to " +
                     format_number(0.5 * std::min(width, height)) + ", half of the shorter side");
  const auto at = [&](double x, double y) -> Vec3 {
    return plane.centre + x * plane.x + y * plane.y;
  };
  const double w = 0.5 * width, h = 0.5 * height, r = radius;
  std::vector<std::shared_ptr<const InputCurve>> parts;
  Vec3 last = at(0, -h);
  const auto line_to = [&](const Vec3& end) {
    if ((end - last).norm() > 1e-12 * (width + height)) parts.push_back(straight(last, end));
    last = end;
  };
  const double sx[] = {1, 1, -1, -1}, sy[] = {-1, 1, 1, -1};
  for (int k = 0; k < 4; ++k) {
    const bool upright = k % 2 == 1;  // the side behind corner k is horizontal
    const double cx = sx[k] * (w - r), cy = sy[k] * (h - r);
    line_to(upright ? at(sx[k] * w, cy) : at(cx, sy[k] * h));
    if (r > 0) {
      CurvePlane corner = plane;
      corner.centre = at(cx, cy);
      parts.push_back(ellipse_arc(corner, r, r, (k - 1) * pi / 2, k * pi / 2));
      last = upright ? at(cx, sy[k] * h) : at(sx[k] * w, cy);
    }
  }
  line_to(at(0, -h));
  return concatenated(std::move(parts));
}

std::shared_ptr<const InputCurve> concatenated(
    std::vector<std::shared_ptr<const InputCurve>> curves) {
  if (curves.empty()) throw InputError("found no curve to concatenate, expected one or more");
  return std::make_shared<CompositeCurve>(std::move(curves));
}

Vec3 AffineTransform::operator()(const Vec3& x) const { return A * x + b; }

AffineTransform AffineTransform::then(const AffineTransform& next) const {
  return {next.A * A, next.A * b + next.b};
}

AffineTransform reflection_in(const Vec3& point, const Vec3& normal) {
  if (!(normal.norm() > 0)) throw InputError("found a normal of length zero, expected a direction");
  const Vec3 n = normal.normalized();
  return {Mat3::Identity() - 2 * n * n.transpose(), 2 * n.dot(point) * n};
}

AffineTransform rotation_about(const Vec3& point, const Vec3& axis, double radians) {
  if (!(axis.norm() > 0)) throw InputError("found an axis of length zero, expected a direction");
  const Mat3 A = Eigen::AngleAxisd(radians, axis.normalized()).toRotationMatrix();
  return {A, point - A * point};
}

AffineTransform scaling_about(const Vec3& point, double factor) {
  require_positive("scale", factor);
  return {factor * Mat3::Identity(), (1 - factor) * point};
}

std::shared_ptr<const InputCurve> transformed(std::shared_ptr<const InputCurve> curve,
                                              const AffineTransform& transform) {
  return std::make_shared<TransformedCurve>(std::move(curve), transform);
}

// NURBS curves.

namespace {

using Homogeneous = Eigen::Vector4d;

// A B-spline in homogeneous coordinates (rational if needed) and its two derivatives.
class Spline final : public InputCurve {
 public:
  Spline(int degree, std::vector<Homogeneous> poles, std::vector<double> knots, bool rational)
      : degree_(degree), knots_(std::move(knots)), rational_(rational) {
    poles_[0] = std::move(poles);
    // Poles of the derivatives, over the same knots without the outermost ones.
    for (int d = 1; d <= 2 && d <= degree; ++d) {
      const auto& p = poles_[d - 1];
      for (int i = 0; i + 1 < isize(p); ++i) {
        const double length = knots_[i + degree + 1] - knots_[i + d];
        poles_[d].push_back(length > 0 ? Homogeneous((degree - d + 1) / length * (p[i + 1] - p[i]))
                                       : Homogeneous::Zero());
      }
    }
  }
  double start() const override { return knots_[degree_]; }
  double end() const override { return knots_[knots_.size() - 1 - degree_]; }
  bool piecewise_cubic() const override { return !rational_ && degree_ <= 3; }
  std::vector<double> breaks() const override {
    std::vector<double> all(knots_.begin() + degree_, knots_.end() - degree_);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  Vec3 evaluate(double t, int order) const override {
    const Homogeneous h = de_boor(t, 0);
    const double w = h[3];
    const Vec3 x = h.head<3>() / w;
    if (order == 0) return x;
    const Homogeneous h1 = de_boor(t, 1);
    const Vec3 x1 = (h1.head<3>() - h1[3] * x) / w;
    if (order == 1) return x1;
    const Homogeneous h2 = de_boor(t, 2);
    return (h2.head<3>() - 2 * h1[3] * x1 - h2[3] * x) / w;
  }

 private:
  Homogeneous de_boor(double t, int derivative) const {
    const int p = degree_ - derivative;
    if (p < 0) return Homogeneous::Zero();
    const auto& poles = poles_[derivative];
    const double* knots = knots_.data() + derivative;
    // The span [knot k, knot k+1) that contains t.
    const auto k =
        static_cast<int>(std::upper_bound(knots + p + 1, knots + poles.size(), t) - knots) - 1;
    std::array<Homogeneous, 10> d;
    for (int i = 0; i <= p; ++i) d[i] = poles[k - p + i];
    for (int r = 1; r <= p; ++r)
      for (int i = p; i >= r; --i) {
        const double a = knots[k - p + i], b = knots[k + 1 + i - r];
        const double f = b > a ? (t - a) / (b - a) : 0;
        d[i] = (1 - f) * d[i - 1] + f * d[i];
      }
    return d[p];
  }

  int degree_;
  std::vector<double> knots_;
  bool rational_;
  std::array<std::vector<Homogeneous>, 3> poles_;
};

std::vector<double> even_knots(int degree, int poles) {
  std::vector<double> knots(degree + 1, 0.0);
  const int spans = poles - degree;
  for (int i = 1; i < spans; ++i) knots.push_back(static_cast<double>(i) / spans);
  knots.insert(knots.end(), degree + 1, 1.0);
  return knots;
}

void check_knots(int degree, int poles, const std::vector<double>& knots) {
  if (isize(knots) != poles + degree + 1)
    throw InputError("found " + std::to_string(knots.size()) + " knots for " +
                     std::to_string(poles) + " poles and degree " + std::to_string(degree) +
                     ", expected " + std::to_string(poles + degree + 1));
  for (size_t i = 0; i + 1 < knots.size(); ++i)
    if (!(knots[i] <= knots[i + 1]))
      throw InputError("found the knot " + format_number(knots[i + 1]) + " after " +
                       format_number(knots[i]) + ", expected knots that do not decrease");
  // An inner knot of multiplicity `degree` still leaves the curve connected.
  const double first = knots[degree], last = knots[knots.size() - 1 - degree];
  for (size_t i = 0; i + degree < knots.size(); ++i)
    if (knots[i] == knots[i + degree] && knots[i] > first && knots[i] < last)
      throw InputError("found the knot " + format_number(knots[i]) + " more than " +
                       std::to_string(degree) +
                       " times, which would disconnect the curve; expected at most the degree");
  if (!(last > first)) throw InputError("found equal knots only, expected knots that increase");
}

}  // namespace

std::shared_ptr<const InputCurve> nurbs_curve(int degree, const std::vector<Vec3>& poles,
                                              const std::vector<double>& weights,
                                              const std::vector<double>& knots) {
  constexpr int most = 9;
  if (degree < 1 || degree > most)
    throw InputError("found the degree " + std::to_string(degree) + ", expected 1 to " +
                     std::to_string(most));
  if (isize(poles) <= degree)
    throw InputError("found " + std::to_string(poles.size()) + " poles for degree " +
                     std::to_string(degree) + ", expected " + std::to_string(degree + 1) +
                     " or more");
  if (!weights.empty() && weights.size() != poles.size())
    throw InputError("found " + std::to_string(weights.size()) + " weights for " +
                     std::to_string(poles.size()) + " poles, expected one for each");
  if (!knots.empty()) check_knots(degree, isize(poles), knots);
  std::vector<Homogeneous> all;
  bool rational = false;
  for (size_t i = 0; i < poles.size(); ++i) {
    const double w = weights.empty() ? 1 : weights[i];
    if (!(w > 0))
      throw InputError("found the weight " + format_number(w) + ", expected weights above 0");
    rational = rational || w != (weights.empty() ? 1 : weights[0]);
    all.emplace_back(w * poles[i].x(), w * poles[i].y(), w * poles[i].z(), w);
  }
  return std::make_shared<Spline>(
      degree, std::move(all), knots.empty() ? even_knots(degree, isize(poles)) : knots, rational);
}

}  // namespace batten
