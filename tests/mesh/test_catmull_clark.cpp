// SPDX-License-Identifier: MPL-2.0
// Catmull-Clark subdivision of control cages: invariants of the limit.
#include "batten/mesh/catmull_clark.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

ShellMesh cube() {
  ShellMesh mesh;
  mesh.points.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    mesh.points.row(i) << (i & 1 ? 1 : -1), (i & 2 ? 1 : -1), (i & 4 ? 1 : -1);
  for (const std::array<int, 4>& f : std::vector<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    mesh.add_face(f);
  return mesh;
}

/// n × n quads over [0, n]² with heights from a function.
template <class Height>
ShellMesh grid(int n, const Height& height) {
  ShellMesh mesh;
  mesh.points.resize((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.points.row(j * (n + 1) + i) << i, j, height(i, j);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int v = j * (n + 1) + i;
      mesh.add_face(std::array{v, v + 1, v + n + 2, v + n + 1});
    }
  return mesh;
}

}  // namespace

TEST_CASE("limits of a node do not depend on the number of rounds", "[mesh][subdivision]") {
  ShellMesh cage = cube();
  cage.points(7, 2) = 1.7;
  const ShellMesh a = catmull_clark(cage, {1}), b = catmull_clark(cage, {3});
  CHECK((a.points - b.points.topRows(a.node_count())).cwiseAbs().maxCoeff() < 1e-14);
  CHECK(b.face_count() == 6 * 4 * 16);
}

TEST_CASE("a regular part is a bicubic B-spline: cubics come back moved, planes as they are",
          "[mesh][subdivision]") {
  // The B-spline of control values f(i) is Σ f B = (f(-1) + 4 f(0) + f(1))/6 at a node: i² + 1/3
  // for i².
  const ShellMesh fine = catmull_clark(grid(8, [](double x, double y) { return x * x - y; }), {2});
  for (int j = 2; j <= 6; ++j)
    for (int i = 2; i <= 6; ++i) {
      const int v = j * 9 + i;
      CHECK((fine.points.row(v) - Eigen::RowVector3d(i, j, i * i + 1.0 / 3 - j)).norm() < 1e-13);
    }
  const ShellMesh plane = catmull_clark(grid(3, [](double x, double y) { return 2 * x - y; }), {3});
  CHECK(
      (plane.points.col(2) - 2 * plane.points.col(0) + plane.points.col(1)).cwiseAbs().maxCoeff() <
      1e-13);
  CHECK(plane.points.topRows(1).norm() < 1e-15);  // corners stay
}

TEST_CASE("a cube's limit is closed and round, and sharp edges stay where they are",
          "[mesh][subdivision]") {
  const PreparedMesh smooth = prepare(catmull_clark(cube(), {4}));
  for (const auto& edge : smooth.mesh.topology().edges())
    CHECK((edge.left >= 0 && edge.right >= 0));
  double low = 9, high = 0;
  for (int v = 0; v < smooth.mesh.vertex_count(); ++v) {
    low = std::min(low, smooth.mesh.point(v).norm());
    high = std::max(high, smooth.mesh.point(v).norm());
  }
  CHECK(high < 0.9);
  CHECK(high / low < 1.1);
  CatmullClarkOptions sharp;
  sharp.tags.creases = {{4, 5}, {5, 7}, {7, 6}, {6, 4}};
  const ShellMesh lid = catmull_clark(cube(), sharp);
  int on_top = 0;
  for (int v = 0; v < lid.node_count(); ++v) on_top += std::abs(lid.points(v, 2) - 1) < 1e-14;
  CHECK(on_top == 17 * 17);  // the face with its edges is planar
}

TEST_CASE("a roof's ridge of sharpness s follows the cubic spline of theory",
          "[mesh][subdivision]") {
  // Across the ridge it is the subdivision of -|x|: s levels keep the ridge and halve its
  // neighbours, then it is smooth, so it converges to -2^-k (2 - f)/6 for s = k + f.
  constexpr int n = 12;
  const ShellMesh roof = grid(n, [](double x, double) { return -std::abs(x - n / 2); });
  for (const double s : {0.0, 0.25, 1.0, 1.5, 2.0, 3.75, 6.0, 9.5}) {
    INFO(s);
    CatmullClarkOptions options;
    options.levels = 2;
    for (int j = 0; j < n; ++j)
      options.tags.creases.push_back({j * (n + 1) + n / 2, (j + 1) * (n + 1) + n / 2, s});
    const double k = std::floor(s);
    const ShellMesh limit = catmull_clark(roof, options);
    CHECK(limit.points(6 * (n + 1) + n / 2, 2) ==
          Approx(-std::pow(2, -k) * (2 - (s - k)) / 6).epsilon(1e-12));
    CHECK(std::abs(limit.points(6 * (n + 1) + n / 2, 0) - n / 2) < 1e-14);
  }
  CatmullClarkOptions for_good;
  for (int j = 0; j < n; ++j)
    for_good.tags.creases.push_back({j * (n + 1) + n / 2, (j + 1) * (n + 1) + n / 2});
  CHECK(std::abs(catmull_clark(roof, for_good).points(6 * (n + 1) + n / 2, 2)) < 1e-15);
}

TEST_CASE("limits do not depend on the rounds, whatever is sharp and by how much",
          "[mesh][subdivision]") {
  ShellMesh cage = cube();
  cage.points(7, 2) = 1.7;
  cage.points(2, 0) = -1.4;
  CatmullClarkOptions options;
  options.tags.creases = {{0, 1, 0.5}, {1, 3, 2.3}, {3, 7, 10}, {5, 7, 1}, {6, 7, 4.7}, {4, 6, 10}};
  options.tags.corners = {{2, 1.4}, {5, 10}};
  std::vector<ShellMesh> limits;
  for (const int levels : {1, 2, 4, 6}) {
    options.levels = levels;
    limits.push_back(catmull_clark(cage, options));
  }
  for (size_t k = 1; k < limits.size(); ++k)
    CHECK((limits[0].points - limits[k].points.topRows(limits[0].node_count()))
              .cwiseAbs()
              .maxCoeff() < 1e-13);
  CHECK((limits[0].points.row(5) - cage.points.row(5)).norm() == 0);
}

TEST_CASE("no sharpness is smooth, and more is nearer to the cage", "[mesh][subdivision]") {
  const auto top = [](double s) {
    CatmullClarkOptions options;
    options.tags.corners = {{7, s}};
    return catmull_clark(cube(), options).points.row(7).norm();
  };
  CHECK(top(0) == catmull_clark(cube()).points.row(7).norm());
  double before = top(0);
  for (const double s : {0.3, 1.0, 1.7, 2.0, 3.3, 6.0, 9.9}) {
    CHECK(top(s) > before);
    before = top(s);
  }
  CHECK(top(10) == std::sqrt(3.0));
}

TEST_CASE("cages and options that cannot be are refused", "[mesh][subdivision]") {
  CHECK_THROWS_WITH(catmull_clark(cube(), {0}), Contains("1 or more"));
  CHECK_THROWS_WITH(catmull_clark(cube(), {12}), Contains("4,000,000"));
  CatmullClarkOptions wrong;
  wrong.tags.creases = {{0, 7}};
  CHECK_THROWS_WITH(catmull_clark(cube(), wrong), Contains("node 1 to 8 is not an edge"));
  wrong.tags = {{{0, 1, -2}}, {}};
  CHECK_THROWS_WITH(catmull_clark(cube(), wrong), Contains("sharpness of -2"));
  wrong.tags = {{}, {{8}}};
  CHECK_THROWS_WITH(catmull_clark(cube(), wrong), Contains("corner 9 is not a node"));
}
