// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/domains/hole_triangulation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/op_counter.h"

#if BATTEN_HAVE_CGAL
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#endif

namespace batten {
namespace {

constexpr size_t kMaxPoints = 400;

void check(const std::vector<Vec3>& loop) {
  if (loop.size() < 3)
    throw InputError("hole triangulation: found a loop of " + std::to_string(loop.size()) +
                     " points, expected three or more");
  if (loop.size() > kMaxPoints)
    throw InputError("hole triangulation: found a loop of " + std::to_string(loop.size()) +
                     " points, expected at most " + std::to_string(kMaxPoints));
  for (const Vec3& p : loop)
    if (!p.allFinite()) throw InputError("hole triangulation: a point is not finite");
}

void measure(const std::vector<Vec3>& loop, HoleTriangulation& triangulation) {
  std::vector<Vec3> normals;
  // First triangle at each edge, keyed by the edge's vertices, lower first.
  std::map<std::pair<int, int>, size_t> across;
  for (size_t t = 0; t < triangulation.triangles.size(); ++t) {
    const auto& [a, b, c] = triangulation.triangles[t];
    const Vec3 twice = (loop[b] - loop[a]).cross(loop[c] - loop[a]);
    normals.push_back(twice);
    triangulation.area += 0.5 * twice.norm();
    triangulation.area_vector += 0.5 * twice;
  }
  for (size_t t = 0; t < triangulation.triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const std::pair edge =
          std::minmax({triangulation.triangles[t][i], triangulation.triangles[t][(i + 1) % 3]});
      const auto [it, first] = across.try_emplace(edge, t);
      if (first) continue;
      const Vec3 &m = normals[it->second], &n = normals[t];
      constexpr double degrees = 180 / 3.14159265358979323846;
      triangulation.max_dihedral_deg = std::max(triangulation.max_dihedral_deg,
                                                degrees * std::atan2(m.cross(n).norm(), m.dot(n)));
    }
}

}  // namespace

#if BATTEN_HAVE_CGAL

std::optional<HoleTriangulation> triangulate_hole(const std::vector<Vec3>& loop) {
  check(loop);
  count(OpCounter::HoleTriangulation);
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> points;
  for (const Vec3& p : loop) points.emplace_back(p.x(), p.y(), p.z());
  struct Triangle {
    Triangle(int a, int b, int c) : corners{a, b, c} {}
    std::array<int, 3> corners;
  };
  std::vector<Triangle> found;
  CGAL::Polygon_mesh_processing::triangulate_hole_polyline(points, std::back_inserter(found));
  if (found.size() + 2 != loop.size()) return std::nullopt;

  HoleTriangulation triangulation;
  for (const Triangle& t : found) triangulation.triangles.push_back(t.corners);
  // The triangles run either all along the loop or all against it.
  const int last = isize(loop) - 1;
  bool against = false;
  for (const auto& t : triangulation.triangles)
    for (int i = 0; i < 3; ++i)
      if (t[(i + 1) % 3] == last && t[i] == 0) against = true;
  for (auto& t : triangulation.triangles) {
    if (against) std::swap(t[1], t[2]);
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  }
  std::sort(triangulation.triangles.begin(), triangulation.triangles.end());
  measure(loop, triangulation);
  if (!(triangulation.area > 0)) return std::nullopt;
  return triangulation;
}

#else

std::optional<HoleTriangulation> triangulate_hole(const std::vector<Vec3>& loop) {
  check(loop);
  return std::nullopt;
}

#endif

namespace {

// Best triangulation of the sub-polygon that a chord cuts off: the points between its ends.
struct BestTriangulation {
  double cost = 0;  // of all triangles of the sub-polygon
  int apex = -1;  // third vertex of the triangle on the chord; -1: the chord is a side of the loop
  Vec3 normal = Vec3::Zero();
  double area = 0;
};

}  // namespace

std::optional<HoleTriangulation> developable_triangulation(const std::vector<Vec3>& loop) {
  check(loop);
  count(OpCounter::HoleTriangulation);
  constexpr double bending = 0.03, flat = 1e-6;
  const int n = isize(loop);
  const double stiffness = bending * bounding_box(loop).diagonal().squaredNorm();

  std::vector<BestTriangulation> parts(loop.size() * loop.size());
  const auto part = [&](int i, int j) -> BestTriangulation& {
    return parts[static_cast<size_t>(i) * loop.size() + static_cast<size_t>(j)];
  };
  for (int span = 2; span < n; ++span)
    for (int i = 0; i + span < n; ++i) {
      const int j = i + span;
      const Vec3 chord = loop[j] - loop[i];
      BestTriangulation best;
      best.cost = kInfinity;
      for (int k = i + 1; k < j; ++k) {
        const BestTriangulation &a = part(i, k), &b = part(k, j);
        double cost = a.cost + b.cost;
        if (!(cost < best.cost)) continue;
        const Vec3 ik = loop[k] - loop[i], kj = loop[j] - loop[k];
        Vec3 normal = ik.cross(kj);
        const double twice = normal.norm();
        const double ik2 = ik.squaredNorm(), kj2 = kj.squaredNorm();
        if (!(twice > flat * std::max({ik2, kj2, chord.squaredNorm()}))) continue;
        normal /= twice;
        cost += 0.5 * twice;
        if (a.apex >= 0)
          cost += stiffness * (1 - normal.dot(a.normal)) * ik2 / std::min(0.5 * twice, a.area);
        if (b.apex >= 0)
          cost += stiffness * (1 - normal.dot(b.normal)) * kj2 / std::min(0.5 * twice, b.area);
        if (cost < best.cost) best = {cost, k, normal, 0.5 * twice};
      }
      part(i, j) = best;
    }
  if (part(0, n - 1).apex < 0) return std::nullopt;

  HoleTriangulation triangulation;
  std::vector<std::pair<int, int>> chords{{0, n - 1}};
  while (!chords.empty()) {
    const auto [i, j] = chords.back();
    chords.pop_back();
    const int k = part(i, j).apex;
    if (k < 0) continue;
    triangulation.triangles.push_back({i, k, j});
    chords.emplace_back(i, k);
    chords.emplace_back(k, j);
  }
  std::sort(triangulation.triangles.begin(), triangulation.triangles.end());
  measure(loop, triangulation);
  return triangulation;
}

std::vector<TriangulationCorner> triangulation_corners(const std::vector<Vec3>& loop,
                                                       const HoleTriangulation& triangulation) {
  std::vector<TriangulationCorner> corners(loop.size());
  for (const auto& t : triangulation.triangles)
    for (int i = 0; i < 3; ++i) {
      TriangulationCorner& corner = corners[t[i]];
      const Vec3 a = loop[t[(i + 1) % 3]] - loop[t[i]], b = loop[t[(i + 2) % 3]] - loop[t[i]];
      const Vec3 twice = a.cross(b);
      corner.normal += 0.5 * twice;
      corner.angle += std::atan2(twice.norm(), a.dot(b));
    }
  return corners;
}

bool turns_left(const Vec3& before, const Vec3& after, const TriangulationCorner& corner) {
  constexpr double pi = 3.14159265358979323846, small = pi / 9;
  const Vec3 turning_vector = before.cross(after);
  if (std::atan2(turning_vector.norm(), before.dot(after)) > small) return corner.angle < pi;
  return turning_vector.dot(corner.normal) >= 0;
}

}  // namespace batten
