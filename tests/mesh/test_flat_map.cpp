// SPDX-License-Identifier: MPL-2.0
// Flattened surfaces: no inverted triangles, and flat surfaces are unchanged.
#include "batten/mesh/pn_triangle_mesh.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

constexpr int kRings = 6, kAround = 24;

/// A cap of the unit sphere up to the colatitude `last`, in rings of triangles around its pole.
PnTriangleMesh cap(double last) {
  Points points(1 + kRings * kAround, 3);
  points.row(0) = Vec3::UnitZ();
  std::vector<std::array<int, 3>> triangles;
  const auto number = [](int ring, int i) { return 1 + (ring - 1) * kAround + i % kAround; };
  for (int ring = 1; ring <= kRings; ++ring)
    for (int i = 0; i < kAround; ++i) {
      const double down = last * ring / kRings, around = 2 * std::numbers::pi * i / kAround;
      points.row(number(ring, i)) << std::sin(down) * std::cos(around),
          std::sin(down) * std::sin(around), std::cos(down);
      if (ring == 1) {
        triangles.push_back({0, number(1, i), number(1, i + 1)});
        continue;
      }
      const int a = number(ring - 1, i), b = number(ring - 1, i + 1), c = number(ring, i),
                d = number(ring, i + 1);
      triangles.push_back({a, c, d});
      triangles.push_back({a, d, b});
    }
  std::vector<PnTriangle::Corners> normals;
  for (const auto& t : triangles)
    normals.push_back({points.row(t[0]).normalized(), points.row(t[1]).normalized(),
                       points.row(t[2]).normalized()});
  return PnTriangleMesh(TriangleMesh(points, triangles), normals);
}

/// From the circle around the z axis to the square of side 2: along the same ray.
Vec2 on_square(const Vec3& p) { return p.head<2>() / std::max(std::abs(p.x()), std::abs(p.y())); }

double twice_area(const HarmonicMap& map, const std::array<int, 3>& t) {
  const Vec2 u = map.parameter(t[1]) - map.parameter(t[0]),
             v = map.parameter(t[2]) - map.parameter(t[0]);
  return u.x() * v.y() - u.y() * v.x();
}

}  // namespace

TEST_CASE("No triangle of a deep cap inverts if its boundary is mapped to a square",
          "[mesh][flat_map]") {
  const PnTriangleMesh mesh = cap(2.6);  // most of the sphere: the rest is the smaller part
  const HarmonicMap map(mesh, on_square);
  double sum = 0;
  for (const auto& t : mesh.mesh().triangles()) {
    CHECK(twice_area(map, t) > 0);
    sum += twice_area(map, t) / 2;
  }
  CHECK(sum == Approx(4).epsilon(0.05));  // except the square's corners, which are not vertices
  for (int v = 0; v < mesh.mesh().vertex_count(); ++v)
    CHECK((map.surface_point(map.parameter(v)) - mesh.mesh().point(v)).norm() < 1e-12);
  // Between the vertices the surface is the sphere, not a chord.
  CHECK(std::abs(map.surface_point({0.31, 0.17}).norm() - 1) < 2e-3);
}

TEST_CASE("A planar piece is flattened by the affine map of its boundary", "[mesh][flat_map]") {
  constexpr int n = 6;
  Points points((n + 1) * (n + 1), 3);
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const int a = j * (n + 1) + i;
      points.row(a) << i + 0.3 * j, 0.8 * j, 0.1 * i;
      if (i == n || j == n) continue;
      triangles.push_back({a, a + 1, a + n + 2});
      triangles.push_back({a, a + n + 2, a + n + 1});
    }
  const PnTriangleMesh mesh(TriangleMesh(points, triangles));
  const auto wanted = [](const Vec3& p) { return Vec2(2 * p.x() + 1, p.y() - p.x()); };
  const HarmonicMap map(mesh, wanted);
  for (int v = 0; v < points.rows(); ++v)
    CHECK((map.parameter(v) - wanted(points.row(v))).norm() < 1e-12);
}

TEST_CASE("A closed surface, or two, cannot be laid flat", "[mesh][flat_map]") {
  Points points(4, 3);
  points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  const PnTriangleMesh closed(TriangleMesh(points, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
  CHECK_THROWS_AS(HarmonicMap(closed, on_square), InputError);
  Points six(6, 3);
  six << 0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0;
  const PnTriangleMesh two(TriangleMesh(six, {{0, 1, 2}, {3, 4, 5}}));
  CHECK_THROWS_AS(HarmonicMap(two, on_square), InputError);
}
