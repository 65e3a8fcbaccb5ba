// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/facets/line_subdivision.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

bool before(const SubdivisionPoint& a, const SubdivisionPoint& b) { return a.t < b.t; }

}  // namespace

MeanEdge mean_edge(const Surface& surface) {
  const ParametricMesh& mesh = surface.mesh();
  const auto outside = [&](int t) {
    return t < 0 || (surface.trim() && surface.trim()->side(t) == Trim::Side::Outside);
  };
  MeanEdge sum;
  int count = 0;
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    if (outside(edge.triangle[0]) && outside(edge.triangle[1])) continue;
    sum.space += (surface.dofs().row(3 * edge.low) - surface.dofs().row(3 * edge.high)).norm();
    sum.uv += mesh.edge_length(e);
    ++count;
  }
  return {sum.space / count, sum.uv / count};
}

LineSubdivision::LineSubdivision(const SkinnedRegion& region, double edge_length,
                                 const SubdivisionRequest& requested)
    : region_(region), requested_(requested) {
  const ParametricMesh& mesh = region.surface.mesh();
  if (region.boundary.empty() || region.boundary[0].empty())
    throw InputError(message_prefix() + "found embedded curves, but no boundary");
  for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
    lines_.emplace_back(mesh, aligned_line);
  for (const EmbeddedLine& line : region.embedded) lines_.emplace_back(line);
  subdivisions_.resize(lines_.size());
  min_edges_.assign(lines_.size(), 1);
  on_boundary_.assign(lines_.size(), 0);
  for (const auto& loop : region.boundary)
    for (const BoundarySegment& piece : loop) {
      constexpr int min_loop_edges = 8;  // per loop
      on_boundary_[line_of(piece)] = 1;
      min_edges_[line_of(piece)] = (min_loop_edges + isize(loop) - 1) / isize(loop);
    }
  merge_tolerance_ = 1e-7 * bounding_box(mesh.vertices()).diagonal().norm();
  const MeanEdge mean = mean_edge(region.surface);
  if (!(edge_length > 0)) edge_length = mean.space;
  size_ = mean.uv * (edge_length / mean.space);
  edge_length_ = edge_length;
  if (has_seam()) cut_open();
  add_fixed_points();
  find_crossings();
  subdivide();
}

void LineSubdivision::add(size_t line, double t) {
  auto& subdivision = subdivisions_[line];
  const SubdivisionPoint point{t, new_node(lines_[line].at(t)), false};
  subdivision.insert(std::lower_bound(subdivision.begin(), subdivision.end(), point, before),
                     point);
}

double LineSubdivision::beyond_seam(const Vec2& p) const {
  const Vec2 from = lines_[seam()].at(0), to = lines_[seam()].at(lines_[seam()].end());
  return p.x() - from.x() - (p.y() - from.y()) / (to.y() - from.y()) * (to.x() - from.x());
}

bool LineSubdivision::on_seam(int node) const {
  const auto& subdivision = subdivisions_[seam()];
  return std::any_of(subdivision.begin(), subdivision.end(),
                     [&](const SubdivisionPoint& point) { return point.node == node; });
}

const SubdivisionPoint* LineSubdivision::fixed_near(size_t line, const Vec2& p) const {
  for (const SubdivisionPoint& point : subdivisions_[line])
    if ((near(nodes_[point.node], p) - p).norm() <= merge_tolerance_) return &point;
  return nullptr;
}

CurvePoint LineSubdivision::closest(const FacetLine& line, const Vec2& p) const {
  if (!has_seam()) return line.closest(p);
  const auto [low, high] = line.u_range();
  CurvePoint best{0, std::numeric_limits<double>::infinity()};
  for (double k = std::floor((low - p.x()) / period()); p.x() + (k - 1) * period() <= high; ++k) {
    const CurvePoint there = line.closest({p.x() + k * period(), p.y()});
    if (there.distance < best.distance) best = there;
  }
  return best;
}

