// SPDX-License-Identifier: MPL-2.0
// Intersecting shells: T-joints, crosses, parts that touch, one-sided sheets.
#include <algorithm>
#include <numbers>

#include "batten/core/geometry.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/selection.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

constexpr int kLong = 12, kWide = 8, kHigh = 4;

/// Walls that share a row of nodes along x at y = z = 0, each at its own angle about it, degrees.
ShellMesh star(const std::vector<double>& angles, const std::vector<int>& widths) {
  std::vector<Vec3> points;
  ShellMesh mesh;
  for (int i = 0; i <= kLong; ++i) points.emplace_back(i, 0, 0);
  for (size_t w = 0; w < angles.size(); ++w) {
    const double a = angles[w] * std::numbers::pi / 180;
    const auto first = static_cast<int>(points.size());
    for (int j = 1; j <= widths[w]; ++j)
      for (int i = 0; i <= kLong; ++i) points.emplace_back(i, j * std::cos(a), j * std::sin(a));
    const auto node = [&](int i, int j) { return j == 0 ? i : first + (j - 1) * (kLong + 1) + i; };
    for (int j = 0; j < widths[w]; ++j)
      for (int i = 0; i < kLong; ++i)
        mesh.add_face(
            std::vector<int>{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
  }
  mesh.points.resize(static_cast<long>(points.size()), 3);
  for (size_t v = 0; v < points.size(); ++v) mesh.points.row(static_cast<long>(v)) = points[v];
  return mesh;
}

/// A plate with a stiffener on its middle.
ShellMesh stiffened() { return star({0, 180, 90}, {kWide, kWide, kHigh}); }

ShellMesh moebius(int n) {
  ShellMesh mesh;
  mesh.points.resize(2 * n, 3);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    const Vec3 out(std::cos(a), std::sin(a), 0);
    const Vec3 across = std::cos(a / 2) * Vec3::UnitZ() + std::sin(a / 2) * out;
    mesh.points.row(2 * i) = 3 * out - across;
    mesh.points.row(2 * i + 1) = 3 * out + across;
  }
  for (int i = 0; i < n - 1; ++i)
    mesh.add_face(std::vector<int>{2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1});
  mesh.add_face(std::vector<int>{2 * n - 2, 1, 0, 2 * n - 1});
  return mesh;
}

double area_of(const TriangleMesh& mesh) {
  double area = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) area += mesh.area_vector(t).norm() / 2;
  return area;
}

/// Nodes beyond a plane x = const.
Selection end_of(const TriangleMesh& mesh, double x, bool above) {
  return vertices_beyond_plane(mesh, {x, 0, 0}, Vec3::UnitX() * (above ? 1 : -1));
}

Points moved(const TriangleMesh& mesh, const HandleTransform& move) {
  Points p(mesh.vertex_count(), 3);
  for (int v = 0; v < mesh.vertex_count(); ++v) p.row(v) = move(mesh.point(v)).transpose();
  return p;
}

}  // namespace

TEST_CASE("a skin goes on past its stiffener, which ends there", "[mesh][joints]") {
  const PreparedMesh ready = prepare(stiffened());
  const MeshTopology& t = ready.mesh.topology();
  CHECK(ready.diagnosis.non_manifold_edge_count == kLong);
  CHECK(ready.diagnosis.manifold_patches == 2);
  CHECK(ready.diagnosis.components == 1);
  CHECK(ready.diagnosis.non_manifold_node_count == 0);
  CHECK(t.node_count() == ready.mesh.points().rows() - (kLong + 1));
  CHECK(t.component_count() == 2);
  for (int v = t.node_count(); v < t.vertex_count(); ++v) {
    CHECK(ready.mesh.point(v) == ready.mesh.point(t.node_of(v)));
    CHECK(t.coincident_vertices(v).size() == 2);
    CHECK(t.component()[v] != t.component()[t.node_of(v)]);
  }
  CHECK(area_of(ready.mesh) == Approx(kLong * (2 * kWide + kHigh)));
  // The outline of the plate is a free edge; that of the stiffener runs along the plate.
  REQUIRE(t.boundary_loops().size() == 1);
  CHECK(t.boundary_loops()[0].size() == 2 * (kLong + 2 * kWide));
  CHECK(t.non_manifold_loops().size() == 1);
  CHECK(detect_features(ready.mesh).empty());
}

TEST_CASE("at a non-manifold edge all patches end that do not clearly continue", "[mesh][joints]") {
  const auto manifold_patches = [](const std::vector<double>& angles) {
    return prepare(star(angles, std::vector<int>(angles.size(), 2))).diagnosis.manifold_patches;
  };
  CHECK(manifold_patches({0, 120, 240}) == 3);
  CHECK(manifold_patches({0, 180, 90, 270}) == 2);  // both plates of a cross
  CHECK(manifold_patches({0, 180, 20, 340}) == 3);  // and two stiffeners
  CHECK(manifold_patches({0, 150, 240}) == 2);      // bends by 30°
  CHECK(manifold_patches({0, 130, 240}) == 3);      // by 50°
  CHECK(manifold_patches({0, 175, 185}) == 3);      // ambiguous continuation
  CHECK(manifold_patches({0, 90}) == 1);            // two faces are one manifold patch at any angle
}

