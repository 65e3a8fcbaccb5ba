// SPDX-License-Identifier: MPL-2.0
// Selections by position, by neighbourhood and by distance along the surface.
#include "batten/mesh/selection.h"

#include <algorithm>
#include <cmath>

#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sample_meshes.h"

using namespace batten_test;

namespace {

double flat_distance(const TriangleMesh& mesh, int a, int b) {
  return (mesh.point(a) - mesh.point(b)).norm();
}

/// Largest deviation of the distances from Euclidean ones: zero on flat convex meshes.
double flat_error(const TriangleMesh& mesh, int source) {
  const VecX d = geodesic_distances(mesh, {source});
  double error = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    error = std::max(error, std::abs(d[v] - flat_distance(mesh, v, source)));
  return error;
}

template <class Map>
TriangleMesh mapped(const TriangleMesh& mesh, const Map& map) {
  Points p = mesh.points();
  for (int v = 0; v < mesh.vertex_count(); ++v) p.row(v) = map(mesh.point(v)).transpose();
  return mesh.with_points(p);
}

/// Sphere: largest error of the distance from `source`, up to the given angle.
double sphere_error(const TriangleMesh& mesh, int source, double up_to) {
  const VecX d = geodesic_distances(mesh, {source});
  double error = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = mesh.point(v), s = mesh.point(source);
    const double exact = std::atan2(p.cross(s).norm(), p.dot(s));
    if (exact <= up_to) error = std::max(error, std::abs(d[v] - exact));
  }
  return error;
}

}  // namespace

TEST_CASE("selections by position contain what lies there and nothing else", "[mesh][selection]") {
  const TriangleMesh mesh = flat_square(10, 0, 1);  // spacing 0.1, 11 vertices per row
  CHECK(vertices_in_box(mesh, Vec3(0, 0, 0), Vec3(0.31, 0.01, 0)) == Selection{0, 1, 2, 3});
  CHECK(vertices_in_box(mesh, Vec3(0, 0, 0.1), Vec3(1, 1, 1)).empty());
  CHECK(vertices_in_sphere(mesh, Vec3(0.5, 0.5, 0), 0.101) == Selection{49, 59, 60, 61, 71});
  CHECK(vertices_beyond_plane(mesh, Vec3(0, 0.95, 0), Vec3(0, 7, 0)).front() == 110);
  CHECK(vertices_beyond_plane(mesh, Vec3(0, 0.95, 0), Vec3(0, 7, 0)).size() == 11);
  CHECK(vertices_beyond_plane(mesh, Vec3(0.75, 0, 0), Vec3(-2, 0, 0), 0.2).size() == 22);
  CHECK(nearest_vertex(mesh, Vec3(0.52, 0.48, 5)) == 60);
  CHECK(error_message([&] {
          vertices_beyond_plane(mesh, Vec3(0, 0, 0), Vec3(0, 0, 0));
        }).find("normal of the plane has length 0") != std::string::npos);

  SECTION("vertices without triangles are not there") {
    Points p(mesh.vertex_count() + 1, 3);
    p << mesh.points(), Eigen::RowVector3d(0.52, 0.48, 0);
    const TriangleMesh more(p, mesh.triangles());
    CHECK(vertices_in_box(more, Vec3(0, 0, 0), Vec3(1, 1, 0)).size() == 121);
    CHECK(nearest_vertex(more, Vec3(0.52, 0.48, 0)) == 60);
    CHECK(std::isinf(geodesic_distances(more, {0})[121]));
  }
}

TEST_CASE("rings, borders and sets", "[mesh][selection]") {
  const TriangleMesh mesh = flat_square(10, 0, 1);
  const MeshTopology& topology = mesh.topology();
  CHECK(grown(topology, {60, 60}, 0) == Selection{60});
  Selection ring = {60};
  for (const int j : topology.neighbours(60)) ring.push_back(j);
  std::sort(ring.begin(), ring.end());
  CHECK(grown(topology, {60}, 1) == ring);
  CHECK(grown(topology, {60}, 2) == grown(topology, ring, 1));
  CHECK(grown(topology, {60}, 100).size() == 121);

  const Selection square = vertices_in_box(mesh, Vec3(0.25, 0.25, 0), Vec3(0.75, 0.75, 0));
  Selection inner = vertices_in_box(mesh, Vec3(0.35, 0.35, 0), Vec3(0.65, 0.65, 0));
  CHECK(border(topology, square) == difference_of(square, inner));
  CHECK(border(topology, grown(topology, {60}, 100)).empty());
  CHECK(union_of(inner, border(topology, square)) == square);
  CHECK(intersection_of(square, inner) == inner);

  const std::vector<int> triangles = triangles_touching(topology, {60});
  CHECK(triangles ==
        std::vector<int>(topology.triangles_of(60).begin(), topology.triangles_of(60).end()));
  CHECK(vertices_of_triangles(topology, triangles) == ring);
  CHECK(error_message([&] {
          grown(topology, {3, 121}, 1);
        }) == "found vertex 121, expected 0 to 120");
  CHECK(error_message([&] { vertices_of_triangles(topology, {-1}); }) ==
        "found triangle -1, expected 0 to 199");
}

TEST_CASE("distances are exact on flat meshes", "[mesh][selection]") {
  for (const double jitter : {0.0, 0.24})  // angles up to almost 180 degrees
    for (const int n : {4, 15, 60}) {
      const TriangleMesh mesh = flat_square(n, jitter, 3);
      CHECK(flat_error(mesh, 0) < 1e-13);
      CHECK(flat_error(mesh, (n / 2) * (n + 1) + n / 3) < 1e-13);
    }
}

