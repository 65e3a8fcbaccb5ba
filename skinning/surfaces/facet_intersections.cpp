// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/surface_defects.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "batten/core/box_tree.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

using Facet = std::array<int, 3>;
using Corners = std::array<Vec3, 3>;

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double s = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
  return (a + s * d - p).norm();
}

// Appends to `found` the points at which edges of `x` pierce the interior of `y`.
void pierce(const Corners& x, const Corners& y, std::vector<Vec3>& found) {
  const Vec3 e1 = y[1] - y[0], e2 = y[2] - y[0], n = e1.cross(e2);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0)) return;
  constexpr double kMargin = 1e-9;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = x[i], &q = x[(i + 1) % 3];
    const double dp = n.dot(p - y[0]), dq = n.dot(q - y[0]);
    const double least = kMargin * std::sqrt(n2) * (q - p).norm();
    if (!((dp > least && dq < -least) || (dp < -least && dq > least))) continue;
    const Vec3 at = p + dp / (dp - dq) * (q - p), d = at - y[0];
    const double u = n.dot(d.cross(e2)) / n2, v = n.dot(e1.cross(d)) / n2;
    if (u > kMargin && v > kMargin && u + v < 1 - kMargin) found.push_back(at);
  }
}

// Overlap of two coplanar facets: a corner of one inside the other, or edges that cross.
void overlap(const Corners& x, const Corners& y, std::vector<Vec3>& found) {
  const Vec3 n = (y[1] - y[0]).cross(y[2] - y[0]), m = (x[1] - x[0]).cross(x[2] - x[0]);
  const double size = std::max(
      {(y[1] - y[0]).norm(), (y[2] - y[0]).norm(), (x[1] - x[0]).norm(), (x[2] - x[0]).norm()});
  constexpr double kSamePlane = 1e-7, kMargin = 1e-6;
  if (!(n.norm() > 0) || !(m.norm() > 0)) return;
  for (const Vec3& p : x)
    if (std::abs(n.dot(p - y[0])) > kSamePlane * size * n.norm()) return;
  const Vec3 e = (y[1] - y[0]).normalized(), f = n.normalized().cross(e);
  const auto flat = [&](const Vec3& p) { return Vec2(e.dot(p - y[0]), f.dot(p - y[0])); };
  std::array<Vec2, 3> a, b;
  for (int i = 0; i < 3; ++i) a[i] = flat(x[i]), b[i] = flat(y[i]);
  if (cross(a[1] - a[0], a[2] - a[0]) < 0) std::swap(a[1], a[2]);
  const auto inside = [&](const std::array<Vec2, 3>& t, const Vec2& p) {
    for (int i = 0; i < 3; ++i)
      if (!(cross(t[(i + 1) % 3] - t[i], p - t[i]) > kMargin * size * size)) return false;
    return true;
  };
  // With a small margin, so that collinear edges do not count as overlap.
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
      if (std::abs(det) < kMargin * size * size) continue;
      const double s = cross(q - p, g) / det, t = cross(q - p, d) / det;
      constexpr double kInset = 1e-3;
      if (s > kInset && s < 1 - kInset && t > kInset && t < 1 - kInset) return put(p + s * d);
    }
}

bool have_common_point(const Facet& a, const Facet& b) {
  for (const int v : a)
    for (const int w : b)
      if (v == w) return true;
  return false;
}

// Stores in `found` the points at which two facets intersect.
void cross_pair(const Corners& a, const Corners& b, std::vector<Vec3>& found) {
  found.clear();
  pierce(a, b, found);
  pierce(b, a, found);
  if (found.empty()) overlap(a, b, found);
}

// Two intersecting facets and their common points.
struct IntersectingPair {
  int a, b;
  std::vector<Vec3> found;
};

