#include "batten/skinning/surfaces/orientation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/box.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/skinning/domains/plain_fill.h"
#include "batten/skinning/domains/ring.h"
#include "batten/skinning/surfaces/normal_side.h"

namespace batten {
namespace {

ArcLoop turned(const ArcLoop& loop) {
  ArcLoop back(loop.rbegin(), loop.rend());
  for (ArcUse& use : back) use.reversed = !use.reversed;
  return back;
}

// Points of each arc in polyline().
int points_per_arc(const ArcLoop& loop) {
  constexpr int most_points = 96;
  return std::clamp(most_points / count_of(loop), 2, 12);
}

// Points along a loop, as many of each arc.
std::vector<Vec3> polyline(const CharacterLineNetwork& network, const ArcLoop& loop) {
  const int per_arc = points_per_arc(loop);
  std::vector<Vec3> points;
  for (const ArcUse& use : loop) {
    const HermiteCurve& curve = network.arcs()[use.arc].curve;
    for (int i = 0; i < per_arc; ++i) {
      const double f = static_cast<double>(i) / per_arc;
      points.push_back(curve.evaluate(curve.end() * (use.reversed ? 1 - f : f)));
    }
  }
  return points;
}

// `count` points around a loop, evenly by arc length.
std::vector<Vec3> even_points(const CharacterLineNetwork& network, const ArcLoop& loop, int count) {
  double length = 0, begin = 0;
  for (const ArcUse& use : loop) length += network.arcs()[use.arc].length;
  std::vector<Vec3> points;
  for (const ArcUse& use : loop) {
    const NetworkArc& arc = network.arcs()[use.arc];
    for (;;) {
      const double along = length * static_cast<double>(points.size()) / count - begin;
      if (along >= arc.length || count_of(points) == count) break;
      // Arcs run at even speed.
      const double f = std::max(0.0, along) / arc.length;
      points.push_back(arc.curve.evaluate(arc.curve.end() * (use.reversed ? 1 - f : f)));
    }
    begin += arc.length;
  }
  return points;
}

// The strip between two rims: points of the second one beside those of the first, least apart.
struct Strip {
  std::vector<Vec3> first, second;
  bool along = true;  ///< the second rim runs as the first one does
};
Strip strip_between(const CharacterLineNetwork& network, const ArcLoop& a, const ArcLoop& b) {
  constexpr int count = 64;
  Strip strip{even_points(network, a, count), {}, true};
  const std::vector<Vec3> other = even_points(network, b, count);
  strip.along = rims_run_alike(strip.first, other);
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

// Loops of one region so that they run around it: rims against each other, holes against the
// outline.
void run_around(const CharacterLineNetwork& network, NetworkRegion& region) {
  const auto vector = [&](const ArcLoop& loop) {
    const std::vector<Vec3> points = polyline(network, loop);
    Vec3 sum = Vec3::Zero();
    for (size_t i = 0; i < points.size(); ++i)
      sum += (points[i] - points[0]).cross(points[(i + 1) % points.size()] - points[0]);
    return sum;
  };
  for (size_t l = 1; l < region.loops.size(); ++l) {
    const bool same = region.ring ? strip_between(network, region.loops[0], region.loops[l]).along
                                  : vector(region.loops[0]).dot(vector(region.loops[l])) > 0;
    if (same) region.loops[l] = turned(region.loops[l]);
  }
}

// What one region looks like from far: by plain fillings.
struct Sketch {
  double area = 0, size = 0;
  SideIntegrals sides;
  // Normals of the facets along the arcs of its loops: one for each interval between points, in the
  // direction of the loop.
  std::map<int, std::pair<ArcUse, std::vector<Vec3>>> beside;
};

double turn_between(const Vec3& n, const Vec3& m, const Vec3& outwards) {
  return std::copysign(std::atan2(n.cross(m).norm(), n.dot(m)), m.dot(outwards));
}

// Adds triangles and the angles between them. Returns the normal beside each edge between one point
// and the next one.
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
    if (j == (i + 1) % count_of(points)) beside[i] = n;
    const auto other = normal_at.find({j, i});
    if (i > j || other == normal_at.end()) continue;
    const Vec3 along = points[j] - points[i];
    sides.curvature += 0.5 * along.norm() * turn_between(n, other->second, along.cross(n));
  }
  return beside;
}

Sketch sketch_of(const CharacterLineNetwork& network, const NetworkRegion& region) {
  Sketch sketch;
  Box3 box;
  bool filled = !region.ring;
  for (size_t l = 0; l < region.loops.size(); ++l) {
    const ArcLoop& loop = region.loops[l];
    const std::vector<Vec3> points = polyline(network, loop);
    box.extend(box_around(points));
    const auto fill = filled ? plain_fill(points) : std::nullopt;
    filled = filled && fill;
    if (region.ring) continue;
    std::vector<std::array<int, 3>> triangles;
    if (fill) triangles = fill->triangles;
    for (int i = 1; !fill && i + 1 < count_of(points); ++i) triangles.push_back({0, i, i + 1});
    // A hole runs the other way around: what fills it is taken away.
    const auto beside = add_triangles(points, triangles, sketch.sides);
    if (l > 0) sketch.sides.area -= 2 * (fill ? fill->area : 0);
    if (fill) sketch.area += l == 0 ? fill->area : -fill->area;
    const auto per_arc = static_cast<std::ptrdiff_t>(points_per_arc(loop));
    for (size_t i = 0; fill && i < loop.size(); ++i) {
      const auto first = beside.begin() + static_cast<std::ptrdiff_t>(i) * per_arc;
      sketch.beside[loop[i].arc] = {loop[i], {first, first + per_arc}};
    }
  }
  if (!filled) sketch.area = 0;
  if (region.ring) {
    const Strip strip = strip_between(network, region.loops[0], region.loops[1]);
    std::vector<Vec3> points = strip.first;
    points.insert(points.end(), strip.second.begin(), strip.second.end());
    const int n = count_of(strip.first);
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

// The regions that hang together with one, and which of them have to be turned over.
class ShellWalk {
 public:
  ShellWalk(const std::vector<NetworkRegion>& regions,
            const std::vector<std::vector<ArcSide>>& sides)
      : turn(regions.size(), 0), regions_(regions), sides_(sides), seen_(regions.size(), 0) {}

  std::vector<char> turn;  // whether each region has to be turned over

  bool seen(int region) const { return seen_[region] != 0; }

  // The shell of a region, and its sheets.
  ModelShell from(int seed, std::vector<OrientedSheet>& sheets) {
    ModelShell shell;
    shell.closed = true;
    std::vector<int> beyond{seed};  // other sheets, where arcs have more than two uses
    for (size_t k = 0; k < beyond.size(); ++k) {
      if (seen(beyond[k])) continue;
      OrientedSheet sheet;
      reach(sheet, beyond[k]);
      for (size_t q = 0; q < sheet.regions.size(); ++q) {
        const int r = sheet.regions[q];
        for (const ArcLoop& loop : regions_[r].loops)
          for (const ArcUse& use : loop) cross(shell, sheet, beyond, r, use);
      }
      std::sort(sheet.regions.begin(), sheet.regions.end());
      shell.orientable = shell.orientable && sheet.orientable;
      shell.regions.insert(shell.regions.end(), sheet.regions.begin(), sheet.regions.end());
      sheets.push_back(std::move(sheet));
    }
    std::sort(shell.regions.begin(), shell.regions.end());
    return shell;
  }

 private:
  void reach(OrientedSheet& sheet, int region) {
    seen_[region] = 1;
    sheet.regions.push_back(region);
  }

  // What lies across an arc of region r.
  void cross(ModelShell& shell, OrientedSheet& sheet, std::vector<int>& beyond, int r,
             const ArcUse& use) {
    const auto& sides = sides_[use.arc];
    if (sides.size() == 1) shell.closed = false;
    if (sides.size() > 2) shell.orientable = false;
    if (sides.size() != 2) {
      sheet.closed = false;
      for (const ArcSide& other : sides)
        if (!seen(other.region)) beyond.push_back(other.region);
      return;
    }
    if (sides[0].region == r && sides[1].region == r) {
      if (sides[0].reversed == sides[1].reversed) sheet.orientable = false;
      return;
    }
    const ArcSide& other = sides[0].region == r ? sides[1] : sides[0];
    const auto o = static_cast<size_t>(other.region);
    const bool same = (use.reversed != static_cast<bool>(turn[r])) ==
                      (other.reversed != static_cast<bool>(turn[o]));
    if (!seen(other.region)) {
      turn[o] = same;
      reach(sheet, other.region);
    } else if (same) {
      sheet.orientable = false;
    }
  }

  const std::vector<NetworkRegion>& regions_;
  const std::vector<std::vector<ArcSide>>& sides_;
  std::vector<char> seen_;
};

// What is known of a sheet by the sketches of its regions, with the creases between them.
SideIntegrals rough_integrals(const CharacterLineNetwork& network, const OrientedSheet& sheet,
                              const std::vector<Sketch>& sketches, const std::vector<char>& turn) {
  SideIntegrals sum;
  std::map<int, int> first;  // of each arc: the region that was met first
  for (const int r : sheet.regions) {
    sum.add(sketches[r].sides, turn[r] != 0);
    for (const auto& [arc, mine] : sketches[r].beside) {
      const auto [at, is_first] = first.try_emplace(arc, r);
      if (is_first) continue;
      const auto& theirs = sketches[at->second].beside.at(arc);
      const auto normal = [](const auto& beside, bool turned, double f) {
        const auto n = static_cast<double>(beside.second.size());
        const double along = beside.first.reversed ? 1 - f : f;
        const Vec3& found = beside.second[static_cast<size_t>(std::min(along * n, n - 1))];
        return Vec3(turned ? -found : found);
      };
      const HermiteCurve& curve = network.arcs()[arc].curve;
      constexpr int pieces = 8;
      for (int k = 0; k < pieces; ++k) {
        const double f = (k + 0.5) / pieces;
        const Vec3 along = curve.evaluate(curve.end() * (k + 1) / pieces) -
                           curve.evaluate(curve.end() * k / pieces);
        const Vec3 n = normal(mine, turn[r] != 0, f), m = normal(theirs, turn[at->second] != 0, f);
        // Mine lies to the left of the arc where its loop runs along it.
        const double left = mine.first.reversed == (turn[r] != 0) ? 1 : -1;
        sum.curvature += 0.5 * along.norm() * turn_between(n, m, left * along.cross(n));
      }
    }
  }
  return sum;
}

// The side of every loop on its arcs.
std::vector<std::vector<ArcSide>> sides_of(const std::vector<NetworkRegion>& regions, size_t arcs) {
  std::vector<std::vector<ArcSide>> sides(arcs);
  for (int r = 0; r < count_of(regions); ++r)
    for (const ArcLoop& loop : regions[r].loops)
      for (const ArcUse& use : loop) sides[use.arc].push_back({r, use.reversed});
  return sides;
}

}  // namespace

void turn_over(int region, NetworkRegion& plan, Orientation& orientation) {
  for (ArcLoop& loop : plan.loops) {
    loop = turned(loop);
    for (const ArcUse& use : loop)
      for (ArcSide& side : orientation.sides[use.arc])
        if (side.region == region) side.reversed = use.reversed;
  }
}

Orientation orient(const CharacterLineNetwork& network, std::vector<NetworkRegion>& regions) {
  const int n = count_of(regions);
  for (NetworkRegion& region : regions) run_around(network, region);
  std::vector<Sketch> sketches(static_cast<size_t>(n));
  parallel_parts(n, [&](int r) {
    const auto i = static_cast<size_t>(r);
    sketches[i] = sketch_of(network, regions[i]);
  });
  Orientation result;
  result.sides = sides_of(regions, network.arcs().size());
  for (const Sketch& sketch : sketches) {
    result.plain_areas.push_back(sketch.area);
    result.sizes.push_back(sketch.size);
  }
  ShellWalk walk(regions, result.sides);
  for (int seed = 0; seed < n; ++seed)
    if (!walk.seen(seed)) result.shells.push_back(walk.from(seed, result.sheets));
  for (const OrientedSheet& sheet : result.sheets)
    if (const SideIntegrals all = rough_integrals(network, sheet, sketches, walk.turn);
        !normal_side(all, sheet.closed && sheet.orientable).agrees)
      for (const int r : sheet.regions) walk.turn[r] ^= 1;
  for (int r = 0; r < n; ++r)
    if (walk.turn[r]) turn_over(r, regions[r], result);
  return result;
}

}  // namespace batten