void LineSubdivision::cut_open() {
  const ParametricMesh& mesh = region_.surface.mesh();
  size_ = std::min(size_, period() / 8);
  std::vector<Vec2> rims[2];
  for (const int r : {0, 1})
    for (const BoundarySegment& piece : region_.boundary.at(static_cast<size_t>(r)))
      for (const int v : region_.edge_aligned.at(static_cast<size_t>(piece.index)).vertices)
        rims[r].push_back(mesh.vertices()[v]);
  struct Sample {
    Vec2 c, direction;
    bool boundary;
  };
  std::vector<Sample> samples;
  for (size_t l = region_.edge_aligned.size(); l < lines_.size(); ++l) {
    const HermiteCurve& pcurve = lines_[l].embedded()->pcurve;
    constexpr int cuts = 16;  // per segment
    for (int s = 0; s < pcurve.segment_count(); ++s)
      for (int k = 0; k <= cuts; ++k) {
        const CurveMesh::SegmentPoint where{s, static_cast<double>(k) / cuts};
        samples.push_back({pcurve.evaluate(where).head<2>(),
                           pcurve.evaluate(where, 1).head<2>().normalized(), on_boundary_[l] != 0});
      }
  }
  double least = std::numeric_limits<double>::infinity();
  Vec2 best[2];
  for (const Vec2& from : rims[0]) {
    Vec2 to = rims[1][0];
    for (const Vec2& p : rims[1])
      if (std::abs(near(p, from).x() - from.x()) < std::abs(near(to, from).x() - from.x())) to = p;
    to = near(to, from);
    const Vec2 up = (to - from).normalized();
    double along = 0;
    for (const Sample& sample : samples) {
      const double fraction = (sample.c.y() - from.y()) / (to.y() - from.y());
      const double beside =
          std::abs(std::remainder(sample.c.x() - from.x() - fraction * (to - from).x(), period()));
      // The weight of lines next to the seam decreases with their distance.
      const double u_range = 0.5 * size_;
      if (beside < u_range)
        along = std::max(along, (sample.boundary ? 2 : 1) * (1 - beside / u_range) *
                                    std::abs(sample.direction.dot(up)));
      if (sample.boundary && beside < 0.1 * size_) along = 10;
    }
    constexpr double min_improvement = 0.05;
    if (along > least - min_improvement) continue;
    least = along;
    best[0] = from;
    best[1] = to;
  }
  if (least >= 10)
    throw InputError(message_prefix() +
                     "every straight seam between the two boundaries of the annulus meets a hole");
  lines_.emplace_back("seam", best[0], best[1]);
  subdivisions_.emplace_back();
  min_edges_.push_back(1);
  on_boundary_.push_back(0);
}

void LineSubdivision::add_fixed_points() {
  std::map<int, int> node_of_vertex;
  const ParametricMesh& mesh = region_.surface.mesh();
  for (size_t r = 0; r < region_.edge_aligned.size(); ++r)
    for (size_t k = 0; k < region_.edge_aligned[r].vertices.size(); ++k) {
      const int v = region_.edge_aligned[r].vertices[k];
      const auto [found, added] = node_of_vertex.try_emplace(v, isize(nodes_));
      if (added) new_node(mesh.vertices()[v]);
      fix(r, region_.edge_aligned[r].parameters[k], found->second);
    }
  // Ends and corners. The boundary comes first, so that inner lines snap to it.
  for (const bool boundary : {true, false})
    for (size_t l = region_.edge_aligned.size(); l < lines_.size(); ++l) {
      if (static_cast<bool>(on_boundary_[l]) != boundary) continue;
      const EmbeddedLine* line = lines_[l].embedded();
      for (const double t :
           line ? breaks(*line) : std::vector<double>{lines_[l].start(), lines_[l].end()}) {
        const Vec2 p = lines_[l].at(t);
        int node = -1;
        for (size_t i = 0; node < 0 && i < nodes_.size(); ++i)
          if ((near(nodes_[i], p) - p).norm() <= merge_tolerance_) node = static_cast<int>(i);
        fix(l, t, node >= 0 ? node : new_node(p));
      }
    }
  // Ends that lie on another line.
  for (size_t l = 0; l < lines_.size(); ++l)
    for (const double t : {lines_[l].start(), lines_[l].end()}) {
      const Vec2 p = lines_[l].at(t);
      const int node = fixed_near(l, p)->node;
      for (size_t m = 0; m < lines_.size(); ++m) {
        if (m == l || fixed_near(m, p)) continue;
        const CurvePoint there = closest(lines_[m], p);
        if (there.distance > merge_tolerance_) continue;
        fix(m, there.u, node);
        if (!on_boundary_[l] && lines_[l].embedded()) nodes_[node] = lines_[m].at(there.u);
      }
    }
}

void LineSubdivision::find_crossings() {
  for (size_t l = 0; l < lines_.size(); ++l)
    for (size_t m = l + 1; m < lines_.size(); ++m) {
      if (on_boundary_[l] && on_boundary_[m]) continue;
      // Both edge-aligned: they share mesh vertices.
      if (!lines_[l].embedded() && !lines_[m].embedded()) continue;
      // Tested against each periodic copy of the second line in range.
      double first = 0, last = 0;
      if (has_seam()) {
        const auto a = lines_[l].u_range(), b = lines_[m].u_range();
        first = std::ceil((a.first - b.second - merge_tolerance_) / period());
        last = std::floor((a.second - b.first + merge_tolerance_) / period());
      }
      for (double k = first; k <= last; ++k)
        for (size_t i = 0; i < lines_[l].arc_count(); ++i)
          for (size_t j = 0; j < lines_[m].arc_count(); ++j)
            intersect_segments(l, i, 0, 1, m, j, 0, 1, k * period(), 0);
    }
}

