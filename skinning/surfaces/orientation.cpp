// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/orientation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/skinning/domains/annulus_domain.h"
#include "batten/skinning/domains/hole_triangulation.h"
#include "batten/skinning/surfaces/normal_side.h"

namespace batten {
namespace {

EdgeLoop reversed_loop(const EdgeLoop& loop) {
  EdgeLoop back(loop.rbegin(), loop.rend());
  for (OrientedEdge& use : back) use.reversed = !use.reversed;
  return back;
}

// Number of points per edge in polyline().
int points_per_edge(const EdgeLoop& loop) {
  constexpr int kMaxPoints = 96;
  return std::clamp(kMaxPoints / isize(loop), 2, 12);
}

// Points along a loop, with equally many per edge.
std::vector<Vec3> polyline(const CurveNetwork& network, const EdgeLoop& loop) {
  const int per_edge = points_per_edge(loop);
  std::vector<Vec3> points;
  for (const OrientedEdge& use : loop) {
    const HermiteCurve& curve = network.edges()[use.edge].curve;
    for (int i = 0; i < per_edge; ++i) {
      const double f = static_cast<double>(i) / per_edge;
      points.push_back(curve.evaluate(curve.end() * (use.reversed ? 1 - f : f)));
    }
  }
  return points;
}

// `count` points around a loop, uniform in arc length.
std::vector<Vec3> even_points(const CurveNetwork& network, const EdgeLoop& loop, int count) {
  double length = 0, begin = 0;
  for (const OrientedEdge& use : loop) length += network.edges()[use.edge].length;
  std::vector<Vec3> points;
  for (const OrientedEdge& use : loop) {
    const NetworkEdge& edge = network.edges()[use.edge];
    for (;;) {
      const double along = length * static_cast<double>(points.size()) / count - begin;
      if (along >= edge.length || isize(points) == count) break;
      // Edges are parametrised at constant speed.
      const double f = std::max(0.0, along) / edge.length;
      points.push_back(edge.curve.evaluate(edge.curve.end() * (use.reversed ? 1 - f : f)));
    }
    begin += edge.length;
  }
  return points;
}

// The strip between two boundary circles: points of the second one next to those of the first, with
// minimum distance.
struct Strip {
  std::vector<Vec3> first, second;
  bool along = true;  ///< the second circle has the same direction as the first
};
Strip strip_between(const CurveNetwork& network, const EdgeLoop& a, const EdgeLoop& b) {
  constexpr int count = 64;
  Strip strip{even_points(network, a, count), {}, true};
  const std::vector<Vec3> other = even_points(network, b, count);
  strip.along = circles_have_same_direction(strip.first, other);
  double least = std::numeric_limits<double>::infinity();
  int phase = 0;
  const auto at = [&](int i, int shift) {
    return static_cast<size_t>(((strip.along ? i : -i) + shift + 2 * count) % count);
  };
  for (int shift = 0; shift < count; ++shift) {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += (strip.first[i] - other[at(i, shift)]).squaredNorm();
    if (sum >= least) continue;
    least = sum;
    phase = shift;
  }
  for (int i = 0; i < count; ++i) strip.second.push_back(other[at(i, phase)]);
  return strip;
}

// Orients the loops of one region to run around it: boundary circles against each other, holes
// against the outer loop.
void orient_loops(const CurveNetwork& network, NetworkRegion& region) {
  const auto vector = [&](const EdgeLoop& loop) {
    const std::vector<Vec3> points = polyline(network, loop);
    Vec3 sum = Vec3::Zero();
    for (size_t i = 0; i < points.size(); ++i)
      sum += (points[i] - points[0]).cross(points[(i + 1) % points.size()] - points[0]);
    return sum;
  };
  for (size_t l = 1; l < region.loops.size(); ++l) {
    const bool same = region.annulus
                          ? strip_between(network, region.loops[0], region.loops[l]).along
                          : vector(region.loops[0]).dot(vector(region.loops[l])) > 0;
    if (same) region.loops[l] = reversed_loop(region.loops[l]);
  }
}

// Rough geometry of a region, from hole-filling triangulations.
struct FillingSketch {
  double area = 0, size = 0;
  SideIntegrals sides;
  // Facet normals along the edges of its loops: one per interval between points, in the direction
  // of the loop.
  std::map<int, std::pair<OrientedEdge, std::vector<Vec3>>> beside;
};

double dihedral_angle(const Vec3& n, const Vec3& m, const Vec3& outwards) {
  return std::copysign(std::atan2(n.cross(m).norm(), n.dot(m)), m.dot(outwards));
}

// Adds triangles and the angles between them. Returns the normal next to each side from one point
// to the next.
std::vector<Vec3> add_triangles(const std::vector<Vec3>& points,
                                const std::vector<std::array<int, 3>>& triangles,
                                SideIntegrals& sides) {
  std::vector<Vec3> beside(points.size(), Vec3::Zero());
  std::map<std::pair<int, int>, Vec3> normal_at;  // by directed edge
  for (const auto& t : triangles) {
    const Vec3 &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    sides.add_facet(a, b, c);
    const Vec3 n = (b - a).cross(c - a);
    if (!(n.norm() > 0)) continue;
    for (int k = 0; k < 3; ++k) normal_at[{t[k], t[(k + 1) % 3]}] = n.normalized();
  }
  for (const auto& [edge, n] : normal_at) {
    const auto [i, j] = edge;
    if (j == (i + 1) % isize(points)) beside[i] = n;
    const auto other = normal_at.find({j, i});
    if (i > j || other == normal_at.end()) continue;
    const Vec3 along = points[j] - points[i];
    sides.curvature += 0.5 * along.norm() * dihedral_angle(n, other->second, along.cross(n));
  }
  return beside;
}

FillingSketch sketch_of(const CurveNetwork& network, const NetworkRegion& region) {
  FillingSketch sketch;
  Box3 box;
  bool filled = !region.annulus;
  for (size_t l = 0; l < region.loops.size(); ++l) {
    const EdgeLoop& loop = region.loops[l];
    const std::vector<Vec3> points = polyline(network, loop);
    box.extend(bounding_box(points));
    const auto fill = filled ? triangulate_hole(points) : std::nullopt;
    filled = filled && fill;
    if (region.annulus) continue;
    std::vector<std::array<int, 3>> triangles;
    if (fill) triangles = fill->triangles;
    for (int i = 1; !fill && i + 1 < isize(points); ++i) triangles.push_back({0, i, i + 1});
    // A hole runs in the opposite direction, so its filling is subtracted.
    const auto beside = add_triangles(points, triangles, sketch.sides);
    if (l > 0) sketch.sides.area -= 2 * (fill ? fill->area : 0);
    if (fill) sketch.area += l == 0 ? fill->area : -fill->area;
    const auto per_edge = static_cast<std::ptrdiff_t>(points_per_edge(loop));
    for (size_t i = 0; fill && i < loop.size(); ++i) {
      const auto first = beside.begin() + static_cast<std::ptrdiff_t>(i) * per_edge;
      sketch.beside[loop[i].edge] = {loop[i], {first, first + per_edge}};
    }
  }
  if (!filled) sketch.area = 0;
  if (region.annulus) {
    const Strip strip = strip_between(network, region.loops[0], region.loops[1]);
    std::vector<Vec3> points = strip.first;
    points.insert(points.end(), strip.second.begin(), strip.second.end());
    const int n = isize(strip.first);
    std::vector<std::array<int, 3>> triangles;
    for (int i = 0; i < n; ++i) {
      const int next = (i + 1) % n;
      triangles.push_back({i, next, n + next});
      triangles.push_back({i, n + next, n + i});
    }
    add_triangles(points, triangles, sketch.sides);
  }
  sketch.size = box.diagonal().norm();
  return sketch;
}

// Traverses connected regions, and finds which of them have to be reversed.
class ShellTraversal {
 public:
  ShellTraversal(const std::vector<NetworkRegion>& regions,
                 const std::vector<std::vector<EdgeUse>>& sides)
      : flipped(regions.size(), 0), regions_(regions), sides_(sides), seen_(regions.size(), 0) {}

