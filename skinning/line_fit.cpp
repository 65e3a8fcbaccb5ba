#include "batten/skinning/line_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"
#include "batten/core/words.h"

namespace batten {
namespace {

// One part of a curve, forwards or backwards.
class Part final : public InputCurve {
 public:
  Part(std::shared_ptr<const InputCurve> whole, double from, double to, bool backwards)
      : whole_(std::move(whole)), from_(from), to_(to), backwards_(backwards) {}
  double start() const override { return backwards_ ? -to_ : from_; }
  double end() const override { return backwards_ ? -from_ : to_; }
  Vec3 evaluate(double t, int order) const override {
    if (!backwards_) {
      // At its end the part's own side answers, not the piece behind a corner.
      if (order > 0 && t >= to_) t = to_ - 1e-12 * (to_ - from_);
      return whole_->evaluate(t, order);
    }
    double forward = -t;
    if (order > 0 && forward >= to_) forward = to_ - 1e-12 * (to_ - from_);
    return (order == 1 ? -1 : 1) * whole_->evaluate(forward, order);
  }
  std::vector<double> breaks() const override {
    std::vector<double> inside = {from_};
    for (const double b : whole_->breaks())
      if (b > from_ && b < to_) inside.push_back(b);
    inside.push_back(to_);
    if (backwards_) {
      std::reverse(inside.begin(), inside.end());
      for (double& b : inside) b = -b;
    }
    return inside;
  }
  bool piecewise_cubic() const override { return whole_->piecewise_cubic(); }

 private:
  std::shared_ptr<const InputCurve> whole_;
  double from_, to_;
  bool backwards_;
};

// Derivative just before and just after a break.
std::pair<Vec3, Vec3> one_sided(const InputCurve& curve, double t) {
  const double e = 1e-9 * (curve.end() - curve.start());
  return {curve.evaluate(t - e, 1), curve.evaluate(t + e, 1)};
}

}  // namespace

std::shared_ptr<const InputCurve> reversed(std::shared_ptr<const InputCurve> curve) {
  const double a = curve->start(), b = curve->end();
  return std::make_shared<Part>(std::move(curve), a, b, true);
}

std::vector<Stretch> cut_at_corners(const CharacterLine& line, double corner_angle) {
  if (!line.curve) throw InputError("line '" + line.name + "' has no curve");
  const InputCurve& curve = *line.curve;
  constexpr int samples = 64;
  double length = 0;
  Vec3 before = curve.evaluate(curve.start());
  for (int i = 0; i <= samples; ++i) {
    const Vec3 p = curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / samples);
    if (!p.allFinite()) throw InputError("line '" + line.name + "' has a point that is not finite");
    length += (p - before).norm();
    before = p;
  }
  if (!(length > 0)) throw InputError("line '" + line.name + "' has zero length");

  std::vector<double> cuts = {curve.start()};
  const std::vector<double> breaks = curve.breaks();
  for (size_t i = 1; i + 1 < breaks.size(); ++i) {
    const auto [a, b] = one_sided(curve, breaks[i]);
    if (degrees_between(a, b) > corner_angle) cuts.push_back(breaks[i]);
  }
  cuts.push_back(curve.end());
  if (cuts.size() == 2) return {{line.name, line.role, line.curve}};
  std::vector<Stretch> parts;
  for (size_t i = 0; i + 1 < cuts.size(); ++i)
    parts.push_back({line.name + "." + std::to_string(i + 1), line.role,
                     std::make_shared<Part>(line.curve, cuts[i], cuts[i + 1], false)});
  return parts;
}

// --- arc length
// -----------------------------------------------------------------------------------

