// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/input_curve.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/curves/cubic.h"

namespace batten {
namespace {

class Hermite final : public InputCurve {
 public:
  explicit Hermite(HermiteCurve curve) : curve_(std::move(curve)) {}
  double start() const override { return curve_.start(); }
  double end() const override { return curve_.end(); }
  Vec3 evaluate(double t, int order) const override {
    // Avoids wrapping at the seam of a closed curve.
    if (t >= curve_.end()) return curve_.evaluate({curve_.segment_count() - 1, 1}, order);
    return curve_.evaluate(t, order);
  }
  std::vector<double> breaks() const override { return curve_.parameters(); }
  std::vector<double> corners() const override {
    std::vector<double> all;
    for (const int node : curve_.mesh().corners())
      all.push_back(curve_.parameters()[static_cast<size_t>(node)]);
    return all;
  }
  bool piecewise_cubic() const override { return true; }

 private:
  HermiteCurve curve_;
};

class FormulaCurve final : public InputCurve {
 public:
  FormulaCurve(double start, double end, std::function<Vec3(double, int)> formula)
      : start_(start), end_(end), formula_(std::move(formula)) {}
  double start() const override { return start_; }
  double end() const override { return end_; }
  Vec3 evaluate(double t, int order) const override { return formula_(t, order); }

 private:
  double start_, end_;
  std::function<Vec3(double, int)> formula_;
};

class BezierCurve final : public InputCurve {
 public:
  BezierCurve(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& p3)
      : cubic_(PowerCubic<Vec3>::of_bezier({{p0, p1, p2, p3}})) {}
  double start() const override { return 0; }
  double end() const override { return 1; }
  Vec3 evaluate(double t, int order) const override {
    return order == 0 ? cubic_.at(t) : order == 1 ? cubic_.slope(t) : cubic_.second(t);
  }
  bool piecewise_cubic() const override { return true; }

