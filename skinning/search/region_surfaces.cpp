// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/search/region_surfaces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/domains/hole_triangulation.h"
#include "batten/skinning/search/region_graph.h"

namespace batten {
namespace {

// Closest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
Vec3 nearest(const Vec3& p, const std::array<Vec3, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
  const double sum = va + vb + vc;
  return sum > 0 ? Vec3(a + vb / sum * ab + vc / sum * ac) : a;
}

std::vector<Vec3> points_of(const GraphEdge& edge) {
  return {edge.points.begin(), edge.points.end()};
}

double distance_to_loop(const RegionGraph& graph, const EdgeLoop& loop, const Vec3& p) {
  double least = HUGE_VAL;
  for (const OrientedEdge& use : loop)
    for (int k = 0; k < GraphEdge::kPieces; ++k) {
      const auto& x = graph.edges[use.edge].points;
      least = std::min(least, (nearest(p, {x[k], x[k + 1], x[k + 1]}) - p).norm());
    }
  return least;
}

}  // namespace

RoughSurface::RoughSurface(const RegionGraph& graph, const EdgeLoop& outline) {
  constexpr int kMaxPoints = 240;
  const int n = isize(outline);
  const std::vector<Vec3> points = graph.sampled(outline, std::clamp(kMaxPoints / n, 1, 8));
  box_ = bounding_box(points);
  diagonal_ = box_.diagonal().norm();
  const auto fill =
      points.size() <= 400 && points.size() > 2 ? triangulate_hole(points) : std::nullopt;
  if (fill) {
    for (const auto& [a, b, c] : fill->triangles)
      triangles_.push_back({points[a], points[b], points[c]});
    return;
  }
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    triangles_.push_back({points[i], points[(i + 1) % points.size()], mean});
}

double RoughSurface::farthest(const std::vector<Vec3>& points, double enough) const {
  double most = 0;
  for (const Vec3& p : points) {
    const Vec3 outside = (box_.min() - p).cwiseMax(p - box_.max()).cwiseMax(0);
    if (outside.norm() > enough) return HUGE_VAL;
    double least = HUGE_VAL;
    for (const auto& triangle : triangles_)
      least = std::min(least, (nearest(p, triangle) - p).squaredNorm());
    most = std::max(most, std::sqrt(least));
    if (most > enough) return HUGE_VAL;
  }
  return most;
}

void find_inner_lines(const RegionGraph& graph, const LoopCosts& costs,
                      std::vector<NetworkRegion>& regions) {
  std::vector<char> unused_edges(graph.edges.size(), 1);
  for (const NetworkRegion& region : regions) {
    for (const int edge : region.inner) unused_edges[edge] = 0;
    for (const EdgeLoop& loop : region.loops)
      for (const OrientedEdge& use : loop) unused_edges[use.edge] = 0;
  }
  // Regions with an outer loop or inner edge there.
  std::vector<std::set<int>> at(graph.nodes.size());
  std::vector<LoopCandidate> outlines;
  for (size_t r = 0; r < regions.size(); ++r) {
    outlines.push_back(measure_loop(graph, regions[r].loops[0], costs));
    for (const OrientedEdge& use : regions[r].loops[0])
      at[graph.node_before(use)].insert(static_cast<int>(r));
  }
  std::map<int, std::unique_ptr<RoughSurface>> surfaces;
  const auto distance = [&](int r, int a) {
    auto& surface = surfaces[r];
    const EdgeLoop& loop = regions[r].loops[0];
    if (!surface) surface = std::make_unique<RoughSurface>(graph, loop);
    const double d = surface->farthest(points_of(graph.edges[a]), 0.1 * surface->diagonal());
    if (!std::isfinite(d)) return d;
    double from_border = 0;
    for (const Vec3& p : graph.edges[a].points)
      from_border = std::max(from_border, distance_to_loop(graph, loop, p));
    return from_border < 0.01 * surface->diagonal() ? HUGE_VAL : d;
  };
  for (bool more = true; more;) {
    more = false;
    for (int a = 0; a < isize(graph.edges); ++a) {
      if (!unused_edges[a]) continue;
      int best = -1;
      double least = HUGE_VAL;
      for (const bool end : {false, true}) {
        const int node = graph.edges[a].nodes[end];
        for (const int r : at[node]) {
          if (regions[r].annulus) continue;
          const auto& inner = regions[r].inner;
          const bool hangs = std::any_of(inner.begin(), inner.end(), [&](int b) {
            return graph.edges[b].nodes[0] == node || graph.edges[b].nodes[1] == node;
          });
          if (!hangs && !leaves_into(graph, outlines[r], {a, end})) continue;
          const double d = distance(r, a);
          if (d < least) best = r, least = d;
        }
      }
      if (best < 0) continue;
      regions[best].inner.push_back(a);
      unused_edges[a] = 0;
      for (const int node : graph.edges[a].nodes) at[node].insert(best);
      more = true;
    }
  }
  for (NetworkRegion& region : regions) std::sort(region.inner.begin(), region.inner.end());
}

void assign_stated_inner_lines(const RegionGraph& graph, std::vector<NetworkRegion>& regions) {
  using Role = CharacterLine::Role;
  std::vector<char> placed(graph.edges.size(), 0);
  for (const NetworkRegion& region : regions) {
    for (const int edge : region.inner) placed[edge] = 1;
    for (const EdgeLoop& loop : region.loops)
      for (const OrientedEdge& use : loop) placed[use.edge] = 1;
  }
  std::vector<std::unique_ptr<RoughSurface>> surfaces(regions.size());
  const auto nearest_region = [&](const std::vector<Vec3>& points, const std::string& line) {
    constexpr double kNear = 0.1;  // of the region's size
    int best = -1;
    double least = HUGE_VAL;
    for (size_t r = 0; r < regions.size(); ++r) {
      if (!surfaces[r]) surfaces[r] = std::make_unique<RoughSurface>(graph, regions[r].loops[0]);
      const double d = surfaces[r]->farthest(points, kNear * surfaces[r]->diagonal());
      if (d < least) best = static_cast<int>(r), least = d;
    }
    if (best < 0 && regions.size() == 1) return 0;
    if (best < 0)
      throw InputError("curve '" + line +
                       "' has role = \"inner\" or \"hole\", expected it on a face, but it lies on "
                       "none");
    return best;
  };
  std::vector<int> hole_edges;
  for (int a = 0; a < isize(graph.edges); ++a) {
    if (placed[a]) continue;
    if (graph.edges[a].role == Role::Hole) hole_edges.push_back(a);
    if (graph.edges[a].role == Role::Inner)
      regions[nearest_region(points_of(graph.edges[a]), graph.edges[a].line)].inner.push_back(a);
  }
  for (EdgeLoop& hole : closed_chains(graph, hole_edges)) {
    for (const OrientedEdge& use : hole) placed[use.edge] = 1;
    const std::string& line = graph.edges[hole.front().edge].line;
    regions[nearest_region(graph.sampled(hole, 8), line)].loops.push_back(std::move(hole));
  }
  for (const int a : hole_edges)
    if (!placed[a])
      throw InputError("curve '" + graph.edges[a].line +
                       "' has role = \"hole\", expected curves that form a closed loop");
  for (NetworkRegion& region : regions) std::sort(region.inner.begin(), region.inner.end());
}

std::vector<Island> find_islands(const RegionGraph& graph,
                                 const std::vector<NetworkRegion>& regions) {
  std::vector<Island> islands;
  if (graph.component_count < 2) return islands;
  std::vector<int> regions_of(graph.component_count, 0);
  std::vector<size_t> edges_of_component(graph.component_count, 0);
  for (size_t a = 0; a < graph.edges.size(); ++a)
    if (graph.core[a]) ++edges_of_component[graph.component[a]];
  for (const NetworkRegion& region : regions)
    ++regions_of[graph.component[region.loops[0][0].edge]];
  std::map<size_t, std::unique_ptr<RoughSurface>> surfaces;
  for (size_t r = 0; r < regions.size(); ++r) {
    const EdgeLoop& loop = regions[r].loops[0];
    const int component = graph.component[loop[0].edge];
    if (regions[r].requested || regions_of[component] != 1 ||
        edges_of_component[component] != loop.size())
      continue;
    const std::vector<Vec3> points = graph.sampled(loop, 4);
    for (size_t s = 0; s < regions.size(); ++s) {
      if (graph.component[regions[s].loops[0][0].edge] == component || regions[s].annulus) continue;
      auto& surface = surfaces[s];
      if (!surface) surface = std::make_unique<RoughSurface>(graph, regions[s].loops[0]);
      const double near = 0.02 * surface->diagonal();
      if (surface->farthest(points, near) <= near) {
        islands.push_back({static_cast<int>(r), static_cast<int>(s)});
        break;
      }
    }
  }
  return islands;
}

std::vector<EdgeLoop> closed_chains(const RegionGraph& graph, const std::vector<int>& edges) {
  std::map<int, std::vector<OrientedEdge>> leaving;  // for each node, in both directions
  for (const int a : edges)
    for (const bool reversed : {false, true})
      leaving[graph.edges[a].nodes[reversed]].push_back({a, reversed});
  std::set<int> done;
  const auto chain_from = [&](int first) -> EdgeLoop {
    EdgeLoop loop{{first, false}};
    const int home = graph.edges[first].nodes[0];
    for (int node = graph.node_after(loop.back()); node != home;
         node = graph.node_after(loop.back())) {
      const auto& continuations = leaving[node];
      if (continuations.size() != 2) return {};
      loop.push_back(continuations[0].edge == loop.back().edge ? continuations[1]
                                                               : continuations[0]);
      if (!done.insert(loop.back().edge).second) return {};
    }
    return leaving[home].size() == 2 ? loop : EdgeLoop();
  };
  std::vector<EdgeLoop> chains;
  for (const int first : edges)
    if (done.insert(first).second)
      if (EdgeLoop loop = chain_from(first); !loop.empty()) chains.push_back(std::move(loop));
  return chains;
}

std::vector<PlanarHole> find_planar_holes(const RegionGraph& graph,
                                          const std::vector<NetworkRegion>& regions,
                                          const std::vector<int>& free_edges) {
  std::vector<PlanarHole> holes;
  std::vector<std::optional<PlanarFace>> faces(regions.size());
  const std::vector<EdgeLoop> chains = closed_chains(graph, free_edges);
  for (size_t r = 0; r < regions.size() && !chains.empty(); ++r)
    if (!regions[r].annulus && !regions[r].requested)
      faces[r] = planar_face(graph, regions[r].loops[0]);
  for (const EdgeLoop& chain : chains) {
    int best = -1;
    const std::vector<Vec3> points = graph.sampled(chain, GraphEdge::kPieces);
    for (size_t r = 0; r < regions.size(); ++r)
      if (faces[r] && faces[r]->contains(points) &&
          (best < 0 || faces[r]->area < faces[best]->area))
        best = static_cast<int>(r);
    if (best >= 0) holes.push_back({chain, best});
  }
  return holes;
}

bool are_boundary_circles(const RegionGraph& graph, const EdgeLoop& a, const EdgeLoop& b) {
  Vec3 middle[2], axis[2];
  double radius[2]{};
  for (const int k : {0, 1}) {
    const EdgeLoop& loop = k ? b : a;
    for (size_t i = 0; i < loop.size(); ++i)
      if (degrees_between(graph.arriving(loop[i]), graph.leaving(loop[(i + 1) % loop.size()])) > 35)
        return false;
    const std::vector<Vec3> points = graph.sampled(loop, GraphEdge::kPieces);
    const double n = static_cast<double>(points.size());
    middle[k] = axis[k] = Vec3::Zero();
    for (const Vec3& p : points) middle[k] += p / n;
    for (size_t i = 0; i < points.size(); ++i)
      axis[k] += (points[i] - middle[k]).cross(points[(i + 1) % points.size()] - middle[k]);
    axis[k].normalize();
    for (const Vec3& p : points) radius[k] += (p - middle[k]).norm() / n;
  }
  if (axis[0].dot(axis[1]) < 0) axis[1] = -axis[1];
  if (degrees_between(axis[0], axis[1]) > 60) return false;
  const Vec3 along = (axis[0] + axis[1]).normalized(), apart = middle[1] - middle[0];
  const double spacing = std::abs(apart.dot(along));
  const double aside = (apart - apart.dot(along) * along).norm();
  constexpr double kMaxSlope = 2;  // of the line between the centres: 63 degrees from the axis
  return aside < std::max({radius[0], radius[1], kMaxSlope * spacing});
}

}  // namespace batten
