// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/cubic.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "batten/core/containers.h"
#include "batten/core/solvers/band_cholesky.h"

namespace batten {

std::vector<double> BernsteinCubic::monotone_parts() const {
  std::vector<double> t{0};
  const double d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
  const double a = d0 - 2 * d1 + d2, half = d1 - d0;  // a t² + 2 half t + d0 = 0
  const double disc = half * half - a * d0;
  if (disc > 0) {
    const double q = -(half + std::copysign(std::sqrt(disc), half));
    for (const double x : {q / a, d0 / q})
      if (x > 0 && x < 1) t.push_back(x);
    std::sort(t.begin(), t.end());
  }
  t.push_back(1);
  return t;
}

double BernsteinCubic::zero(double low, double high) const {
  const bool rises = at(high) > at(low);
  double t = 0.5 * (low + high);
  for (int step = 0; step < 100; ++step) {
    const double f = at(t);
    if (f == 0) return t;
    ((f > 0) == rises ? high : low) = t;
    double next = t - f / slope(t);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - t) <= 1e-16 || next == t) return next;
    t = next;
  }
  return t;
}

std::vector<double> BernsteinCubic::zeros() const {
  std::vector<double> found;
  const auto parts = monotone_parts();
  for (size_t i = 0; i + 1 < parts.size(); ++i) {
    const double f0 = at(parts[i]), f1 = at(parts[i + 1]);
    if ((f0 < 0) != (f1 < 0)) found.push_back(zero(parts[i], parts[i + 1]));
  }
  return found;
}

void spline_slopes(std::span<const double> knots, const Eigen::Ref<const Points>& values,
                   SplineEnd first, SplineEnd last, Eigen::Ref<Points> slopes) {
  const long n = std::ssize(knots);
  if (n == 2 && first == SplineEnd::Parabolic && last == SplineEnd::Parabolic) {
    slopes = ((values.row(1) - values.row(0)) / (knots[1] - knots[0])).replicate(2, 1);
    return;
  }
  // Tridiagonal system for the slopes m: continuity of the second derivative; at parabolic ends
  // m0 + m1 = 2 (x1 - x0)/h, at natural ends 2 m0 + m1 = 3 (x1 - x0)/h.
  std::vector<double> diagonal(n), upper(n), lower(n);
  Points right(n, 3);
  for (long i = 0; i < n; ++i) {
    const SplineEnd end = i == 0 ? first : last;
    if ((i == 0 || i + 1 == n) && end == SplineEnd::Given) {
      diagonal[i] = 1;
      right.row(i) = slopes.row(i);
      continue;
    }
    const double left = i > 0 ? knots[i] - knots[i - 1] : 0,
                 next = i + 1 < n ? knots[i + 1] - knots[i] : 0;
    diagonal[i] = (left > 0 ? 2 / left : 0) + (next > 0 ? 2 / next : 0);
    lower[i] = left > 0 ? 1 / left : 0;
    upper[i] = next > 0 ? 1 / next : 0;
    right.row(i).setZero();
    if (left > 0) right.row(i) += 3 / (left * left) * (values.row(i) - values.row(i - 1));
    if (next > 0) right.row(i) += 3 / (next * next) * (values.row(i + 1) - values.row(i));
    if ((left > 0 && next > 0) || end == SplineEnd::Natural) continue;
    diagonal[i] /= 2;
    right.row(i) *= 2.0 / 3;
  }
  for (long i = 1; i < n; ++i) {
    const double f = lower[i] / diagonal[i - 1];
    diagonal[i] -= f * upper[i - 1];
    right.row(i) -= f * right.row(i - 1);
  }
  for (long i = n - 1; i >= 0; --i) {
    if (i + 1 < n) right.row(i) -= upper[i] * right.row(i + 1);
    right.row(i) /= diagonal[i];
  }
  slopes = right;
}

PiecewiseCubic PiecewiseCubic::through(std::vector<double> knots, const Points& values, Ends ends) {
  const int n = isize(knots);
  Points slopes = Points::Zero(n, 3);
  if (n < 2) return {std::move(knots), values, slopes};
  if (!std::is_sorted(knots.begin(), knots.end(), std::less_equal<>()))
    throw std::logic_error("the knots of a curve must increase");
  const SplineEnd end = ends == Ends::Flat ? SplineEnd::Given : SplineEnd::Natural;
  spline_slopes(knots, values, end, end, slopes);
  return {std::move(knots), values, slopes};
}

PiecewiseCubic PiecewiseCubic::fitted(const std::vector<double>& u, const Points& values,
                                      int spans) {
  const double first = u.front(), h = (u.back() - first) / spans;
  // Fit the difference to the line between the ends, so that straight lines are reproduced to
  // rounding.
  const Eigen::RowVector3d start = values.row(0),
                           rise = (values.row(values.rows() - 1) - start) / (u.back() - first);
  BandCholesky A;
  A.reset(spans + 3, 3);
  Points poles = Points::Zero(spans + 3, 3);
  for (int k = 0; k < isize(u); ++k) {
    const int piece = std::clamp(static_cast<int>((u[k] - first) / h), 0, spans - 1);
    const double s = (u[k] - first) / h - piece, r = 1 - s;
    const std::array<double, 4> basis = {r * r * r / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
                                         (3 * r * r * r - 6 * r * r + 4) / 6, s * s * s / 6};
    const Eigen::RowVector3d off = values.row(k) - start - (u[k] - first) * rise;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j <= i; ++j) A.add(piece + i, piece + j, basis[i] * basis[j]);
      poles.row(piece + i) += basis[i] * off;
    }
  }
  if (!A.factorize()) throw std::logic_error("too few values to fit a curve");
  A.solve(poles);
  std::vector<double> knots(spans + 1);
  Points at(spans + 1, 3), slopes(spans + 1, 3);
  for (int i = 0; i <= spans; ++i) {
    knots[i] = i < spans ? first + i * h : u.back();
    at.row(i) = start + (knots[i] - first) * rise +
                (poles.row(i) + 4 * poles.row(i + 1) + poles.row(i + 2)) / 6;
    slopes.row(i) = rise + (poles.row(i + 2) - poles.row(i)) / (2 * h);
  }
  return {std::move(knots), at, slopes};
}

int PiecewiseCubic::piece(double u) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), u);
  return std::clamp(static_cast<int>(after - knots_.begin()) - 1, 0,
                    std::max(isize(knots_) - 2, 0));
}

Vec3 PiecewiseCubic::at(double u) const {
  const int last = isize(knots_) - 1;
  for (const int end : {0, last})
    if (end == 0 ? u <= knots_[0] : u >= knots_[last])
      return values_.row(end) + (u - knots_[end]) * slopes_.row(end);
  const int i = piece(u);
  const double h = knots_[i + 1] - knots_[i];
  return hermite_value<Vec3>(values_.row(i), slopes_.row(i), values_.row(i + 1), slopes_.row(i + 1),
                             h, (u - knots_[i]) / h);
}

Vec3 PiecewiseCubic::slope(double u) const {
  const int last = isize(knots_) - 1;
  if (u <= knots_[0]) return slopes_.row(0);
  if (u >= knots_[last]) return slopes_.row(last);
  const int i = piece(u);
  const double h = knots_[i + 1] - knots_[i], s = (u - knots_[i]) / h, r = 1 - s;
  return 6 * s * r / h * (values_.row(i + 1) - values_.row(i)) + r * (r - 2 * s) * slopes_.row(i) +
         s * (s - 2 * r) * slopes_.row(i + 1);
}

}  // namespace batten
