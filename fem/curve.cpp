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
  Closest best{start(), std::numeric_limits<double>::infinity()};
  double step = 0;
  for (int i = 0; i + 1 < node_count(); ++i) {
    const double h = parameters_[i + 1] - parameters_[i];
    for (int k = 0; k <= samples; ++k) {
      const double u = parameters_[i] + h * k / samples;
      if (const double d = (evaluate(u) - p).norm(); d < best.distance) {
        best = {u, d};
        step = h / samples;
      }
    }
  }
  // Newton on (X - p)·X' = 0, kept within one sample of the best.
  const double low = std::max(start(), best.u - step), high = std::min(end(), best.u + step);
  double u = best.u;
  for (int i = 0; i < 20; ++i) {
    const Vec3 d = evaluate(u) - p, d1 = evaluate(u, 1);
    const double slope = d1.squaredNorm() + std::max(0.0, d.dot(evaluate(u, 2)));
    if (!(slope > 0)) break;
    const double next = std::clamp(u - d.dot(d1) / slope, low, high);
    const bool done = std::abs(next - u) <= 1e-15 * (end() - start());
    u = next;
    if (done) break;
  }
  if (const double d = (evaluate(u) - p).norm(); d < best.distance) best = {u, d};
  return best;
}

}  // namespace batten
