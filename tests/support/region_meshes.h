// SPDX-License-Identifier: MPL-2.0
// Shapes for tests of feature regions and iterative deformers.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/tests/support/sample_meshes.h"

namespace batten_test {

template <class Inside>
std::vector<int> vertices_where(const TriangleMesh& mesh, const Inside& inside) {
  std::vector<int> found;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (inside(mesh.point(v))) found.push_back(v);
  return found;
}

inline std::vector<int> disc_of(const TriangleMesh& mesh, double x, double y, double radius) {
  return vertices_where(mesh,
                        [&](const Vec3& p) { return std::hypot(p.x() - x, p.y() - y) < radius; });
}

/// A flat sheet over [0, 4]² with a square boss in the middle: top over |x - 2|, |y - 2| ≤ 0.4,
/// walls out to 0.5. Vertices are on its edges if n is divisible by 40. Fixed: x ≤ 0.4; handle: x ≥
/// 3.6.
struct BossPanel {
  TriangleMesh mesh;
  std::vector<int> fixed, boss, ring;  // ring: sheet around the boss
  std::vector<Handle> handles;

  explicit BossPanel(int n, double height = 0.2)
      : mesh([&] {
          const TriangleMesh flat = sheet(n, 0, 0);
          Points p = flat.points();
          for (int v = 0; v < flat.vertex_count(); ++v) {
            const double off = std::max(std::abs(p(v, 0) - 2), std::abs(p(v, 1) - 2));
            p(v, 2) = height * std::clamp((0.5 - off) / 0.1, 0.0, 1.0);
          }
          return flat.with_points(p);
        }()) {
    const auto off = [](const Vec3& p) {
      return std::max(std::abs(p.x() - 2), std::abs(p.y() - 2));
    };
    fixed = vertices_where(mesh, [](const Vec3& p) { return p.x() < 0.4 + 1e-9; });
    handles = {{"patch", vertices_where(mesh, [](const Vec3& p) { return p.x() > 3.6 - 1e-9; })}};
    boss = vertices_where(mesh, [&](const Vec3& p) { return off(p) < 0.5 + 1e-9; });
    ring = vertices_where(
        mesh, [&](const Vec3& p) { return off(p) > 0.5 + 1e-9 && off(p) < 0.8 + 1e-9; });
  }
  std::vector<HandleTransform> lift(double height) const {
    HandleTransform move;
    move.translation = {0, 0, height};
    return {move};
  }
};

/// Surface of a box [0, length] × [-½, ½]², `across` squares along its width. Fixed: the end at 0;
/// handle: the other one.
struct Bar {
  TriangleMesh mesh;
  std::vector<int> fixed;
  std::vector<Handle> handles;

  Bar(double length, int across) : mesh(surface(length, across)) {
    fixed = vertices_where(mesh, [](const Vec3& p) { return p.x() < 1e-9; });
    handles = {{"end", vertices_where(mesh, [&](const Vec3& p) { return p.x() > length - 1e-9; })}};
  }
  static TriangleMesh surface(double length, int across) {
    const int along = static_cast<int>(std::lround(length * across));
    std::vector<Vec3> points;
    std::map<std::tuple<int, int, int>, int> number;
    const auto at = [&](int i, int j, int k) {
      const auto [it, is_new] =
          number.emplace(std::tuple(i, j, k), static_cast<int>(points.size()));
      if (is_new) points.emplace_back(i, j - across / 2.0, k - across / 2.0);
      return it->second;
    };
    std::vector<std::array<int, 3>> triangles;
    const auto quad = [&](int a, int b, int c, int d, bool turned) {
      if (turned)
        triangles.insert(triangles.end(), {{a, b, d}, {b, c, d}});
      else
        triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
    };
    const int m = across;
    for (int i = 0; i < along; ++i)
      for (int j = 0; j < m; ++j) {
        const bool turned = (i + j) % 2 != 0;
        quad(at(i, j, m), at(i + 1, j, m), at(i + 1, j + 1, m), at(i, j + 1, m), turned);
        quad(at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0), at(i, j, 0), turned);
        quad(at(i, 0, j), at(i + 1, 0, j), at(i + 1, 0, j + 1), at(i, 0, j + 1), turned);
        quad(at(i, m, j + 1), at(i + 1, m, j + 1), at(i + 1, m, j), at(i, m, j), turned);
      }
    for (int j = 0; j < m; ++j)
      for (int k = 0; k < m; ++k) {
        quad(at(0, j, k + 1), at(0, j + 1, k + 1), at(0, j + 1, k), at(0, j, k), (j + k) % 2 != 0);
        quad(at(along, j, k), at(along, j + 1, k), at(along, j + 1, k + 1), at(along, j, k + 1),
             (j + k) % 2 != 0);
      }
    Points p(static_cast<long>(points.size()), 3);
    for (size_t v = 0; v < points.size(); ++v)
      p.row(static_cast<long>(v)) = points[v].transpose() / across;
    return {p, triangles};
  }
  /// The end rotated about the bar's axis.
  static std::vector<HandleTransform> twist(double degrees) {
    HandleTransform move;
    move.rotation_vector = {degrees * std::numbers::pi / 180, 0, 0};
    return {move};
  }
};

/// Tilt of a set of vertices in degrees: angle between the rotated original normal and the normal
/// of the best-fit plane.
inline double tilt_degrees(const Points& points, const std::vector<int>& vertices) {
  Vec3 mean = Vec3::Zero();
  for (const int v : vertices) mean += points.row(v).transpose();
  mean /= static_cast<double>(vertices.size());
  Mat3 spread = Mat3::Zero();
  for (const int v : vertices) {
    const Vec3 u = points.row(v).transpose() - mean;
    spread += u * u.transpose();
  }
  const Vec3 n = symmetric_eigen(Mat3(spread)).vectors.col(0);
  return std::atan2(std::hypot(n.x(), n.y()), std::abs(n.z())) * 180 / std::numbers::pi;
}

/// Largest and mean relative change of the lengths of edges with both ends in `inside` (flags).
struct EdgeChange {
  double most = 0, mean = 0;
};
inline EdgeChange edge_change(const TriangleMesh& mesh, const Points& after,
                              const std::vector<char>& inside) {
  EdgeChange change;
  int count = 0;
  for (const auto& e : mesh.topology().edges()) {
    if (!inside[e.low] || !inside[e.high]) continue;
    const double before = (mesh.point(e.low) - mesh.point(e.high)).norm();
    const double c = std::abs((after.row(e.low) - after.row(e.high)).norm() / before - 1);
    change.most = std::max(change.most, c);
    change.mean += c;
    ++count;
  }
  change.mean /= std::max(1, count);
  return change;
}

/// The same for the angles of triangles, in degrees.
inline EdgeChange angle_change(const TriangleMesh& mesh, const Points& after,
                               const std::vector<char>& inside) {
  const auto angle = [](const Points& p, int a, int b, int c) {
    const Vec3 u = (p.row(b) - p.row(a)).transpose(), v = (p.row(c) - p.row(a)).transpose();
    return std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / std::numbers::pi;
  };
  EdgeChange change;
  int count = 0;
  for (const auto& t : mesh.triangles()) {
    if (!inside[t[0]] || !inside[t[1]] || !inside[t[2]]) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const double d = std::abs(angle(after, a, b, c) - angle(mesh.points(), a, b, c));
      change.most = std::max(change.most, d);
      change.mean += d;
      ++count;
    }
  }
  change.mean /= std::max(1, count);
  return change;
}

}  // namespace batten_test
