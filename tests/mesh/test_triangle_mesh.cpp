// SPDX-License-Identifier: MPL-2.0
// Topology, preprocessing and operators of triangle meshes.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "batten/core/eigen.h"
#include "batten/mesh/differential_operators.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/mesh_models.h"
#include "batten/tests/support/sampling.h"

using namespace batten;
using namespace batten_test;

namespace {

ShellMesh shells_of(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& faces) {
  ShellMesh shells;
  shells.points.resize(static_cast<long>(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i) shells.points.row(static_cast<long>(i)) = points[i];
  for (const auto& f : faces) shells.add_face(f);
  return shells;
}

/// An octahedron refined n times onto the unit sphere.
TriangleMesh sphere(int times) {
  std::vector<Vec3> points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<int, 3>> triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                               {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int k = 0; k < times; ++k) {
    std::map<std::pair<int, int>, int> middle;
    const auto half = [&](int a, int b) {
      const auto [it, added] = middle.emplace(std::pair(std::min(a, b), std::max(a, b)),
                                              static_cast<int>(points.size()));
      if (added) points.push_back((points[a] + points[b]).normalized());
      return it->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const int ab = half(a, b), bc = half(b, c), ca = half(c, a);
      for (const auto& t : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
        finer.push_back(t);
    }
    triangles = std::move(finer);
  }
  Points p(static_cast<long>(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i) p.row(static_cast<long>(i)) = points[i];
  return TriangleMesh(p, triangles);
}

double total_area(const TriangleMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) sum += mesh.area_vector(t).norm() / 2;
  return sum;
}

MatX full(const SparseMatrix& lower) {
  return lower.selfadjointView<Eigen::Lower>() * MatX::Identity(lower.rows(), lower.rows());
}

const std::vector<Vec3> kSquare = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};

}  // namespace

TEST_CASE("topology: edges, fans, loops and parts count up", "[mesh][triangle_mesh]") {
  const MeshModel model = plate_with_holes();
  const TriangleMesh mesh = prepare(model.shells).mesh;
  const MeshTopology& t = mesh.topology();
  // Euler characteristic of a disc with five holes.
  CHECK(mesh.vertex_count() - static_cast<int>(t.edges().size()) + mesh.triangle_count() == 1 - 5);
  CHECK(t.component_count() == 1);
  REQUIRE(t.boundary_loops().size() == 6);
  int on_loops = 0;
  for (const auto& loop : t.boundary_loops()) {
    CHECK(loop[0] == *std::min_element(loop.begin(), loop.end()));
    // The surface is on the left: with the plate's normal up, holes run clockwise.
    double turning = 0;
    for (size_t i = 0; i < loop.size(); ++i) {
      CHECK(t.on_boundary(loop[i]));
      const Vec3 a = mesh.point(loop[i]), b = mesh.point(loop[(i + 1) % loop.size()]);
      turning += a.x() * b.y() - a.y() * b.x();
    }
    CHECK((turning > 0) == (mesh.length(loop) > 1000));
    on_loops += static_cast<int>(loop.size());
  }
  int boundary = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    boundary += t.on_boundary(v);
    const auto ring = t.neighbours(v);
    CHECK(std::is_sorted(ring.begin(), ring.end()));
    CHECK(ring.size() == t.triangles_of(v).size() + (t.on_boundary(v) ? 1 : 0));
    for (const int u : ring) {
      const auto back = t.neighbours(u);
      CHECK(std::binary_search(back.begin(), back.end(), v));
    }
  }
  CHECK(boundary == on_loops);
  for (int i = 0; i < mesh.triangle_count(); ++i)
    for (int c = 0; c < 3; ++c)
      if (const int other = t.across(i, c); other >= 0) {
        bool back = false;
        for (int d = 0; d < 3; ++d) back = back || t.across(other, d) == i;
        CHECK(back);
      }
}