TEST_CASE("parts that touch at a node are joined there", "[mesh][joints]") {
  ShellMesh mesh;
  mesh.points.resize(5, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0;
  mesh.add_face(std::vector<int>{0, 1, 2});
  mesh.add_face(std::vector<int>{0, 3, 4});
  const PreparedMesh ready = prepare(mesh);
  CHECK(ready.diagnosis.non_manifold_nodes == std::vector<int>{0});
  CHECK(ready.diagnosis.components == 1);
  CHECK(ready.diagnosis.manifold_patches == 2);
  CHECK(ready.mesh.vertex_count() == 6);
  CHECK(ready.mesh.topology().expand_to_nodes({0}) == std::vector<int>{0, 5});
  CHECK(ready.mesh.topology().nodes_of({5, 2}) == std::vector<int>{0, 2});
}

TEST_CASE("a one-sided patch is cut open, and deforms as one", "[mesh][joints]") {
  const PreparedMesh ready = prepare(moebius(24));
  CHECK(!ready.diagnosis.orientable);
  CHECK(ready.diagnosis.manifold_patches == 1);
  CHECK(ready.diagnosis.non_manifold_node_count == 0);
  const TriangleMesh& mesh = ready.mesh;
  CHECK(mesh.vertex_count() == mesh.topology().node_count() + 2);
  DeformProblem problem;
  problem.fixed = {10, 11};
  problem.handles = {{"grip", {30, 31}}};
  FormFeatureDeformer deformer(mesh, problem);
  HandleTransform move;
  move.translation = {0, 0, 1};
  const Points& p = deformer.deform({{move}, {}, {}, {}});
  for (int v = mesh.topology().node_count(); v < mesh.vertex_count(); ++v)
    CHECK(p.row(v) == p.row(mesh.topology().node_of(v)));
  CHECK(deformer.hard_residual() < 1e-14);
}

TEST_CASE("joined patches: rigid motions are reproduced, and joined vertices stay joined",
          "[mesh][joints]") {
  const PreparedMesh ready = prepare(stiffened());
  const TriangleMesh& mesh = ready.mesh;
  HandleTransform move;
  move.about = {3, 1, 0};
  move.rotation_vector = to_rotation_vector({1, 2, -1}, 2.5);
  move.translation = {1, -2, 3};
  DeformProblem problem;
  problem.handles = {{"left", end_of(mesh, 1, false)}, {"right", end_of(mesh, kLong - 1, true)}};
  problem.features = {{"middle of the stiffener", {}}};
  for (const int v : vertices_in_box(mesh, {5, -0.1, -0.1}, {7, 0.1, 9}))
    if (v < mesh.topology().node_count()) problem.features[0].vertices.push_back(v);
  FormFeatureDeformer deformer(mesh, problem);
  const Points rigid = deformer.deform({{move, move}, {}, {}, {}});
  CHECK((rigid - moved(mesh, move)).cwiseAbs().maxCoeff() < 1e-9);

  HandleTransform bent;
  bent.about = {kLong, 0, 0};
  bent.rotation_vector = to_rotation_vector({0, -1, 0}, 0.5);
  bent.translation = {-0.4, 0, 3};
  const Points p = deformer.deform({{HandleTransform{}, bent}, {}, {}, {}});
  deformer.correct();
  CHECK(deformer.hard_residual() < 1e-14);
  for (int v = mesh.topology().node_count(); v < mesh.vertex_count(); ++v)
    CHECK(p.row(v) == p.row(mesh.topology().node_of(v)));
  CHECK(fit_similarity(mesh.points(), p, problem.features[0].vertices).max_error < 1e-13);
  // The stiffener stays perpendicular to the plate: so do the normals along it.
  const auto row = [&](int i) {
    const auto place = [&](double y, double z) {
      return p.row(nearest_vertex(mesh, Vec3(i, y, z))).transpose().eval();
    };
    const Vec3 across = place(1, 0) - place(-1, 0), up = place(0, 1) - place(0, 0);
    return std::abs(across.normalized().dot(up.normalized()));
  };
  for (int i = 0; i <= kLong; ++i) CHECK(row(i) < 0.01);
}

TEST_CASE("a stretch passes joints as if they were not there", "[mesh][joints]") {
  // A plate with two ribs across it: the sheet behaves like a plate without ribs.
  const PreparedMesh ready = prepare(stiffened());
  const TriangleMesh& mesh = ready.mesh;
  DeformProblem problem;
  problem.fixed = vertices_beyond_plane(mesh, {0, 1 - kWide, 0}, -Vec3::UnitY());
  problem.handles = {{"edge", vertices_beyond_plane(mesh, {0, kWide - 1, 0}, Vec3::UnitY())}};
  HandleTransform move;
  move.translation = {0, 1, 0};
  FormFeatureDeformer deformer(mesh, problem);
  const Points p = deformer.deform({{move}, {}, {}, {}});
  const MeshTopology& t = mesh.topology();
  for (const auto& e : t.edges()) {
    const Vec3 before = mesh.point(e.high) - mesh.point(e.low);
    const Vec3 after = (p.row(e.high) - p.row(e.low)).transpose();
    if (std::abs(before.y()) == 1 && before.x() == 0)
      CHECK(after.norm() < 1.12);  // 1 / (2 · 7) on average
  }
}

TEST_CASE("distances and rings pass non-manifold edges", "[mesh][joints]") {
  const PreparedMesh ready = prepare(stiffened());
  const TriangleMesh& mesh = ready.mesh;
  const int source = nearest_vertex(mesh, {6, 5, 0});
  const VecX d = geodesic_distances(mesh, {source});
  // Straight up the stiffener, unfolded to the other side.
  CHECK(d[nearest_vertex(mesh, {6, 0, kHigh})] == Approx(5 + kHigh));
  CHECK(d[nearest_vertex(mesh, {6, -3, 0})] == Approx(8));
  const MeshTopology& t = mesh.topology();
  const Selection near = grown(t, {nearest_vertex(mesh, {6, 1, 0})}, 2);
  CHECK(std::binary_search(near.begin(), near.end(), nearest_vertex(mesh, {6, 0, 1})));
  CHECK(t.expand_to_nodes(near) == near);
}
