// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/shape/shape_constraints.h"

#include <Eigen/Geometry>
#include <cmath>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

// A square sheet with constraints, under a load that acts everywhere.
struct Sheet {
  std::shared_ptr<const ParametricMesh> mesh;
  TriangleElement kind;
  ConstraintSet set;
  SurfaceConstraints shape;

  Sheet(int n, TriangleElement k)
      : mesh(std::make_shared<ParametricMesh>(ParametricMesh::unit_square(n))),
        kind(k),
        set(DofMap(*mesh).count()),
        shape(*mesh, kind, set) {}

  int vertex(int i, int j) const {
    const int side = static_cast<int>(std::lround(std::sqrt(mesh->vertex_count())));
    return j * side + i;
  }
  void fix_corners() {
    for (int v = 0; v < mesh->vertex_count(); ++v) {
      const Vec2& p = mesh->vertices()[v];
      if ((p.x() == 0 || p.x() == 1) && (p.y() == 0 || p.y() == 1))
        shape.point("corner", v, Vec3(p.x(), p.y(), 0));
    }
  }
  Surface solve() const {
    const SurfaceAssembler assembler(*mesh, kind);
    const SparseMatrix K = assembler.stiffness(SurfaceStiffness::isotropic(0.3, 1));
    const Points q = solve_constrained(set, K, assembler.load(Vec3(1, -2, 20)));
    CHECK(set.max_residual(q) < 1e-12);
    return {mesh, kind, q};
  }
  /// The point at s in [0, 1] of an edge, from its lower end.
  Location on_edge(int edge, double s) const {
    const auto& e = mesh->edges()[edge];
    const auto& v = mesh->triangles()[e.triangle[0]];
    Location where{e.triangle[0], Vec3::Zero()};
    for (int i = 0; i < 3; ++i) where.L[i] = v[i] == e.low ? 1 - s : v[i] == e.high ? s : 0;
    return where;
  }
  std::vector<int> edges_along(const std::vector<int>& vertices) const {
    std::vector<int> edges;
    for (size_t i = 0; i + 1 < vertices.size(); ++i)
      edges.push_back(mesh->edge_between(vertices[i], vertices[i + 1]));
    return edges;
  }
};

std::vector<int> bottom_row(const Sheet& sheet, int n) {
  std::vector<int> vertices;
  for (int i = 0; i <= n; ++i) vertices.push_back(sheet.vertex(i, 0));
  return vertices;
}

}  // namespace

TEST_CASE("a held point of the surface is where it is held", "[constraints][surfaces]") {
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    Sheet sheet(3, kind);
    sheet.fix_corners();
    const Location inside{7, Vec3(0.5, 0.2, 0.3)}, on_edge{2, Vec3(0, 0.25, 0.75)};
    sheet.shape.point("inside", inside, Vec3(0.4, 0.6, 1));
    sheet.shape.point("on an edge", on_edge, Vec3(0.7, 0.1, -1));
    sheet.shape.point("vertex", sheet.vertex(1, 2), Vec3(0.3, 0.8, 0.5));
    const Surface surface = sheet.solve();
    CHECK((surface.position(inside) - Vec3(0.4, 0.6, 1)).norm() < 1e-12);
    CHECK((surface.position(on_edge) - Vec3(0.7, 0.1, -1)).norm() < 1e-12);
    const Vec2 uv = sheet.mesh->vertices()[sheet.vertex(1, 2)];
    CHECK((surface.position(surface.locate(uv)) - Vec3(0.3, 0.8, 0.5)).norm() < 1e-12);
    CHECK_FALSE(sheet.set.coupled());
    CHECK(sheet.set.constraints().size() == 7);
  }
}

TEST_CASE("a tangent and a normal at a vertex are parallel to the given directions",
          "[constraints][surfaces]") {
  const Vec3 tau(1, 2, -1), n(0.2, -0.3, 5);
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    Sheet sheet(3, kind);
    sheet.fix_corners();
    const int a = sheet.vertex(1, 1), b = sheet.vertex(2, 2);
    const Vec2 s(3, -4);
    sheet.shape.tangent("tangent", a, s, tau);
    sheet.shape.normal("normal", b, n);
    CHECK(sheet.set.coupled_constraints().size() == 4);
    const Surface surface = sheet.solve();
    const Points& q = surface.dofs();
    const Vec3 along = s.x() * q.row(3 * a + 1) + s.y() * q.row(3 * a + 2);
    CHECK(along.norm() > 1e-3);
    CHECK(along.cross(tau).norm() < 1e-12);
    const SurfaceJet j = surface.jet(surface.locate(sheet.mesh->vertices()[b]));
    CHECK(j.area_vector().norm() > 1e-3);
    CHECK(j.normal().cross(n.normalized()).norm() < 1e-12);
  }
  // The length of the prescribed normal does not matter, only its direction.
  const auto height = [&](double scale) {
    Sheet sheet(2, TriangleElement::HCT);
    sheet.fix_corners();
    sheet.shape.normal("normal", sheet.vertex(1, 1), scale * n);
    sheet.shape.tangent("tangent", sheet.vertex(1, 0), scale * Vec2(1, 0), -scale * tau);
    return Vec3(sheet.solve().dofs().row(3 * sheet.vertex(1, 1)));
  };
  CHECK((height(1) - height(1e8)).norm() < 1e-12);
  CHECK((height(1) - height(1e-8)).norm() < 1e-12);
}

