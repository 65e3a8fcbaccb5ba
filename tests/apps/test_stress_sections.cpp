// SPDX-License-Identifier: MPL-2.0
// batten stress: laminates, temperatures, the reference surface, and limits of the theory.
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

// A plate of 100 by 100 in mm, pinned so that it is statically determinate if `supports` is empty.
std::string square_plate(const std::string& stress, double edge_length = 20) {
  const auto curve = [](const std::string& name, const std::string& points) {
    return "[[curve]]\nname = \"" + name + "\"\npoints = " + points + "\n";
  };
  return "name = \"plate\"\nunit = \"mm\"\n" + curve("a", "[[0,0,0],[100,0,0]]") +
         curve("b", "[[100,0,0],[100,100,0]]") + curve("c", "[[100,100,0],[0,100,0]]") +
         curve("d", "[[0,100,0],[0,0,0]]") +
         "[mesh]\nedge_length = " + std::to_string(edge_length) + "\n[stress]\n" + stress + "\n";
}

const std::string kHeld = "supports = [{curve = \"a\"}]\n";
const std::string kFree =
    "supports = [{point = [0, 0, 0]}, {point = [100, 0, 0], directions = [[0, 1, 0], [0, 0, 1]]}, "
    "{point = [0, 100, 0], directions = [[0, 0, 1]]}]\n";
const std::string kCarbon =
    "young = [140000, 10000]\npoisson = 0.3\nshear_modulus = 5000\ndensity = 1.6e-9\n"
    "expansion = [-0.5e-6, 30e-6]\nmaterial_direction = [1, 0, 0]\n"
    "strength = { tension = [1500, 50], compression = [1200, 250], shear = 70 }\n";

nlohmann::json report_of(const CliCase& c, const std::string& scene,
                         std::vector<std::string> options = {}) {
  c.file("s.toml", scene);
  std::vector<std::string> arguments = {"stress", "s.toml", "--out", "out"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const CliResult r = c.run(arguments);
  INFO(r.err);
  REQUIRE((r.code == 0 || r.code == 4));  // pictures need a display
  return nlohmann::json::parse(contents(c / "out/report.json"));
}

nlohmann::json case_of(const CliCase& c, const std::string& stress) {
  return report_of(c, square_plate(stress))["stress"]["cases"][0];
}

double number(const nlohmann::json& value) { return value.get<double>(); }

void expect_refusal(const CliCase& c, const std::string& stress,
                    const std::vector<std::string>& parts) {
  c.file("s.toml", square_plate(stress));
  const CliResult r = c.run({"stress", "s.toml", "--out", "out"});
  INFO(stress << "\n" << r.err);
  CHECK(r.code == 1);
  for (const std::string& part : parts) CHECK(r.err.find(part) != std::string::npos);
}

}  // namespace

TEST_CASE("a laminate is the same by its stacking sequence and by its plies", "[apps][stress]") {
  const CliCase c("stress_laminate");
  const std::string load = kHeld + "loads = [{curve = \"c\", force = [0, 0, -0.05]}]\n";
  const auto layup =
      case_of(c, kCarbon + "layup = \"[0/±45/90]s\"\nply_thickness = 0.125\n" + load);
  std::string plies = "plies = [";
  for (const char* angle : {"0", "45", "-45", "90", "90", "-45", "45", "0"})
    plies += "{thickness = 0.125, angle = " + std::string(angle) + "}, ";
  const auto listed = case_of(c, kCarbon + plies + "]\n" + load);
  CHECK(number(layup["max_displacement"]) == number(listed["max_displacement"]));
  // Bending is carried by the outer plies: the 0° plies along the lever would be stiffer.
  const auto along =
      case_of(c, kCarbon + "layup = \"[90/+-45/0]s\"\nply_thickness = 0.125\n" + load);
  CHECK(number(along["max_displacement"]) < 0.5 * number(layup["max_displacement"]));
  REQUIRE(layup["reserve_factors"].size() == 2);
  CHECK(layup["reserve_factors"][0]["criterion"] == "Tsai-Hill");
  const double reserve = number(layup["reserve_factors"][0]["factor"]);
  const auto twice = case_of(c, kCarbon + "layup = \"[0/±45/90]s\"\nply_thickness = 0.125\n" +
                                    kHeld + "loads = [{curve = \"c\", force = [0, 0, -0.1]}]\n");
  CHECK(number(twice["reserve_factors"][0]["factor"]) == Approx(reserve / 2));
  CHECK(layup["stress_ply"].get<int>() >= 1);
  CHECK(fs::exists(c / "out/plate_loads.vtu"));
  CHECK(contents(c / "out/plate_loads.vtu").find("Ply_8_top") != std::string::npos);
}

