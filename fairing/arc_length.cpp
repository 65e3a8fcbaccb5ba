#include "batten/fairing/arc_length.h"

#include <algorithm>
#include <cmath>

#include "batten/elements/quadrature.h"

namespace batten {
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

double ArcLength::length_at(double t) const {
  t = std::clamp(t, t_.front(), t_.back());
  const auto i = std::upper_bound(t_.begin() + 1, t_.end() - 1, t) - t_.begin();
  return length_[i - 1] + speed_integral(*curve_, t_[i - 1], t);
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
    const double before = t;
    t = std::clamp(t - dt, a, b);
    // A short piece of a long curve has parameters much larger than their range.
    const double rounding = 4e-16 * std::max(std::abs(a), std::abs(b));
    if (std::abs(t - before) <= std::max(1e-15 * (t_.back() - t_.front()), rounding)) break;
  }
  return t;
}

}  // namespace batten
