// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "batten/core/errors.h"
#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"
#include "batten/fem/trim.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten;

namespace {

using Triangle = ParametricMesh::Triangle;

// True if the construction of the mesh throws an InputError whose message contains this text.
bool rejected(const std::vector<Vec2>& vertices, const std::vector<Triangle>& triangles,
              const std::string& words) {
  try {
    const ParametricMesh mesh(vertices, triangles);
  } catch (const InputError& error) {
    UNSCOPED_INFO(error.what());
    return std::string(error.what()).find(words) != std::string::npos;
  }
  return false;
}

double total_area(const ParametricMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) sum += mesh.shape(t).area;
  return sum;
}

// Four triangles around vertex 0, which is not in the centre.
ParametricMesh fan() {
  return {{{0.2, 0.1}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}},
          {{0, 1, 2}, {0, 2, 3}, {3, 4, 0}, {4, 1, 0}}};
}

constexpr double around = 2.5;  // a period

// A strip that is periodic in u, with uneven columns; the seam is `shift` away from a column.
ParametricMesh strip(int columns, int rows, double shift) {
  std::vector<Vec2> vertices;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double wave = 0.2 * std::sin(1.0 + i + 2 * j) * (j > 0 && j < rows);
      const double u = around * (i + wave) / columns + shift;
      vertices.emplace_back(u - around * std::floor(u / around), 0.3 * j);
    }
  std::vector<Triangle> triangles;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * columns + i, b = j * columns + (i + 1) % columns;
      triangles.push_back({a, b, b + columns});
      triangles.push_back({a, b + columns, a + columns});
    }
  return {vertices, triangles, around};
}

}  // namespace

TEST_CASE("a square mesh has the counts of Euler's formula and covers the square",
          "[fem][parametric_mesh]") {
  for (const int n : {1, 2, 5}) {
    const ParametricMesh mesh = ParametricMesh::unit_square(n);
    CHECK(mesh.vertex_count() == (n + 1) * (n + 1));
    CHECK(mesh.triangle_count() == 2 * n * n);
    CHECK(mesh.edge_count() == n * n + 2 * n * (n + 1));
    CHECK(mesh.vertex_count() - mesh.edge_count() + mesh.triangle_count() == 1);
    CHECK(std::abs(total_area(mesh) - 1) < 1e-15);
    int boundary = 0;
    for (const auto& e : mesh.edges()) boundary += e.boundary();
    CHECK(boundary == 4 * n);
    // The cut runs along (0,0)-(1,1).
    CHECK(mesh.edge_between(0, n + 2) >= 0);
    CHECK(mesh.edge_between(1, n + 1) == -1);
  }
  CHECK_THROWS_AS(ParametricMesh::unit_square(0), InputError);
}

TEST_CASE("edges know their triangles, and triangles their edges", "[fem][parametric_mesh]") {
  for (const ParametricMesh& mesh : {ParametricMesh::unit_square(3), fan()}) {
    std::map<std::pair<int, int>, int> uses;
    int last_new = -1;
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int i = 0; i < 3; ++i) {
        const auto& v = mesh.triangles()[t];
        const int a = v[(i + 1) % 3], b = v[(i + 2) % 3], e = mesh.edges_of(t)[i];
        const auto& edge = mesh.edges()[e];
        CHECK(edge.low == std::min(a, b));
        CHECK(edge.high == std::max(a, b));
        CHECK(mesh.edge_between(a, b) == e);
        CHECK(mesh.edge_between(b, a) == e);
        const int side = edge.triangle[0] == t ? 0 : 1;
        CHECK(edge.triangle[side] == t);
        CHECK(edge.local[side] == i);
        ++uses[{edge.low, edge.high}];
        CHECK(e <= last_new + 1);  // numbered by first appearance
        last_new = std::max(last_new, e);
      }
    CHECK(static_cast<int>(uses.size()) == mesh.edge_count());
    for (const auto& e : mesh.edges()) CHECK(uses[{e.low, e.high}] == (e.boundary() ? 1 : 2));
  }
  CHECK(fan().edge_between(1, 3) == -1);
}

TEST_CASE("the two triangles of an edge have opposite signs, and +1 has the normal pointing in",
          "[fem][parametric_mesh]") {
  const ParametricMesh mesh = fan();
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    const Vec2 t = mesh.edge_tangent(e), n = mesh.edge_normal(e);
    const Vec2 along = mesh.vertices()[edge.high] - mesh.vertices()[edge.low];
    CHECK(std::abs(mesh.edge_length(e) - along.norm()) < 1e-15);
    CHECK((along / along.norm() - t).norm() < 1e-15);
    CHECK((n - Vec2(-t.y(), t.x())).norm() < 1e-15);
    double sum = 0;
    for (int side = 0; side < (edge.boundary() ? 1 : 2); ++side) {
      const int triangle = edge.triangle[side], i = edge.local[side];
      const double sign = mesh.edge_sign(triangle, i);
      sum += sign;
      const Vec2 opposite = mesh.vertices()[mesh.triangles()[triangle][i]];
      CHECK(sign * n.dot(opposite - mesh.vertices()[edge.low]) > 0);
      CHECK(mesh.shape(triangle).edge_sign[i] == sign);
    }
    if (!edge.boundary()) CHECK(sum == 0);
  }
}