TEST_CASE("plies of several materials", "[apps][stress]") {
  const CliCase c("stress_sandwich");
  const std::string core = "materials = [{name = \"foam\", young = 70, poisson = 0.3}]\n";
  const auto sandwich =
      case_of(c,
              "plies = [{material = \"aluminium\", thickness = 0.5}, {material = \"foam\", "
              "thickness = 10}, "
              "{material = \"aluminium\", thickness = 0.5}]\n" +
                  core + kHeld + "loads = [{curve = \"c\", force = [0, 0, -1]}]\n");
  // Faces at ±5.25 mm carry the bending; a wide cantilever is between beam and cylindrical bending.
  const double stiffness =
      70000 * (0.5 * 2 * 5.25 * 5.25 + 2 * std::pow(0.5, 3) / 12) + 70 * 1000 / 12.0;
  CHECK(number(sandwich["max_displacement"]) == Approx(1e6 / 3 / stiffness).epsilon(0.08));
  CHECK(sandwich["stress_ply"] != 2);
}

TEST_CASE("free plates expand, and held ones are compressed", "[apps][stress]") {
  const CliCase c("stress_heat");
  const std::string steel = "material = \"steel\"\nthickness = 1\n";
  const auto free = case_of(c, steel + kFree + "loads = [{temperature = 100}]\n");
  CHECK(number(free["max_displacement"]) ==
        Approx(12e-6 * 100 * 100 * std::sqrt(2.0)).epsilon(1e-6));
  CHECK(number(free["max_von_mises"]) < 1e-5);
  CHECK(number(free["error_estimate"]) == 0);
  const std::string all =
      "supports = [{curve = \"a\"}, {curve = \"b\"}, {curve = \"c\"}, {curve = \"d\"}]\n";
  const auto held = case_of(c, steel + all + "loads = [{temperature = 100}]\n");
  CHECK(number(held["max_von_mises"]) == Approx(210e3 * 12e-6 * 100 / 0.7).epsilon(1e-6));
  const auto gradient = case_of(c, steel + all + "loads = [{temperature_difference = \"50\"}]\n");
  CHECK(number(gradient["max_von_mises"]) == Approx(210e3 * 12e-6 * 25 / 0.7).epsilon(1e-6));
  // A linear temperature field strains a free plate without stress.
  const auto varying = case_of(c, steel + kFree + "loads = [{temperature = \"2 * x\"}]\n");
  CHECK(number(varying["max_von_mises"]) < 1e-3 * 210e3 * 12e-6 * 200);
  // The plate buckles at 2 π² D/a² in both directions with pinned edges.
  std::string pinned = "supports = [";
  for (const char* curve : {"a", "b", "c", "d"})
    pinned += "{curve = \"" + std::string(curve) + "\", type = \"pinned\"}, ";
  const auto buckled =
      case_of(c, steel + pinned + "]\nbuckling = 1\nloads = [{temperature = 1}]\n");
  const double D = 210000.0 / (12 * 0.91), pi = std::acos(-1.0);
  CHECK(number(buckled["buckling_factors"][0]) ==
        Approx(2 * pi * pi * D / 1e4 / (210e3 * 12e-6 / 0.7)).epsilon(1e-2));
}

TEST_CASE("the reference surface may be the bottom of the shell", "[apps][stress]") {
  const CliCase c("stress_reference");
  const std::string load = kHeld + "loads = [{curve = \"c\", force = [0, 0, -0.01]}]\n",
                    steel = "material = \"steel\"\nthickness = 1\n";
  const auto middle = case_of(c, steel + load);
  const auto bottom = case_of(c, steel + "reference_surface = \"bottom\"\n" + load);
  // Clamping the bottom instead of the middle changes little.
  CHECK(number(bottom["max_displacement"]) ==
        Approx(number(middle["max_displacement"])).epsilon(0.01));
  // A pull in the plane of the bottom bends the plate.
  const std::string pull = kHeld + "loads = [{curve = \"c\", force = [0, 1, 0]}]\n";
  const auto bent = case_of(c, steel + "reference_surface = \"bottom\"\n" + pull);
  CHECK(number(bent["max_displacement"]) == Approx(0.5 * 1e4 / 2 / (210e3 / 12)).epsilon(0.1));
  CHECK(number(bent["displacement"][2]) > 0);  // the middle, above the bottom, lags behind the pull
}