// All pairs of facets that intersect, ascending. `joined`: the facets with merged points; facets
// with a common point are not tested.
std::vector<IntersectingPair> intersecting_pairs(const std::vector<Vec3>& points,
                                                 const std::vector<Facet>& facets,
                                                 const std::vector<Facet>& joined) {
  const auto corners = [&](int f) -> Corners {
    return {points[facets[f][0]], points[facets[f][1]], points[facets[f][2]]};
  };
  // Facets with a point that is not finite, and facets without extent, intersect nothing: their
  // boxes stay empty.
  std::vector<Box3> boxes(facets.size());
  for (int f = 0; f < isize(facets); ++f) {
    const Corners c = corners(f);
    const Box3 box = bounding_box(c);
    if ((c[0] + c[1] + c[2]).allFinite() && box.sizes().maxCoeff() > 0) boxes[f] = box;
  }
  const BoxTree<3> tree(boxes);
  constexpr int kFacetsOfPart = 256;
  const auto parts = tree.pair_parts(0, kFacetsOfPart);
  std::vector<std::vector<IntersectingPair>> of_parts(parts.size());
  parallel_for(isize(parts), [&](int part) {
    std::vector<Vec3> found;
    tree.for_each_near_pair(parts[part], 0, [&](int a, int b) {
      if (have_common_point(joined[a], joined[b])) return;
      cross_pair(corners(a), corners(b), found);
      if (!found.empty()) of_parts[part].push_back({a, b, found});
    });
  });
  std::vector<IntersectingPair> all;
  for (auto& part : of_parts)
    all.insert(all.end(), std::make_move_iterator(part.begin()),
               std::make_move_iterator(part.end()));
  std::sort(all.begin(), all.end(), [](const IntersectingPair& x, const IntersectingPair& y) {
    return std::tie(x.a, x.b) < std::tie(y.a, y.b);
  });
  return all;
}

// Boundary sides of each facet, and the points at their ends.
struct FreeEdges {
  const std::vector<Vec3>& points;
  const std::vector<Facet>&facets, &joined;
  std::vector<char> at_boundary;
  std::vector<std::array<char, 3>> is_free;

  FreeEdges(const std::vector<Vec3>& points, const std::vector<Facet>& facets,
            const std::vector<Facet>& joined, const std::vector<int>& surface_of)
      : points(points),
        facets(facets),
        joined(joined),
        at_boundary(points.size(), 0),
        is_free(joined.size()) {
    for (const auto& [f, i] : boundary_sides(joined, surface_of)) {
      is_free[f][i] = 1;
      at_boundary[joined[f][i]] = at_boundary[joined[f][(i + 1) % 3]] = 1;
    }
  }

  // True if a point lies within `near` of a boundary side of the facet, or of a boundary point.
  bool close_to(int f, const Vec3& p, double near) const {
    for (int i = 0; i < 3; ++i) {
      const Vec3 &a = points[facets[f][i]], &b = points[facets[f][(i + 1) % 3]];
      if (is_free[f][i] && distance_to_segment(p, a, b) <= near) return true;
      if (at_boundary[joined[f][i]] && (p - a).norm() <= near) return true;
    }
    return false;
  }
};

}  // namespace

std::vector<std::pair<int, int>> boundary_sides(const std::vector<Facet>& facets,
                                                const std::vector<int>& surface_of) {
  std::vector<std::array<int, 5>> sides;  // point indices, surface, facet, side
  for (int f = 0; f < isize(facets); ++f)
    for (int i = 0; i < 3; ++i) {
      const auto [v, w] = std::minmax(facets[f][i], facets[f][(i + 1) % 3]);
      sides.push_back({v, w, surface_of.empty() ? 0 : surface_of[f], f, i});
    }
  throw_if_cancelled();
  std::sort(sides.begin(), sides.end());
  const auto same = [&](size_t i, size_t j) {
    return std::equal(sides[i].begin(), sides[i].begin() + 3, sides[j].begin());
  };
  std::vector<std::pair<int, int>> free;
  for (size_t i = 0; i < sides.size(); ++i)
    if ((i == 0 || !same(i - 1, i)) && (i + 1 == sides.size() || !same(i, i + 1)))
      free.emplace_back(sides[i][3], sides[i][4]);
  std::sort(free.begin(), free.end());
  return free;
}

std::vector<FacetIntersection> facet_intersections(const std::vector<Vec3>& points,
                                                   const std::vector<std::array<int, 3>>& facets,
                                                   const std::vector<std::array<int, 3>>& joined,
                                                   const std::vector<int>& surface_of,
                                                   double near) {
  const std::vector<IntersectingPair> passing = intersecting_pairs(points, facets, joined);
  if (passing.empty()) return {};
  const FreeEdges free_edges(points, facets, joined, surface_of);
  std::vector<FacetIntersection> result;
  for (const IntersectingPair& pair : passing) {
    const bool touching = std::all_of(pair.found.begin(), pair.found.end(), [&](const Vec3& p) {
      return free_edges.close_to(pair.a, p, near) && free_edges.close_to(pair.b, p, near);
    });
    if (!touching) result.push_back({pair.a, pair.b, pair.found[0]});
  }
  return result;
}

}  // namespace batten
