// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/display_points.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fem/surface.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

// A wavy sheet with random edge slopes, so that every dof matters.
Surface wavy(int n, TriangleElement kind, unsigned seed) {
  Random random(seed);
  return interpolated(std::make_shared<ParametricMesh>(perturbed_square(n, seed)), kind,
                      [&](const Vec2& p) {
                        struct {
                          Vec3 x, x_u, x_v;
                        } f{{p.x(), p.y(), 0.2 * std::sin(4 * p.x() + p.y())},
                            Vec3(1, 0.1, 0.8 * std::cos(4 * p.x() + p.y())) + 0.2 * random.point(),
                            Vec3(0.1, 1, 0.2 * std::cos(4 * p.x() + p.y())) + 0.2 * random.point()};
                        return f;
                      });
}

// Vertices, points on edges, points inside.
std::vector<Location> places(const ParametricMesh& mesh, unsigned seed) {
  std::vector<Location> where = tessellate(mesh, 3).points;
  Random random(seed);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3 L(random.between(0, 1), random.between(0, 1), random.between(0, 1));
    where.push_back({t, L / L.sum()});
    const double s = random.between(0, 1);
    Vec3 on_edge = Vec3::Zero();
    on_edge[t % 3] = s;
    on_edge[(t + 1) % 3] = 1 - s;
    where.push_back({t, on_edge});
    where.push_back({t, Vec3::Unit(t % 3)});
  }
  return where;
}

struct Shown {
  std::vector<float> points, normals;
  Shown(const DisplayPoints& display, const Points& x, const Vec3& shift = Vec3::Zero())
      : points(static_cast<size_t>(3 * display.count()), 7),
        normals(static_cast<size_t>(3 * display.count()), 7) {
    display.evaluate(x, shift, points.data(), normals.data());
  }
  Vec3 point(size_t p) const { return {points[3 * p], points[3 * p + 1], points[3 * p + 2]}; }
  Vec3 normal(size_t p) const { return {normals[3 * p], normals[3 * p + 1], normals[3 * p + 2]}; }
};

}  // namespace

TEST_CASE("display points and normals are those of the surface", "[fem][display]") {
  for (const TriangleElement kind : kBothElements)
    for (const int n : {1, 3, 40}) {
      const Surface surface = wavy(n, kind, 3);
      const auto where = places(surface.mesh(), 4);
      const DisplayPoints display(surface.mesh(), kind, where);
      REQUIRE(display.count() == static_cast<int>(where.size()));
      const Vec3 shift(0.5, -2, 1);
      const Shown shown(display, surface.dofs(), shift);
      double point = 0, normal = 0;
      for (size_t p = 0; p < where.size(); ++p) {
        const SurfaceJet jet = surface.jet(where[p]);
        point = std::max(point, (shown.point(p) - jet.x - shift).cwiseAbs().maxCoeff());
        normal = std::max(normal, (shown.normal(p) - jet.normal()).cwiseAbs().maxCoeff());
      }
      INFO(name(kind) << ", " << n << ": " << point << " " << normal);
      CHECK(point < 5e-7);
      CHECK(normal < 1e-6);
    }
}

TEST_CASE("display points of a tube go around its seam", "[fem][display]") {
  // Twelve columns around, two rows, one diagonal per cell.
  std::vector<Vec2> vertices;
  std::vector<ParametricMesh::Triangle> triangles;
  constexpr int columns = 12, rows = 2;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i < columns; ++i) vertices.emplace_back(i * 0.5, j * 0.5);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * columns + i, b = j * columns + (i + 1) % columns;
      triangles.push_back({a, b, b + columns});
      triangles.push_back({a, b + columns, a + columns});
    }
  const auto mesh = std::make_shared<ParametricMesh>(vertices, triangles, columns * 0.5);
  Random random(9);
  Points q(DofMap(*mesh).count(), 3);
  for (long i = 0; i < q.rows(); ++i) q.row(i) = random.point();
  const Surface surface(mesh, TriangleElement::HCT, q);
  const auto where = places(*mesh, 5);
  const Shown shown(DisplayPoints(*mesh, TriangleElement::HCT, where), q);
  double worst = 0;
  for (size_t p = 0; p < where.size(); ++p)
    worst = std::max(worst, (shown.point(p) - surface.position(where[p])).norm());
  CHECK(worst < 2e-6);
}