  std::vector<char> flipped;  // by region: true if it has to be reversed

  bool seen(int region) const { return seen_[region] != 0; }

  // The shell of a region, and its patches.
  ModelShell from(int seed, std::vector<OrientedPatch>& patches) {
    ModelShell shell;
    shell.closed = true;
    std::vector<int> beyond{seed};  // regions of other patches, across non-manifold edges
    for (size_t k = 0; k < beyond.size(); ++k) {
      if (seen(beyond[k])) continue;
      OrientedPatch patch;
      reach(patch, beyond[k]);
      for (size_t q = 0; q < patch.regions.size(); ++q) {
        const int r = patch.regions[q];
        for (const EdgeLoop& loop : regions_[r].loops)
          for (const OrientedEdge& use : loop) cross(shell, patch, beyond, r, use);
      }
      std::sort(patch.regions.begin(), patch.regions.end());
      shell.orientable = shell.orientable && patch.orientable;
      shell.regions.insert(shell.regions.end(), patch.regions.begin(), patch.regions.end());
      patches.push_back(std::move(patch));
    }
    std::sort(shell.regions.begin(), shell.regions.end());
    return shell;
  }

 private:
  void reach(OrientedPatch& patch, int region) {
    seen_[region] = 1;
    patch.regions.push_back(region);
  }