TEST_CASE("refinement cuts each triangle in four equal ones and stays conforming",
          "[fem][parametric_mesh]") {
  const ParametricMesh coarse = fan();
  const ParametricMesh fine = coarse.refined();
  CHECK(fine.triangle_count() == 4 * coarse.triangle_count());
  CHECK(fine.vertex_count() == coarse.vertex_count() + coarse.edge_count());
  CHECK(fine.edge_count() == 2 * coarse.edge_count() + 3 * coarse.triangle_count());
  CHECK(std::abs(total_area(fine) - total_area(coarse)) < 1e-15);
  for (int v = 0; v < coarse.vertex_count(); ++v) CHECK(fine.vertices()[v] == coarse.vertices()[v]);
  for (int e = 0; e < coarse.edge_count(); ++e) {
    const auto& edge = coarse.edges()[e];
    const int middle = coarse.vertex_count() + e;
    const Vec2 ends = coarse.vertices()[edge.low] + coarse.vertices()[edge.high];
    CHECK(fine.vertices()[middle] == Vec2(0.5 * ends));
    for (const int end : {edge.low, edge.high}) {
      const int half = fine.edge_between(end, middle);
      REQUIRE(half >= 0);
      CHECK(fine.edges()[half].boundary() == edge.boundary());
    }
  }
  for (int t = 0; t < fine.triangle_count(); ++t)
    CHECK(std::abs(4 * fine.shape(t).area - coarse.shape(t / 4).area) < 1e-15);
}

TEST_CASE("every dof has one number, and neighbours share those of their edge",
          "[fem][parametric_mesh]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(3);
  const DofMap dofs(mesh);
  CHECK(dofs.count() == 3 * mesh.vertex_count() + mesh.edge_count());
  std::set<int> used;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto map = dofs.triangle(mesh, t);
    used.insert(map.begin(), map.end());
    for (int i = 0; i < 3; ++i) {
      for (int d = 0; d < 3; ++d) CHECK(map[3 * i + d] == dofs.vertex(mesh.triangles()[t][i], d));
      CHECK(map[9 + i] == dofs.edge(mesh.edges_of(t)[i]));
    }
  }
  CHECK(static_cast<int>(used.size()) == dofs.count());
  CHECK(*used.begin() == 0);
  CHECK(*used.rbegin() == dofs.count() - 1);
}

TEST_CASE("invalid meshes are input errors that state the reason", "[fem][parametric_mesh]") {
  const std::vector<Vec2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  CHECK_NOTHROW(ParametricMesh(square, {{0, 1, 2}, {0, 2, 3}}));
  CHECK(rejected(square, {}, "at least one triangle"));
  CHECK(rejected({}, {}, "at least one triangle"));
  CHECK(rejected(square, {{0, 1, 2}, {0, 2, 4}}, "triangle 1 uses vertex 4, expected 0 to 3"));
  CHECK(rejected(square, {{0, 1, 2}, {-1, 2, 3}}, "triangle 1 uses vertex -1, expected 0 to 3"));
  CHECK(rejected(square, {{0, 2, 1}, {0, 3, 2}}, "counter-clockwise"));
  CHECK(rejected(square, {{0, 1, 2}}, "vertex 3 belongs to no triangle"));
  CHECK(rejected({{0, 0}, {1, 0}, {2, 0}}, {{0, 1, 2}}, "area 0"));
  CHECK(rejected({{0, 0}, {1, 0}, {0, NAN}}, {{0, 1, 2}}, "vertex 2 is not finite"));
  CHECK(rejected({{0, 0}, {INFINITY, 0}, {0, 1}}, {{0, 1, 2}}, "vertex 1 is not finite"));
  // Folded: both triangles are on the same side of edge 0-1.
  CHECK(rejected({{0, 0}, {1, 0}, {0, 1}, {1, 1}}, {{0, 1, 2}, {0, 1, 3}},
                 "edge 0-1 have opposite orientations"));
  // Non-manifold: three triangles at edge 0-1.
  CHECK(rejected({{0, 0}, {1, 0}, {0, 1}, {0, -1}, {1, -1}}, {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}},
                 "edge 0-1 has more than two triangles"));
  CHECK_THROWS_AS(ParametricMesh(square, {{0, 1, 1}, {0, 2, 3}}), InputError);
}

