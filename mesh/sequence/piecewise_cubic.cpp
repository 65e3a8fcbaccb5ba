#include "batten/mesh/sequence/piecewise_cubic.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "batten/core/band_cholesky.h"
#include "batten/core/isize.h"

namespace batten {

PiecewiseCubic PiecewiseCubic::through(std::vector<double> knots, const Points& values, Ends ends) {
  const int n = isize(knots);
  if (n < 2) return {std::move(knots), values, Points::Zero(n, 3)};
  // Equal second derivatives from both sides; without curvature at natural ends.
  BandCholesky A;
  A.reset(n, 1);
  Points slopes = Points::Zero(n, 3);
  for (int i = 0; i + 1 < n; ++i) {
    const double h = knots[i + 1] - knots[i];
    const Eigen::RowVector3d secant = (values.row(i + 1) - values.row(i)) / h;
    A.add(i, i, 2 / h);
    A.add(i + 1, i + 1, 2 / h);
    A.add(i + 1, i, 1 / h);
    slopes.row(i) += 3 / h * secant;
    slopes.row(i + 1) += 3 / h * secant;
  }
  if (ends == Ends::Flat) {
    A.fix(0, Vec3::Zero(), slopes);
    A.fix(n - 1, Vec3::Zero(), slopes);
  }
  if (!A.factorize()) throw std::logic_error("knots of a curve that do not increase");
  A.solve(slopes);
  return {std::move(knots), values, slopes};
}

PiecewiseCubic PiecewiseCubic::fitted(const std::vector<double>& u, const Points& values,
                                      int spans) {
  const double first = u.front(), h = (u.back() - first) / spans;
  // Fitted is what is left of the line between the ends: a straight line comes back to rounding.
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
  if (!A.factorize()) throw std::logic_error("a curve fitted to too few values");
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
  const double h = knots_[i + 1] - knots_[i], s = (u - knots_[i]) / h, r = 1 - s;
  return values_.row(i) + s * s * (3 - 2 * s) * (values_.row(i + 1) - values_.row(i)) +
         h * s * r * (r * slopes_.row(i) - s * slopes_.row(i + 1));
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
