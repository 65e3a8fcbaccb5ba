// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/line_corners.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"

namespace batten {

std::vector<Vec3> polyline_vertices(const InputCurve& curve) {
  const std::vector<double> breaks = curve.breaks();
  if (!curve.piecewise_cubic() || breaks.size() < 3) return {};
  std::vector<Vec3> vertices;
  for (const double t : breaks) vertices.push_back(curve.evaluate(t));
  const double tolerance = 1e-12 * bounding_box(vertices).diagonal().norm();
  for (size_t i = 0; i + 1 < breaks.size(); ++i) {
    const Vec3 chord = vertices[i + 1] - vertices[i];
    // A cubic with two inner points on its chord is straight.
    for (const double part : {1.0 / 3, 2.0 / 3}) {
      const Vec3 d = curve.evaluate(std::lerp(breaks[i], breaks[i + 1], part)) - vertices[i];
      if (!(d.cross(chord).norm() <= tolerance * chord.norm()) || !(d.dot(chord) > 0)) return {};
    }
  }
  return vertices;
}

bool is_closed_polyline(const std::vector<Vec3>& points) {
  const double size = bounding_box(points).diagonal().norm();
  return points.size() > 3 && (points.front() - points.back()).norm() < 1e-9 * size;
}

std::optional<double> sampled_curve_deviation(const std::vector<Vec3>& points) {
  constexpr size_t fewest = 16;
  constexpr double most = 2e-3;
  if (points.size() < fewest) return std::nullopt;
  const auto curve = curve_through_points("", points);
  if (curve->corners().size() + 3 > points.size()) return std::nullopt;
  const std::vector<double> t = curve->breaks();
  double deviation = 0;
  for (size_t i = 0; i + 1 < t.size(); ++i) {
    const Vec3 a = curve->evaluate(t[i]), chord = curve->evaluate(t[i + 1]) - a;
    const Vec3 d = curve->evaluate((t[i] + t[i + 1]) / 2) - a;
    deviation = std::max(deviation, d.cross(chord).norm() / chord.norm());
  }
  if (!(deviation <= most * bounding_box(points).diagonal().norm())) return std::nullopt;
  return deviation;
}

std::vector<int> all_corners(const std::vector<Vec3>& points) {
  std::vector<int> corners;
  for (int i = is_closed_polyline(points) ? 0 : 1; i + 1 < isize(points); ++i) corners.push_back(i);
  return corners;
}

namespace {

/// A curve with given corners; without corners, its kinks are no breaks.
class CurveWithCorners : public InputCurve {
 public:
  CurveWithCorners(std::shared_ptr<const InputCurve> curve, std::vector<double> corners)
      : curve_(std::move(curve)), corners_(std::move(corners)) {}
  double start() const override { return curve_->start(); }
  double end() const override { return curve_->end(); }
  Vec3 evaluate(double t, int order) const override { return curve_->evaluate(t, order); }
  std::vector<double> breaks() const override {
    return corners_.empty() ? InputCurve::breaks() : curve_->breaks();
  }
  std::vector<double> corners() const override { return corners_; }
  bool piecewise_cubic() const override { return !corners_.empty() && curve_->piecewise_cubic(); }

 private:
  std::shared_ptr<const InputCurve> curve_;
  std::vector<double> corners_;
};

bool ends_where_it_starts(const InputCurve& curve) {
  const Vec3 start = curve.evaluate(curve.start()), end = curve.evaluate(curve.end());
  double size = 0;
  for (const double t : {0.25, 0.5, 0.75})
    size =
        std::max(size, (curve.evaluate(std::lerp(curve.start(), curve.end(), t)) - start).norm());
  return (end - start).norm() <= 1e-9 * size;
}

/// The change of direction at a break, degrees; at the end, that to the start.
double kink_at(const InputCurve& curve, double before, double at) {
  // The derivative at `at` is that behind it: that before it is taken from within.
  constexpr double near = 1e-7;
  const double behind = at == curve.end() ? curve.start() : at;
  return degrees_between(curve.evaluate(std::lerp(at, before, near), 1), curve.evaluate(behind, 1));
}

}  // namespace

std::shared_ptr<const InputCurve> with_corners(std::shared_ptr<const InputCurve> curve, bool all,
                                               const std::vector<int>& numbers) {
  const std::vector<double> breaks = curve->breaks();
  std::vector<double> corners;
  constexpr double smooth = 0.01;  // degrees
  const bool closed = ends_where_it_starts(*curve);
  for (size_t i = 1; all && i + (closed ? 0 : 1) < breaks.size(); ++i)
    if (kink_at(*curve, breaks[i - 1], breaks[i]) > smooth) corners.push_back(breaks[i]);
  for (const int n : numbers) {
    if (n >= isize(breaks))
      throw InputError("found a corner at point " + std::to_string(n + 1) + ", expected 1 to " +
                       std::to_string(breaks.size()) + ", the points where segments join");
    if (closed || (n > 0 && n + 1 < isize(breaks))) corners.push_back(breaks[n]);
  }
  for (double& corner : corners)
    if (corner == breaks.back()) corner = breaks.front();
  if (all && corners.empty()) return curve;
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return std::make_shared<CurveWithCorners>(std::move(curve), std::move(corners));
}

std::shared_ptr<const InputCurve> with_corner_at_seam(std::shared_ptr<const InputCurve> curve) {
  std::vector<double> corners = curve->corners();
  if (!corners.empty() && corners.front() == curve->start()) return curve;
  corners.insert(corners.begin(), curve->start());
  return std::make_shared<CurveWithCorners>(std::move(curve), std::move(corners));
}

}  // namespace batten
