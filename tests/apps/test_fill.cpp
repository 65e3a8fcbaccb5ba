// SPDX-License-Identifier: MPL-2.0
// batten fill and [[neighbour]]: faces that continue those of a CAD file.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/catch.h"

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
