#include "batten/skinning/surfaces/orientation.h"

#include <algorithm>
#include <cmath>

#include "batten/core/box.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/skinning/domains/plain_fill.h"
#include "batten/skinning/domains/ring.h"

namespace batten {
namespace {

ArcLoop turned(const ArcLoop& loop) {
  ArcLoop back(loop.rbegin(), loop.rend());
  for (ArcUse& use : back) use.reversed = !use.reversed;
  return back;
}

// Points along a loop, as many of each arc.
std::vector<Vec3> polyline(const CharacterLineNetwork& network, const ArcLoop& loop) {
  constexpr int most_points = 96;
  const int per_arc = std::clamp(most_points / count_of(loop), 2, 12);
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
  double volume = 0;  ///< under it, seen from `about`
  Vec3 vector = Vec3::Zero();
};

Sketch sketch_of(const CharacterLineNetwork& network, const NetworkRegion& region,
                 const Vec3& about) {
  Sketch sketch;
  Box3 box;
  bool filled = !region.ring;
  for (size_t l = 0; l < region.loops.size(); ++l) {
    const std::vector<Vec3> points = polyline(network, region.loops[l]);
    box.extend(box_around(points));
    for (size_t i = 0; i < points.size(); ++i)
      sketch.vector += 0.5 * (points[i] - about).cross(points[(i + 1) % points.size()] - about);
    // A hole runs the other way around, so its filling counts negative by itself.
    const auto fill = filled ? plain_fill(points) : std::nullopt;
    filled = filled && fill;
    if (!fill) continue;
    sketch.area += l == 0 ? fill->area : -fill->area;
    for (const auto& t : fill->triangles)
      sketch.volume +=
          (points[t[0]] - about).dot((points[t[1]] - about).cross(points[t[2]] - about)) / 6;
  }
  if (!filled) sketch.area = 0;
  if (region.ring) {
    const Strip strip = strip_between(network, region.loops[0], region.loops[1]);
    const size_t n = strip.first.size();
    for (size_t i = 0; i < n; ++i) {
      const size_t next = (i + 1) % n;
      const Vec3 a = strip.first[i] - about, b = strip.first[next] - about,
                 c = strip.second[next] - about, d = strip.second[i] - about;
      sketch.volume += (a.dot(b.cross(c)) + a.dot(c.cross(d))) / 6;
    }
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

  ModelShell from(int seed) {
    ModelShell shell;
    shell.closed = true;
    reach(shell, seed);
    for (size_t q = 0; q < shell.regions.size(); ++q) {
      const int r = shell.regions[q];
      for (const ArcLoop& loop : regions_[r].loops)
        for (const ArcUse& use : loop) cross(shell, r, use);
    }
    std::sort(shell.regions.begin(), shell.regions.end());
    return shell;
  }

 private:
  void reach(ModelShell& shell, int region) {
    seen_[region] = 1;
    shell.regions.push_back(region);
  }

  // What lies across an arc of region r.
  void cross(ModelShell& shell, int r, const ArcUse& use) {
    const auto& sides = sides_[use.arc];
    if (sides.size() == 1) shell.closed = false;
    if (sides.size() > 2) shell.orientable = false;
    if (sides.size() != 2) {
      for (const ArcSide& other : sides)
        if (!seen(other.region)) reach(shell, other.region);
      return;
    }
    if (sides[0].region == r && sides[1].region == r) {
      if (sides[0].reversed == sides[1].reversed) shell.orientable = false;
      return;
    }
    const ArcSide& other = sides[0].region == r ? sides[1] : sides[0];
    const auto o = static_cast<size_t>(other.region);
    const bool same = (use.reversed != static_cast<bool>(turn[r])) ==
                      (other.reversed != static_cast<bool>(turn[o]));
    if (!seen(other.region)) {
      turn[o] = same;
      reach(shell, other.region);
    } else if (same) {
      shell.orientable = false;
    }
  }

  const std::vector<NetworkRegion>& regions_;
  const std::vector<std::vector<ArcSide>>& sides_;
  std::vector<char> seen_;
};

// Whether a shell shows its inside, or, where it has none, looks down.
bool inwards(const ModelShell& shell, const std::vector<Sketch>& sketches,
             const std::vector<char>& turn) {
  double volume = 0, area = 0;
  Vec3 up = Vec3::Zero();
  for (const int r : shell.regions) {
    const auto i = static_cast<size_t>(r);
    const double sign = turn[i] ? -1 : 1;
    volume += sign * sketches[i].volume;
    up += sign * sketches[i].vector;
    area += sketches[i].vector.norm();
  }
  double outwards = volume;
  if (!shell.closed || !shell.orientable) {
    constexpr double clear = 0.05;
    outwards = 0;
    for (const int axis : {2, 0, 1})
      if (outwards == 0 && std::abs(up[axis]) > clear * area) outwards = up[axis];
  }
  return outwards < 0;
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

Orientation orient(const CharacterLineNetwork& network, std::vector<NetworkRegion>& regions) {
  const int n = count_of(regions);
  Vec3 about = Vec3::Zero();
  for (const NetworkNode& node : network.nodes())
    about += node.position / static_cast<double>(network.nodes().size());
  for (NetworkRegion& region : regions) run_around(network, region);
  std::vector<Sketch> sketches(static_cast<size_t>(n));
  parallel_parts(n, [&](int r) {
    const auto i = static_cast<size_t>(r);
    sketches[i] = sketch_of(network, regions[i], about);
  });
  Orientation result;
  result.sides = sides_of(regions, network.arcs().size());
  for (const Sketch& sketch : sketches) {
    result.plain_areas.push_back(sketch.area);
    result.sizes.push_back(sketch.size);
  }
  ShellWalk walk(regions, result.sides);
  for (int seed = 0; seed < n; ++seed) {
    if (walk.seen(seed)) continue;
    ModelShell shell = walk.from(seed);
    if (inwards(shell, sketches, walk.turn))
      for (const int r : shell.regions) walk.turn[r] ^= 1;
    result.shells.push_back(std::move(shell));
  }
  for (int r = 0; r < n; ++r) {
    if (!walk.turn[r]) continue;
    for (ArcLoop& loop : regions[r].loops) loop = turned(loop);
    for (auto& sides : result.sides)
      for (ArcSide& side : sides)
        if (side.region == r) side.reversed = !side.reversed;
  }
  return result;
}

}  // namespace batten
