#include "batten/fem/parametric_mesh.h"

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "batten/core/errors.h"
#include "batten/tests/catch.h"

using namespace batten;

namespace {

using Triangle = ParametricMesh::Triangle;

// True when making the mesh is an InputError whose message has these words.
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

// Four triangles around vertex 0, which is not in the middle.
ParametricMesh fan() {
  return {{{0.2, 0.1}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}},
          {{0, 1, 2}, {0, 2, 3}, {3, 4, 0}, {4, 1, 0}}};
}

}  // namespace

TEST_CASE("a square mesh has the counts of Euler's formula and covers the square") {
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

TEST_CASE("edges know their triangles, and triangles their edges") {
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

TEST_CASE("the two triangles of an edge have opposite signs, and +1 has the normal pointing in") {
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

TEST_CASE("refinement cuts each triangle in four equal ones and stays conforming") {
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

TEST_CASE("every dof has one number, and neighbours share those of their edge") {
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

TEST_CASE("meshes that are none are input errors that say what is wrong") {
  const std::vector<Vec2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  CHECK_NOTHROW(ParametricMesh(square, {{0, 1, 2}, {0, 2, 3}}));
  CHECK(rejected(square, {}, "at least one triangle"));
  CHECK(rejected({}, {}, "at least one triangle"));
  CHECK(rejected(square, {{0, 1, 2}, {0, 2, 4}}, "triangle 1 names vertex 4 of 4"));
  CHECK(rejected(square, {{0, 1, 2}, {-1, 2, 3}}, "triangle 1 names vertex -1 of 4"));
  CHECK(rejected(square, {{0, 2, 1}, {0, 3, 2}}, "counter-clockwise"));
  CHECK(rejected(square, {{0, 1, 2}}, "vertex 3 has no triangle"));
  CHECK(rejected({{0, 0}, {1, 0}, {2, 0}}, {{0, 1, 2}}, "area 0"));
  CHECK(rejected({{0, 0}, {1, 0}, {0, NAN}}, {{0, 1, 2}}, "vertex 2 is not finite"));
  CHECK(rejected({{0, 0}, {INFINITY, 0}, {0, 1}}, {{0, 1, 2}}, "vertex 1 is not finite"));
  // Folded over: both triangles on the same side of edge 0-1.
  CHECK(rejected({{0, 0}, {1, 0}, {0, 1}, {1, 1}}, {{0, 1, 2}, {0, 1, 3}},
                 "edge 0-1 are wound in opposite directions"));
  // A fin: three triangles at edge 0-1.
  CHECK(rejected({{0, 0}, {1, 0}, {0, 1}, {0, -1}, {1, -1}}, {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}},
                 "edge 0-1 has more than two triangles"));
  CHECK_THROWS_AS(ParametricMesh(square, {{0, 1, 1}, {0, 2, 3}}), InputError);
}
