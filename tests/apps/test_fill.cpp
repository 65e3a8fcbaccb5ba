// SPDX-License-Identifier: MPL-2.0
// batten fill and [[neighbour]]: faces that continue those of a CAD file.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_meshes.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace fill_tests {

// A ring around the z axis between circles of the radii `low` at z = 0 and `high` at z = `height`.
std::string ring(double low, double high, double height) {
  const auto circle = [](const std::string& name, double radius, double z) {
    return "[[curve]]\nname = \"" + name + "\"\ncircle = { centre = [0, 0, " + std::to_string(z) +
           "], normal = [0, 0, 1], radius = " + std::to_string(radius) + " }\n";
  };
  return "unit = \"mm\"\n" + circle("low", low, 0) + circle("high", high, height) +
         "[output]\nstep = \"ring.step\"\n";
}

void make_ring(const CliCase& c, double low, double high, double height) {
  c.file("ring.toml", ring(low, high, height));
  const CliResult r = c.run({"run", "ring.toml", "--out", "part"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
}

}  // namespace fill_tests

using namespace fill_tests;

TEST_CASE("a tube is filled with two flat ends, and with a dome on request", "[apps][fill]") {
  const CliCase c("fill_tube");
  make_ring(c, 30, 30, 50);
  CliResult r = c.run({"fill", "part/ring.step", "--out", "out"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  auto j = report(c, "out");
  CHECK(j["faces"].size() == 2);
  CHECK(j["step"]["faces"] == 3);
  CHECK(j["step"]["solids"] == 1);
  CHECK(j["step"]["valid"].get<bool>());
  CHECK(j["step"]["neighbours"]["edges"] == 2);
  CHECK(j["step"]["neighbours"]["smooth_edges"] == 0);
  const double volume = std::numbers::pi * 900 * 50;
  CHECK(j["step"]["volume"].get<double>() == Approx(volume).epsilon(1e-4));

  r = c.run({"fill", "part/ring.step", "--opening", "1", "--continuity", "G1", "--out", "dome"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  j = report(c, "dome");
  REQUIRE(j["joins"].size() == 1);
  CHECK(j["joins"][0]["continuity"] == "smooth");
  CHECK(j["joins"][0]["neighbours"][0] == "face 1 of ring.step");
  CHECK(j["joins"][0]["max_inside_deg"].get<double>() < 0.1);
  CHECK(j["step"]["neighbours"]["smooth_edges"] == 1);
  CHECK(j["step"]["neighbours"]["max_smooth_deg"].get<double>() < 0.1);
  CHECK(j["step"]["free_edges"] == 1);
  // The scene that is written gives the same surface.
  r = c.run({"run", "dome/ring-filled.toml", "--out", "again"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  CHECK(report(c, "again")["surface"]["area"] == j["surface"]["area"]);
}

TEST_CASE("a bridge connects two openings tangentially", "[apps][fill]") {
  const CliCase c("fill_bridge");
  make_ring(c, 30, 25, 40);
  c.file("both.toml",
         "unit = \"mm\"\n[[neighbour]]\nfile = \"part/ring.step\"\nopenings = [2]\nbridge = true\n"
         "[[neighbour]]\nfile = \"upper/upper.step\"\nopenings = [1]\n"
         "[output]\nstep = \"both.step\"\n");
  c.file("upper.toml",
         "unit = \"mm\"\n[[curve]]\nname = \"a\"\n"
         "circle = { centre = [0, 0, 80], normal = [0, 0, 1], radius = 30 }\n"
         "[[curve]]\nname = \"b\"\n"
         "circle = { centre = [0, 0, 120], normal = [0, 0, 1], radius = 20 }\n"
         "[output]\nstep = \"upper.step\"\n");
  CliResult r = c.run({"run", "upper.toml", "--out", "upper"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  r = c.run({"run", "both.toml", "--out", "out"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out");
  REQUIRE(j["joins"].size() == 2);
  for (const auto& join : j["joins"]) {
    CHECK(join["continuity"] == "smooth");
    CHECK(join["max_inside_deg"].get<double>() < 0.1);
  }
  CHECK(j["step"]["faces"] == 3);
  CHECK(j["step"]["shells"] == 1);
  CHECK(j["step"]["valid"].get<bool>());
}

TEST_CASE("requests that cannot be filled name the openings", "[apps][fill]") {
  const CliCase c("fill_errors");
  make_ring(c, 30, 30, 50);
  CliResult r = c.run({"fill", "part/ring.step", "--opening", "3", "--out", "out"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("no opening 3, expected 1 to 2") && Contains("opening 1: 1 edge") &&
                        Contains("beside face 1"));
  r = c.run({"fill", "part/ring.step", "--replace", "face 9", "--out", "out"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("no face 'face 9'"));
  r = c.run({"fill", "part/ring.step", "--opening", "1.5", "--out", "out"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("1.5"));
  r = c.run({"fill", "missing.step", "--out", "out"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("missing.step"));
}

namespace fill_tests {

// A sphere of radius 50 as OBJ text, with a group "cap" of the triangles around the north pole, whose
// boundary zigzags; without this group on request.
std::string sphere_obj(double cap_height, bool with_cap) {
  const TriangleMesh mesh = sphere(4);
  std::string rest = "g rest\n", cap = "g cap\n", text;
  for (int v = 0; v < mesh.points().rows(); ++v) {
    text += "v";
    for (int c = 0; c < 3; ++c) text += " " + std::to_string(50 * mesh.points()(v, c));
    text += "\n";
  }
  for (const auto& t : mesh.triangles()) {
    const double z = (mesh.point(t[0]) + mesh.point(t[1]) + mesh.point(t[2])).z() / 3;
    std::string face = "f";
    for (const int v : t) face += " " + std::to_string(v + 1);
    (50 * z < cap_height ? rest : cap) += face + "\n";
  }
  return text + rest + (with_cap ? cap : "");
}

// The triangles of a written mesh and their largest distance from the sphere.
struct FilledSphere {
  int free_edges = 0, folds = 0;
  double volume = 0, distance = 0;
};

FilledSphere filled_sphere(const std::filesystem::path& file) {
  const ShellMesh mesh = MeshFile::read(file).shells();
  const TriangleMesh triangles = prepare(mesh).mesh;
  FilledSphere found;
  for (const auto& loop : triangles.topology().boundary_loops())
    found.free_edges += static_cast<int>(loop.size());
  std::map<std::pair<int, int>, Vec3> normals;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const auto c = mesh.corners(f);
    const auto at = [&](size_t k) -> Vec3 { return mesh.points.row(c[k % 3]).transpose(); };
    found.volume += at(0).dot(at(1).cross(at(2))) / 6;
    const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    for (size_t k = 0; k < 3; ++k) {
      found.distance = std::max(found.distance, std::abs(at(k).norm() - 50));
      const auto [other, is_first] = normals.emplace(std::minmax(c[k], c[(k + 1) % 3]), normal);
      found.folds += !is_first && other->second.dot(normal) < 0.9;
    }
  }
  return found;
}

}  // namespace fill_tests

TEST_CASE("a hole in a scan is filled tangentially, and the mesh is joined", "[apps][fill][mesh]") {
  const CliCase c("fill_scan");
  for (const double height : {46.0, 35.0, 12.0}) {
    c.file("scan.obj", sphere_obj(height, false));
    const std::string out = "out" + std::to_string(static_cast<int>(height));
    const CliResult r = c.run({"fill", "scan.obj", "--out", out});
    INFO(height << r.out << r.err);
    REQUIRE(r.code == 0);
    const auto j = report(c, out);
    REQUIRE(j["joins"].size() == 1);
    CHECK(j["joins"][0]["continuity"] == "smooth");
    CHECK(j["joins"][0]["neighbours"][0] == "mesh of scan.obj");
    CHECK(j["mesh"]["joined_openings"] == 1);
    CHECK(j["mesh"]["free_edges"] == 0);
    const FilledSphere found = filled_sphere(c / (out + "/scan-filled.obj"));
    CHECK(found.free_edges == 0);
    CHECK(found.folds == 0);
    CHECK(found.volume == Approx(4 / 3.0 * std::numbers::pi * 125'000).epsilon(5e-3));
    CHECK(found.distance < 2e-3 * 2 * std::sqrt(2500 - height * height));
  }
}

TEST_CASE("a face set of a mesh is replaced", "[apps][fill][mesh]") {
  const CliCase c("fill_set");
  c.file("scan.obj", sphere_obj(35, true));
  CliResult r = c.run({"fill", "scan.obj", "--out", "closed"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("no free edge"));
  r = c.run({"fill", "scan.obj", "--replace", "cup", "--out", "wrong"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("no face set 'cup', expected one of: rest, cap"));
  for (int twice = 0; twice < 2; ++twice) {
    r = c.run({"fill", "scan.obj", "--replace", "cap", "--out", "out"});
    INFO(r.out << r.err);
    REQUIRE(r.code == 0);
  }
  const MeshFile written = MeshFile::read(c / "out/scan-filled.obj");
  std::vector<std::string> names;
  for (const MeshSet& set : written.sets()) names.push_back(set.name);
  for (const MeshSet& set : written.properties()) names.push_back(set.name);
  std::sort(names.begin(), names.end());
  CHECK(names == std::vector<std::string>{"patch", "rest"});
  CHECK(filled_sphere(c / "out/scan-filled.obj").free_edges == 0);
}

namespace fill_tests {

// A flat sheet with edges named "1" to "4", as NAME/NAME.step.
void make_sheet(const CliCase& c, const std::string& name,
                const std::vector<std::string>& corners) {
  std::string text = "unit = \"mm\"\n";
  for (size_t i = 0; i < corners.size(); ++i)
    text += "[[curve]]\nname = \"" + std::to_string(i + 1) + "\"\npoints = [" + corners[i] + ", " +
            corners[(i + 1) % corners.size()] + "]\n";
  c.file(name + ".toml", text + "[output]\nstep = \"" + name + ".step\"\n");
  const CliResult r = c.run({"run", name + ".toml", "--out", name});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
}

}  // namespace fill_tests

TEST_CASE("a blend connects edges of two sheets, with tension at its sides", "[apps][fill]") {
  const CliCase c("blend_sheets");
  make_sheet(c, "a", {"[0, 0, 0]", "[40, 0, 0]", "[40, 30, 0]", "[0, 30, 0]"});
  make_sheet(c, "b", {"[70, 0, 30]", "[70, 30, 30]", "[70, 30, 60]", "[70, 0, 60]"});
  const auto scene = [](const std::string& more) {
    return "unit = \"mm\"\n[[neighbour]]\nfile = \"a/a.step\"\nbridge = true\nedges = [\"2\"]\n" +
           more +
           "[[neighbour]]\nfile = \"b/b.step\"\nedges = [\"1\"]\n[output]\nstep = \"s.step\"\n";
  };
  for (const std::string tension : {"", "tension = 2\n"}) {
    c.file("both.toml", scene(tension));
    const CliResult r = c.run({"run", "both.toml", "--out", "out" + tension.substr(0, 1)});
    INFO(r.out << r.err);
    REQUIRE(r.code == 0);
    const auto j = report(c, "out" + tension.substr(0, 1));
    for (const auto& join : j["joins"]) {
      const bool is_side = join["edge"].get<std::string>().starts_with("side");
      CHECK(join["continuity"] == (is_side ? "free edge" : "smooth"));
      if (!is_side) CHECK(join["max_inside_deg"].get<double>() < 0.1);
    }
    CHECK(j["step"]["faces"] == 3);
    CHECK(j["step"]["shells"] == 1);
    // The blend is the translation of its sides by the width: Hermite cubics from (40, 0) along x to
    // (70, 30) along z with derivatives of `tension` times sqrt(1800); their lengths are from quadrature.
    const double length = tension.empty() ? 46.1171 : 53.0623;
    CHECK(j["surface"]["area"].get<double>() == Approx(30 * length).epsilon(2e-4));
  }

  CliResult r = c.run({"blend", "a/a.step", "--edge", "1", "--edge", "2", "--out", "touch"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("2 edges in 1 chain") && Contains("two chains"));
  r = c.run({"blend", "a/a.step", "--out", "none"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("opening 1: 4 edges (1, 2, 3, 4)"));
  r = c.run({"fill", "a/a.step", "--edge", "5", "--out", "none"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("no free edge '5', expected one of: 1, 2, 3, 4"));
}

TEST_CASE("the openings of a tube are selected by their edges, and blended", "[apps][fill]") {
  const CliCase c("blend_tubes");
  make_ring(c, 30, 25, 40);
  CliResult r = c.run({"fill", "part/ring.step", "--edge", "high", "--out", "out"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  CHECK(report(c, "out")["joins"][0]["edge"] == "high");
  // Both ends of one tube: a ring around it, tangent at both.
  r = c.run({"blend", "part/ring.step", "--edge", "high", "--edge", "low", "--tension", "2",
             "--out", "no"});
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("tension") && Contains("closed edges"));
}