TEST_CASE("CalculiX agrees on heated shells", "[apps][stress]") {
  if (std::system("command -v ccx > /dev/null") != 0) {
    WARN("no ccx here: skipped");
    return;
  }
  const CliCase c("stress_ccx_heat");
  const std::string steel = "material = \"steel\"\nthickness = 1\n";
  const auto found = report_of(
      c,
      square_plate(
          steel + kHeld + "loads = [{temperature = \"0.5 * x\", temperature_difference = 20}]\n",
          8),
      {"--with-ccx", "--ccx-elements", "S8R"})["stress"]["cases"][0];
  REQUIRE(found.contains("calculix"));
  CHECK(number(found["calculix"]["displacement_at_same_point"]) ==
        Approx(number(found["max_displacement"])).epsilon(0.01));
}

TEST_CASE("displacements and thicknesses beyond the linear theory of thin shells are warned of",
          "[apps][stress]") {
  const CliCase c("stress_limits");
  const auto warned = [&](const std::string& stress, const std::string& text) {
    const auto report = report_of(c, square_plate(stress));
    std::string all;
    for (const auto& warning : report["warnings"]) all += warning.get<std::string>() + "\n";
    INFO(all);
    return all.find(text) != std::string::npos;
  };
  const std::string steel = "material = \"steel\"\nthickness = 1\n";
  std::string pinned = "supports = [";
  for (const char* curve : {"a", "b", "c", "d"})
    pinned += "{curve = \"" + std::string(curve) + "\", type = \"pinned\"}, ";
  pinned += "]\n";
  const std::string large = "too large for a linear analysis";
  CHECK_FALSE(warned(steel + pinned + "loads = [{pressure = 5e-4}]\n", large));
  CHECK(warned(steel + pinned + "loads = [{pressure = 0.02}]\n", large));
  // A cantilever bends freely by the same displacement.
  CHECK_FALSE(warned(steel + kHeld + "loads = [{curve = \"c\", force = [0, 0, 0.05]}]\n", large));
  CHECK(
      warned(steel + kHeld + "loads = [{curve = \"c\", force = [0, 0, 5]}]\n", "check the units"));
  CHECK(warned("material = \"steel\"\nthickness = 20\n" + pinned + "loads = [{pressure = 1}]\n",
               "transverse shear"));
}

