// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/search/region_graph.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

constexpr int kPieces = GraphEdge::kPieces;

Vec3 any_across(const Vec3& t) {
  int least = 0;
  t.cwiseAbs().minCoeff(&least);
  return t.cross(Vec3::Unit(least)).normalized();
}

// Transports u to the next point by double reflection; reflections preserve lengths and angles.
Vec3 transported(const Vec3& u, const Vec3& p, const Vec3& q, const Vec3& t, const Vec3& t_next) {
  const auto reflected = [](const Vec3& x, const Vec3& axis) -> Vec3 {
    const double c = axis.squaredNorm();
    return c > 0 ? Vec3(x - (2 * axis.dot(x) / c) * axis) : x;
  };
  const Vec3 between = q - p;
  const Vec3 half = reflected(u, between), t_half = reflected(t, between);
  const Vec3 next = reflected(half, t_next - t_half);
  return (next - next.dot(t_next) * t_next).normalized();
}

// Computes tangents and frames from the points. `ends`: the end tangents, if they are known.
void make_frames(GraphEdge& edge, const std::optional<std::pair<Vec3, Vec3>>& ends = {}) {
  const auto& x = edge.points;
  const double scale = (x.front() - x[kPieces / 2]).norm() + (x.back() - x[kPieces / 2]).norm();
  const auto direction = [&](int a, int b) {
    for (; a > 0 || b < kPieces; a = std::max(a - 1, 0), b = std::min(b + 1, kPieces))
      if ((x[b] - x[a]).norm() > 1e-12 * scale) break;
    const Vec3 d = x[b] - x[a];
    return d.norm() > 0 ? Vec3(d.normalized()) : Vec3(Vec3::UnitX());
  };
  for (int k = 0; k <= kPieces; ++k)
    edge.tangents[k] = direction(std::max(k - 1, 0), std::min(k + 1, kPieces));
  // End tangents: from the parabola through three points, unless the edge turns too much there.
  const auto at_end = [&](Vec3& tangent, const Vec3& p, const Vec3& q, const Vec3& r, int sign) {
    const Vec3 parabola = sign * (4 * (q - p) - (r - p));
    if (parabola.norm() > 1e-12 * scale && parabola.normalized().dot(tangent) > 0.5)
      tangent = parabola.normalized();
  };
  at_end(edge.tangents.front(), x[0], x[1], x[2], 1);
  at_end(edge.tangents.back(), x[kPieces], x[kPieces - 1], x[kPieces - 2], -1);
  if (ends && ends->first.norm() > 0) edge.tangents.front() = ends->first.normalized();
  if (ends && ends->second.norm() > 0) edge.tangents.back() = ends->second.normalized();
  edge.u[0] = any_across(edge.tangents[0]);
  for (int k = 0; k < kPieces; ++k) {
    edge.u[k + 1] = transported(edge.u[k], x[k], x[k + 1], edge.tangents[k], edge.tangents[k + 1]);
    const Vec3 tangent_change = edge.tangents[k + 1] - edge.tangents[k];
    const Vec3 u = (edge.u[k] + edge.u[k + 1]) / 2,
               t = (edge.tangents[k] + edge.tangents[k + 1]) / 2;
    edge.turning_u += tangent_change.dot(u);
    edge.turning_v += tangent_change.dot(t.cross(u));
  }
  for (int k = 0; k <= kPieces; ++k) edge.v[k] = edge.tangents[k].cross(edge.u[k]);
}

}  // namespace

double GraphEdge::angle(bool end, const Vec3& across) const {
  const int k = end ? kPieces : 0;
  return std::atan2(across.dot(v[k]), across.dot(u[k]));
}

Vec3 GraphEdge::across(bool end, double angle) const {
  const int k = end ? kPieces : 0;
  return std::cos(angle) * u[k] + std::sin(angle) * v[k];
}

Vec3 GraphEdge::parallel_transported(bool from_end, const Vec3& across) const {
  const int k = from_end ? kPieces : 0, l = kPieces - k;
  const Vec3 next = across.dot(u[k]) * u[l] + across.dot(v[k]) * v[l];
  const double norm = next.norm();
  return norm > 1e-12 ? Vec3(next / norm) : u[l];
}