TEST_CASE("meshes of nothing but slivers cost a fraction of an edge, and no time",
          "[mesh][selection]") {
  const int n = 60;
  for (const double shear : {0.0, 1.0, 4.0})
    for (const double width : {1.0, 0.1, 0.01}) {
      const TriangleMesh mesh = mapped(flat_square(n, 0.24, 3), [&](const Vec3& p) {
        return Vec3(p.x() + shear * p.y(), width * p.y(), 0);
      });
      double longest = 0;
      for (const auto& e : mesh.topology().edges())
        longest = std::max(longest, flat_distance(mesh, e.low, e.high));
      CHECK(flat_error(mesh, 0) < 0.3 * longest);
      CHECK(flat_error(mesh, (n / 2) * (n + 1) + n / 3) < 0.3 * longest);
    }
}

TEST_CASE("bending without stretching keeps distances", "[mesh][selection]") {
  const int n = 20;
  const TriangleMesh flat = flat_square(n, 0, 5);
  // Fan folds along every fourth line of edges.
  const TriangleMesh folded = mapped(flat, [](const Vec3& p) {
    const double at = 5 * p.y(), piece = std::floor(at), rest = at - piece;
    const double up = static_cast<int>(piece) % 2 == 0 ? rest : 1 - rest;
    return Vec3(p.x(), 0.2 * at * std::cos(1.0), 0.2 * up * std::sin(1.0));
  });
  for (const int source : {0, n / 2, 7 * (n + 1) + 3}) {
    const VecX before = geodesic_distances(flat, {source}),
               after = geodesic_distances(folded, {source});
    CHECK((before - after).cwiseAbs().maxCoeff() < 1e-13);
  }
}

TEST_CASE("distances on a sphere are arcs, to first order", "[mesh][selection]") {
  for (const int source : {0, 20}) {
    double last = 0;
    for (int level = 2; level <= 5; ++level) {
      const TriangleMesh mesh = sphere(level);
      const double h = 1.1 / (1 << level);
      const double quarter = sphere_error(mesh, source, 1.6), whole = sphere_error(mesh, source, 4);
      CHECK(quarter < 0.1 * h);
      CHECK(whole < 0.8 * h);
      if (last > 0) CHECK(quarter < 0.6 * last);
      last = quarter;
    }
  }
}

TEST_CASE("a row of sources is a curve", "[mesh][selection]") {
  const int n = 30;
  const TriangleMesh mesh = flat_square(n, 0.24, 9);
  std::vector<int> row;
  for (int i = 0; i <= n; ++i) row.push_back(i);
  const VecX d = geodesic_distances(mesh, row);
  CHECK((d - mesh.points().col(1)).cwiseAbs().maxCoeff() < 1e-12);

  // Around a hole: the distance from its edge, up to a fraction of the spacing.
  for (const int steps : {32, 64}) {
    const double h = 2 * std::numbers::pi / steps;
    const TriangleMesh ring = revolved_profile(subdivided({{4, 0}, {1, 0}}, 2 * h), steps);
    std::vector<int> rim;
    for (int i = 0; i < steps; ++i) rim.push_back(ring.vertex_count() - steps + i);
    const VecX from_rim = geodesic_distances(ring, rim);
    for (int v = 0; v < ring.vertex_count(); ++v)
      CHECK(std::abs(from_rim[v] - (ring.point(v).norm() - 1)) < 0.2 * h);
  }
}

TEST_CASE("several sources: the nearest one counts", "[mesh][selection]") {
  const int n = 40, a = 10 * (n + 1) + 10, b = 30 * (n + 1) + 20;
  const TriangleMesh mesh = flat_square(n, 0.24, 11);
  const VecX both = geodesic_distances(mesh, {b, a, b});
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double exact = std::min(flat_distance(mesh, v, a), flat_distance(mesh, v, b));
    CHECK(std::abs(both[v] - exact) < 0.5 / n);
  }
  CHECK(both[a] == 0);
  CHECK(both[b] == 0);
}

TEST_CASE("distances stop at their limit, and at the end of a part", "[mesh][selection]") {
  const TriangleMesh one = flat_square(20, 0.24, 13), mesh = disjoint_union(one, sphere(2));
  const VecX all = geodesic_distances(mesh, {5}), near = geodesic_distances(mesh, {5}, 0.4);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    CHECK(std::isfinite(all[v]) == (v < one.vertex_count()));
    CHECK(near[v] == (all[v] <= 0.4 ? all[v] : std::numeric_limits<double>::infinity()));
  }
  const Selection within = vertices_within(mesh, {5}, 0.4);
  for (int v = 0; v < one.vertex_count(); ++v) {
    const double d = flat_distance(mesh, v, 5);
    if (std::abs(d - 0.4) > 1e-12)
      CHECK(std::binary_search(within.begin(), within.end(), v) == (d < 0.4));
  }
  CHECK(error_message([&] { geodesic_distances(mesh, {}); }).find("source") != std::string::npos);
  CHECK(error_message([&] { geodesic_distances(mesh, {100000}); }).find("100000") !=
        std::string::npos);
}

TEST_CASE("distances are one number each way and never longer than along edges",
          "[mesh][selection]") {
  const TriangleMesh mesh = sphere(3);
  const VecX from = geodesic_distances(mesh, {17});
  for (const auto& e : mesh.topology().edges())
    CHECK(std::abs(from[e.low] - from[e.high]) <= (1 + 1e-9) * flat_distance(mesh, e.low, e.high));
  for (const int v : {0, 100, 300})
    CHECK(geodesic_distances(mesh, {v})[17] == Approx(from[v]).epsilon(0.02));
}