TEST_CASE("display points ask for no memory and give the same bits on one thread or two",
          "[fem][display]") {
  const Surface surface = wavy(50, TriangleElement::HCT, 1);
  const auto where = places(surface.mesh(), 2);
  const DisplayPoints display(surface.mesh(), surface.kind(), where);
  REQUIRE(where.size() > 20000);
  const Shown shown(display, surface.dofs());  // starts the threads
  Shown again = shown;
  if (counts_allocations()) {
    const ScopedOpCount work;
    display.evaluate(surface.dofs(), Vec3::Zero(), again.points.data(), again.normals.data());
    CHECK(work.of(OpCounter::Allocation) == 0);
  }
  const ThreadGuard one(1);
  std::fill(again.points.begin(), again.points.end(), 0.0F);
  std::fill(again.normals.begin(), again.normals.end(), 0.0F);
  display.evaluate(surface.dofs(), Vec3::Zero(), again.points.data(), again.normals.data());
  const size_t bytes = sizeof(float) * shown.points.size();
  CHECK(std::memcmp(shown.points.data(), again.points.data(), bytes) == 0);
  CHECK(std::memcmp(shown.normals.data(), again.normals.data(), bytes) == 0);
}

TEST_CASE("display normals do not depend on the unit of length", "[fem][display]") {
  const Surface surface = wavy(3, TriangleElement::HCT, 8);
  const auto where = places(surface.mesh(), 2);
  const DisplayPoints display(surface.mesh(), surface.kind(), where);
  const Shown one(display, surface.dofs());
  for (const double unit : {1e-9, 1e9}) {
    const Shown other(display, unit * surface.dofs());
    for (size_t p = 0; p < where.size(); ++p)
      CHECK((one.normal(p) - other.normal(p)).norm() < 1e-6);
  }
}

TEST_CASE("a singular point has no normal, its neighbours have theirs", "[fem][display]") {
  Surface surface = wavy(4, TriangleElement::HCT, 6);
  Points q = surface.dofs();
  q.row(3 * 7 + 2) = -3 * q.row(3 * 7 + 1);  // x_v ∥ x_u at vertex 7
  const auto where = tessellate(surface.mesh(), 1).points;
  const Shown shown(DisplayPoints(surface.mesh(), surface.kind(), where), q);
  for (size_t p = 0; p < where.size(); ++p)
    CHECK(shown.normal(p).norm() == Approx(p == 7 ? 0.0 : 1.0).margin(1e-6));
}

TEST_CASE("locations outside of all triangles, and dofs of another mesh, are refused",
          "[fem][display]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(2);
  const auto make = [&](const Location& where) {
    return DisplayPoints(mesh, TriangleElement::HCT, {{}, where});
  };
  CHECK_THROWS_WITH(make({8, Vec3::Constant(1.0 / 3)}),
                    Contains("point 1") && Contains("found triangle 8, expected 0 to 7"));
  CHECK_THROWS_AS(make({-1, Vec3::Constant(1.0 / 3)}), InputError);
  CHECK_THROWS_WITH(make({0, Vec3(0.5, 0.6, -0.1)}), Contains("point 1") && Contains("-0.1"));
  CHECK_THROWS_AS(make({0, Vec3(0.5, 0.3, 0.3)}), InputError);
  CHECK_THROWS_AS(make({0, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())}), InputError);
  const DisplayPoints display(mesh, TriangleElement::HCT, {{}});
  float points[3], normals[3];
  CHECK_THROWS_AS(display.evaluate(Points::Zero(5, 3), Vec3::Zero(), points, normals), InputError);
  const DisplayPoints none(mesh, TriangleElement::HCT, {});
  none.evaluate(Points::Zero(DofMap(mesh).count(), 3), Vec3::Zero(), points, normals);
  CHECK(none.count() == 0);
}
