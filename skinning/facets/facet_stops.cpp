#include "batten/skinning/facets/facet_stops.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/core/plane.h"

namespace batten {
namespace {

bool before(const FacetStop& a, const FacetStop& b) { return a.t < b.t; }

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

FacetStops::FacetStops(const SkinnedRegion& region, double edge_length, const LineStops& asked)
    : region_(region), asked_(asked) {
  const ParametricMesh& mesh = region.surface.mesh();
  if (region.boundary.empty() || region.boundary[0].empty())
    throw InputError(who() + "found embedded lines, but no boundary");
  for (const LineRun& run : region.runs) lines_.emplace_back(mesh, run);
  for (const EmbeddedLine& line : region.embedded) lines_.emplace_back(line);
  stops_.resize(lines_.size());
  at_least_.assign(lines_.size(), 1);
  on_boundary_.assign(lines_.size(), 0);
  for (const auto& loop : region.boundary)
    for (const BoundaryPiece& piece : loop) {
      constexpr int least_edges = 8;  // of a loop
      on_boundary_[line_of(piece)] = 1;
      at_least_[line_of(piece)] = (least_edges + count_of(loop) - 1) / count_of(loop);
    }
  same_ = 1e-7 * box_around(mesh.vertices()).diagonal().norm();
  const MeanEdge mean = mean_edge(region.surface);
  if (!(edge_length > 0)) edge_length = mean.space;
  size_ = mean.uv * (edge_length / mean.space);
  space_ = edge_length;
  if (has_seam()) cut_open();
  place_fixed_stops();
  find_crossings();
  divide();
}

void FacetStops::add(size_t line, double t) {
  auto& stops = stops_[line];
  const FacetStop stop{t, new_node(lines_[line].at(t)), false};
  stops.insert(std::lower_bound(stops.begin(), stops.end(), stop, before), stop);
}

double FacetStops::beyond_seam(const Vec2& p) const {
  const Vec2 from = lines_[seam()].at(0), to = lines_[seam()].at(lines_[seam()].end());
  return p.x() - from.x() - (p.y() - from.y()) / (to.y() - from.y()) * (to.x() - from.x());
}

bool FacetStops::on_seam(int node) const {
  const auto& stops = stops_[seam()];
  return std::any_of(stops.begin(), stops.end(),
                     [&](const FacetStop& stop) { return stop.node == node; });
}

const FacetStop* FacetStops::fixed_near(size_t line, const Vec2& p) const {
  for (const FacetStop& stop : stops_[line])
    if ((near(nodes_[stop.node], p) - p).norm() <= same_) return &stop;
  return nullptr;
}

CurvePoint FacetStops::closest(const FacetLine& line, const Vec2& p) const {
  if (!has_seam()) return line.closest(p);
  const auto [low, high] = line.reach();
  CurvePoint best{0, std::numeric_limits<double>::infinity()};
  for (double k = std::floor((low - p.x()) / period()); p.x() + (k - 1) * period() <= high; ++k) {
    const CurvePoint there = line.closest({p.x() + k * period(), p.y()});
    if (there.distance < best.distance) best = there;
  }
  return best;
}

void FacetStops::cut_open() {
  const ParametricMesh& mesh = region_.surface.mesh();
  size_ = std::min(size_, period() / 8);
  std::vector<Vec2> rims[2];
  for (const int r : {0, 1})
    for (const BoundaryPiece& piece : region_.boundary.at(static_cast<size_t>(r)))
      for (const int v : region_.runs.at(static_cast<size_t>(piece.index)).vertices)
        rims[r].push_back(mesh.vertices()[v]);
  struct Sample {
    Vec2 c, direction;
    bool boundary;
  };
  std::vector<Sample> samples;
  for (size_t l = region_.runs.size(); l < lines_.size(); ++l) {
    const HermiteCurve& image = lines_[l].embedded()->image;
    constexpr int cuts = 16;  // of a segment
    for (int s = 0; s < image.segment_count(); ++s)
      for (int k = 0; k <= cuts; ++k) {
        const CurveMesh::Where where{s, static_cast<double>(k) / cuts};
        samples.push_back({image.evaluate(where).head<2>(),
                           image.evaluate(where, 1).head<2>().normalized(), on_boundary_[l] != 0});
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
      const double share = (sample.c.y() - from.y()) / (to.y() - from.y());
      const double beside =
          std::abs(std::remainder(sample.c.x() - from.x() - share * (to - from).x(), period()));
      // Lines beside it count less and less.
      const double reach = 0.5 * size_;
      if (beside < reach)
        along = std::max(along, (sample.boundary ? 2 : 1) * (1 - beside / reach) *
                                    std::abs(sample.direction.dot(up)));
      if (sample.boundary && beside < 0.1 * size_) along = 10;
    }
    constexpr double worth_it = 0.05;
    if (along > least - worth_it) continue;
    least = along;
    best[0] = from;
    best[1] = to;
  }
  if (least >= 10)
    throw InputError(who() + "no straight seam from rim to rim of the ring is free of holes");
  lines_.emplace_back("seam", best[0], best[1]);
  stops_.emplace_back();
  at_least_.push_back(1);
  on_boundary_.push_back(0);
}

void FacetStops::place_fixed_stops() {
  std::map<int, int> node_of_vertex;
  const ParametricMesh& mesh = region_.surface.mesh();
  for (size_t r = 0; r < region_.runs.size(); ++r)
    for (size_t k = 0; k < region_.runs[r].vertices.size(); ++k) {
      const int v = region_.runs[r].vertices[k];
      const auto [found, added] = node_of_vertex.try_emplace(v, count_of(nodes_));
      if (added) new_node(mesh.vertices()[v]);
      fix(r, region_.runs[r].parameters[k], found->second);
    }
  // Ends and corners; those of the boundary first, so that inner lines come to it.
  for (const bool boundary : {true, false})
    for (size_t l = region_.runs.size(); l < lines_.size(); ++l) {
      if (static_cast<bool>(on_boundary_[l]) != boundary) continue;
      const EmbeddedLine* line = lines_[l].embedded();
      for (const double t :
           line ? breaks(*line) : std::vector<double>{lines_[l].start(), lines_[l].end()}) {
        const Vec2 p = lines_[l].at(t);
        int node = -1;
        for (size_t i = 0; node < 0 && i < nodes_.size(); ++i)
          if ((near(nodes_[i], p) - p).norm() <= same_) node = static_cast<int>(i);
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
        if (there.distance > same_) continue;
        fix(m, there.u, node);
        if (!on_boundary_[l] && lines_[l].embedded()) nodes_[node] = lines_[m].at(there.u);
      }
    }
}

void FacetStops::find_crossings() {
  for (size_t l = 0; l < lines_.size(); ++l)
    for (size_t m = l + 1; m < lines_.size(); ++m) {
      if (on_boundary_[l] && on_boundary_[m]) continue;
      if (!lines_[l].embedded() && !lines_[m].embedded()) continue;  // share mesh vertices
      // Against each image of the second line that comes near.
      double first = 0, last = 0;
      if (has_seam()) {
        const auto a = lines_[l].reach(), b = lines_[m].reach();
        first = std::ceil((a.first - b.second - same_) / period());
        last = std::floor((a.second - b.first + same_) / period());
      }
      for (double k = first; k <= last; ++k)
        for (size_t i = 0; i < lines_[l].arc_count(); ++i)
          for (size_t j = 0; j < lines_[m].arc_count(); ++j)
            cross_arcs(l, i, 0, 1, m, j, 0, 1, k * period(), 0);
    }
}

void FacetStops::cross_arcs(size_t l, size_t i, double s0, double s1, size_t m, size_t j, double t0,
                            double t1, double du, int depth) {
  const PlanarCubic a = lines_[l].arc(i, s0, s1);
  PlanarCubic b = lines_[m].arc(j, t0, t1);
  for (Vec2& p : b.b) p.x() += du;
  const Box2 of_a = box_around(a.b), of_b = box_around(b.b);
  if ((of_a.max() - of_b.min()).minCoeff() < -same_ ||
      (of_b.max() - of_a.min()).minCoeff() < -same_)
    return;
  constexpr int deepest = 6;
  if (depth < deepest) {
    const double s = 0.5 * (s0 + s1), t = 0.5 * (t0 + t1);
    for (const int part : {0, 1, 2, 3})
      cross_arcs(l, i, part < 2 ? s0 : s, part < 2 ? s : s1, m, j, part % 2 ? t : t0,
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
  constexpr double hair = 1e-6;
  if (s < -hair || s > 1 + hair || t < -hair || t > 1 + hair) return;
  s = std::clamp(s, 0.0, 1.0);
  t = std::clamp(t, 0.0, 1.0);
  if ((a.at(s) - b.at(t)).norm() > same_) return;
  const FacetStop *on_l = fixed_near(l, a.at(s)), *on_m = fixed_near(m, b.at(t));
  if (on_l && on_m) return;
  const double at_l = lines_[l].parameter(i, s0 + s * (s1 - s0)),
               at_m = lines_[m].parameter(j, t0 + t * (t1 - t0));
  const int node = on_l   ? on_l->node
                   : on_m ? on_m->node
                          : new_node(on_boundary_[m] ? lines_[m].at(at_m) : lines_[l].at(at_l));
  if (!on_l) fix(l, at_l, node);
  if (!on_m) fix(m, at_m, node);
}

void FacetStops::divide() {
  for (size_t l = 0; l < lines_.size(); ++l) {
    if (l < asked_.at.size() && !asked_.at[l].empty())
      divide_as_asked(l);
    else if (lines_[l].embedded())
      divide_embedded(l);
    std::stable_sort(stops_[l].begin(), stops_[l].end(), before);
  }
  if (has_seam()) divide_seam();
}

// A fixed stop takes the place of one that is near; ends and corners are fixed themselves.
void FacetStops::divide_embedded(size_t l) {
  std::vector<FacetStop> all;
  for (const double t : divisions(*lines_[l].embedded(), space_, at_least_[l]))
    all.push_back({t, -1, false});
  for (const FacetStop& fixed : stops_[l]) {
    const auto next = std::lower_bound(all.begin(), all.end(), fixed, before);
    const auto i = static_cast<size_t>(next - all.begin());
    const size_t above = std::min(i, all.size() - 1), below = i == 0 ? 0 : i - 1;
    const size_t near =
        std::abs(all[above].t - fixed.t) <= std::abs(all[below].t - fixed.t) ? above : below;
    const double gap = all[above].t - all[below].t;
    constexpr double share = 0.3;
    if (!all[near].fixed && (std::abs(all[near].t - fixed.t) <= share * gap || gap == 0))
      all[near] = fixed;
    else
      all.insert(all.begin() + static_cast<long>(i), fixed);
  }
  stops_[l] = std::move(all);
  for (FacetStop& stop : stops_[l])
    if (stop.node < 0) stop.node = new_node(lines_[l].at(stop.t));
}

// What is asked for beside the fixed stops.
void FacetStops::divide_as_asked(size_t l) {
  const double same = kSameParameter * (lines_[l].end() - lines_[l].start());
  const std::vector<FacetStop> fixed = stops_[l];
  for (const double t : asked_.at[l])
    if (std::none_of(fixed.begin(), fixed.end(),
                     [&](const FacetStop& stop) { return std::abs(stop.t - t) <= same; }))
      stops_[l].push_back({t, new_node(lines_[l].at(t)), false});
}

void FacetStops::divide_seam() {
  std::vector<FacetStop> all;
  for (const FacetStop& stop : stops_[seam()]) {
    const double from = all.empty() ? 0 : all.back().t, gap = stop.t - from;
    const auto cuts = static_cast<int>(std::lround(gap / size_));
    for (int k = 1; k < cuts; ++k) {
      const double t = from + gap * k / cuts;
      all.push_back({t, new_node(lines_[seam()].at(t)), false});
    }
    all.push_back(stop);
  }
  stops_[seam()] = std::move(all);
}

}  // namespace batten