TEST_CASE(
    "a strip that is periodic in u has no seam: Euler's number 0, two boundaries, the whole area",
    "[fem][parametric_mesh]") {
  for (const double shift : {0.0, 0.17, 1.9}) {
    const ParametricMesh mesh = strip(7, 3, shift);
    CHECK(mesh.vertex_count() == 7 * 4);
    CHECK(mesh.vertex_count() - mesh.edge_count() + mesh.triangle_count() == 0);
    CHECK(DofMap(mesh).count() == 3 * 28 + mesh.edge_count());
    CHECK(std::abs(total_area(mesh) - around * 0.9) < 1e-14);
    int rim = 0;
    double rim_length = 0;
    for (int e = 0; e < mesh.edge_count(); ++e)
      if (mesh.edges()[e].boundary()) {
        ++rim;
        rim_length += mesh.edge_length(e);
      }
    CHECK(rim == 2 * 7);
    CHECK(std::abs(rim_length - 2 * around) < 1e-14);
    CHECK((mesh.chain_vector({0, 1, 2, 3, 4, 5, 6, 0}) - Vec2(around, 0)).norm() < 1e-14);
    CHECK((mesh.chain_vector({2, 1, 0, 6, 5, 4, 3, 2}) + Vec2(around, 0)).norm() < 1e-14);
    CHECK((mesh.chain_vector({5, 6, 0}) - Vec2(2 * around / 7, 0)).norm() < 1e-14);
  }
}

TEST_CASE("moving the seam of a periodic mesh moves nothing else", "[fem][parametric_mesh]") {
  const ParametricMesh one = strip(7, 3, 0), other = strip(7, 3, 1.9);
  for (int e = 0; e < one.edge_count(); ++e) {
    CHECK(std::abs(one.edge_length(e) - other.edge_length(e)) < 1e-15);
    CHECK((one.edge_normal(e) - other.edge_normal(e)).norm() < 1e-14);
    const auto& edge = one.edges()[e];
    for (int side = 0; side < (edge.boundary() ? 1 : 2); ++side) {
      // The edge is the same vector in each of its triangles.
      const TriangleShape shape = other.shape(edge.triangle[side]);
      const int i = edge.local[side];
      const Vec2 along = shape.vertex[(i + 2) % 3] - shape.vertex[(i + 1) % 3];
      CHECK((shape.edge_sign[i] * along / other.edge_length(e) - other.edge_tangent(e)).norm() <
            1e-14);
    }
  }
  const auto K = [](const ParametricMesh& mesh) {
    return SurfaceAssembler(mesh, TriangleElement::HCT).stiffness(SurfaceStiffness{});
  };
  CHECK((K(one) - K(other)).norm() < 1e-12 * K(one).norm());
  const ParametricMesh fine = one.refined(), fine_other = other.refined();
  CHECK(fine.period() == around);
  CHECK(std::abs(total_area(fine) - total_area(one)) < 1e-14);
  for (int e = 0; e < fine.edge_count(); ++e)
    CHECK(std::abs(fine.edge_length(e) - fine_other.edge_length(e)) < 1e-15);
}

TEST_CASE("a periodic function is interpolated across the seam as elsewhere, and C1",
          "[fem][parametric_mesh]") {
  const auto mesh = std::make_shared<ParametricMesh>(strip(24, 6, 0.04));
  const double k = 2 * std::acos(-1.0) / around;
  const auto f = [&](Vec2 p) {
    return Vec3(std::sin(k * p.x()) * p.y(), k * std::cos(k * p.x()) * p.y(), std::sin(k * p.x()));
  };
  VecX q(DofMap(*mesh).count());
  for (int v = 0; v < mesh->vertex_count(); ++v) q.segment<3>(3 * v) = f(mesh->vertices()[v]);
  for (int e = 0; e < mesh->edge_count(); ++e) {
    const Vec2& low = mesh->vertices()[mesh->edges()[e].low];
    const Vec2 middle = low + 0.5 * mesh->edge_length(e) * mesh->edge_tangent(e);
    q[DofMap(*mesh).edge(e)] = mesh->edge_normal(e).dot(f(middle).tail<2>());
  }
  const Surface surface(mesh, TriangleElement::HCT, q.replicate(1, 3));
  const TriangleLocator locator(*mesh);
  double worst = 0;
  for (int i = -60; i < 120; ++i) {
    const Vec2 p(0.013 + around * i / 30.0, 0.37);
    worst = std::max(worst, std::abs(surface.position(locator.locate(p)).x() - f(p)[0]));
    const Location here = locator.locate(p), there = locator.locate(p + Vec2(3 * around, 0));
    CHECK(here.triangle == there.triangle);
    CHECK((here.L - there.L).norm() < 1e-12);
  }
  CHECK(worst < 1e-4);
  for (const auto& edge : mesh->edges())
    if (!edge.boundary()) {
      Vec3 at[2] = {Vec3::Zero(), Vec3::Zero()};
      for (const int side : {0, 1}) {
        const auto& v = mesh->triangles()[edge.triangle[side]];
        for (int i = 0; i < 3; ++i)
          at[side][i] = v[i] == edge.low ? 0.3 : v[i] == edge.high ? 0.7 : 0;
      }
      const SurfaceJet a = surface.jet({edge.triangle[0], at[0]}),
                       b = surface.jet({edge.triangle[1], at[1]});
      CHECK((a.x_u - b.x_u).norm() + (a.x_v - b.x_v).norm() < 1e-12);
    }
}