TEST_CASE("stiffeners of a scene, their forces, masses, and requested results", "[apps][stress]") {
  const CliCase c("stress_stiffeners");
  // A strip of 20 by 100 with a rib along its middle, clamped at one end.
  const auto strip = [](const std::string& stress) {
    return "name = \"strip\"\nunit = \"mm\"\n"
           "[[curve]]\nname = \"root\"\npoints = [[0,0,0],[20,0,0]]\n"
           "[[curve]]\nname = \"right\"\npoints = [[20,0,0],[20,100,0]]\n"
           "[[curve]]\nname = \"tip\"\npoints = [[20,100,0],[0,100,0]]\n"
           "[[curve]]\nname = \"left\"\npoints = [[0,100,0],[0,0,0]]\n"
           "[[curve]]\nname = \"rib\"\nrole = \"inner\"\npoints = [[10,0,0],[10,100,0]]\n"
           "[mesh]\nedge_length = 10\n[stress]\nyoung = 210e3\npoisson = 0\ndensity = "
           "7.85e-9\nthickness = 1\nsupports = [{curve = \"root\"}]\n" +
           stress + "\n";
  };
  const std::string load = "loads = [{curve = \"tip\", force = [0, 0, 0.05]}]\n";
  const auto solved = [&](const std::string& stress) {
    return report_of(c, strip(stress))["stress"];
  };
  const double width = 2, height = 6, e = 0.5 + height / 2, sheet = 20, rib = width * height,
               axis = rib * e / (sheet + rib);
  const double EI = 210e3 * (20.0 / 12 + width * std::pow(height, 3) / 12 + sheet * axis * axis +
                             rib * (e - axis) * (e - axis));
  const std::string ribs = "stiffeners = [{curve = \"rib\", rectangle = [2, 6]}]\n";
  const auto stiff = solved(ribs + load +
                            "results = [{name = \"end\", point = [10, 100, 0]}, {curve = \"tip\"}, "
                            "{face = \"strip\"}]\n")["cases"][0];
  REQUIRE(stiff["stiffeners"].size() == 1);
  CHECK(stiff["stiffeners"][0]["name"] == "rib");
  const double fibre = 0.5 + height - axis;
  CHECK(std::abs(number(stiff["stiffeners"][0]["max_stress"])) ==
        Approx(210e3 * 100 * fibre / EI).epsilon(0.05));
  // The same section by its numbers, and on the other side: the same deflection.
  const auto numbers = solved(
      "stiffeners = [{curve = \"rib\", section = {area = 12, inertia = 36, "
      "lateral_inertia = 4, torsion = 12.6, eccentricity = 3.5}}]\n" +
      load)["cases"][0];
  CHECK(number(numbers["max_displacement"]) ==
        Approx(number(stiff["max_displacement"])).epsilon(1e-3));
  const auto below =
      solved("stiffeners = [{curve = \"rib\", rectangle = [2, 6], side = \"bottom\"}]\n" +
             load)["cases"][0];
  CHECK(number(below["max_displacement"]) ==
        Approx(number(stiff["max_displacement"])).epsilon(1e-6));

  // Requested results.
  REQUIRE(stiff["results"].size() == 3);
  const auto &end = stiff["results"][0], &tip = stiff["results"][1], &face = stiff["results"][2];
  CHECK(end["kind"] == "point");
  CHECK(number(end["displacement_vector"][2]) == Approx(1e6 / (3 * EI)).epsilon(0.02));
  CHECK(end["principal_top_middle_bottom"].size() == 3);
  CHECK(number(tip["length"]) == Approx(20).epsilon(1e-6));
  CHECK(number(tip["displacement"]["max"]) ==
        Approx(number(stiff["max_displacement"])).epsilon(1e-3));
  CHECK(number(face["area"]) == Approx(2000).epsilon(1e-6));
  CHECK(number(face["von_mises"]["max"]) <= number(stiff["max_von_mises"]) * (1 + 1e-9));
  const std::string csv = contents(c / "out/strip_loads_tip.csv");
  CHECK(csv.starts_with("s [mm],x [mm],y [mm],z [mm],ux [mm]"));
  CHECK(csv.find("von_mises_top [N/mm²]") != std::string::npos);
  CHECK(std::count(csv.begin(), csv.end(), '\n') >= 5);

  // A mass at the tip lowers the frequency: f ~ 1/√(M + 0.243 m).
  const auto frequency = [&](const std::string& more) {
    return number(solved(ribs + "modes = 1\n" + more)["frequencies"][0]);
  };
  const double mass = 7.85e-9 * 100 * (sheet + rib), added = 5 * mass;
  CHECK(frequency("masses = [{point = [10, 100, 0], mass = " + std::to_string(added * 1e6) +
                  "e-6}]\n") /
            frequency("") ==
        Approx(std::sqrt(0.2427 * mass / (added + 0.2427 * mass))).epsilon(0.02));
  const auto weight = solved(ribs +
                             "gravity = [0, 0, -9810]\nmasses = [{point = [10, 100, 0], mass "
                             "= 1e-6}]\n")["cases"][0];
  CHECK(number(weight["force"][2]) == Approx(-9810 * (mass + 1e-6)).epsilon(1e-6));

  const auto refuse = [&](const std::string& stress, const std::string& part) {
    c.file("s.toml", strip(stress));
    const CliResult r = c.run({"stress", "s.toml", "--out", "out2"});
    INFO(r.err);
    CHECK(r.code == 1);
    CHECK(r.err.find(part) != std::string::npos);
  };
  refuse("stiffeners = [{curve = \"rip\", rectangle = [2, 6]}]\n" + load, "found the curve 'rip'");
  refuse("stiffeners = [{curve = \"rib\"}]\n" + load, "without a section");
  refuse("stiffeners = [{curve = \"rib\", circle = 1, tube = [2, 1]}]\n" + load,
         "several sections");
  refuse("stiffeners = [{curve = \"rib\", tube = [1, 2]}]\n" + load, "at most the radius");
  refuse("results = [{curve = \"tip\", face = \"x\"}]\n" + load, "one of point, curve and face");
  refuse("results = [{curve = \"tipp\"}]\n" + load, "'tip'");
  refuse("masses = [{point = [0, 0, 50], mass = 1}]\n" + load, "from the surface");
}