namespace {

const SegmentRule& length_rule() {
  static const SegmentRule rule = gauss_legendre(8);
  return rule;
}

double speed_integral(const InputCurve& curve, double a, double b) {
  double sum = 0;
  for (long p = 0; p < length_rule().s.size(); ++p)
    sum += length_rule().weights[p] * curve.evaluate(a + (b - a) * length_rule().s[p], 1).norm();
  return sum * (b - a);
}

// Halves a panel until two halves agree with the whole.
void add_panels(const InputCurve& curve, double a, double b, double whole, double total, int depth,
                std::vector<double>& t, std::vector<double>& length) {
  const double middle = 0.5 * (a + b);
  const double first = speed_integral(curve, a, middle), second = speed_integral(curve, middle, b);
  if (depth >= 12 || std::abs(first + second - whole) <= 1e-14 * total) {
    t.push_back(b);
    length.push_back(length.back() + first + second);
    return;
  }
  add_panels(curve, a, middle, first, total, depth + 1, t, length);
  add_panels(curve, middle, b, second, total, depth + 1, t, length);
}

}  // namespace

ArcLength::ArcLength(std::shared_ptr<const InputCurve> curve) : curve_(std::move(curve)) {
  const std::vector<double> breaks = curve_->breaks();
  t_ = {breaks.front()};
  length_ = {0};
  std::vector<double> whole;
  double total = 0;
  for (size_t i = 0; i + 1 < breaks.size(); ++i) {
    whole.push_back(speed_integral(*curve_, breaks[i], breaks[i + 1]));
    total += whole.back();
  }
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    add_panels(*curve_, breaks[i], breaks[i + 1], whole[i], total, 0, t_, length_);
}

double ArcLength::parameter(double s) const {
  if (s <= 0) return t_.front();
  if (s >= total()) return t_.back();
  const auto i = std::upper_bound(length_.begin() + 1, length_.end() - 1, s) - length_.begin();
  const double a = t_[i - 1], b = t_[i], panel = length_[i] - length_[i - 1],
               rest = s - length_[i - 1];
  double t = a + (b - a) * rest / panel;
  for (int step = 0; step < 30; ++step) {
    const double speed = curve_->evaluate(t, 1).norm();
    const double dt =
        (speed_integral(*curve_, a, t) - rest) / std::max(speed, 1e-3 * panel / (b - a));
    t = std::clamp(t - dt, a, b);
    if (std::abs(dt) <= 1e-15 * (t_.back() - t_.front())) break;
  }
  return t;
}

// --- fitting
// ----------------------------------------------------------------------------------------

HermiteCurve fit_by_bisection(const Stretch& stretch, double tolerance, const LineEnd& start,
                              const LineEnd& end) {
  const InputCurve& curve = *stretch.curve;
  const ArcLength arc(stretch.curve);
  const double total = arc.total();
  struct Node {
    double s;
    Vec3 x, tangent;
  };
  const auto node = [&](double s) {
    const double t = arc.parameter(s);
    // Where the direction jumps a little, the mean of both sides.
    const double e = 1e-9 * (curve.end() - curve.start());
    const Vec3 before = curve.evaluate(std::max(curve.start(), t - e), 1).normalized();
    const Vec3 after = curve.evaluate(std::min(curve.end(), t + e), 1).normalized();
    Vec3 tangent = before + after;
    if (!(tangent.norm() > 0.1) || !tangent.allFinite())
      throw InputError("line '" + stretch.name + "' stands still or turns back at arc length " +
                       number(s));
    return Node{s, curve.evaluate(t), tangent.normalized()};
  };
  constexpr int samples = 12, most_depth = 14;
  const double allowed = 0.5 * tolerance;
  std::vector<Node> nodes = {{0, start.position, start.tangent}};
  const auto fit = [&](auto&& self, const Node& a, const Node& b, int depth) -> void {
    Points x(2, 3), d(2, 3);
    x << a.x.transpose(), b.x.transpose();
    d << a.tangent.transpose(), b.tangent.transpose();
    const HermiteCurve segment({a.s, b.s}, x, d);
    double worst = 0;
    for (int k = 1; k < samples && worst <= allowed; ++k) {
      const double s = a.s + (b.s - a.s) * k / samples;
      worst = std::max(worst, (segment.evaluate(s) - curve.evaluate(arc.parameter(s))).norm());
    }
    if (worst <= allowed) {
      nodes.push_back(b);
      return;
    }
    if (depth == most_depth)
      throw InputError("line '" + stretch.name + "' is not within " + number(tolerance) +
                       " of a smooth curve after " + std::to_string(most_depth) +
                       " halvings (off by " + number(worst) + " near arc length " + number(a.s) +
                       "): is there a corner, or is the tolerance too small?");
    const Node middle = node(0.5 * (a.s + b.s));
    self(self, a, middle, depth + 1);
    self(self, middle, b, depth + 1);
  };
  fit(fit, Node(nodes[0]), {total, end.position, end.tangent}, 0);

  std::vector<double> u;
  Points x(nodes.size(), 3), d(nodes.size(), 3);
  for (size_t i = 0; i < nodes.size(); ++i) {
    u.push_back(nodes[i].s);
    x.row(static_cast<long>(i)) = nodes[i].x;
    d.row(static_cast<long>(i)) = nodes[i].tangent;
  }
  return {u, x, d};
}