TEST_CASE("a cubic curve along straight runs of edges is the surface's own, everywhere on them",
          "[constraints][surfaces]") {
  const int n = 4;
  for (const auto kind : kBothElements) {
    Random random(3);
    // Two cubics over four edges, with a parameter three times the domain's length.
    const auto random_curve = [&](const Vec3& from, const Vec3& to, double length) {
      Points X(3, 3), D(3, 3);
      X.row(0) = from;
      X.row(1) = 0.5 * (from + to) + 0.3 * random.point();
      X.row(2) = to;
      for (int i = 0; i < 3; ++i) D.row(i) = ((to - from) + random.point()) / (3 * length);
      return HermiteCurve({0, 1.5 * length, 3 * length}, X, D);
    };
    struct Run {
      const char* name;
      Vec2 start, direction;
      double length;
    };
    const Run runs[] = {{"bottom", {0, 0}, {1, 0}, 1},
                        {"left, downwards", {0, 1}, {0, -1}, 1},
                        {"diagonal", {0, 0}, Vec2(1, 1).normalized(), std::sqrt(2.0)}};
    for (const Run& run : runs) {
      INFO(name(kind) << ", " << run.name);
      Sheet sheet(n, kind);
      sheet.fix_corners();
      std::vector<int> vertices;
      std::vector<double> parameters;
      for (int i = 0; i <= n; ++i) {
        const Vec2 p = n * (run.start + run.direction * run.length * i / n);
        vertices.push_back(sheet.vertex(static_cast<int>(std::lround(p.x())),
                                        static_cast<int>(std::lround(p.y()))));
        parameters.push_back(3 * run.length * i / n);
      }
      const Vec2 end = run.start + run.direction * run.length;
      const HermiteCurve curve =
          random_curve(Vec3(run.start.x(), run.start.y(), 0),
                       Vec3(std::round(end.x()), std::round(end.y()), 0), run.length);
      sheet.shape.curve("line", vertices, parameters, curve, run.direction);
      CHECK_FALSE(sheet.set.coupled());
      const Surface surface = sheet.solve();
      double distance = 0, slope = 0;
      for (const int edge : sheet.edges_along(vertices))
        for (int k = 0; k <= 10; ++k) {
          const Location where = sheet.on_edge(edge, k / 10.0);
          const Vec2 uv = sheet.mesh->shape(where.triangle).point(where.L);
          const double u = 3 * run.direction.dot(uv - run.start);
          const SurfaceJet j = surface.jet(where);
          distance = std::max(distance, (j.x - curve.evaluate(u)).norm());
          const Vec3 along = run.direction.x() * j.x_u + run.direction.y() * j.x_v;
          slope = std::max(slope, (along - 3 * curve.evaluate(u, 1)).norm());
        }
      CHECK(distance < 1e-13);
      CHECK(slope < 1e-12);
    }
  }
}

TEST_CASE("a constant normal along edges is exact between the nodes too",
          "[constraints][surfaces]") {
  const int n = 4;
  const Vec3 normal(0, -0.4, 1);
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    Sheet sheet(n, kind);
    sheet.fix_corners();
    const std::vector<int> edges = sheet.edges_along(bottom_row(sheet, n));
    sheet.shape.constant_normal("rim", edges, normal);
    const Surface surface = sheet.solve();
    double angle = 0, off_plane = 0, bend = 0;
    for (const int edge : edges)
      for (int k = 0; k <= 16; ++k) {
        const SurfaceJet j = surface.jet(sheet.on_edge(edge, k / 16.0));
        REQUIRE(j.area_vector().norm() > 1e-2);
        angle = std::max(angle, j.normal().cross(normal.normalized()).norm());
        off_plane = std::max(off_plane, std::abs(j.x.dot(normal)));
        bend = std::max(bend, std::abs(j.x.z()));
      }
    CHECK(angle < 1e-12);
    CHECK(off_plane < 1e-13);
    CHECK(bend > 1e-4);  // the edge moves in its plane: it is not just fixed
    // Elsewhere the surface does not have that normal.
    const SurfaceJet inside = surface.jet(surface.locate({0.5, 0.5}));
    CHECK(inside.normal().cross(normal.normalized()).norm() > 1e-2);
  }

  // Corners outside such a plane: a conflict with both names.
  Sheet sheet(n, TriangleElement::HCT);
  sheet.fix_corners();
  sheet.shape.constant_normal("rim", sheet.edges_along(bottom_row(sheet, n)), Vec3(1, 0, 1));
  try {
    sheet.solve();
    FAIL("no conflict");
  } catch (const ConflictError& error) {
    REQUIRE(error.conflicts().size() == 1);
    auto names = error.conflicts()[0].names;
    std::sort(names.begin(), names.end());
    CHECK(names == std::vector<std::string>{"corner", "rim"});
  }
}