TEST_CASE("a disc held in cylindrical directions, and a rigid hole", "[apps][stress]") {
  const CliCase c("stress_axes");
  const auto disc = [&](const std::string& more, const std::string& stress) {
    return report_of(
        c,
        "name = \"disc\"\nunit = \"mm\"\n[[curve]]\nname = \"rim\"\ncircle = {centre = [10, 20, "
        "0], radius = 50}\n" +
            more + "[mesh]\nedge_length = 10\n[stress]\nmaterial = \"steel\"\nthickness = 1\n" +
            stress,
        {"--accuracy", "0"})["stress"]["cases"][0];
  };
  const std::string results = "results = [{curve = \"rim\"}]\nloads = [{temperature = 100}]\n";
  // Free along the radius: no stress. The same without that freedom: a stress.
  const std::string guided = "axis = [0, 0, 1], origin = [10, 20, 0]}]\n";
  const auto free = disc(
      "", "supports = [{curve = \"rim\", directions = [\"hoop\", \"axial\"], " + guided + results);
  CHECK(number(free["max_von_mises"]) < 1e-3 * 210e3 * 12e-6 * 100);
  CHECK(number(free["results"][0]["displacement"]["min"]) ==
        Approx(12e-6 * 100 * 50).epsilon(1e-3));
  const auto held = disc("",
                         "supports = [{curve = \"rim\", directions = [\"radial\", \"hoop\", "
                         "\"axial\"], displacement = [0.06, 0, 0], " +
                             guided + results);
  CHECK(number(held["max_von_mises"]) < 1e-3 * 210e3 * 12e-6 * 100);
  const auto fixed =
      disc("", "supports = [{curve = \"rim\", directions = [\"radial\", \"hoop\", \"axial\"], " +
                   guided + results);
  CHECK(number(fixed["max_von_mises"]) == Approx(210e3 * 12e-6 * 100 / 0.7).epsilon(5e-3));

  // A clamped annulus, and a moment on its hole about the y axis.
  const std::string hole =
      "[[curve]]\nname = \"hole\"\nrole = \"hole\"\ncircle = {centre = [10, 20, "
      "0], radius = 10}\n";
  const std::string load =
      "supports = [{curve = \"rim\"}]\nloads = [{curve = \"hole\", total_moment = [0, 500, "
      "0]}]\nresults = [{point = [20, 20, 0]}, {point = [0, 20, 0]}, {point = [10, 30, 0]}, {point "
      "= "
      "[17.0710678, 27.0710678, 0]}]\n";
  const auto height = [](const nlohmann::json& one, size_t k) {
    return number(one["results"][k]["displacement_vector"][2]);
  };
  const std::string rigid_hole = "rigid_curves = [\"hole\"]\n";
  const auto turned = disc(hole, load + rigid_hole);
  const double tilt = height(turned, 0);
  // A clamped annulus of radii 10 and 50 whose inner edge is rigid.
  CHECK(std::abs(tilt) == Approx(0.0142009).epsilon(0.02));
  CHECK(height(turned, 1) == Approx(-tilt).epsilon(5e-3));
  CHECK(std::abs(height(turned, 2)) < 5e-3 * std::abs(tilt));
  CHECK(height(turned, 3) == Approx(tilt * std::sqrt(0.5)).epsilon(5e-3));
  // Forces that bend the rim to a saddle.
  const std::string saddle =
      "supports = [{curve = \"rim\"}]\nloads = [{point = [20, 20, 0], force = [0, 0, 5]}, {point = "
      "[0, "
      "20, 0], force = [0, 0, 5]}, {point = [10, 30, 0], force = [0, 0, -5]}, {point = [10, 10, "
      "0], "
      "force = [0, 0, -5]}]\nresults = [{point = [20, 20, 0]}]\n";
  const double soft = height(disc(hole, saddle), 0),
               rigid = height(disc(hole, saddle + rigid_hole), 0);
  CHECK(std::abs(rigid) < 0.02 * std::abs(soft));

  const auto refuse = [&](const std::string& support, const std::string& part) {
    c.file("s.toml", square_plate("material = \"steel\"\nthickness = 1\nsupports = [" + support +
                                  "]\npressure = 1\n"));
    const CliResult r = c.run({"stress", "s.toml", "--out", "out2"});
    INFO(r.err);
    CHECK(r.code == 1);
    CHECK(r.err.find(part) != std::string::npos);
  };
  refuse("{curve = \"a\", directions = [\"radiel\"], axis = [0, 0, 1]}", "did you mean 'radial'");
  refuse("{curve = \"a\", axis = [0, 0, 1]}", "'axis' without directions");
  refuse("{curve = \"a\", directions = [\"radial\"], axis = [0, 0, 1], origin = [50, 0, 0]}",
         "on the axis");
}

