// Subdivision of cages: what the limit keeps.
#include "batten/mesh/catmull_clark.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/mesh/prepare.h"
#include "batten/tests/catch.h"

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

/// n × n quads over [0, n]² at heights of a formula.
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

TEST_CASE("limits of a node do not depend on the number of rounds") {
  ShellMesh cage = cube();
  cage.points(7, 2) = 1.7;
  const ShellMesh a = catmull_clark(cage, {1}), b = catmull_clark(cage, {3});
  CHECK((a.points - b.points.topRows(a.node_count())).cwiseAbs().maxCoeff() < 1e-14);
  CHECK(b.face_count() == 6 * 4 * 16);
}

TEST_CASE("a regular part is a bicubic B-spline: cubics come back moved, planes as they are") {
  // The B-spline of control values f(i) is Σ f B = (f(-1) + 4 f(0) + f(1))/6 at a node: i² + 1/3 for i².
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

TEST_CASE("a cube's limit is closed and round, and sharp edges stay where they are") {
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
  sharp.creases = {{4, 5}, {5, 7}, {7, 6}, {6, 4}};
  const ShellMesh lid = catmull_clark(cube(), sharp);
  int on_top = 0;
  for (int v = 0; v < lid.node_count(); ++v) on_top += std::abs(lid.points(v, 2) - 1) < 1e-14;
  CHECK(on_top == 17 * 17);  // the face with its edges is a plane
}

TEST_CASE("cages and options that cannot be are refused") {
  CHECK_THROWS_WITH(catmull_clark(cube(), {0}), Contains("1 or more"));
  CHECK_THROWS_WITH(catmull_clark(cube(), {12}), Contains("4,000,000"));
  CHECK_THROWS_WITH(catmull_clark(cube(), {1, {{0, 7}}}), Contains("node 1 to 8 is no edge"));
}