namespace {
constexpr double kSameEnd = 1e-8;  // of a line's length: where inner lines meet the outline
}

HermiteCurve exact_cubic(const Stretch& stretch, double shortest, const Vec3& start,
                         const Vec3& end) {
  const InputCurve& curve = *stretch.curve;
  if (!curve.piecewise_cubic()) return {};
  const std::vector<double> breaks = curve.breaks();
  const double total = ArcLength(stretch.curve).total();
  const double scale = total / (curve.end() - curve.start());
  if ((curve.evaluate(curve.start()) - start).norm() > kSameEnd * total ||
      (curve.evaluate(curve.end()) - end).norm() > kSameEnd * total)
    return {};
  double slowest = std::numeric_limits<double>::infinity(), fastest = 0;
  for (size_t i = 0; i + 1 < breaks.size(); ++i) {
    if ((breaks[i + 1] - breaks[i]) * scale < shortest && breaks.size() > 2) return {};
    for (int k = 0; k <= 8; ++k) {
      const double t = breaks[i] + (breaks[i + 1] - breaks[i]) * k / 8.0;
      const double speed = curve.evaluate(t, 1).norm();
      slowest = std::min(slowest, speed);
      fastest = std::max(fastest, speed);
    }
    if (i == 0) continue;
    const auto [before, after] = one_sided(curve, breaks[i]);
    if ((before - after).norm() > 1e-6 * after.norm()) return {};
  }
  constexpr double even_enough = 3;
  if (!(fastest <= even_enough * slowest)) return {};
  std::vector<double> u;
  Points x(breaks.size(), 3), d(breaks.size(), 3);
  for (size_t i = 0; i < breaks.size(); ++i) {
    u.push_back((breaks[i] - curve.start()) * scale);
    x.row(static_cast<long>(i)) = curve.evaluate(breaks[i]);
    d.row(static_cast<long>(i)) = curve.evaluate(breaks[i], 1) / scale;
  }
  x.row(0) = start;
  x.row(x.rows() - 1) = end;
  return {u, x, d};
}

double distance_to(const InputCurve& curve, const Vec3& p) {
  constexpr int samples = 128;
  const double a = curve.start(), b = curve.end(), step = (b - a) / samples;
  double best = std::numeric_limits<double>::infinity(), t = a;
  for (int i = 0; i <= samples; ++i)
    if (const double d = (curve.evaluate(a + i * step) - p).norm(); d < best) {
      best = d;
      t = a + i * step;
    }
  const double low = std::max(a, t - step), high = std::min(b, t + step);
  for (int i = 0; i < 30; ++i) {
    const Vec3 d = curve.evaluate(t) - p, d1 = curve.evaluate(t, 1);
    const double slope = d1.squaredNorm() + std::max(0.0, d.dot(curve.evaluate(t, 2)));
    if (!(slope > 0)) break;
    const double next = std::clamp(t - d.dot(d1) / slope, low, high);
    const bool done = std::abs(next - t) <= 1e-15 * (b - a);
    t = next;
    if (done) break;
  }
  return std::min(best, (curve.evaluate(t) - p).norm());
}

}  // namespace batten