 private:
  PowerCubic<Vec3> cubic_;
};

}  // namespace

std::shared_ptr<const InputCurve> curve_from_hermite(HermiteCurve curve) {
  return std::make_shared<Hermite>(std::move(curve));
}

std::shared_ptr<const InputCurve> curve_from_formula(double start, double end,
                                                     std::function<Vec3(double, int)> formula) {
  if (!(end > start)) throw InputError("a curve defined by a formula needs start < end");
  return std::make_shared<FormulaCurve>(start, end, std::move(formula));
}

std::shared_ptr<const InputCurve> bezier_curve(const Vec3& p0, const Vec3& p1, const Vec3& p2,
                                               const Vec3& p3) {
  return std::make_shared<BezierCurve>(p0, p1, p2, p3);
}

namespace {

constexpr int kPoints = 8;
using Speeds = Eigen::Matrix<double, kPoints, 1>;

const SegmentRule& length_rule() {
  static const SegmentRule rule = gauss_legendre(kPoints);
  return rule;
}

Speeds speeds(const InputCurve& curve, double a, double b) {
  Speeds result;
  for (int p = 0; p < kPoints; ++p)
    result[p] = curve.evaluate(a + (b - a) * length_rule().s[p], 1).norm();
  return result;
}

double speed_integral(const InputCurve& curve, double a, double b) {
  return length_rule().weights.dot(speeds(curve, a, b)) * (b - a);
}

// Coefficients of 1, x, … of the polynomial that interpolates values at the Gauss points of [0, 1].
Speeds polynomial(const Speeds& values) {
  using Square = Eigen::Matrix<double, kPoints, kPoints>;
  static const Square inverse = [] {
    Square powers;
    for (int p = 0; p < kPoints; ++p)
      for (int k = 0; k < kPoints; ++k) powers(p, k) = std::pow(length_rule().s[p], k);
    return Square(powers.inverse());
  }();
  return inverse * values;
}

// Solves for x in [0, 1]: the integral of the interpolant of `speed` from 0 to x is `fraction` of
// the whole.
double inverse_of_integral(const Speeds& speed, double fraction) {
  constexpr double rounding = 1e-13;
  if (speed.maxCoeff() - speed.minCoeff() <= rounding * speed.maxCoeff()) return fraction;
  const Speeds c = polynomial(speed);
  const auto integral = [&](double x) {
    double sum = 0;
    for (int k = kPoints - 1; k >= 0; --k) sum = (sum + c[k] / (k + 1)) * x;
    return sum;
  };
  const double length = fraction * integral(1);
  double x = fraction;
  for (int step = 0; step < 20; ++step) {
    double slope = 0;
    for (int k = kPoints - 1; k >= 0; --k) slope = slope * x + c[k];
    if (!(slope > 0)) return fraction;
    const double dx = (integral(x) - length) / slope;
    x = std::clamp(x - dx, 0.0, 1.0);
    if (std::abs(dx) < 1e-12) break;
  }
  return x;
}

}  // namespace

// Bisects a panel until the sum of both halves agrees with the whole.
void ArcLength::add_panels(const Panel& whole, double tolerance, int depth) {
  const double middle = 0.5 * (whole.start + whole.end);
  const auto half = [&](double a, double b) {
    const Speeds speed = speeds(*curve_, a, b);
    return Panel{a, b, 0, length_rule().weights.dot(speed) * (b - a), speed};
  };
  Panel first = half(whole.start, middle), second = half(middle, whole.end);
  if (depth >= 12 || std::abs(first.length + second.length - whole.length) <= tolerance) {
    for (Panel* panel : {&first, &second}) {
      panel->before = panels_.empty() ? 0 : this->total();
      panels_.push_back(*panel);
    }
    return;
  }
  add_panels(first, tolerance, depth + 1);
  add_panels(second, tolerance, depth + 1);
}

ArcLength::ArcLength(std::shared_ptr<const InputCurve> curve) : curve_(std::move(curve)) {
  const std::vector<double> breaks = curve_->breaks();
  std::vector<Panel> spans;
  double total = 0, far = 0;
  for (size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double length = speed_integral(*curve_, breaks[i], breaks[i + 1]);
    spans.push_back({breaks[i], breaks[i + 1], total, length, Speeds::Zero()});
    total += length;
    far = std::max(far, curve_->evaluate(breaks[i]).norm());
  }
  // On a curve far from the origin, speeds have rounding errors that no bisection reduces.
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  const double tolerance = std::max(1e-14 * total, rounding * far);
  for (const Panel& span : spans) add_panels(span, tolerance, 0);
}

// The panel that contains the value; `start` selects parameters or lengths.
const ArcLength::Panel& ArcLength::panel_at(double value, double Panel::*start) const {
  const auto after =
      std::upper_bound(panels_.begin() + 1, panels_.end(), value,
                       [&](double v, const Panel& panel) { return v < panel.*start; });
  return *(after - 1);
}

double ArcLength::length_at(double t) const {
  t = std::clamp(t, panels_.front().start, panels_.back().end);
  const Panel& panel = panel_at(t, &Panel::start);
  return panel.before + speed_integral(*curve_, panel.start, t);
}

double ArcLength::parameter(double s) const {
  const double first = panels_.front().start, last = panels_.back().end;
  if (s <= 0) return first;
  if (s >= total()) return last;
  const Panel& panel = panel_at(s, &Panel::before);
  const double a = panel.start, b = panel.end, rest = s - panel.before;
  double t = a + (b - a) * inverse_of_integral(panel.speed, rest / panel.length);
  for (int step = 0; step < 30; ++step) {
    const double speed = curve_->evaluate(t, 1).norm();
    const double dt =
        (speed_integral(*curve_, a, t) - rest) / std::max(speed, 1e-3 * panel.length / (b - a));
    const double before = t;
    t = std::clamp(t - dt, a, b);
    // The error after a step is quadratic in the step. On a short piece of a long curve, parameters
    // are much larger than their range.
    const double rounding = 4e-16 * std::max(std::abs(a), std::abs(b));
    const double small = std::max({1e-15 * (last - first), rounding, 1e-8 * (b - a)});
    if (std::abs(t - before) <= small) break;
  }
  return t;
}

}  // namespace batten
