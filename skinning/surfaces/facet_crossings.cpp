#include "batten/skinning/surfaces/facet_crossings.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <tuple>

#include "batten/core/plane.h"

namespace batten {
namespace {

using Facet = std::array<int, 3>;
using Corners = std::array<Vec3, 3>;

struct Box {
  Vec3 low, high;
  explicit Box(const Corners& c)
      : low(c[0].cwiseMin(c[1]).cwiseMin(c[2])), high(c[0].cwiseMax(c[1]).cwiseMax(c[2])) {}
  bool meets(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double s = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
  return (a + s * d - p).norm();
}

// Points at which edges of `x` pierce the inside of `y`, added to `found`.
void pierce(const Corners& x, const Corners& y, std::vector<Vec3>& found) {
  const Vec3 e1 = y[1] - y[0], e2 = y[2] - y[0], n = e1.cross(e2);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0)) return;
  constexpr double margin = 1e-9;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = x[i], &q = x[(i + 1) % 3];
    const double dp = n.dot(p - y[0]), dq = n.dot(q - y[0]);
    const double least = margin * std::sqrt(n2) * (q - p).norm();
    if (!((dp > least && dq < -least) || (dp < -least && dq > least))) continue;
    const Vec3 at = p + dp / (dp - dq) * (q - p), d = at - y[0];
    const double u = n.dot(d.cross(e2)) / n2, v = n.dot(e1.cross(d)) / n2;
    if (u > margin && v > margin && u + v < 1 - margin) found.push_back(at);
  }
}

// Overlap of two facets in one plane: a corner of one inside of the other, or edges that cross.
void overlap(const Corners& x, const Corners& y, std::vector<Vec3>& found) {
  const Vec3 n = (y[1] - y[0]).cross(y[2] - y[0]), m = (x[1] - x[0]).cross(x[2] - x[0]);
  const double size = std::max(
      {(y[1] - y[0]).norm(), (y[2] - y[0]).norm(), (x[1] - x[0]).norm(), (x[2] - x[0]).norm()});
  constexpr double same_plane = 1e-7, margin = 1e-6;
  if (!(n.norm() > 0) || !(m.norm() > 0)) return;
  for (const Vec3& p : x)
    if (std::abs(n.dot(p - y[0])) > same_plane * size * n.norm()) return;
  const Vec3 e = (y[1] - y[0]).normalized(), f = n.normalized().cross(e);
  const auto flat = [&](const Vec3& p) { return Vec2(e.dot(p - y[0]), f.dot(p - y[0])); };
  std::array<Vec2, 3> a, b;
  for (int i = 0; i < 3; ++i) a[i] = flat(x[i]), b[i] = flat(y[i]);
  if (cross(a[1] - a[0], a[2] - a[0]) < 0) std::swap(a[1], a[2]);
  const auto inside = [&](const std::array<Vec2, 3>& t, const Vec2& p) {
    for (int i = 0; i < 3; ++i)
      if (!(cross(t[(i + 1) % 3] - t[i], p - t[i]) > margin * size * size)) return false;
    return true;
  };
  // Shrunk by a hair, so that edges along each other are no overlap.
  const auto middle = [](const std::array<Vec2, 3>& t) { return Vec2((t[0] + t[1] + t[2]) / 3); };
  const auto put = [&](const Vec2& p) { found.push_back(y[0] + p.x() * e + p.y() * f); };
  const Vec2 ma = middle(a), mb = middle(b);
  if (inside(b, ma)) return put(ma);
  if (inside(a, mb)) return put(mb);
  for (int i = 0; i < 3; ++i) {
    if (inside(b, a[i])) return put(a[i]);
    if (inside(a, b[i])) return put(b[i]);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Vec2 p = a[i], d = a[(i + 1) % 3] - p, q = b[j], g = b[(j + 1) % 3] - q;
      const double det = cross(d, g);
      if (std::abs(det) < margin * size * size) continue;
      const double s = cross(q - p, g) / det, t = cross(q - p, d) / det;
      constexpr double in = 1e-3;
      if (s > in && s < 1 - in && t > in && t < 1 - in) return put(p + s * d);
    }
}

// Facets by the cells of a grid that their boxes meet, sorted by cell.
struct Grid {
  struct Entry {
    std::uint64_t cell;
    int facet;
    bool operator<(const Entry& o) const {
      return std::tie(cell, facet) < std::tie(o.cell, o.facet);
    }
  };
  std::vector<Entry> entries;  // none where no facet has an extent
  Vec3 low;
  double side = 1;

  explicit Grid(const std::vector<Box>& boxes)
      : low(Vec3::Constant(std::numeric_limits<double>::infinity())) {
    double extent = 0, largest = 0;
    for (const Box& box : boxes) {
      low = low.cwiseMin(box.low);
      extent += (box.high - box.low).maxCoeff();
      largest = std::max(largest, (box.high - box.low).maxCoeff());
    }
    if (boxes.empty() || !(extent > 0)) return;
    constexpr double most_cells = 16;  // a side of the largest facet's box
    side = std::max(1.5 * extent / static_cast<double>(boxes.size()), largest / most_cells);
    for (size_t f = 0; f < boxes.size(); ++f) enter(boxes[f], static_cast<int>(f));
    std::sort(entries.begin(), entries.end());
  }

