#include "batten/fem/curves/spline_axis.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

// Power coefficients in s of the four functions on interval k, by the Cox-de Boor recursion.
Mat4 powers_on(const std::vector<double>& t, size_t k) {
  const size_t m = k + 3;  // t[m] to t[m + 1] is the interval
  const double a = t[m], h = t[m + 1] - t[m];
  Mat4 N = Mat4::Zero();
  N(0, 3) = 1;  // column c: function that begins at t[m - 3 + c]
  for (int p = 1; p <= 3; ++p) {
    Mat4 next = Mat4::Zero();
    for (int c = 3 - p; c < 4; ++c) {
      const size_t i = m - 3 + static_cast<size_t>(c);
      const auto add = [&](const Vec4& f, double constant, double slope) {
        next.col(c) += constant * f;
        next.col(c).tail<3>() += slope * f.head<3>();
      };
      if (c > 3 - p) {
        const double width = t[i + p] - t[i];
        add(N.col(c), (a - t[i]) / width, h / width);
      }
      if (c < 3) {
        const double width = t[i + p + 1] - t[i + 1];
        add(N.col(c + 1), (t[i + p + 1] - a) / width, -h / width);
      }
    }
    N = next;
  }
  return N;
}

}  // namespace

SplineAxis::SplineAxis(std::vector<double> knots, bool periodic)
    : knots_(std::move(knots)), periodic_(periodic) {
  const int n = intervals();
  if (n < (periodic ? 4 : 1))
    throw InputError("found a B-spline with " + std::to_string(n) + " intervals, expected " +
                     (periodic ? "4" : "1") + " or more");
  for (int k = 0; k < n; ++k)
    if (!(length(k) > 0)) throw InputError("the knots of a B-spline must increase");
  std::vector<double> all;
  const double period = knots_.back() - knots_.front();
  for (int k = 3; k >= 1; --k) all.push_back(periodic ? knots_[n - k] - period : knots_[0]);
  all.insert(all.end(), knots_.begin(), knots_.end());
  for (int k = 1; k <= 3; ++k) all.push_back(periodic ? knots_[k] + period : knots_[n]);
  for (int k = 0; k < n; ++k) powers_.push_back(powers_on(all, static_cast<size_t>(k)));
}

double SplineAxis::wrapped(double t) const {
  const double low = knots_.front(), high = knots_.back();
  if (periodic_ && !(t >= low && t <= high))
    t -= std::floor((t - low) / (high - low)) * (high - low);
  return std::clamp(t, low, high);
}

int SplineAxis::interval(double t) const {
  const auto above = std::upper_bound(knots_.begin(), knots_.end(), wrapped(t));
  return std::clamp(static_cast<int>(above - knots_.begin()) - 1, 0, intervals() - 1);
}

Eigen::Vector4d SplineAxis::basis(int interval, double s, int derivative) const {
  Eigen::RowVector4d power;
  switch (derivative) {
    case 0:
      power << 1, s, s * s, s * s * s;
      break;
    case 1:
      power << 0, 1, 2 * s, 3 * s * s;
      break;
    case 2:
      power << 0, 0, 2, 6 * s;
      break;
    default:
      power << 0, 0, 0, 6;
  }
  return (power * powers_[interval]).transpose();
}

}  // namespace batten
