// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/corner_normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "batten/core/containers.h"

namespace batten {
namespace {

using Triangle = std::array<int, 3>;

/// Union-find over triangle corners, numbered 3 t + k. Each class gets one normal.
class Corners {
 public:
  explicit Corners(size_t triangles) : parent_(3 * triangles) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int first(int corner) {
    while (parent_[corner] != corner) corner = parent_[corner] = parent_[parent_[corner]];
    return corner;
  }
  void join(int a, int b) {
    a = first(a);
    b = first(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

Vec3 point(const Points& points, int node) { return points.row(node).transpose(); }

Vec3 unit_normal(const Points& points, const Triangle& t) {
  const Vec3 a = point(points, t[0]);
  const Vec3 n = (point(points, t[1]) - a).cross(point(points, t[2]) - a);
  return n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero());
}

double angle_at(const Points& points, const Triangle& t, int k) {
  const Vec3 p = point(points, t[k]), a = point(points, t[(k + 1) % 3]) - p,
             b = point(points, t[(k + 2) % 3]) - p;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Edge of a triangle from corner k to corner k + 1, with its two nodes in ascending order.
struct Side {
  int low, high, triangle, k;
};

void join_smooth(const std::vector<Triangle>& triangles, const std::vector<Vec3>& normals,
                 double cosine, Corners& corners) {
  std::vector<Side> sides;
  for (int t = 0; t < isize(triangles); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      sides.push_back({low, high, t, k});
    }
  const auto key = [](const Side& s) { return std::pair(s.low, s.high); };
  std::stable_sort(sides.begin(), sides.end(),
                   [&](const Side& a, const Side& b) { return key(a) < key(b); });
  for (size_t i = 0; i < sides.size();) {
    size_t end = i + 1;
    while (end < sides.size() && key(sides[end]) == key(sides[i])) ++end;
    if (end == i + 2) {
      const Side &a = sides[i], &b = sides[i + 1];
      // Two consistently oriented triangles traverse their shared edge in opposite directions.
      if (triangles[a.triangle][a.k] != triangles[b.triangle][b.k] &&
          normals[a.triangle].dot(normals[b.triangle]) > cosine) {
        corners.join(3 * a.triangle + a.k, 3 * b.triangle + (b.k + 1) % 3);
        corners.join(3 * a.triangle + (a.k + 1) % 3, 3 * b.triangle + b.k);
      }
    }
    i = end;
  }
}

}  // namespace

CornerNormals corner_normals(const Points& points, const std::vector<Triangle>& triangles,
                             double crease_deg) {
  std::vector<Vec3> flat;
  for (const Triangle& t : triangles) flat.push_back(unit_normal(points, t));
  Corners corners(triangles.size());
  join_smooth(triangles, flat, std::cos(crease_deg * std::numbers::pi / 180), corners);
  CornerNormals result;
  result.of.resize(triangles.size());
  std::vector<int> number(3 * triangles.size(), -1);
  for (int t = 0; t < isize(triangles); ++t)
    for (int k = 0; k < 3; ++k) {
      int& own = number[corners.first(3 * t + k)];
      if (own < 0) {
        own = isize(result.normals);
        result.normals.emplace_back(Vec3::Zero());
        result.nodes.push_back(triangles[t][k]);
      }
      result.of[t][k] = own;
      result.normals[own] += angle_at(points, triangles[t], k) * flat[t];
    }
  for (Vec3& n : result.normals) n = n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::UnitZ());
  return result;
}

}  // namespace batten
