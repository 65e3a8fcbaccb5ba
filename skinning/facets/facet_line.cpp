#include "batten/skinning/facets/facet_line.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace batten {

FacetLine::FacetLine(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line)
    : name_(aligned_line.line.name), parameters_(aligned_line.parameters) {
  for (const int v : aligned_line.vertices)
    points_.push_back(points_.empty() ? mesh.vertices()[v]
                                      : mesh.image_near(mesh.vertices()[v], points_.back()));
  make_segments();
}

FacetLine::FacetLine(std::string name, const Vec2& from, const Vec2& to)
    : name_(std::move(name)), parameters_{0, (to - from).norm()}, points_{from, to} {
  make_segments();
}

FacetLine::FacetLine(const EmbeddedLine& line)
    : name_(line.line.name),
      embedded_(&line),
      parameters_(line.pcurve.parameters()),
      arcs_(planar_cubics(line.pcurve)) {}

Vec2 FacetLine::at(double t) const {
  if (embedded_) return embedded_->pcurve.evaluate(t).head<2>();
  const size_t k = segment(t);
  const double s = (t - parameters_[k]) / (parameters_[k + 1] - parameters_[k]);
  return (1 - s) * points_[k] + s * points_[k + 1];
}

Vec2 FacetLine::slope(double t) const {
  if (embedded_) return embedded_->pcurve.evaluate(t, 1).head<2>();
  const size_t k = segment(t);
  return (points_[k + 1] - points_[k]) / (parameters_[k + 1] - parameters_[k]);
}

std::pair<double, double> FacetLine::u_range() const {
  std::pair<double, double> range{arcs_[0].b[0].x(), arcs_[0].b[0].x()};
  for (const PlanarCubic& arc : arcs_)
    for (const Vec2& p : arc.b)
      range = {std::min(range.first, p.x()), std::max(range.second, p.x())};
  return range;
}

CurvePoint FacetLine::closest(const Vec2& p) const {
  if (embedded_) return embedded_->pcurve.closest_point({p.x(), p.y(), 0});
  CurvePoint best{0, std::numeric_limits<double>::infinity()};
  for (size_t k = 0; k + 1 < points_.size(); ++k) {
    const Vec2 d = points_[k + 1] - points_[k];
    const double s = std::clamp((p - points_[k]).dot(d) / d.squaredNorm(), 0.0, 1.0);
    const double distance = (points_[k] + s * d - p).norm();
    if (distance < best.distance) best = {parameter(k, s), distance};
  }
  return best;
}

void FacetLine::make_segments() {
  for (size_t k = 0; k + 1 < points_.size(); ++k) {
    const Vec2 third = (points_[k + 1] - points_[k]) / 3;
    arcs_.push_back({{points_[k], points_[k] + third, points_[k + 1] - third, points_[k + 1]}});
  }
}

size_t FacetLine::segment(double t) const {
  const auto above = std::upper_bound(parameters_.begin(), parameters_.end(), t);
  const auto k = static_cast<size_t>(std::max<long>(0, above - parameters_.begin() - 1));
  return std::min(k, parameters_.size() - 2);
}

std::vector<double> breaks(const EmbeddedLine& line) {
  std::vector<double> t{line.pcurve.start(), line.pcurve.end()};
  for (const HermiteCurve* curve : {&line.pcurve, &line.fitted})
    for (const int node : curve->mesh().corners()) t.push_back(curve->parameters()[node]);
  std::sort(t.begin(), t.end());
  t.erase(std::unique(t.begin(), t.end()), t.end());
  return t;
}

namespace {

/// By how much a curve turns between two parameters inside of which it is smooth, radians.
double turning_angle(const HermiteCurve& curve, double t0, double t1) {
  constexpr int samples = 4;
  double sum = 0;
  Vec3 before;
  for (int k = 0; k <= samples; ++k) {
    const double inside = std::clamp(static_cast<double>(k) / samples, 1e-6, 1 - 1e-6);
    const Vec3 slope = curve.evaluate(t0 + inside * (t1 - t0), 1);
    if (k > 0) sum += std::atan2(before.cross(slope).norm(), before.dot(slope));
    before = slope;
  }
  return sum;
}

}  // namespace

std::vector<double> subdivide_line(const EmbeddedLine& line, double edge_length, int min_edges) {
  const HermiteCurve& curve = line.fitted;
  constexpr int samples = 16;  // of each segment
  std::vector<double> t{curve.start()}, arc{0};
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 1; k <= samples; ++k) {
      const double from = curve.parameters()[s], to = curve.parameters()[s + 1];
      const double next = k == samples ? to : from + (to - from) * k / samples;
      arc.push_back(arc.back() + (curve.evaluate({s, static_cast<double>(k) / samples}, 0) -
                                  curve.evaluate({s, static_cast<double>(k - 1) / samples}, 0))
                                     .norm());
      t.push_back(next);
    }
  const auto interpolated = [](const std::vector<double>& x, const std::vector<double>& y,
                               double at) {
    const auto above = std::lower_bound(x.begin() + 1, x.end() - 1, at);
    const auto k = static_cast<size_t>(above - x.begin());
    if (x[k] == x[k - 1]) return y[k];
    return y[k - 1] + (y[k] - y[k - 1]) * ((at - x[k - 1]) / (x[k] - x[k - 1]));
  };
  constexpr double most = 36 * std::numbers::pi / 180;
  std::vector<double> result;
  const auto split = [&](const auto& self, double t0, double t1, int depth) -> void {
    if (depth < 12 && turning_angle(curve, t0, t1) > most) {
      const double middle = 0.5 * (t0 + t1);
      self(self, t0, middle, depth + 1);
      self(self, middle, t1, depth + 1);
    } else {
      result.push_back(t1);
    }
  };
  const std::vector<double> ends = breaks(line);
  result.push_back(ends.front());
  for (size_t b = 0; b + 1 < ends.size(); ++b) {
    const double from = interpolated(t, arc, ends[b]), to = interpolated(t, arc, ends[b + 1]);
    const double fraction = (to - from) / std::max(arc.back(), 1e-300);
    const int count = std::max({1, static_cast<int>(std::lround((to - from) / edge_length)),
                                static_cast<int>(std::ceil(min_edges * fraction - 1e-9))});
    double before = ends[b];
    for (int k = 1; k <= count; ++k) {
      const double next =
          k == count ? ends[b + 1] : interpolated(arc, t, from + (to - from) * k / count);
      split(split, before, next, 0);
      before = next;
    }
  }
  return result;
}

}  // namespace batten
