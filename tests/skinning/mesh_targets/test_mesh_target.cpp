// SPDX-License-Identifier: MPL-2.0
// Targets given by meshes and curved facets, and limits of control cages.
#include "batten/skinning/mesh_targets/mesh_target.h"

#include <array>
#include <cmath>
#include <numbers>

#include "batten/mesh/catmull_clark.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

/// The unit cube as six quads, with its corner nodes; `moved`: by this vector.
ShellMesh cube(const Vec3& moved = Vec3::Zero()) {
  ShellMesh mesh;
  mesh.points.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    mesh.points.row(i) = moved.transpose() + Vec3(i & 1, (i >> 1) & 1, i >> 2).transpose();
  for (const auto& f : {std::array{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}})
    mesh.add_face(f);
  return mesh;
}

/// The octahedron of radius 1 with its exact normals as curved triangles.
void append_octahedron(TargetFaces& faces, const std::vector<int>& part) {
  ShellMesh mesh;
  mesh.points.resize(6, 3);
  mesh.points << 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  std::vector<PnTriangle::Corners> normals;
  for (int i = 0; i < 4; ++i)
    for (const auto& f : {std::array{i, (i + 1) % 4, 4}, {(i + 1) % 4, i, 5}}) {
      mesh.add_face(f);
      PnTriangle::Corners& n = normals.emplace_back();
      for (size_t k = 0; k < 3; ++k) n[k] = mesh.points.row(f[k]);
    }
  faces.append(mesh, 1, normals, part);
}

}  // namespace

TEST_CASE("a mesh is one target, with a part for each patch between creases",
          "[skinning][target]") {
  TargetFaces faces;
  faces.append(cube(), 2);
  const TargetParts target = target_parts(faces);
  CHECK(target.parts.size() == 6);
  const auto found = target.whole->nearest({1, 0.7, 5}, Vec3::Zero());
  REQUIRE(found);
  CHECK((found->at - Vec3(1, 0.7, 2)).norm() < 1e-12);
  CHECK(found->normal.dot(Vec3::UnitZ()) == Approx(1));
  // Of the points with a normal along -z, the nearest is on the lower side.
  const auto below = target.whole->nearest({1, 0.7, 5}, -Vec3::UnitZ());
  REQUIRE(below);
  CHECK(below->at.z() == Approx(0).margin(1e-12));
  CHECK_FALSE(found->at_boundary);
}

TEST_CASE("samples are closer than 1/100 of the size, and on the target", "[skinning][target]") {
  TargetFaces faces;
  faces.append(cube(), 1);
  const auto samples = target_parts(faces).whole->samples();
  CHECK(samples.size() > 6 * 50 * 50);
  for (const auto& sample : samples) {
    const Vec3 p = sample.at.array() - 0.5;
    CHECK(p.cwiseAbs().maxCoeff() == Approx(0.5).epsilon(1e-12));
    CHECK(sample.normal.dot(p) > 0);
  }
}

TEST_CASE("a part with a boundary has a parametrization, a closed target has none",
          "[skinning][target]") {
  TargetFaces faces;
  faces.append(cube(), 1);
  const TargetParts target = target_parts(faces);
  const auto flat = [](const Vec3& p) { return Vec2(p.x(), p.y()); };
  CHECK_FALSE(target.whole->parametrize(flat));
  int on_z = 0;
  for (const auto& part : target.parts) {
    if (std::abs(part->samples().front().normal.z()) < 0.5) continue;
    ++on_z;
    const auto map = part->parametrize(flat);
    REQUIRE(map);
    const Vec3 p = map({0.25, 0.5});
    CHECK((Vec2(p.x(), p.y()) - Vec2(0.25, 0.5)).norm() < 1e-9);
  }
  CHECK(on_z == 2);
}

TEST_CASE("curved facets are nearer to the sphere than flat ones, and parts are CAD faces",
          "[skinning][target]") {
  TargetFaces faces;
  append_octahedron(faces, {0, 0, 0, 0, 1, 1, 1, 1});
  const TargetParts target = target_parts(faces);
  REQUIRE(target.parts.size() == 2);
  const Vec3 middle = Vec3::Ones().normalized();
  const auto curved = target.whole->nearest(3 * middle, Vec3::Zero());
  REQUIRE(curved);
  CHECK(curved->at.norm() == Approx(4 / std::sqrt(27)).epsilon(1e-9));  // flat: 1/√3
  TargetFaces two;
  append_octahedron(two, {0, 0, 0, 0, 1, 1, 1, 1});
  CHECK(two.next_part == 2);
  two.append(cube({5, 0, 0}), 1);
  CHECK(two.next_part == 2);
  CHECK(target_parts(two).parts.size() == 8);
}

TEST_CASE("degenerate curved facets are left out", "[skinning][target]") {
  ShellMesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0;
  mesh.add_face(std::array{0, 1, 2});
  mesh.add_face(std::array{0, 1, 3});
  const PnTriangle::Corners up = {Vec3::UnitZ(), Vec3::UnitZ(), Vec3::UnitZ()};
  TargetFaces faces;
  faces.append(mesh, 1, {up, up}, {0, 1});
  CHECK(faces.shells.face_count() == 1);
  CHECK(faces.part == std::vector<int>{0});
}

TEST_CASE("the limit of a cage is as fine as its chord requires", "[skinning][target]") {
  const ShellMesh coarse = catmull_clark_limit(cube(), {}, 0.05),
                  fine = catmull_clark_limit(cube(), {}, 1e-3);
  CHECK(coarse.face_count() < fine.face_count());
  // Nodes are on the limit surface whatever the number of subdivisions.
  for (int i = 0; i < 8; ++i) CHECK((coarse.points.row(i) - fine.points.row(i)).norm() < 1e-12);
  CHECK(catmull_clark_limit(cube(), {}, 1e-12).face_count() <= 200'000);
}