  // Crosses a network edge of region r to the regions on the other side.
  void cross(ModelShell& shell, OrientedPatch& patch, std::vector<int>& beyond, int r,
             const OrientedEdge& use) {
    const auto& sides = sides_[use.edge];
    if (sides.size() == 1) shell.closed = false;
    if (sides.size() > 2) shell.orientable = false;
    if (sides.size() != 2) {
      patch.closed = false;
      for (const EdgeUse& other : sides)
        if (!seen(other.region)) beyond.push_back(other.region);
      return;
    }
    if (sides[0].region == r && sides[1].region == r) {
      if (sides[0].reversed == sides[1].reversed) patch.orientable = false;
      return;
    }
    const EdgeUse& other = sides[0].region == r ? sides[1] : sides[0];
    const auto o = static_cast<size_t>(other.region);
    const bool same = (use.reversed != static_cast<bool>(flipped[r])) ==
                      (other.reversed != static_cast<bool>(flipped[o]));
    if (!seen(other.region)) {
      flipped[o] = same;
      reach(patch, other.region);
    } else if (same) {
      patch.orientable = false;
    }
  }

  const std::vector<NetworkRegion>& regions_;
  const std::vector<std::vector<EdgeUse>>& sides_;
  std::vector<char> seen_;
};

// Integrals over a patch from the rough geometry of its regions, including the creases between
// them.
SideIntegrals rough_integrals(const CurveNetwork& network, const OrientedPatch& patch,
                              const std::vector<FillingSketch>& sketches,
                              const std::vector<char>& flipped) {
  SideIntegrals sum;
  std::map<int, int> first;  // for each edge, the region that was met first
  for (const int r : patch.regions) {
    sum.add(sketches[r].sides, flipped[r] != 0);
    for (const auto& [edge, mine] : sketches[r].beside) {
      const auto [at, is_first] = first.try_emplace(edge, r);
      if (is_first) continue;
      const auto& theirs = sketches[at->second].beside.at(edge);
      const auto normal = [](const auto& beside, bool reversed_loop, double f) {
        const auto n = static_cast<double>(beside.second.size());
        const double along = beside.first.reversed ? 1 - f : f;
        const Vec3& found = beside.second[static_cast<size_t>(std::min(along * n, n - 1))];
        return Vec3(reversed_loop ? -found : found);
      };
      const HermiteCurve& curve = network.edges()[edge].curve;
      constexpr int kSamples = 8;
      for (int k = 0; k < kSamples; ++k) {
        const double f = (k + 0.5) / kSamples;
        const Vec3 along = curve.evaluate(curve.end() * (k + 1) / kSamples) -
                           curve.evaluate(curve.end() * k / kSamples);
        const Vec3 n = normal(mine, flipped[r] != 0, f),
                   m = normal(theirs, flipped[at->second] != 0, f);
        // The region `mine` lies to the left of the edge if its loop runs along the edge.
        const double left = mine.first.reversed == (flipped[r] != 0) ? 1 : -1;
        sum.curvature += 0.5 * along.norm() * dihedral_angle(n, m, left * along.cross(n));
      }
    }
  }
  return sum;
}

// Uses of each network edge by the loops of all regions.
std::vector<std::vector<EdgeUse>> sides_of(const std::vector<NetworkRegion>& regions,
                                           size_t edges) {
  std::vector<std::vector<EdgeUse>> sides(edges);
  for (int r = 0; r < isize(regions); ++r)
    for (const EdgeLoop& loop : regions[r].loops)
      for (const OrientedEdge& use : loop) sides[use.edge].push_back({r, use.reversed});
  return sides;
}

}  // namespace

void flip_region(int region, NetworkRegion& plan, Orientation& orientation) {
  for (EdgeLoop& loop : plan.loops) {
    loop = reversed_loop(loop);
    for (const OrientedEdge& use : loop)
      for (EdgeUse& side : orientation.sides[use.edge])
        if (side.region == region) side.reversed = use.reversed;
  }
}

Orientation orient(const CurveNetwork& network, std::vector<NetworkRegion>& regions) {
  const int n = isize(regions);
  for (NetworkRegion& region : regions) orient_loops(network, region);
  std::vector<FillingSketch> sketches(static_cast<size_t>(n));
  parallel_for(n, [&](int r) {
    const auto i = static_cast<size_t>(r);
    sketches[i] = sketch_of(network, regions[i]);
  });
  Orientation result;
  result.sides = sides_of(regions, network.edges().size());
  for (const FillingSketch& sketch : sketches) {
    result.filling_areas.push_back(sketch.area);
    result.sizes.push_back(sketch.size);
  }
  ShellTraversal walk(regions, result.sides);
  for (int seed = 0; seed < n; ++seed)
    if (!walk.seen(seed)) result.shells.push_back(walk.from(seed, result.patches));
  for (const OrientedPatch& patch : result.patches)
    if (const SideIntegrals all = rough_integrals(network, patch, sketches, walk.flipped);
        !normal_side(all, patch.closed && patch.orientable).agrees)
      for (const int r : patch.regions) walk.flipped[r] ^= 1;
  for (int r = 0; r < n; ++r)
    if (walk.flipped[r]) flip_region(r, regions[r], result);
  return result;
}

}  // namespace batten