RegionGraph::RegionGraph(const CurveNetwork& network, EndTangents tangents) : size(network.size()) {
  for (const NetworkNode& node : network.nodes()) nodes.push_back(node.position);
  for (const NetworkEdge& from : network.edges()) {
    GraphEdge edge;
    edge.name = from.name;
    edge.line = network.lines()[from.line].name;
    edge.role = network.lines()[from.line].role;
    edge.nodes = from.nodes;
    edge.length = from.length;
    const double a = from.curve.start(), b = from.curve.end();
    for (int k = 0; k <= kPieces; ++k)
      edge.points[k] = from.curve.evaluate(a + (b - a) * k / kPieces);
    edge.points.front() = nodes[edge.nodes[0]];
    edge.points.back() = nodes[edge.nodes[1]];
    if (tangents == EndTangents::OfCurve)
      make_frames(edge, std::pair{from.curve.evaluate(a, 1), from.curve.evaluate(b, 1)});
    else
      make_frames(edge);
    edges.push_back(std::move(edge));
  }
  connect();
}

RegionGraph::RegionGraph(std::vector<Vec3> positions, std::vector<std::array<int, 2>> edge_nodes,
                         const std::vector<std::vector<Vec3>>& polylines,
                         std::vector<std::string> names)
    : nodes(std::move(positions)) {
  Box3 box;
  for (size_t a = 0; a < polylines.size(); ++a) {
    const auto& line = polylines[a];
    std::vector<double> along{0};
    for (size_t i = 1; i < line.size(); ++i)
      along.push_back(along.back() + (line[i] - line[i - 1]).norm());
    if (line.size() < 2 || !std::isfinite(along.back()) || along.back() <= 0)
      throw InputError("edge '" + names[a] + "' needs two or more distinct finite points");
    GraphEdge edge;
    edge.name = edge.line = names[a];
    edge.nodes = edge_nodes[a];
    edge.length = along.back();
    size_t i = 1;
    for (int k = 0; k <= kPieces; ++k) {
      const double s = along.back() * k / kPieces;
      while (i + 1 < along.size() && along[i] < s) ++i;
      const double piece = along[i] - along[i - 1];
      const double f = piece > 0 ? std::clamp((s - along[i - 1]) / piece, 0.0, 1.0) : 0;
      edge.points[k] = (1 - f) * line[i - 1] + f * line[i];
      box.extend(edge.points[k]);
    }
    make_frames(edge);
    edges.push_back(std::move(edge));
  }
  if (!edges.empty()) size = box.diagonal().norm();
  connect();
}

void RegionGraph::connect() {
  ends.resize(nodes.size());
  for (int a = 0; a < isize(edges); ++a)
    for (const bool end : {false, true}) ends[edges[a].nodes[end]].push_back({a, end});
  find_core();
  find_components();
}

// Removes dangling edges repeatedly, from their free ends inwards.
void RegionGraph::find_core() {
  core.assign(edges.size(), true);
  for (size_t a = 0; a < edges.size(); ++a) core[a] = edges[a].role == CharacterLine::Role::Outline;
  std::vector<int> degree(nodes.size()), free_ends;
  for (size_t n = 0; n < nodes.size(); ++n) {
    degree[n] = static_cast<int>(std::count_if(ends[n].begin(), ends[n].end(),
                                               [&](const EdgeEnd& e) { return core[e.edge]; }));
    if (degree[n] == 1) free_ends.push_back(static_cast<int>(n));
  }
  while (!free_ends.empty()) {
    const int n = free_ends.back();
    free_ends.pop_back();
    for (const EdgeEnd& e : ends[n])
      if (core[e.edge]) {
        core[e.edge] = false;
        const int other = edges[e.edge].nodes[!e.end];
        if (--degree[other] == 1) free_ends.push_back(other);
      }
  }
}