TEST_CASE("a steady vibration has the static limit, resonances and phases", "[apps][stress]") {
  const CliCase c("stress_harmonic");
  const std::string cantilever = "material = \"steel\"\nthickness = 1\n" + kHeld +
                                 "modes = 2\nloads = [{curve = \"c\", force = [0, 0, 0.01]}]\n";
  const auto report = report_of(
      c, square_plate(cantilever +
                      "results = [{name = \"tip\", point = [50, 100, 0]}]\n"
                      "harmonic = {from = 0, to = 150, steps = 10, damping = 0.01}\n"))["stress"];
  const double first = number(report["frequencies"][0]);
  const auto& one = report["cases"][0];
  REQUIRE(one["harmonic"].size() == 2);
  CHECK(one["harmonic"][1]["point"] == "tip");
  CHECK(number(one["harmonic"][1]["frequency"]) == Approx(first).epsilon(1e-6));
  // At resonance, a single mode: 1/(2 ζ) times its part of the static displacement, which is nearly all.
  CHECK(number(one["harmonic"][1]["amplitude"]) ==
        Approx(number(one["results"][0]["displacement_vector"][2]) / 0.02).epsilon(0.05));
  std::istringstream csv(contents(c / "out/plate_loads_harmonic.csv"));
  std::string header, row;
  std::getline(csv, header);
  CHECK(header.find("\"tip: uz [mm]\"") != std::string::npos);
  std::getline(csv, row);  // at 0 Hz: the static displacement, in phase
  std::vector<double> numbers;
  std::istringstream cells(row);
  for (std::string cell; std::getline(cells, cell, ',');) numbers.push_back(std::stod(cell));
  REQUIRE(numbers.size() == 13);
  CHECK(numbers[11] == Approx(number(one["results"][0]["displacement_vector"][2])).epsilon(1e-9));
  CHECK(std::abs(numbers[12]) < 1e-9);
  const auto refuse = [&](const std::string& harmonic, const std::string& part) {
    expect_refusal(c, cantilever + "harmonic = {" + harmonic + "}\n", {part});
  };
  refuse("to = 10", "damping");
  refuse("from = 20, to = 10, damping = 0.02", "below 'to'");
  refuse("to = 10, damping = 2", "below 1");
  expect_refusal(c,
                 "young = 210e3\nthickness = 1\nharmonic = {to = 1, damping = 0.1}\n" + kHeld +
                     "pressure = 1\n",
                 {"'density'"});
}

TEST_CASE("the response to a constant spectrum is nearly that to a weight", "[apps][stress]") {
  const CliCase c("stress_spectrum");
  const std::string steel = "material = \"steel\"\nthickness = 1\n" + kHeld +
                            "gravity = [0, 0, -9810]\n"
                            "results = [{name = \"tip\", point = [50, 100, 0]}]\n";
  const auto report = report_of(
      c, square_plate(steel +
                      "spectrum = {direction = [0, 0, 1], damping = 0.05, points = [[1, 9810], "
                      "[1000, 9810]]}\n"))["stress"];
  const auto &weight = report["cases"][0], &spectrum = report["spectrum"];
  // The first mode of a cantilever has 1.013 times the deflection of its tip.
  CHECK(number(spectrum["points"][0]["displacement"][2]) ==
        Approx(-1.013 * number(weight["results"][0]["displacement_vector"][2])).epsilon(0.02));
  CHECK(number(spectrum["mass_fraction"]) > 0.8);
  CHECK(number(spectrum["mass_fraction"]) <= 1);
  CHECK(number(spectrum["reactions"][0]["force"][2]) < std::abs(number(weight["force"][2])));
  CHECK(number(spectrum["reactions"][0]["force"][2]) > 0.6 * std::abs(number(weight["force"][2])));
  CHECK(number(spectrum["max_von_mises"]) == Approx(number(weight["max_von_mises"])).epsilon(0.2));
  CHECK(fs::exists(c / "out/plate_spectrum.vtu"));
  expect_refusal(
      c, steel + "spectrum = {direction = [0, 0, 1], damping = 0.05, points = [[2, 1], [1, 1]]}\n",
      {"ascending"});
  expect_refusal(c,
                 steel + "spectrum = {direction = [0, 0, 0], damping = 0.05, points = [[1, 1]]}\n",
                 {"direction"});
}