  void enter(const Box& box, int facet) {
    const auto a = cell(box.low), b = cell(box.high);
    for (std::uint64_t x = a[0]; x <= b[0]; ++x)
      for (std::uint64_t y = a[1]; y <= b[1]; ++y)
        for (std::uint64_t z = a[2]; z <= b[2]; ++z) entries.push_back({key(x, y, z), facet});
  }

  std::array<std::uint64_t, 3> cell(const Vec3& p) const {
    std::array<std::uint64_t, 3> at;
    for (int k = 0; k < 3; ++k)
      at[k] = static_cast<std::uint64_t>(std::clamp((p[k] - low[k]) / side, 0.0, 2097151.0));
    return at;
  }
  static std::uint64_t key(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
    return x << 42 | y << 21 | z;
  }
  // The one cell in which a pair is looked at: where both boxes begin.
  std::uint64_t home(const Box& a, const Box& b) const {
    const auto at = cell(a.low.cwiseMax(b.low));
    return key(at[0], at[1], at[2]);
  }
};

// Free edges of each facet, and the points at their ends.
struct FreeEdges {
  const std::vector<Corners>& corners;
  const std::vector<Facet>& joined;
  std::vector<char> at_rim;
  std::vector<std::array<char, 3>> is_free;

  FreeEdges(const std::vector<Corners>& corners, const std::vector<Facet>& joined,
            const std::vector<int>& surface_of, size_t points)
      : corners(corners), joined(joined), at_rim(points, 0), is_free(joined.size()) {
    const auto key = [&](size_t f, int i) {
      const auto [v, w] = std::minmax(joined[f][i], joined[f][(i + 1) % 3]);
      return std::tuple(v, w, surface_of[f]);
    };
    std::map<std::tuple<int, int, int>, int> uses_of_surface;
    for (size_t f = 0; f < joined.size(); ++f)
      for (int i = 0; i < 3; ++i) ++uses_of_surface[key(f, i)];
    for (size_t f = 0; f < joined.size(); ++f)
      for (int i = 0; i < 3; ++i) {
        is_free[f][i] = uses_of_surface[key(f, i)] == 1;
        if (is_free[f][i]) at_rim[joined[f][i]] = at_rim[joined[f][(i + 1) % 3]] = 1;
      }
  }

  // Whether a point lies within `near` of a free edge of the facet, or of the end of one.
  bool close_to(size_t f, const Vec3& p, double near) const {
    for (int i = 0; i < 3; ++i) {
      if (is_free[f][i] && distance_to_segment(p, corners[f][i], corners[f][(i + 1) % 3]) <= near)
        return true;
      if (at_rim[joined[f][i]] && (p - corners[f][i]).norm() <= near) return true;
    }
    return false;
  }
};

bool have_common_point(const Facet& a, const Facet& b) {
  for (const int v : a)
    for (const int w : b)
      if (v == w) return true;
  return false;
}

// Points in which two facets pass through each other, put into `found`.
void cross_pair(const Corners& a, const Corners& b, std::vector<Vec3>& found) {
  found.clear();
  pierce(a, b, found);
  pierce(b, a, found);
  if (found.empty()) overlap(a, b, found);
}

}  // namespace

std::vector<FacetCrossing> facet_crossings(const std::vector<Vec3>& points,
                                           const std::vector<std::array<int, 3>>& facets,
                                           const std::vector<std::array<int, 3>>& joined,
                                           const std::vector<int>& surface_of, double near) {
  std::vector<Corners> corners;
  std::vector<Box> boxes;
  for (const Facet& f : facets) {
    corners.push_back({points[f[0]], points[f[1]], points[f[2]]});
    boxes.emplace_back(corners.back());
  }
  const Grid grid(boxes);
  if (grid.entries.empty()) return {};
  const FreeEdges free_edges(corners, joined, surface_of, points.size());

  std::vector<FacetCrossing> result;
  std::vector<Vec3> found;
  const auto test = [&](std::uint64_t cell, size_t a, size_t b) {
    if (!boxes[a].meets(boxes[b]) || grid.home(boxes[a], boxes[b]) != cell) return;
    if (have_common_point(joined[a], joined[b])) return;
    cross_pair(corners[a], corners[b], found);
    const bool touching = std::all_of(found.begin(), found.end(), [&](const Vec3& p) {
      return free_edges.close_to(a, p, near) && free_edges.close_to(b, p, near);
    });
    if (!found.empty() && !touching)
      result.push_back({static_cast<int>(a), static_cast<int>(b), found[0]});
  };
  for (size_t begin = 0; begin < grid.entries.size();) {
    const std::uint64_t cell = grid.entries[begin].cell;
    size_t end = begin;
    while (end < grid.entries.size() && grid.entries[end].cell == cell) ++end;
    for (size_t i = begin; i < end; ++i)
      for (size_t j = i + 1; j < end; ++j)
        test(cell, static_cast<size_t>(grid.entries[i].facet),
             static_cast<size_t>(grid.entries[j].facet));
    begin = end;
  }
  std::sort(result.begin(), result.end(), [](const FacetCrossing& x, const FacetCrossing& y) {
    return std::tie(x.a, x.b) < std::tie(y.a, y.b);
  });
  return result;
}

}  // namespace batten
