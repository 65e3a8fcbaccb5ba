// Curves through points: C2 between corners.
#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/words.h"
#include "batten/fairing/fair_curve.h"
#include "batten/fairing/input_curve.h"

namespace batten {
namespace {

// Slopes of the C2 cubic spline through rows first … last of the points over u, whose first and last
// pieces are parabolas: its ends are curved as the points beside them are. Two points: straight.
void spline_slopes(const std::vector<double>& u, const Points& x, long first, long last,
                   Points& slope) {
  const long n = last - first + 1;
  if (n == 2) {
    slope.middleRows(first, 2) =
        ((x.row(last) - x.row(first)) / (u[last] - u[first])).replicate(2, 1);
    return;
  }
  // Tridiagonal system for the slopes m: continuity of the second derivative; at both ends
  // m0 + m1 = 2 (x1 - x0)/h.
  std::vector<double> diagonal(n), upper(n), lower(n);
  Points right(n, 3);
  for (long i = 0; i < n; ++i) {
    const long g = first + i;
    const double left = i > 0 ? u[g] - u[g - 1] : 0, next = i + 1 < n ? u[g + 1] - u[g] : 0;
    diagonal[i] = (left > 0 ? 2 / left : 0) + (next > 0 ? 2 / next : 0);
    lower[i] = left > 0 ? 1 / left : 0;
    upper[i] = next > 0 ? 1 / next : 0;
    right.row(i).setZero();
    if (left > 0) right.row(i) += 3 / (left * left) * (x.row(g) - x.row(g - 1));
    if (next > 0) right.row(i) += 3 / (next * next) * (x.row(g + 1) - x.row(g));
    if (left > 0 && next > 0) continue;
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
  slope.middleRows(first, n) = right;
}

// C2 between corners; one Hermite curve for each stretch between them.
class PointCurve final : public InputCurve {
 public:
  PointCurve(std::vector<double> u, const Points& x, const std::vector<long>& corners)
      : knots_(std::move(u)) {
    Points slope(x.rows(), 3);
    for (size_t c = 0; c + 1 < corners.size(); ++c) {
      const long a = corners[c], n = corners[c + 1] - a + 1;
      spline_slopes(knots_, x, a, a + n - 1, slope);
      pieces_.emplace_back(std::vector<double>(knots_.begin() + a, knots_.begin() + a + n),
                           x.middleRows(a, n), slope.middleRows(a, n));
    }
  }
  double start() const override { return knots_.front(); }
  double end() const override { return knots_.back(); }
  Vec3 evaluate(double t, int order) const override {
    const auto it = std::find_if(pieces_.begin(), pieces_.end() - 1,
                                 [&](const HermiteCurve& piece) { return t < piece.end(); });
    return it->evaluate(t, order);
  }
  std::vector<double> breaks() const override { return knots_; }
  bool piecewise_cubic() const override { return true; }

 private:
  std::vector<double> knots_;
  std::vector<HermiteCurve> pieces_;
};

}  // namespace

std::shared_ptr<const InputCurve> curve_through_points(const std::string& name,
                                                       const std::vector<Vec3>& points,
                                                       double corner_angle) {
  const auto n = static_cast<long>(points.size());
  if (n < 2)
    throw InputError("line '" + name + "' has " + std::to_string(n) + " point" +
                     (n == 1 ? "" : "s") + ": it needs two or more");
  Points x(n, 3);
  for (long i = 0; i < n; ++i) {
    if (!points[i].allFinite())
      throw InputError("line '" + name + "', point " + std::to_string(i + 1) +
                       ": a coordinate is not a finite number");
    x.row(i) = points[i];
  }
  const double size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();
  if (!(size > 0)) throw InputError("line '" + name + "' has zero length: all points are the same");
  std::vector<double> u(n, 0);
  for (long i = 0; i + 1 < n; ++i) {
    const double step = (points[i + 1] - points[i]).norm();
    if (step < 1e-9 * size)
      throw InputError("line '" + name + "', points " + std::to_string(i + 1) + " and " +
                       std::to_string(i + 2) + " are duplicates at " + at(points[i]) +
                       (n == 2 ? ": the line has zero length" : ""));
    u[i + 1] = u[i] + step;
  }
  std::vector<long> corners = {0};
  for (long i = 1; i + 1 < n; ++i)
    if (degrees_between(points[i] - points[i - 1], points[i + 1] - points[i]) > corner_angle)
      corners.push_back(i);
  corners.push_back(n - 1);
  const bool closed = n > 3 && (points.front() - points.back()).norm() < 1e-9 * size;
  if (closed &&
      degrees_between(points[n - 1] - points[n - 2], points[1] - points[0]) <= corner_angle) {
    FairOptions options;
    options.closed = true;
    options.corners.emplace(corners.begin() + 1, corners.end() - 1);
    return curve_from_hermite(curve_as_given(name, points, options));
  }
  return std::make_shared<PointCurve>(std::move(u), x, corners);
}

}  // namespace batten