// Components and bridges by depth-first search: an edge is a bridge if no back edge from below it
// reaches above it.
void RegionGraph::find_components() {
  component.assign(edges.size(), -1);
  bridge.assign(edges.size(), false);
  std::vector<int> order(nodes.size(), -1), low(nodes.size());
  int clock = 0;
  struct Visit {
    int node, by;  // edge by which the node was reached
    size_t next = 0;
  };
  for (int first = 0; first < isize(edges); ++first) {
    if (component[first] >= 0) continue;
    std::vector<Visit> path{{edges[first].nodes[0], -1}};
    order[path[0].node] = low[path[0].node] = clock++;
    while (!path.empty()) {
      Visit& here = path.back();
      if (here.next < ends[here.node].size()) {
        const EdgeEnd e = ends[here.node][here.next++];
        component[e.edge] = component_count;
        if (e.edge == here.by) continue;
        const int other = edges[e.edge].nodes[!e.end];
        if (order[other] >= 0) {
          low[here.node] = std::min(low[here.node], order[other]);
        } else {
          order[other] = low[other] = clock++;
          path.push_back({other, e.edge});
        }
      } else {
        const Visit done = here;
        path.pop_back();
        if (path.empty()) break;
        const int above = path.back().node;
        low[above] = std::min(low[above], low[done.node]);
        if (low[done.node] > order[above]) bridge[done.by] = true;
      }
    }
    ++component_count;
  }
}

std::vector<int> RegionGraph::edges_named(const std::string& name) const {
  std::vector<int> own, all;
  for (int a = 0; a < isize(edges); ++a) {
    if (edges[a].name == name) own.push_back(a);
    if (edges[a].line == name) all.push_back(a);
  }
  return own.empty() ? all : own;
}

std::vector<Vec3> RegionGraph::sampled(const EdgeLoop& loop, int per_edge) const {
  std::vector<Vec3> points;
  points.reserve(loop.size() * per_edge);
  for (const OrientedEdge& use : loop)
    for (int i = 0; i < per_edge; ++i) {
      const double s = static_cast<double>(i) / per_edge * kPieces;
      const double along = use.reversed ? kPieces - s : s;
      const int k = std::min(static_cast<int>(along), kPieces - 1);
      const auto& x = edges[use.edge].points;
      points.push_back(x[k] + (along - k) * (x[k + 1] - x[k]));
    }
  return points;
}

std::vector<int> edges_of(const EdgeLoop& loop) {
  std::vector<int> edges;
  for (const OrientedEdge& use : loop) edges.push_back(use.edge);
  std::sort(edges.begin(), edges.end());
  return edges;
}

EdgeLoop canonical(const EdgeLoop& loop) {
  const auto less = [](const EdgeLoop& a, const EdgeLoop& b) {
    return std::lexicographical_compare(
        a.begin(), a.end(), b.begin(), b.end(), [](const OrientedEdge& x, const OrientedEdge& y) {
          return x.edge != y.edge ? x.edge < y.edge : x.reversed < y.reversed;
        });
  };
  EdgeLoop back(loop.rbegin(), loop.rend());
  for (OrientedEdge& use : back) use.reversed = !use.reversed;
  const int lowest = loop.empty() ? 0 : edges_of(loop).front();
  EdgeLoop best;
  for (const EdgeLoop* candidate : {&loop, static_cast<const EdgeLoop*>(&back)})
    for (size_t i = 0; i < candidate->size(); ++i) {
      if ((*candidate)[i].edge != lowest) continue;
      EdgeLoop rotated(candidate->begin() + i, candidate->end());
      rotated.insert(rotated.end(), candidate->begin(), candidate->begin() + i);
      if (best.empty() || less(rotated, best)) best = std::move(rotated);
    }
  return best;
}

namespace {

using std::numbers::pi;
constexpr double kPlaneTolerance = 3e-4;  // of the network size

struct Plane {
  Vec3 at, normal;
  double tolerance;
  bool contains(const GraphEdge& edge) const {
    return std::all_of(edge.points.begin(), edge.points.end(),
                       [&](const Vec3& p) { return std::abs((p - at).dot(normal)) <= tolerance; });
  }
};

// The edge in the plane that turns most to the inside after `use`.
std::optional<OrientedEdge> next_in(const Plane& plane, const RegionGraph& graph,
                                    const OrientedEdge& use) {
  const Vec3 in = graph.arriving(use), inwards = plane.normal.cross(in);
  std::optional<OrientedEdge> best;
  double least = 2 * pi;
  for (const EdgeEnd& e : graph.ends[graph.node_after(use)]) {
    if (!graph.core[e.edge] || e == EdgeEnd{use.edge, !use.reversed}) continue;
    const GraphEdge& edge = graph.edges[e.edge];
    const Vec3 out = edge.out(e.end);
    double angle = std::atan2(out.dot(inwards), -out.dot(in));
    if (angle < 0) angle += 2 * pi;
    if (angle >= least || !plane.contains(edge)) continue;
    least = angle;
    best = {e.edge, e.end};
  }
  return best;
}

Vec3 area_vector(const std::vector<Vec3>& polygon) {
  Vec3 sum = Vec3::Zero();
  for (size_t i = 0; i < polygon.size(); ++i)
    sum += (polygon[i] - polygon[0]).cross(polygon[(i + 1) % polygon.size()] - polygon[0]) / 2;
  return sum;
}

}  // namespace