TEST_CASE("a varying normal is exact at three points of each edge and O(h^3) between",
          "[constraints][surfaces]") {
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    double before = 0;
    for (const int n : {8, 16, 32}) {
      Sheet sheet(n, kind);
      // The bottom side is straight; the surface rotates about it by 0.9 rad.
      const std::vector<int> vertices = bottom_row(sheet, n);
      std::vector<double> parameters;
      for (int i = 0; i <= n; ++i) parameters.push_back(static_cast<double>(i) / n);
      Points ends(2, 3), slopes(2, 3);
      ends << 0, 0, 0, 1, 0, 0;
      slopes << 1, 0, 0, 1, 0, 0;
      sheet.fix_corners();
      sheet.shape.curve("line", vertices, parameters, HermiteCurve({0, 1}, ends, slopes), {1, 0});
      const auto normal_at = [](double u) {
        return Vec3(0, -std::sin(0.9 * u), std::cos(0.9 * u));
      };
      const auto normal = [&](int edge, double s) {
        const auto& e = sheet.mesh->edges()[edge];
        const auto& v = sheet.mesh->vertices();
        return Vec3(3 * normal_at((1 - s) * v[e.low].x() + s * v[e.high].x()));
      };
      const std::vector<int> edges = sheet.edges_along(vertices);
      sheet.shape.varying_normal("turn", edges, normal, true);
      const Surface surface = sheet.solve();
      double exact = 0, between = 0;
      for (const int edge : edges)
        for (int k = 0; k <= 16; ++k) {
          const double s = k / 16.0;
          const SurfaceJet j = surface.jet(sheet.on_edge(edge, s));
          REQUIRE(j.area_vector().norm() > 1e-2);
          const double angle = j.normal().cross(normal(edge, s).normalized()).norm();
          double& worst = k % 8 == 0 ? exact : between;
          worst = std::max(worst, angle);
        }
      CHECK(exact < 1e-12);
      CHECK(between > 1e-12);
      if (before > 0) CHECK(std::log2(before / between) > 2.7);
      before = between;
    }
  }
}

TEST_CASE("a varying normal holds the tangent of an edge whose shape is free",
          "[constraints][surfaces]") {
  const int n = 4;
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    Sheet sheet(n, kind);
    sheet.fix_corners();
    const std::vector<int> edges = sheet.edges_along(bottom_row(sheet, n));
    // Normals of the arch z = 0.4 u (1-u), tilted sideways.
    const auto normal = [&](int edge, double s) {
      const auto& e = sheet.mesh->edges()[edge];
      const double u =
          (1 - s) * sheet.mesh->vertices()[e.low].x() + s * sheet.mesh->vertices()[e.high].x();
      return Vec3(-0.4 * (1 - 2 * u), 0.3, 1);
    };
    sheet.shape.varying_normal("arch", edges, normal, false);
    const Surface surface = sheet.solve();
    double exact = 0;
    for (const int edge : edges)
      for (const double s : {0.0, 0.5, 1.0}) {
        const SurfaceJet j = surface.jet(sheet.on_edge(edge, s));
        const Vec3 wanted = normal(edge, s).normalized();
        exact = std::max({exact, std::abs(j.x_u.dot(wanted)), std::abs(j.x_v.dot(wanted))});
      }
    CHECK(exact < 1e-12);
  }
}

TEST_CASE("meaningless geometric constraints are refused", "[constraints][surfaces]") {
  Sheet sheet(2, TriangleElement::HCT);
  ConstraintSet foreign(7);
  CHECK_THROWS_AS(SurfaceConstraints(*sheet.mesh, TriangleElement::HCT, foreign), InputError);
  CHECK_THROWS_AS(sheet.shape.normal("n", 0, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(sheet.shape.normal("n", 0, Vec3(0, 0, NAN)), InputError);
  CHECK_THROWS_AS(sheet.shape.tangent("t", 0, {0, 0}, Vec3::UnitX()), InputError);
  CHECK_THROWS_AS(sheet.shape.tangent("t", 0, {1, 0}, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(sheet.shape.constant_normal("n", {0}, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(sheet.shape.varying_normal(
                      "n", {0}, [](int, double) { return Vec3(0, 0, 0); }, true),
                  InputError);
  const HermiteCurve line({0, 1}, Points::Identity(2, 3), Points::Ones(2, 3));
  CHECK_THROWS_AS(sheet.shape.curve("c", {0, 1, 2}, {0, 1}, line, {1, 0}), InputError);
  CHECK_THROWS_AS(sheet.shape.curve("c", {0}, {0}, line, {1, 0}), InputError);
  CHECK_THROWS_AS(sheet.shape.point("p", -1, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(sheet.shape.point("p", 0, Vec3(0, 0, INFINITY)), InputError);
}
