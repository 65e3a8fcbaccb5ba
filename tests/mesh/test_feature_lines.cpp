// SPDX-License-Identifier: MPL-2.0
// Creases and free edges of meshes as curves.
#include "batten/mesh/features/feature_lines.h"

#include <cmath>
#include <numbers>
#include <set>

#include "batten/core/errors.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

/// A prism with n sides around z, with its lower cap and, if `lid`, its upper cap.
TriangleMesh prism(int n, bool lid) {
  ShellMesh mesh;
  mesh.points.resize(2 * n, 3);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    mesh.points.row(i) << std::cos(a), std::sin(a), 0;
    mesh.points.row(n + i) << std::cos(a), std::sin(a), 1;
  }
  std::vector<int> low, high;
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.add_face(std::array{i, j, n + j, n + i});
    low.insert(low.begin(), i);
    high.push_back(n + i);
  }
  mesh.add_face(low);
  if (lid) mesh.add_face(high);
  return prepare(mesh).mesh;
}

}  // namespace

TEST_CASE("a box has twelve creases between its corners", "[mesh][features]") {
  const TriangleMesh box = prism(4, true);
  const auto [lines, patches] = feature_lines(box);
  REQUIRE(lines.size() == 12);
  std::set<std::pair<int, int>> ends;
  for (const FeatureLine& line : lines) {
    CHECK(line.vertices.size() == 2);
    CHECK_FALSE(line.closed);
    CHECK(line.kind == FeatureLine::Kind::Crease);
    ends.insert(std::minmax(line.vertices.front(), line.vertices.back()));
  }
  CHECK(ends.size() == 12);
  REQUIRE(patches.size() == 6);
  for (const FeaturePatch& patch : patches) {
    CHECK(patch.flat);
    REQUIRE(patch.loops.size() == 1);
    CHECK(std::set<int>(patch.loops[0].begin(), patch.loops[0].end()).size() == 4);
    CHECK(patch.inner.empty());
  }
}

TEST_CASE("a cup has one closed crease and one closed free edge", "[mesh][features]") {
  const auto [lines, patches] = feature_lines(prism(40, false));
  REQUIRE(lines.size() == 2);
  for (const FeatureLine& line : lines) {
    CHECK(line.closed);
    CHECK(std::set<int>(line.vertices.begin(), line.vertices.end()).size() == 40);
    CHECK(line.vertices.size() == 40);
  }
  CHECK(lines[0].kind != lines[1].kind);
  REQUIRE(patches.size() == 2);  // the wall and the lid
  for (const FeaturePatch& patch : patches) CHECK(patch.loops.size() == (patch.flat ? 1 : 2));
}

TEST_CASE("short creases that end in the open are noise, long ones are not", "[mesh][features]") {
  // A plane with a small tent along one of its edges.
  ShellMesh mesh;
  const auto add = [&](double length) {
    mesh = {};
    mesh.points.resize(6, 3);
    mesh.points << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, -length / 2, 0, 0.5 * length, length / 2,
        0, 0.5 * length;
    for (const auto& f : std::vector<std::array<int, 3>>{
             {0, 1, 5}, {0, 5, 4}, {1, 2, 5}, {2, 3, 4}, {2, 4, 5}, {3, 0, 4}})
      mesh.add_face(f);
    int creases = 0;
    for (const FeatureLine& line : feature_lines(prepare(mesh).mesh).lines)
      creases += line.kind == FeatureLine::Kind::Crease;
    return creases;
  };
  CHECK(add(0.01) == 0);
  CHECK(add(1) > 0);
}

TEST_CASE("angles of feature lines are between 0 and 180", "[mesh][features]") {
  FeatureLineOptions options;
  options.crease_degrees = 0;
  CHECK_THROWS_WITH(feature_lines(prism(4, true), options), Contains("crease angle"));
}

TEST_CASE("paths follow creases and close", "[mesh][features]") {
  const TriangleMesh box = prism(4, true);
  CHECK(crease_path(box, {0, 1}) == std::vector<int>{0, 1});
  CHECK(crease_path(box, {0}) == std::vector<int>{0});
  // Along two creases, although a diagonal in the flat side or cap may be shorter.
  for (const int goal : {2, 5}) {
    const std::vector<int> path = crease_path(box, {0, goal});
    REQUIRE(path.size() == 3);
    CHECK(path.front() == 0);
    CHECK(path.back() == goal);
  }
  CHECK(crease_path(box, {0, 1, 2, 3}, true) == std::vector<int>{0, 1, 2, 3});
  CHECK_THROWS_WITH(crease_path(box, {0, 8}), Contains("found vertex 8"));
  ShellMesh two;
  two.points.resize(6, 3);
  two.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0;
  two.add_face(std::array{0, 1, 2});
  two.add_face(std::array{3, 4, 5});
  CHECK_THROWS_WITH(crease_path(prepare(two).mesh, {0, 3}), Contains("not connected"));
}