void LineSubdivision::intersect_segments(size_t l, size_t i, double s0, double s1, size_t m,
                                         size_t j, double t0, double t1, double du, int depth) {
  const PlanarCubic a = lines_[l].arc(i, s0, s1);
  PlanarCubic b = lines_[m].arc(j, t0, t1);
  for (Vec2& p : b.b) p.x() += du;
  const Box2 of_a = bounding_box(a.b), of_b = bounding_box(b.b);
  if ((of_a.max() - of_b.min()).minCoeff() < -merge_tolerance_ ||
      (of_b.max() - of_a.min()).minCoeff() < -merge_tolerance_)
    return;
  constexpr int deepest = 6;
  if (depth < deepest) {
    const double s = 0.5 * (s0 + s1), t = 0.5 * (t0 + t1);
    for (const int part : {0, 1, 2, 3})
      intersect_segments(l, i, part < 2 ? s0 : s, part < 2 ? s : s1, m, j, part % 2 ? t : t0,
                         part % 2 ? t1 : t, du, depth + 1);
    return;
  }
  double s = 0.5, t = 0.5;
  for (int step = 0; step < 20; ++step) {
    Mat2 J;
    J.col(0) = a.slope(s);
    J.col(1) = -b.slope(t);
    const Vec2 move = J.fullPivLu().solve(b.at(t) - a.at(s));
    if (!move.allFinite()) return;
    s = std::clamp(s + move[0], -0.5, 1.5);
    t = std::clamp(t + move[1], -0.5, 1.5);
  }
  constexpr double tolerance = 1e-6;
  if (s < -tolerance || s > 1 + tolerance || t < -tolerance || t > 1 + tolerance) return;
  s = std::clamp(s, 0.0, 1.0);
  t = std::clamp(t, 0.0, 1.0);
  if ((a.at(s) - b.at(t)).norm() > merge_tolerance_) return;
  const SubdivisionPoint *on_l = fixed_near(l, a.at(s)), *on_m = fixed_near(m, b.at(t));
  if (on_l && on_m) return;
  const double at_l = lines_[l].parameter(i, s0 + s * (s1 - s0)),
               at_m = lines_[m].parameter(j, t0 + t * (t1 - t0));
  const int node = on_l   ? on_l->node
                   : on_m ? on_m->node
                          : new_node(on_boundary_[m] ? lines_[m].at(at_m) : lines_[l].at(at_l));
  if (!on_l) fix(l, at_l, node);
  if (!on_m) fix(m, at_m, node);
}

void LineSubdivision::subdivide() {
  for (size_t l = 0; l < lines_.size(); ++l) {
    if (l < requested_.at.size() && !requested_.at[l].empty())
      subdivide_as_requested(l);
    else if (lines_[l].embedded())
      subdivide_embedded(l);
    std::stable_sort(subdivisions_[l].begin(), subdivisions_[l].end(), before);
  }
  if (has_seam()) subdivide_seam();
}

// A fixed point replaces a computed one near it; ends and corners are fixed points themselves.
void LineSubdivision::subdivide_embedded(size_t l) {
  std::vector<SubdivisionPoint> all;
  for (const double t : subdivide_line(*lines_[l].embedded(), edge_length_, min_edges_[l]))
    all.push_back({t, -1, false});
  for (const SubdivisionPoint& fixed : subdivisions_[l]) {
    const auto next = std::lower_bound(all.begin(), all.end(), fixed, before);
    const auto i = static_cast<size_t>(next - all.begin());
    const size_t above = std::min(i, all.size() - 1), below = i == 0 ? 0 : i - 1;
    const size_t near =
        std::abs(all[above].t - fixed.t) <= std::abs(all[below].t - fixed.t) ? above : below;
    const double gap = all[above].t - all[below].t;
    constexpr double fraction = 0.3;
    if (!all[near].fixed && (std::abs(all[near].t - fixed.t) <= fraction * gap || gap == 0))
      all[near] = fixed;
    else
      all.insert(all.begin() + static_cast<long>(i), fixed);
  }
  subdivisions_[l] = std::move(all);
  for (SubdivisionPoint& point : subdivisions_[l])
    if (point.node < 0) point.node = new_node(lines_[l].at(point.t));
}

// Adds the requested points to the fixed ones.
void LineSubdivision::subdivide_as_requested(size_t l) {
  const double same = kParameterTolerance * (lines_[l].end() - lines_[l].start());
  const std::vector<SubdivisionPoint> fixed = subdivisions_[l];
  for (const double t : requested_.at[l])
    if (std::none_of(fixed.begin(), fixed.end(),
                     [&](const SubdivisionPoint& point) { return std::abs(point.t - t) <= same; }))
      subdivisions_[l].push_back({t, new_node(lines_[l].at(t)), false});
}

void LineSubdivision::subdivide_seam() {
  std::vector<SubdivisionPoint> all;
  for (const SubdivisionPoint& point : subdivisions_[seam()]) {
    const double from = all.empty() ? 0 : all.back().t, gap = point.t - from;
    const auto cuts = static_cast<int>(std::lround(gap / size_));
    for (int k = 1; k < cuts; ++k) {
      const double t = from + gap * k / cuts;
      all.push_back({t, new_node(lines_[seam()].at(t)), false});
    }
    all.push_back(point);
  }
  subdivisions_[seam()] = std::move(all);
}

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
  for (size_t k = 0; k + 1 < points_.size(); ++k)
    arcs_.push_back(PlanarCubic::straight(points_[k], points_[k + 1]));
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

/// Total change of direction of a curve between two parameters, radians. The curve is smooth in
/// between.
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
  constexpr int samples = 16;  // per segment
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