TEST_CASE("loads from files are those of formulas", "[apps][stress]") {
  const CliCase c("stress_fields");
  std::string table = "x [mm],y [mm],z [mm],p [Pa]\n";
  for (int i = 0; i <= 100; ++i)
    for (int j = 0; j <= 100; ++j)
      table +=
          std::to_string(i) + "," + std::to_string(j) + ",0," + std::to_string(10 * i + j) + "\n";
  c.file("cfd.csv", table);
  const std::string steel = "material = \"steel\"\nthickness = 1\n" + kHeld;
  const std::string field = "[[field]]\nname = \"p_cfd\"\nfile = \"cfd.csv\"\n";
  const auto solved = [&](const std::string& load, const std::string& more) {
    return report_of(c,
                     square_plate(steel + "loads = [" + load + "]\n") + more)["stress"]["cases"][0];
  };
  const auto formula = solved("{pressure = \"-1e-6 * (10 * x + y)\"}", "");
  const auto mapped = solved("{pressure = \"-1e-6 * p_cfd\"}", field);
  // The nearest point is at most half a millimetre away.
  CHECK(number(mapped["max_displacement"]) ==
        Approx(number(formula["max_displacement"])).epsilon(5e-3));
  const auto heat = solved("{temperature = \"p_cfd / 100\"}", field);
  CHECK(number(heat["max_displacement"]) ==
        Approx(number(solved("{temperature = \"0.1 * x + 0.01 * y\"}", "")["max_displacement"]))
            .epsilon(5e-3));
  const auto refuse = [&](const std::string& load, const std::string& more,
                          const std::string& part) {
    c.file("s.toml", square_plate(steel + "loads = [" + load + "]\n") + more);
    const CliResult r = c.run({"stress", "s.toml", "--out", "out2"});
    INFO(r.err);
    CHECK(r.code == 1);
    CHECK(r.err.find(part) != std::string::npos);
  };
  refuse("{pressure = \"p_cfd\"}", "", "found 'p_cfd'");
  c.file("m.csv", "0 0 0 1\n0.1 0 0 1\n0 0.1 0 1\n");
  c.file("um.csv", "0 0 0 1\n1e5 0 0 1\n0 1e5 0 1\n");
  for (const char* file : {"m.csv", "um.csv"})
    refuse("{pressure = \"p_cfd\"}",
           "[[field]]\nname = \"p_cfd\"\nfile = \"" + std::string(file) + "\"\n",
           "check the unit of the file");
  refuse("{pressure = \"p_cfd\"}", "[[field]]\nname = \"p_cfd\"\nfile = \"none.csv\"\n",
         "none.csv");
  refuse("{pressure = \"x\"}", "[[field]]\nname = \"x\"\nfile = \"cfd.csv\"\n", "'x'");
}

TEST_CASE("invalid plies, stacking sequences and temperatures are refused", "[apps][stress]") {
  const CliCase c("stress_plies_refused");
  const std::string layup = kCarbon + kHeld + "ply_thickness = 0.1\nlayup = ";
  expect_refusal(c, layup + "\"[0/x]s\"\n",
                 {"s.toml:", "found 'x', expected angles between slashes"});
  expect_refusal(c, layup + "\"[0/90\"\n", {"found '[' without ']'"});
  expect_refusal(c, layup + "\"[0/90]q\"\n", {"found 'q'"});
  expect_refusal(c, layup + "\"[0_x/90]\"\n", {"after '_'"});
  expect_refusal(c, layup + "\"[0//90]\"\n", {"found ''"});
  expect_refusal(c, kCarbon + kHeld + "layup = \"[0]\"\n", {"'layup' without 'ply_thickness'"});
  expect_refusal(c, layup + "\"[0]\"\nthickness = 1\n", {"'thickness' beside plies"});
  expect_refusal(c, layup + "\"[0]\"\nplies = [{thickness = 1}]\n", {"both 'plies' and 'layup'"});
  expect_refusal(c, kHeld + "plies = [{thickness = 1, material = \"alumnium\"}]\n",
                 {"the material 'alumnium'", "did you mean 'aluminium'"});
  expect_refusal(c, kHeld + "plies = [{thickness = 1, material = \"steel\", angle = 30}]\n",
                 {"'material_direction'"});
  expect_refusal(
      c, kHeld + "material = \"steel\"\nthickness = 1\nmaterials = [{name = \"x\", young = 1}]\n",
      {"'materials' without 'plies'"});
  expect_refusal(c, kHeld + "young = 210e3\nthickness = 1\nloads = [{temperature = 1}]\n",
                 {"without 'expansion'"});
  expect_refusal(
      c,
      kHeld + "material = \"steel\"\nthickness = 1\nloads = [{temperature = 1, curve = \"a\"}]\n",
      {"'curve' beside 'temperature'"});
  expect_refusal(c, kHeld + "material = \"steel\"\nthickness = 1\nreference_surface = \"upper\"\n",
                 {"reference_surface"});
  expect_refusal(c,
                 kHeld +
                     "material = \"steel\"\nthickness = 1\n"
                     "strength = {tension = 1, compression = -1, shear = 1}\n",
                 {"a stress above 0"});
}

