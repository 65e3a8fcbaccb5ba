// SPDX-License-Identifier: MPL-2.0
// Curved triangles: distance from exact surfaces, and closest points.
#include "batten/mesh/pn_triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

constexpr double kRadius = 2;

/// A part of a sphere over a square of n × n cells, and its normals.
PnTriangleMesh cap(int n) {
  Points points((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      points.row(j * (n + 1) + i) =
          kRadius * Vec3(2.0 * i / n - 1, 2.0 * j / n - 1, 1.5).normalized();
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  std::vector<PnTriangle::Corners> normals;
  for (const auto& t : triangles) {
    auto& corners = normals.emplace_back();
    for (size_t k = 0; k < 3; ++k) corners[k] = points.row(t[k]).normalized();
  }
  return PnTriangleMesh(TriangleMesh(points, triangles), normals);
}

/// Points around the middle of the cap.
std::vector<Vec3> around(double most_off) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> side(-0.8, 0.8), off(-most_off, most_off);
  std::vector<Vec3> result;
  for (int i = 0; i < 300; ++i)
    result.push_back((kRadius + off(random)) * Vec3(side(random), side(random), 1.5).normalized());
  return result;
}

}  // namespace

TEST_CASE("A curved triangle gives back a quadratic, its derivatives and a flat one",
          "[mesh][curved_mesh]") {
  const std::array<Vec3, 3> corners = {Vec3(0, 0, 0), Vec3(1, 0.1, 0), Vec3(0.2, 0.9, 0)};
  const PnTriangle flat(corners, {Vec3::UnitZ(), Vec3::UnitZ(), Vec3::UnitZ()});
  const Vec3 w(0.2, 0.5, 0.3);
  CHECK((flat.at(w) - (w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2])).norm() < 1e-15);
  // A slightly curved one: derivatives compared with finite differences.
  const PnTriangle bent(corners, {Vec3(-0.3, 0.1, 1).normalized(), Vec3(0.2, 0.2, 1).normalized(),
                                  Vec3(0, 0.4, 1).normalized()});
  const double h = 1e-5;
  const auto at = [&](double u, double v) { return bent.at({1 - u - v, u, v}); };
  const auto jet = bent.jet(w);
  CHECK((jet.u - (at(0.5 + h, 0.3) - at(0.5 - h, 0.3)) / (2 * h)).norm() < 1e-9);
  CHECK((jet.v - (at(0.5, 0.3 + h) - at(0.5, 0.3 - h)) / (2 * h)).norm() < 1e-9);
  const auto by_u = [&](double u, double v) { return bent.jet({1 - u - v, u, v}).u; };
  CHECK((jet.uu - (by_u(0.5 + h, 0.3) - by_u(0.5 - h, 0.3)) / (2 * h)).norm() < 1e-8);
  CHECK((jet.uv - (by_u(0.5, 0.3 + h) - by_u(0.5, 0.3 - h)) / (2 * h)).norm() < 1e-8);
}

TEST_CASE("Curved triangles come nearer to a sphere by 16 where they are halved",
          "[mesh][curved_mesh]") {
  double last = 0;
  for (const int n : {4, 8, 16}) {
    const PnTriangleMesh mesh = cap(n);
    double off = 0;
    for (int t = 0; t < mesh.mesh().triangle_count(); ++t)
      for (const Vec3& w : {Vec3(1, 1, 1), Vec3(1, 1, 0), Vec3(4, 1, 1), Vec3(1, 4, 1)})
        off = std::max(off, std::abs(mesh.triangle(t).at(w / w.sum()).norm() - kRadius));
    if (last > 0) CHECK(last / off > 12);
    last = off;
  }
  CHECK(last < 1e-5 * kRadius);
}

TEST_CASE("The nearest point of curved triangles is the foot of the normal, across their edges",
          "[mesh][curved_mesh]") {
  const PnTriangleMesh mesh = cap(12);
  for (const Vec3& p : around(0.3)) {
    const auto found = mesh.nearest(p);
    REQUIRE(found);
    // Distance from the sphere itself, up to the error of the triangles.
    CHECK((found->at - p).norm() == Approx(std::abs(p.norm() - kRadius)).margin(5e-5));
    CHECK((found->at - kRadius * p.normalized()).norm() < 2e-3);
    CHECK(found->normal.dot(p.normalized()) > 0.999);
    CHECK_FALSE(found->on_boundary);
    CHECK((mesh.triangle(found->triangle).at(found->weights) - found->at).norm() < 1e-14);
  }
  // The back of a one-sided surface.
  CHECK_FALSE(mesh.nearest(Vec3(0, 0, 3), Vec3(0, 0, -1)));
}

TEST_CASE("Beyond the boundary of curved triangles the nearest point is on it",
          "[mesh][curved_mesh]") {
  const PnTriangleMesh mesh = cap(6);
  const auto found = mesh.nearest(Vec3(2.5, 0.05, 1.3));
  REQUIRE(found);
  CHECK(found->on_boundary);
  // The boundary is an arc in the plane x = 2/3 z.
  CHECK(found->at.x() == Approx(found->at.z() / 1.5).margin(1e-3));
  CHECK(found->at.norm() == Approx(kRadius).margin(1e-3));
}

TEST_CASE("Without normals triangles are flat", "[mesh][curved_mesh]") {
  const PnTriangleMesh curved = cap(3);
  const PnTriangleMesh flat(curved.mesh());
  const TriangleTree search(curved.mesh());
  for (const Vec3& p : around(0.2)) {
    const auto found = flat.nearest(p);
    REQUIRE(found);
    CHECK(found->at == search.nearest(p)->at);
    CHECK_FALSE(flat.curved(found->triangle));
  }
  CHECK_THROWS_AS(PnTriangleMesh(curved.mesh(), std::vector<PnTriangle::Corners>(2)), InputError);
}
