// SPDX-License-Identifier: MPL-2.0
// Boundary loops of meshes with the surface beside them.
#include <algorithm>
#include <cmath>
#include <random>

#include "batten/core/geometry.h"
#include "batten/mesh/features/mesh_boundary.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_meshes.h"

using namespace batten;
using namespace batten_test;

namespace mesh_boundary_tests {

// The unit sphere without the triangles whose centre has z > `height`.
TriangleMesh open_sphere(int levels, double height, double noise = 0) {
  const TriangleMesh whole = sphere(levels);
  std::vector<std::array<int, 3>> rest;
  for (int t = 0; t < whole.triangle_count(); ++t) {
    const auto& corners = whole.triangles()[t];
    const Vec3 sum = whole.point(corners[0]) + whole.point(corners[1]) + whole.point(corners[2]);
    if (sum.z() / 3 < height) rest.push_back(corners);
  }
  Points points = whole.points();
  std::mt19937 random(5);
  std::normal_distribution<double> offset(0, noise > 0 ? noise : 1);
  if (noise > 0)
    for (int v = 0; v < points.rows(); ++v)
      for (int c = 0; c < 3; ++c) points(v, c) += offset(random);
  return TriangleMesh(points, rest);
}

struct Errors {
  double normal = 0, curvature = 0;
};

Errors errors_of(const MeshBoundary& boundary) {
  Errors worst;
  for (size_t i = 0; i < boundary.vertices.size(); ++i) {
    const Vec3 n = boundary.points[i].normalized();
    worst.normal = std::max(worst.normal, (boundary.normals[i] - n).norm());
    const Mat3 expected = -(Mat3::Identity() - n * n.transpose());
    worst.curvature =
        std::max(worst.curvature, (boundary.curvatures[i] - expected).cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace mesh_boundary_tests

using namespace mesh_boundary_tests;

TEST_CASE("normals and curvatures beside a hole converge to those of the surface",
          "[mesh][boundary]") {
  Errors before;
  for (const int levels : {4, 5, 6}) {
    const auto loops = mesh_boundaries(open_sphere(levels, 0.85));
    REQUIRE(loops.size() == 1);
    const Errors now = errors_of(loops[0]);
    INFO(levels << ": " << now.normal << ", " << now.curvature);
    if (levels > 4) {
      CHECK(now.normal < 0.4 * before.normal);  // second order or better: 1/4
      CHECK(now.curvature < 0.75 * before.curvature);
    }
    before = now;
  }
  CHECK(before.normal < 1e-3);
  CHECK(before.curvature < 0.05);
}

TEST_CASE("the turning of a hole is that of Gauss and Bonnet", "[mesh][boundary]") {
  // 360 degrees times the Euler characteristic 1, minus the angular defects of the inner vertices.
  for (const double height : {-0.5, 0.2, 0.85}) {
    const TriangleMesh mesh = open_sphere(4, height);
    const auto loops = mesh_boundaries(mesh);
    REQUIRE(loops.size() == 1);
    std::vector<double> angles(static_cast<size_t>(mesh.points().rows()), 0.0);
    for (const auto& t : mesh.triangles())
      for (size_t c = 0; c < 3; ++c)
        angles[t[c]] += degrees_between(mesh.point(t[(c + 1) % 3]) - mesh.point(t[c]),
                                        mesh.point(t[(c + 2) % 3]) - mesh.point(t[c]));
    double defects = 0;
    for (size_t v = 0; v < angles.size(); ++v)
      if (angles[v] > 0 && !std::count(loops[0].vertices.begin(), loops[0].vertices.end(), v))
        defects += 360 - angles[v];
    CHECK(loops[0].turning_deg == Approx(360 - defects).margin(1e-6));
    CHECK(loops[0].length == Approx(mesh.length(loops[0].vertices)));
  }
}

TEST_CASE("noise is averaged over more vertices", "[mesh][boundary]") {
  constexpr double noise = 1e-3;
  const auto smooth = mesh_boundaries(open_sphere(5, 0.85)),
             noisy = mesh_boundaries(open_sphere(5, 0.85, noise));
  REQUIRE(noisy.size() == 1);
  CHECK(smooth[0].noise < 1e-4);
  CHECK(noisy[0].noise == Approx(noise).epsilon(0.3));
  // Triangles of edges 0.035 alone have an error of about noise / 0.035.
  CHECK(errors_of(noisy[0]).normal < 0.015);
}

TEST_CASE("creases and planes beside a boundary keep their own normals", "[mesh][boundary]") {
  // Two walls at a right angle.
  constexpr int n = 8;
  Points points((n + 1) * (2 * n + 1), 3);
  std::vector<std::array<int, 3>> triangles;
  const auto at = [](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j <= 2 * n; ++j)
    for (int i = 0; i <= n; ++i)
      points.row(at(i, j)) = Eigen::RowVector3d(i, std::min(j, n), std::max(j - n, 0));
  for (int j = 0; j < 2 * n; ++j)
    for (int i = 0; i < n; ++i) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  const TriangleMesh mesh(points, triangles);
  const auto loops = mesh_boundaries(mesh);
  REQUIRE(loops.size() == 1);
  for (size_t i = 0; i < loops[0].vertices.size(); ++i) {
    const Vec3 x = mesh.point(loops[0].vertices[i]);
    if (x.z() < 1e-9 && x.y() > n - 1e-9) continue;  // on the crease
    const Vec3 expected = x.z() > 1e-9 ? Vec3(0, -1, 0) : Vec3(0, 0, 1);
    CHECK((loops[0].normals[i] - expected).norm() < 1e-9);
    CHECK(loops[0].curvatures[i].norm() < 1e-9);
  }
}