TEST_CASE("hoop and meridional stresses of a cylinder under pressure, and the linearised stress",
          "[apps][stress]") {
  const CliCase c("stress_revolution");
  const auto arc = [](const std::string& name, int z) {
    std::ostringstream points;
    points.precision(15);
    for (int k = 0; k <= 18; ++k) {
      const double t = k * std::acos(0.0) / 18;
      points << (k ? ", [" : "[") << 100 * std::cos(t) << ", " << 100 * std::sin(t) << ", " << z
             << "]";
    }
    return "[[curve]]\nname = \"" + name + "\"\npoints = [" + points.str() + "]\n";
  };
  const auto shell = [&](const std::string& more) {
    return "name = \"shell\"\nunit = \"mm\"\n[mesh]\nedge_length = 12\n" + arc("low", 0) +
           "[[curve]]\nname = \"gy\"\npoints = [[0, 100, 0], [0, 100, 80]]\n" + arc("high", 80) +
           "[[curve]]\nname = \"gx\"\npoints = [[100, 0, 0], [100, 0, 80]]\n[stress]\n"
           "material = \"steel\"\nthickness = 1\nsupports = [{curve = \"gx\", type = "
           "\"symmetric\", "
           "normal = [0, 1, 0]}, {curve = \"gy\", type = \"symmetric\", normal = [1, 0, 0]}, "
           "{curve = \"low\", directions = [[0, 0, 1]]}]\n" +
           more;
  };
  // Pressure and an axial force: p R/t around, F along.
  const double p = 0.1, along = 5;
  const std::string axis = "axis = [0, 0, 1]";
  const auto report =
      report_of(c, shell("results = [{name = \"wall\", point = [70.71, 70.71, 40], " + axis +
                         "}, {curve = \"high\", " + axis +
                         "}]\nloads = [{pressure = 0.1}, {curve = \"high\", "
                         "force = [0, 0, 5]}]\n"));
  const auto& wall = report["stress"]["cases"][0]["results"][0];
  const double around = std::abs(number(wall["hoop_top_middle_bottom"][1]));
  CHECK(around == Approx(p * 100).epsilon(2e-3));
  for (size_t k = 0; k < 3; ++k) {
    CHECK(number(wall["meridional_top_middle_bottom"][k]) == Approx(along).epsilon(0.01));
    CHECK(std::abs(number(wall["shear_top_middle_bottom"][k])) < 0.01 * p * 100);
  }
  // The normal may point inwards: the pressure is then compressive, and the axial stress the larger.
  const bool outwards = number(wall["hoop_top_middle_bottom"][1]) > 0;
  const auto& direction = wall["principal_directions_top_middle_bottom"][1];
  CHECK(std::abs(number(direction[2])) == Approx(outwards ? 0 : 1).margin(0.01));
  const double hoop = number(wall["hoop_top_middle_bottom"][1]);
  CHECK(number(wall["von_mises_membrane"]) ==
        Approx(std::sqrt(hoop * hoop - hoop * along + along * along)).epsilon(5e-3));
  CHECK(number(wall["von_mises_bending"]) < 0.02 * p * 100);
  const std::string table = contents(c / "out/shell_loads_high.csv");
  CHECK(table.find(",von_mises_membrane [N/mm²],von_mises_bending [N/mm²],hoop_top [N/mm²],"
                   "hoop_middle [N/mm²],hoop_bottom [N/mm²],meridional_top") != std::string::npos);
  // There is no hoop direction on the axis, no axis of a face, and no origin without an axis.
  for (const auto& [results, message] :
       {std::pair<std::string, std::string>{
            "{point = [100, 0, 40], axis = [0, 0, 1], origin = [100, 0, 0]}", "no hoop direction"},
        {"{face = \"shell\", " + axis + "}", "an axis for a face"},
        {"{curve = \"high\", origin = [0, 0, 0]}", "'origin' without 'axis'"}}) {
    c.file("s.toml", shell("results = [" + results + "]\npressure = 0.1\n"));
    const CliResult r = c.run({"stress", "s.toml", "--out", "out2"});
    INFO(results << "\n" << r.err);
    CHECK(r.code == 1);
    CHECK(r.err.find(message) != std::string::npos);
  }
}