std::optional<PlanarFace> planar_face(const RegionGraph& graph, const EdgeLoop& loop) {
  PlanarFace face;
  face.outline = graph.sampled(loop, GraphEdge::kPieces);
  face.tolerance = kPlaneTolerance * graph.size;
  const Vec3 area = area_vector(face.outline);
  face.area = area.norm();
  if (!(face.area > 0)) return std::nullopt;
  face.normal = area / face.area;
  face.at = Vec3::Zero();
  for (const Vec3& p : face.outline) face.at += p / static_cast<double>(face.outline.size());
  for (const Vec3& p : face.outline)
    if (std::abs((p - face.at).dot(face.normal)) > face.tolerance) return std::nullopt;
  return face;
}

bool PlanarFace::contains(const std::vector<Vec3>& points) const {
  return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
    if (std::abs((p - at).dot(normal)) > tolerance) return false;
    double around = 0, nearest = HUGE_VAL;
    for (size_t i = 0; i < outline.size(); ++i) {
      const Vec3 a = outline[i] - p, b = outline[(i + 1) % outline.size()] - p;
      around += std::atan2(a.cross(b).dot(normal), a.dot(b));
      nearest = std::min(nearest, a.norm());
    }
    return nearest > tolerance && around > pi;
  });
}

bool is_straight(const GraphEdge& edge) {
  constexpr double kStraightTolerance = 1e-3;
  const Vec3 chord = edge.points.back() - edge.points.front();
  if (chord.norm() < 0.5 * edge.length) return false;
  const Vec3 along = chord.normalized();
  return std::all_of(edge.points.begin(), edge.points.end(), [&](const Vec3& p) {
    return along.cross(p - edge.points.front()).norm() <= kStraightTolerance * edge.length;
  });
}

int fillet_ends(const RegionGraph& graph, const EdgeLoop& loop) {
  constexpr double kStraightSine = 0.2588;  // sin 15°
  const auto goes_on = [&](size_t i) {
    const OrientedEdge &use = loop[i], &next = loop[(i + 1) % loop.size()];
    const Vec3 in = graph.arriving(use), out = graph.leaving(next);
    return in.dot(out) > 0 && in.cross(out).norm() < kStraightSine &&
           is_straight(graph.edges[use.edge]) != is_straight(graph.edges[next.edge]);
  };
  int ends = 0;
  for (size_t i = 0; i < loop.size(); ++i) ends += goes_on(i);
  if (ends == 0) return 0;
  return planar_face(graph, loop) ? ends : 0;
}

EdgeLoop loop_in_plane(const RegionGraph& graph, const OrientedEdge& in, const OrientedEdge& out,
                       const Vec3& normal) {
  const Plane plane{graph.nodes[graph.node_before(out)], normal, kPlaneTolerance * graph.size};
  if (!plane.contains(graph.edges[in.edge]) || !plane.contains(graph.edges[out.edge])) return {};
  EdgeLoop loop{out};
  while (loop.back() != in) {
    constexpr size_t kMaxEdges = 200;
    const auto next = next_in(plane, graph, loop.back());
    if (!next || loop.size() == kMaxEdges ||
        std::find(loop.begin(), loop.end(), *next) != loop.end())
      return {};
    loop.push_back(*next);
  }
  return area_vector(graph.sampled(loop, GraphEdge::kPieces)).dot(normal) > 0 ? loop : EdgeLoop{};
}

}  // namespace batten