TEST_CASE(
    "a vertex at the seam is found from both sides, a point beyond the boundary on the boundary",
    "[fem][parametric_mesh]") {
  const ParametricMesh mesh = strip(8, 2, 0);
  const TriangleLocator locator(mesh);
  const auto position = [&](const Vec2& p) {
    const Location where = locator.locate(p);
    return mesh.wrapped(mesh.shape(where.triangle).point(where.L));
  };
  for (const double u : {0.0, around, -around, -1e-15, around - 1e-15}) {
    const Vec2 p = position({u, 0.05});
    CHECK(std::min(p.x(), around - p.x()) < 1e-12);
    CHECK(std::abs(p.y() - 0.05) < 1e-12);
    CHECK(locator.locate({u, 0}).triangle == locator.locate({0, 0}).triangle);
  }
  for (const double u : {0.1, 0.3 * around, 0.99 * around, 1.4 * around}) {
    CHECK((position({u, 5}) - mesh.wrapped({u, 0.6})).norm() < 1e-12);
    CHECK((position({u, -2}) - mesh.wrapped({u, 0})).norm() < 1e-12);
  }
}

TEST_CASE("a hole across the seam cuts as much as the same hole elsewhere",
          "[fem][parametric_mesh]") {
  const ParametricMesh mesh = strip(20, 6, 0);
  const auto hole = [](double u) {
    // Clockwise, four cubics about a circle of radius 0.4.
    Points x(4, 3), d(4, 3);
    for (int i = 0; i < 4; ++i) {
      const double t = -std::acos(-1.0) / 2 * i;
      x.row(i) << u + 0.4 * std::cos(t), 0.9 + 0.4 * std::sin(t), 0;
      d.row(i) << 0.66 * std::sin(t), -0.66 * std::cos(t), 0;
    }
    const CurveMesh curve({0, 1, 2, 3, 4}, true);
    Points dofs(curve.dof_count(), 3);
    for (int i = 0; i < 4; ++i) {
      dofs.row(curve.position_dof(i)) = x.row(i);
      dofs.row(curve.slope_out(i)) = d.row(i);
    }
    return DomainLoops({{HermiteCurve(curve, dofs)}}, DomainLoops::Background::Inside);
  };
  for (const double u : {1.2, 0.0, 0.1, around - 0.1}) {
    const DomainLoops loops = hole(u);
    const Trim trim(mesh, loops);
    CHECK(std::abs(trim.area() - (around * 1.8 + loops.area())) < 1e-12);
    CHECK(loops.area() < -0.4);
    CHECK(trim.loops().loops().size() == 3);
  }
}

TEST_CASE("the dissection order of a periodic mesh holds every dof once",
          "[fem][parametric_mesh]") {
  std::vector<int> order = nested_dissection_order(strip(30, 4, 0.3));
  std::set<int> all(order.begin(), order.end());
  CHECK(all.size() == order.size());
  CHECK(static_cast<int>(order.size()) == DofMap(strip(30, 4, 0.3)).count());
}

TEST_CASE("an invalid periodic mesh is refused with the reason", "[fem][parametric_mesh]") {
  CHECK_NOTHROW(strip(4, 1, 0));
  CHECK_THROWS_WITH(strip(3, 1, 0), Catch::Matchers::Contains("at least four columns"));
  const ParametricMesh mesh = strip(5, 1, 0);
  std::vector<Vec2> vertices = mesh.vertices();
  CHECK_THROWS_WITH(ParametricMesh(vertices, mesh.triangles(), -1),
                    Catch::Matchers::Contains("period"));
  vertices[2].x() += around;
  CHECK_THROWS_WITH(ParametricMesh(vertices, mesh.triangles(), around),
                    Catch::Matchers::Contains("vertex 2 has u ="));
}
