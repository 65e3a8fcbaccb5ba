#include "batten/fem/curve.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/elements/hermite_segment.h"
#include "batten/elements/quadrature.h"

namespace batten {

HermiteCurve::HermiteCurve(std::vector<double> parameters, Points positions, Points derivatives)
    : parameters_(std::move(parameters)),
      positions_(std::move(positions)),
      derivatives_(std::move(derivatives)) {
  const long n = node_count();
  if (n < 2) throw InputError("a curve needs at least two nodes");
  if (positions_.rows() != n || derivatives_.rows() != n)
    throw InputError("a curve with " + std::to_string(n) + " parameters, " +
                     std::to_string(positions_.rows()) + " positions and " +
                     std::to_string(derivatives_.rows()) + " derivatives");
  if (!positions_.allFinite() || !derivatives_.allFinite())
    throw InputError("a curve node is not finite");
  if (!std::isfinite(start()) || !std::isfinite(end()))
    throw InputError("a curve parameter is not finite");
  for (long i = 0; i + 1 < n; ++i)
    if (!(parameters_[i + 1] > parameters_[i]))
      throw InputError("curve parameters must increase: " + number(parameters_[i]) + ", " +
                       number(parameters_[i + 1]));
}

int HermiteCurve::segment(double u) const {
  const auto it = std::upper_bound(parameters_.begin() + 1, parameters_.end() - 1, u);
  return static_cast<int>(it - parameters_.begin()) - 1;
}

Vec3 HermiteCurve::evaluate(double u, int order) const {
  u = std::clamp(u, start(), end());
  const int i = segment(u);
  const double h = parameters_[i + 1] - parameters_[i];
  const auto H = HermiteSegment(h).evaluate((u - parameters_[i]) / h, order);
  return (H[0] * positions_.row(i) + H[1] * derivatives_.row(i) + H[2] * positions_.row(i + 1) +
          H[3] * derivatives_.row(i + 1))
      .transpose();
}

double HermiteCurve::curvature(double u) const {
  const Vec3 d1 = evaluate(u, 1), d2 = evaluate(u, 2);
  const double speed = d1.norm();
  return speed > 0 ? d1.cross(d2).norm() / (speed * speed * speed) : 0;
}

double HermiteCurve::length() const {
  static const SegmentRule rule = gauss_legendre(8);
  double length = 0;
  for (int i = 0; i + 1 < node_count(); ++i) {
    const double h = parameters_[i + 1] - parameters_[i];
    for (long p = 0; p < rule.s.size(); ++p)
      length += h * rule.weights[p] * evaluate(parameters_[i] + h * rule.s[p], 1).norm();
  }
  return length;
}

HermiteCurve::Closest HermiteCurve::closest_point(const Vec3& p) const {
  constexpr int samples = 8;
  std::vector<double> u, distance;
  for (int i = 0; i + 1 < node_count(); ++i)
    for (int k = i == 0 ? 0 : 1; k <= samples; ++k) {
      const double h = parameters_[i + 1] - parameters_[i];
      u.push_back(k == samples ? parameters_[i + 1] : parameters_[i] + h * k / samples);
      distance.push_back((evaluate(u.back()) - p).norm());
    }
  Closest best{start(), std::numeric_limits<double>::infinity()};
  const size_t last = u.size() - 1;
  for (size_t i = 0; i <= last; ++i) {
    const size_t below = i == 0 ? 0 : i - 1, above = std::min(i + 1, last);
    if (distance[i] < best.distance) best = {u[i], distance[i]};
    if (distance[i] > distance[below] || distance[i] > distance[above]) continue;
    // Newton on (X - p)·X' = 0, by bisection where it leaves the two samples beside.
    double low = u[below], high = u[above], x = u[i];
    for (int step = 0; step < 60; ++step) {
      const Vec3 d = evaluate(x) - p, d1 = evaluate(x, 1);
      const double g = d.dot(d1), slope = d1.squaredNorm() + d.dot(evaluate(x, 2));
      (g > 0 ? high : low) = x;
      double next = x - g / slope;
      if (!(slope > 0) || !(next >= low) || !(next <= high)) next = 0.5 * (low + high);
      const bool done = std::abs(next - x) <= 1e-15 * (end() - start());
      x = next;
      if (done) break;
    }
    if (const double d = (evaluate(x) - p).norm(); d < best.distance) best = {x, d};
  }
  return best;
}

}  // namespace batten
