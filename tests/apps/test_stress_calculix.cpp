// SPDX-License-Identifier: MPL-2.0
// Supports, loads and sections of [stress] as CalculiX decks: the results of ccx are those of Batten.
#include <cmath>
#include <cstdlib>

#include "batten/tests/apps/cli_case.h"

namespace batten_test::stress_calculix {
namespace {

std::string vector_text(double x, double y, double z) {
  return "[" + std::to_string(x) + ", " + std::to_string(y) + ", " + std::to_string(z) + "]";
}

/// A plate of 100 by 80, rotated about z by an angle in radians. Its sides are a, b, c, d.
std::string plate(const std::string& stress, double angle = 0, const std::string& a = "a") {
  const auto at = [&](double x, double y) {
    return vector_text(std::cos(angle) * x - std::sin(angle) * y,
                       std::sin(angle) * x + std::cos(angle) * y, 0);
  };
  const std::string corners[] = {at(0, 0), at(100, 0), at(100, 80), at(0, 80)};
  const std::string names[] = {a, "b", "c", "d"};
  std::string scene = "name = \"plate\"\nunit = \"mm\"\n[mesh]\nedge_length = 12\n";
  for (int k = 0; k < 4; ++k)
    scene += "[[curve]]\nname = \"" + names[k] + "\"\npoints = [" + corners[k] + ", " +
             corners[(k + 1) % 4] + "]\n";
  return scene + "[stress]\n" + stress;
}

/// A quarter of a cylinder of radius 100 and length 80 about the z axis.
std::string cylinder(const std::string& stress) {
  const auto arc = [](const std::string& name, double z) {
    std::string points;
    for (int k = 0; k <= 18; ++k) {
      const double t = k * std::acos(0.0) / 18;
      points += (k ? ", " : "") + vector_text(100 * std::cos(t), 100 * std::sin(t), z);
    }
    return "[[curve]]\nname = \"" + name + "\"\npoints = [" + points + "]\n";
  };
  return "name = \"shell\"\nunit = \"mm\"\n[mesh]\nedge_length = 12\n" + arc("low", 0) +
         "[[curve]]\nname = \"gy\"\npoints = [[0, 100, 0], [0, 100, 80]]\n" + arc("high", 80) +
         "[[curve]]\nname = \"gx\"\npoints = [[100, 0, 0], [100, 0, 80]]\n[stress]\n" + stress;
}

const std::string kSteel = "material = \"steel\"\nthickness = 1\n";
const std::string kCarbon =
    "young = [140e3, 10e3]\npoisson = 0.3\nshear_modulus = 5e3\nexpansion = [1e-6, 30e-6]\n";

std::string clamped(const std::vector<std::string>& curves, const std::string& more = "") {
  std::string text = "supports = [";
  for (const std::string& curve : curves) text += "{curve = \"" + curve + "\"}, ";
  return text + more + "]\n";
}

double number(const nlohmann::json& value) { return value.get<double>(); }

bool have_ccx() {
  if (std::system("command -v ccx > /dev/null") == 0) return true;
  WARN("no ccx here: skipped");
  return false;
}

nlohmann::json compared(const CliCase& c, const std::string& scene) {
  c.file("s.toml", scene);
  const CliResult r = c.run({"stress", "s.toml", "--accuracy", "0", "--with-ccx", "--ccx-elements",
                             "S8R", "--out", "out"});
  INFO(r.err);
  REQUIRE((r.code == 0 || r.code == 4));  // pictures need a display
  return nlohmann::json::parse(contents(c / "out/report.json"));
}

}  // namespace

TEST_CASE("CalculiX finds the displacements of all supports, loads and sections of a deck",
          "[apps][stress]") {
  if (!have_ccx()) return;
  const CliCase c("stress_ccx_all");
  const auto check = [&](const std::string& scene) {
    INFO(scene.substr(scene.find("[stress]")));
    const auto found = compared(c, scene)["stress"]["cases"][0];
    REQUIRE(found.contains("calculix"));
    CHECK(number(found["calculix"]["displacement_at_same_point"]) ==
          Approx(number(found["max_displacement"])).epsilon(0.015));
  };
  const std::string pressure = "pressure = 0.001\n";
  const double t = 0.5;
  const std::string along = vector_text(std::cos(t), std::sin(t), 0),
                    across = vector_text(-std::sin(t), std::cos(t), 0);
  for (const std::string& supports :
       {clamped({"d"}, "{curve = \"b\", spring = [0, 0, 0.05]}"),
        clamped({"d"}, "{foundation = 1e-3}"),
        clamped({"d"}, "{point = [100, 0, 0], spring = [0, 0, 2]}"),
        clamped({"d"},
                "{curve = \"b\", type = \"prescribed\", directions = [[1, 0, 0]], rotation = "
                "true}"),
        std::string("supports = [{point = [0, 0, 0]}, {point = [100, 0, 0], directions = [[0, 1, "
                    "0], [0, 0, 1]]}, {point = [100, 80, 0], directions = [[0, 0, 1]]}, {point = "
                    "[0, 80, 0], directions = [[0, 0, 1]]}]\n")})
    check(plate(kSteel + supports + pressure));
  check(plate(kSteel + "supports = [{curve = \"a\", type = \"symmetric\", normal = " + across +
                  "}, {curve = \"b\", type = \"symmetric\", normal = " + along +
                  "}, {curve = \"c\", type = \"pinned\"}, {curve = \"d\", type = \"pinned\"}]\n" +
                  pressure,
              t));
  // Forces at nodes with a local coordinate system.
  check(plate(
      kSteel +
          clamped({"d"}, "{curve = \"b\", type = \"prescribed\", directions = [" + along + "]}") +
          "loads = [{curve = \"b\", force = [0.01, 0.02, 0.03]}]\n",
      t));
  for (const std::string load :
       {"{curve = \"b\", moment = 5}", "{curve = \"b\", edge_force = 5}",
        "{curve = \"b\", total_force = [0, 0, 10], total_moment = [200, 0, 0]}",
        "{total_force = [0, 0, 10], total_moment = [200, 0, 0]}",
        "{angular_velocity = 100, axis = [0, 0, 1]}",
        "{curve = \"b\", force = [\"0\", \"0\", \"0.01 * y\"]}"})
    check(plate(kSteel + clamped({"d"}) + "loads = [" + load + "]\n"));
  check(cylinder(kSteel + clamped({"low"}) + "loads = [{curve = \"high\", edge_force = 5}]\n"));
  check(cylinder(
      kSteel +
      clamped({"gx", "gy"}, "{curve = \"low\", directions = [\"radial\"], axis = [0, 0, 1]}") +
      "pressure = 0.1\n"));
  // Orthotropic materials and laminates.
  check(plate(kCarbon + "thickness = 1\nmaterial_direction = [1, 0.5, 0]\n" +
              clamped({"a", "b", "c", "d"}) + pressure));
  check(plate(kCarbon +
              "layup = \"[0/45/90]\"\nply_thickness = 0.33\nmaterial_direction = [1, 0, 0]\n" +
              clamped({"d"}) + pressure));
  check(cylinder(kCarbon +
                 "layup = \"[45/0]\"\nply_thickness = 0.5\nmaterial_direction = [0, 0, 1]\n" +
                 clamped({"low"}) + pressure));
  check(plate(kCarbon +
              "layup = \"[0/90]\"\nply_thickness = 0.5\nmaterial_direction = [1, 0, 0]\n" +
              clamped({"d"}) + "loads = [{temperature = 50}]\n"));
}

TEST_CASE("CalculiX finds the natural frequencies and buckling factors", "[apps][stress]") {
  if (!have_ccx()) return;
  const CliCase c("stress_ccx_modes");
  const auto check = [](const nlohmann::json& a, const nlohmann::json& b, size_t first) {
    REQUIRE(a.size() == b.size() + first);
    for (size_t k = 0; k < b.size(); ++k)
      CHECK(number(b[k]) == Approx(number(a[k + first])).epsilon(0.02));
  };
  const auto free = compared(c, plate(kSteel + "modes = 4\n"))["stress"];
  check(free["frequencies"], free["calculix_frequencies"], 6);
  const auto loaded = compared(
      c,
      plate(
          kSteel + clamped({"a", "b", "c", "d"}) +
          "modes = 3\npressure = 0.01\nmasses = [{point = [50, 40, 0], mass = 1e-5}]\n"))["stress"];
  check(loaded["frequencies"], loaded["calculix_frequencies"], 0);
  const auto pressed = compared(
      c,
      plate(kSteel + "supports = [{curve = \"d\", type = \"pinned\"}, {curve = \"b\", directions = "
                     "[[0, 0, 1], [0, 1, 0]]}]\nbuckling = 3\n"
                     "loads = [{curve = \"b\", force = [-10, 0, 0]}]\n"))["stress"]["cases"][0];
  check(pressed["buckling_factors"], pressed["calculix"]["buckling_factors"], 0);
}

TEST_CASE("what a CalculiX deck cannot contain is not compared, and the analysis is kept",
          "[apps][stress]") {
  if (!have_ccx()) return;
  const CliCase c("stress_ccx_not");
  const auto report =
      compared(c, plate(kSteel + clamped({"d"}) +
                        "stiffeners = [{curve = \"a\", rectangle = [2, 10]}]\npressure = 0.001\n"));
  CHECK_FALSE(report["stress"]["cases"][0].contains("calculix"));
  CHECK(report["warnings"].dump().find("not compared with CalculiX") != std::string::npos);
  // A direction and an axis of rotation without a common coordinate system.
  const auto oblique = compared(
      c, plate(kSteel + "supports = [{curve = \"a\", directions = [[1, 1, 0]], rotation = true}, "
                        "{curve = \"c\"}]\npressure = 0.001\n"));
  CHECK(oblique["warnings"].dump().find("neither parallel nor perpendicular") != std::string::npos);
  // A curve with the name that a support's set would have.
  const auto named =
      compared(c, plate(kSteel + "supports = [{curve = \"Support 1\", box = [[0, -1, "
                                 "-1], [50, 1, 1]]}]\npressure = 0.001\n",
                        0, "Support 1"));
  REQUIRE(named["stress"]["cases"][0].contains("calculix"));
  CHECK(contents(c / "out/plate_loads_ccx.inp").find("NSET=CURVE_SUPPORT_1\n") !=
        std::string::npos);
}

}  // namespace batten_test::stress_calculix