TEST_CASE("meshes that are no oriented manifold are refused with the position",
          "[mesh][triangle_mesh]") {
  using Triangles = std::vector<std::array<int, 3>>;
  const auto why = [](int n, const Triangles& t) {
    return error_message([&] { MeshTopology(n, t); });
  };
  CHECK(why(3, {{0, 1, 3}}).find("uses vertex 3, but there are 3 vertices") != std::string::npos);
  CHECK(why(3, {{0, 1, -1}}).find("uses vertex -1, but there are 3 vertices") != std::string::npos);
  CHECK(why(3, {{0, 1, 1}}).find("has vertex 1 twice") != std::string::npos);
  CHECK(why(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}).find("has 3 triangles") != std::string::npos);
  CHECK(why(4, {{0, 1, 2}, {0, 1, 3}}).find("have opposite orientations") != std::string::npos);
  CHECK(why(5, {{0, 1, 2}, {0, 3, 4}}).find("vertex 0 is non-manifold") != std::string::npos);
  CHECK(why(0, {}).empty());
  Points nan = Points::Zero(3, 3);
  nan(1, 2) = NAN;
  CHECK(error_message([&] {
          TriangleMesh(nan, {{0, 1, 2}});
        }).find("vertex 1") != std::string::npos);
}

TEST_CASE("preparation splits elements and repairs what is safe", "[mesh][triangle_mesh]") {
  // Quads are split along the shorter diagonal, equal ones along 13.
  const auto triangles = [](const ShellMesh& s) { return prepare(s).mesh.triangles(); };
  using Triangles = std::vector<std::array<int, 3>>;
  CHECK(triangles(shells_of(kSquare, {{0, 1, 2, 3}})) == Triangles{{0, 1, 2}, {0, 2, 3}});
  CHECK(triangles(shells_of({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {0.5, 0.5, 0}}, {{0, 1, 2, 3}})) ==
        Triangles{{0, 1, 3}, {1, 2, 3}});
  // A quad with a repeated last node is a triangle.
  CHECK(triangles(shells_of(kSquare, {{0, 1, 2, 2}})) == Triangles{{0, 1, 2}});
  // A concave polygon: no triangle outside, and the area is exact.
  const ShellMesh arrow =
      shells_of({{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {2, 0.5, 0}, {0, 3, 0}}, {{0, 1, 2, 3, 4}});
  CHECK(total_area(prepare(arrow).mesh) == Approx(7));
  // The best ear, an equilateral triangle, contains the tip of a spike that extends into the
  // polygon.
  const ShellMesh spiked = shells_of(
      {{0, 0, 0}, {4.9, 0, 0}, {5, 6, 0}, {5.1, 0, 0}, {10, 0, 0}, {5, 5 * std::sqrt(3.0), 0}},
      {{0, 1, 2, 3, 4, 5}});
  CHECK(total_area(prepare(spiked).mesh) == Approx(25 * std::sqrt(3.0) - 0.6));
  // Second order: four triangles for six nodes, six for eight.
  ShellMesh s6 = shells_of({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {});
  s6.add_face(std::vector<int>{0, 1, 2, 3, 4, 5}, true);
  CHECK(prepare(s6).mesh.triangle_count() == 4);
  CHECK(total_area(prepare(s6).mesh) == Approx(2));

  // Reversed, duplicate and collapsed faces, a node without a face, two coincident nodes.
  std::vector<Vec3> points = kSquare;
  points.insert(points.end(), {{4, 0, 0}, {4, 1, 0}, {9, 9, 9}, {0, 0, 0}, {-1, 0, 0}, {-1, 1, 0}});
  const ShellMesh dirty =
      shells_of(points, {{0, 1, 2, 3}, {2, 5, 4, 1}, {1, 2, 3, 0}, {1, 2, 2, 1}, {7, 8, 9}});
  ShellMesh turned = dirty;
  turned.add_face(std::vector<int>{5, 4, 1, 2});
  const PreparedMesh ready = prepare(turned);
  CHECK(ready.diagnosis.flipped_faces == 1);
  CHECK(ready.diagnosis.duplicate_faces == 2);
  CHECK(ready.diagnosis.collapsed_faces == 1);
  CHECK(ready.diagnosis.unused_nodes == 1);
  CHECK(ready.diagnosis.coincident_nodes == 1);
  const PreparedMesh two = prepare(shells_of(points, {{0, 1, 2, 3}, {1, 2, 5, 4}}));
  CHECK(two.diagnosis.flipped_faces == 1);
  CHECK(two.mesh.area_vector(2).z() > 0);
  CHECK(two.face_of_triangle == std::vector<int>{0, 0, 1, 1});
  CHECK(!two.notes.empty());
  // The orientation of the second quad is that of its triangles, whatever its diagonal.
  const auto polygons = polygons_of(two);
  REQUIRE(polygons.size() == 2);
  CHECK(polygons[0] == std::vector<int>{0, 1, 2, 3});
  CHECK(polygons[1] == std::vector<int>{1, 4, 5, 2});
}

TEST_CASE("preparation refuses what it cannot repair, with the position", "[mesh][triangle_mesh]") {
  const auto why = [](const ShellMesh& shells) {
    return error_message([&] { prepare(shells, [](int v) { return "N" + std::to_string(v); }); });
  };
  const std::vector<Vec3> points = {{0, 0, 0},  {1, 0, 0}, {0, 1, 0},
                                    {0, -1, 0}, {0, 0, 1}, {2, 0, 0}};
  CHECK(why(shells_of(points, {})).find("no faces") != std::string::npos);
  CHECK(why(shells_of(points, {{0, 1, 5}})).find("without area") != std::string::npos);
  CHECK(why(shells_of(points, {{0, 1, 7}})).find("found node 7, expected 0 to 5") !=
        std::string::npos);
  CHECK(why(shells_of(points, {{0, 1, 1}})).find("fewer than three") != std::string::npos);
  ShellMesh nan = shells_of(points, {{0, 1, 2}});
  nan.points(2, 1) = INFINITY;
  CHECK(why(nan).find("node N2") != std::string::npos);
  nan.points(2, 1) = 1;
  nan.points(5, 1) = NAN;  // not in a face: checked only by the mesh
  CHECK(why(nan).find("not finite") != std::string::npos);
}

TEST_CASE("the Laplacian: linear functions cost nothing inside, its energy is that of the plane",
          "[mesh][triangle_mesh]") {
  const TriangleMesh mesh = prepare(plate_with_holes().shells).mesh;
  const SparseMatrix L = cotangent_laplacian(mesh);
  const VecX f = mesh.points() * Vec3(0.3, -1.2, 5) + VecX::Constant(mesh.vertex_count(), 2.0);
  const VecX Lf = L.selfadjointView<Eigen::Lower>() * f;
  const double scale = f.cwiseAbs().maxCoeff();
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (!mesh.topology().on_boundary(v)) CHECK(std::abs(Lf[v]) < 1e-12 * scale);
  CHECK(f.dot(Lf) == Approx((0.09 + 1.44) * total_area(mesh)).epsilon(1e-12));
  CHECK((L * VecX::Zero(mesh.vertex_count())).norm() == 0);
  const MatX dense = full(cotangent_laplacian(sphere(2)));
  CHECK((dense * VecX::Ones(dense.rows())).cwiseAbs().maxCoeff() < 1e-13);
  CHECK(symmetric_eigenvalues(dense)[0] > -1e-13);
}

TEST_CASE("mixed areas sum to the area, obtuse triangles or not, and spheres have curvature 1/R",
          "[mesh][triangle_mesh]") {
  Random random(4);
  for (int trial = 0; trial < 20; ++trial) {
    Points p(5, 3);
    for (long i = 0; i < 5; ++i) p.row(i) << random(), random(), random();
    const TriangleMesh fan(p, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
    CHECK(mixed_areas(fan).sum() == Approx(total_area(fan)));
    CHECK(mixed_areas(fan).minCoeff() > 0);
  }
  // One obtuse triangle: a half at the obtuse corner, quarters elsewhere. One right triangle: the
  // circumcentre is the middle of the hypotenuse, the right corner has half.
  for (const double x : {-0.5, 0.0}) {
    Points p(3, 3);
    p << 0, 0, 0, 1, 0, 0, x, 1, 0;
    const VecX a = mixed_areas(TriangleMesh(p, {{0, 1, 2}}));
    CHECK(a[0] == Approx(0.25));
    CHECK(a[1] == Approx(0.125));
    CHECK(a[2] == Approx(0.125));
  }
  double last = 1;
  for (const int times : {3, 4, 5}) {
    const TriangleMesh mesh = sphere(times);
    const VecX area = mixed_areas(mesh);
    const Points Lp =
        Points(cotangent_laplacian(mesh).selfadjointView<Eigen::Lower>() * mesh.points());
    double worst = 0;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Vec3 delta = Lp.row(v).transpose() / (2 * area[v]);
      worst = std::max(worst, (delta - mesh.point(v)).norm());  // κ n = p/R², R = 1
    }
    CHECK(worst < last);
    last = worst;
  }
  CHECK(last < 0.02);
}
