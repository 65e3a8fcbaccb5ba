// SPDX-License-Identifier: MPL-2.0
// batten stress: its results, its files, and its error messages.
#include "batten/tests/apps/cli_case.h"

#include <cmath>

#include "batten/core/eigen.h"

using namespace batten_test;
using batten::Vec3;

namespace {

std::string line_of(const std::string& name, const std::string& points) {
  return "[[curve]]\nname = \"" + name + "\"\npoints = " + points + "\n";
}

// A plate of 100 by 100, of steel in mm.
std::string plate(const std::string& stress) {
  return "name = \"plate\"\nunit = \"mm\"\n" + line_of("a", "[[0,0,0],[100,0,0]]") +
         line_of("b", "[[100,0,0],[100,100,0]]") + line_of("c", "[[100,100,0],[0,100,0]]") +
         line_of("d", "[[0,100,0],[0,0,0]]") + "[mesh]\nedge_length = 20\n[stress]\n" + stress +
         "\n";
}

const std::string kSteel = "thickness = 1\nmaterial = \"steel\"\n";
const std::string kClamped = "supports = [{curve = \"a\"}]\n";

void refused(const CliCase& c, const std::string& stress, int code,
             const std::vector<std::string>& parts) {
  c.file("s.toml", plate(stress));
  const CliResult r = c.run({"stress", "s.toml", "--out", "out"});
  INFO(stress << "\n" << r.err);
  CHECK(r.code == code);
  for (const std::string& part : parts) CHECK(r.err.find(part) != std::string::npos);
  CHECK_FALSE(fs::exists(c / "out"));
}

nlohmann::json stress_of(const CliCase& c, const std::string& scene) {
  c.file("s.toml", scene);
  const CliResult r = c.run({"stress", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE((r.code == 0 || r.code == 4));  // pictures need a display
  return nlohmann::json::parse(contents(c / "out/report.json"))["stress"];
}

}  // namespace

TEST_CASE("a stress analysis reports displacements, stresses and reactions", "[apps][stress]") {
  const CliCase c("stress_plate");
  const auto stress = stress_of(
      c,
      plate(
          kSteel + kClamped +
          "yield = 235\nmodes = 2\n"
          "loads = [{curve = \"c\", force = [0, 0, -0.01]}, {case = \"wind\", pressure = 1e-4}]\n"
          "combinations = [{name = \"both\", cases = [\"loads\", \"wind\"], factors = [2, -1]}]"));
  REQUIRE(stress["cases"].size() == 3);
  const auto &tip = stress["cases"][0], &wind = stress["cases"][1], &both = stress["cases"][2];
  // A cantilever: w = F L³ / 3EI; a plate of width 100 is slightly stiffer.
  const double beam = 0.01 * 1e6 / (3 * 210000.0 / 12);
  CHECK(tip["max_displacement"].get<double>() == Approx(beam).epsilon(0.08));
  CHECK(tip["displacement"][2].get<double>() < 0);
  CHECK(tip["max_von_mises"].get<double>() == Approx(6.0).epsilon(0.2));
  CHECK(tip["safety_factor"].get<double>() == Approx(235 / tip["max_von_mises"].get<double>()));
  CHECK(tip["reactions"][0]["support"] == "clamped a");
  CHECK(tip["reactions"][0]["force"][2].get<double>() == Approx(1));
  CHECK(tip["equilibrium_residual"].get<double>() < 1e-8);
  CHECK(wind["force"][2].get<double>() == Approx(1));
  CHECK(both["combination"]);
  CHECK(both["displacement"][2].get<double>() ==
        Approx(2 * tip["displacement"][2].get<double>() - wind["displacement"][2].get<double>())
            .epsilon(1e-3));
  // Of a square cantilever plate with ν = 0.3: 3.47 and 8.51 √(D/ρt)/2πL².
  const double unit = std::sqrt(210000.0 / (12 * 0.91) / 7.85e-9) / (2 * std::acos(-1.0) * 1e4);
  CHECK(stress["frequencies"][0].get<double>() == Approx(3.47 * unit).epsilon(0.01));
  CHECK(stress["frequencies"][1].get<double>() == Approx(8.51 * unit).epsilon(0.01));
  for (const char* file : {"plate_loads.vtu", "plate_wind.vtu", "plate_both.vtu",
                           "plate_modes_1.vtu", "plate_modes.pvd"})
    CHECK(fs::exists(c / "out" / file));
}

TEST_CASE("sensitivities agree with solutions for other parameter values", "[apps][stress]") {
  const CliCase c("stress_sensitivity");
  const auto with = [&](double swell) {
    const std::string load =
        "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = " + std::to_string(swell) +
        "\nmin = 0\nmax = 200\n";
    std::string scene =
        plate(kSteel +
              "sensitivities = true\nsupports = [{curve = \"a\"}, {curve = \"c\", type = "
              "\"pinned\"}]\npressure = -1e-2");
    return stress_of(c, scene.insert(scene.find("[stress]"), load));
  };
  const auto here = with(20), up = with(20.2), down = with(19.8);
  const auto& s = here["sensitivities"][0];
  CHECK(s["parameter"] == "swell");
  const auto difference = [&](const char* key, double times) {
    return times * (up["cases"][0][key].get<double>() - down["cases"][0][key].get<double>()) / 0.4;
  };
  CHECK(s["max_displacement"].get<double>() ==
        Approx(difference("max_displacement", 1)).epsilon(1e-2));
  CHECK(s["compliance"].get<double>() == Approx(difference("strain_energy", 2)).epsilon(1e-2));
}

TEST_CASE("a sweep reports the stresses of each shape", "[apps][stress]") {
  const CliCase c("stress_sweep");
  const std::string load =
      "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nmin = 0\nmax = 200\nvalue = 0\n";
  std::string scene = plate(kSteel +
                            "supports = [{curve = \"a\"}, {curve = \"c\", type = \"pinned\"}]\n"
                            "pressure = -1e-2");
  c.file("s.toml", scene.insert(scene.find("[stress]"), load));
  const CliResult r =
      c.run({"sculpt", "s.toml", "--sweep", "swell=0:40:3", "--stress", "--out", "out"});
  INFO(r.err);
  const auto rows =
      nlohmann::json::parse(contents(c / "out/report.json"))["sculpting"]["sweeps"][0]["rows"];
  REQUIRE(rows.size() == 3);
  // A vault is stiffer than a plate.
  CHECK(rows[1]["max_displacement"].get<double>() < rows[0]["max_displacement"].get<double>());
  CHECK(rows[2]["max_von_mises"].get<double>() < rows[0]["max_von_mises"].get<double>());
  CHECK(c.run({"sculpt", "s.toml", "--stress", "--out", "out2"}).code == 1);
}

TEST_CASE("a plate on a foundation sinks by weight over stiffness, an orthotropic one as in theory",
          "[apps][stress]") {
  const CliCase c("stress_springs");
  const auto sunk = stress_of(c, plate(kSteel + "supports = [{foundation = 0.5}, {curve = \"a\", "
                                                "spring = [1, 1, 0]}]\npressure = -0.02"));
  CHECK(sunk["cases"][0]["displacement"][2].get<double>() == Approx(-0.04).epsilon(1e-6));
  const auto tip = [&](const std::string& along) {
    return stress_of(c,
                     plate("thickness = 1\nyoung = [100000, 10000]\nshear_modulus = 5000\npoisson "
                           "= 0\nmaterial_direction = " +
                           along + "\n" + kClamped +
                           "loads = [{curve = \"c\", force = [0, 0, -0.01]}]"))["cases"][0]
                                                                               ["max_displacement"]
                                                                                   .get<double>();
  };
  CHECK(tip("[0, 1, 0]") == Approx(0.01 * 1e6 / (3 * 1e5 / 12)).epsilon(1e-2));
  CHECK(tip("[1, 0, 0]") == Approx(10 * tip("[0, 1, 0]")).epsilon(1e-2));
  const CliCase bad("stress_springs_refused");
  refused(bad, kSteel + "supports = [{foundation = 1, curve = \"a\"}]", 1,
          {"'foundation' with a curve or a point"});
  refused(bad, kSteel + "supports = [{curve = \"a\", spring = [0, 0, 0]}]", 1,
          {"a negative stiffness, or three zeros"});
  refused(bad, "thickness = 1\nyoung = [1e5, 1e4]\n" + kClamped, 1, {"'shear_modulus'"});
}

TEST_CASE("parts in boxes and painted thickness", "[apps][stress]") {
  const CliCase c("stress_parts");
  // Two jaws clamp the plate at its ends; a weight is in the middle.
  const auto held = stress_of(
      c,
      plate(kSteel + "thicknesses = [{near = \"c\", radius = 40, thickness = 2},\n"
                     "  {paint = [{at = [50, 50, 0], radius = 20}], thickness = 1.5}]\n"
                     "supports = [{box = [[-1, 10, -1], [101, -1, 1]]},\n"
                     "  {curve = \"c\", box = [[-1, 99, -1], [50, 101, 1]], type = \"pinned\"}]\n"
                     "loads = [{traction = [0, 0, -0.01], box = [[40, 40, -1], [60, 60, 1]]},\n"
                     "  {curve = \"b\", force = [0, 0, -1], box = [[99, 0, -1], [101, 50, 1]]}]"));
  const auto& loads = held["cases"][0];
  CHECK(loads["force"][2].get<double>() == Approx(-4 - 50).epsilon(0.02));
  CHECK(loads["equilibrium_residual"].get<double>() < 1e-8);
  REQUIRE(loads["reactions"].size() == 2);
  CHECK(loads["reactions"][0]["support"] == "pinned c in the box [-1, 99, -1] to [50, 101, 1]");
  const CliCase bad("stress_parts_refused");
  refused(bad, kSteel + "supports = [{box = [[0, 0, 0], [1, 1, 0]]}]", 1, {"a flat box"});
  refused(bad, kSteel + "supports = [{box = [[0, 0, 0]]}]", 1, {"1 corners"});
  refused(bad, kSteel + "supports = [{box = [[7, 7, 7], [8, 8, 8]]}]", 1, {"contains no part"});
  refused(bad, kSteel + "supports = [{box = [[-1, -1, -1], [9, 9, 9]], rotation = true}]", 1,
          {"'rotation' without a curve"});
  refused(bad, kSteel + "supports = [{curve = \"a\", point = [0, 0, 0]}]", 1,
          {"more than one location"});
  refused(bad, kSteel + kClamped + "loads = [{pressure = 1, box = [[7, 7, 7], [8, 8, 8]]}]", 1,
          {"s.toml:21", "in the box from [7, 7, 7] to [8, 8, 8]"});
  refused(bad, kSteel + kClamped + "thicknesses = [{thickness = 2}]", 1,
          {"a thickness without a location"});
}

TEST_CASE("supports that hardly hold are warned of", "[apps][stress]") {
  const CliCase c("stress_weak");
  c.file("s.toml", plate(kSteel + "supports = [{point = [0, 50, 0]}, {point = [100, 50, 0]},\n"
                                  "  {point = [50, 50.5, 0], directions = [[0, 0, 1]]}]\n"
                                  "loads = [{point = [50, 60, 0], force = [0, 0, -1]}]"));
  const CliResult r = c.run({"stress", "s.toml", "--out", "out"});
  INFO(r.err);
  CHECK(r.err.find("the supports hardly prevent a rigid-body motion: the whole model can rotate "
                   "about the axis along [1, ") != std::string::npos);
}

TEST_CASE("the name of a curve in 'supports' clamps it", "[apps][stress]") {
  const CliCase c("stress_names");
  const std::string loads = "pressure = -1e-3";
  const auto tables = stress_of(
      c,
      plate(kSteel + "supports = [{curve = \"a\"}, {curve = \"b\", type = \"pinned\"}]\n" + loads));
  const auto names = stress_of(
      c, plate(kSteel + "supports = [\"a\", {curve = \"b\", type = \"pinned\"}]\n" + loads));
  CHECK(names == tables);
  const CliCase wrong("stress_wrong_names");
  refused(wrong, kSteel + "supports = [\"aa\"]", 1, {"found the curve 'aa'"});
  refused(wrong, kSteel + "supports = [3]", 1, {"expected a table or a name"});
}

TEST_CASE("the same plate in m and in mm has the same stresses", "[apps][stress]") {
  const CliCase c("stress_units");
  const auto mm = stress_of(c, plate(kSteel + kClamped + "gravity = [0, 0, -9810]"));
  std::string in_m =
      plate("thickness = 0.001\nmaterial = \"steel\"\n" + kClamped + "gravity = [0, 0, -9.81]");
  in_m.replace(in_m.find("\"mm\""), 4, "\"m\"");
  for (size_t at; (at = in_m.find("100")) != std::string::npos;) in_m.replace(at, 3, "0.1");
  in_m.replace(in_m.find("edge_length = 20"), 16, "edge_length = 0.02");
  const auto m = stress_of(c, in_m);
  const auto of = [](const auto& s, const char* key) {
    return s["cases"][0][key].template get<double>();
  };
  CHECK(of(m, "max_displacement") == Approx(1e-3 * of(mm, "max_displacement")).epsilon(1e-6));
  CHECK(of(m, "max_von_mises") == Approx(1e6 * of(mm, "max_von_mises")).epsilon(1e-6));
}

TEST_CASE("invalid settings of a stress analysis are refused with their position",
          "[apps][stress]") {
  const CliCase c("stress_refused");
  refused(c, kSteel, 1, {"found no supports", "supports = [{curve"});
  refused(c, kSteel + "supports = [{type = \"clamped\"}]", 1, {"a support without a location"});
  refused(c, kSteel + "supports = [{curve = \"aa\"}]", 1,
          {"s.toml:", "found the curve 'aa'", "'a'"});
  refused(c, "thickness = -1\nmaterial = \"steel\"\n" + kClamped, 1, {"'thickness'", "-1"});
  refused(c, "thickness = 1\nmaterial = \"stele\"\n" + kClamped, 1, {"did you mean 'steel'"});
  refused(c, "thickness = 1\nyoung = 210e9\n" + kClamped, 1, {"N/mm² (steel: 210000), not Pa"});
  refused(c, "thickness = 1\nyoung = 210e3\ndensity = 7850\n" + kClamped, 1,
          {"t/mm³", "not kg/m³"});
  refused(c, kSteel + kClamped + "loads = [{point = [50, 50, 80], force = [0, 0, 1]}]", 1,
          {"s.toml:", "at a distance of 80 mm from the surface"});
  refused(c, kSteel + kClamped + "loads = [{force = [0, 0, 1]}]", 1,
          {"'force' without a location"});
  refused(c, kSteel + kClamped + "loads = [{pressure = 1, moment = 2}]", 1,
          {"two types of load in one entry"});
  refused(c, kSteel + kClamped + "loads = [{pressure = 1, face = \"top\"}]", 1,
          {"found the face 'top'"});
  refused(c, kSteel + kClamped + "hinges = [\"c\"]", 1,
          {"found the hinge 'c', which is a free edge"});
  refused(c,
          kSteel + kClamped + "combinations = [{name = \"x\", cases = [\"snow\"], factors = [1]}]",
          1, {"the case 'snow'"});
  refused(c, kSteel + "supports = [{curve = \"a\", type = \"pinned\"}]\npressure = 1", 3,
          {"the supports do not constrain the shell: the whole model can rotate about the axis "
           "along [1, 0, 0]"});
  refused(c, "thickness = 1\nyoung = 1000\n" + kClamped + "gravity = [0, 0, 1]", 1, {"'density'"});
}

TEST_CASE("an unconnected face is named", "[apps][stress]") {
  const CliCase c("stress_free");
  const std::string far =
      line_of("e", "[[300,0,0],[400,0,0]]") + line_of("f", "[[400,0,0],[400,100,0]]") +
      line_of("g", "[[400,100,0],[300,100,0]]") + line_of("h", "[[300,100,0],[300,0,0]]");
  std::string scene = plate(kSteel + kClamped + "pressure = 1");
  scene.insert(scene.find("[mesh]"), far + "\n");
  c.file("s.toml", scene);
  const CliResult r = c.run({"stress", "s.toml", "--out", "out"});
  INFO(r.err);
  CHECK(r.code == 3);
  CHECK(r.err.find("the supports do not constrain the shell: face '") != std::string::npos);
  CHECK_FALSE(fs::exists(c / "out"));
}

TEST_CASE("smaller elements where the error is make displacements as exact as asked for",
          "[apps][stress]") {
  const CliCase c("stress_accuracy");
  // Half of a side is supported: stresses are singular at its end.
  c.file("s.toml", plate(kSteel + "supports = [{curve = \"a\", box = [[-1, -1, -1], [50, 1, 1]]}]\n"
                                  "loads = [{curve = \"c\", force = [0, 0, -0.01]}]"));
  const auto at = [&](const std::string& accuracy, const std::string& out) {
    const CliResult r = c.run({"stress", "s.toml", "--accuracy", accuracy, "--out", out});
    INFO(r.err);
    REQUIRE((r.code == 0 || r.code == 4));
    return nlohmann::json::parse(contents(c / out / "report.json"))["stress"];
  };
  const auto coarse = at("0.01", "coarse"), fine = at("0.001", "fine");
  CHECK(fine["unknowns"].get<int>() > coarse["unknowns"].get<int>());
  const auto of = [](const auto& s) {
    return s["cases"][0]["max_displacement"].template get<double>();
  };
  CHECK(of(coarse) == Approx(of(fine)).epsilon(0.02));
  CHECK(fine["meshes"].back()["displacement_error"].get<double>() <= 1e-3);
  // Uniform bisection with as many iterations would give more elements.
  const auto& meshes = fine["meshes"];
  const double grown =
      meshes.back()["unknowns"].get<double>() / meshes[0]["unknowns"].get<double>();
  CHECK(grown < std::pow(2.0, static_cast<double>(meshes.size()) - 1) / 2);
}

TEST_CASE("two processes give the same result as one", "[apps][stress]") {
  const fs::path module = fs::path(BATTEN_CLI).parent_path() / "batten_petsc.so";
  if (!fs::exists(module) || std::system("command -v mpirun > /dev/null") != 0) {
    WARN("no PETSc or mpirun here: skipped");
    return;
  }
  const CliCase c("stress_processes");
  c.file("s.toml", plate(kSteel + kClamped + "modes = 2\npressure = 1e-4"));
  const auto run = [&](const std::string& before, const std::string& out) {
    const std::string command = "cd '" + c.folder().string() + "' && " + before + " '" +
                                std::string(BATTEN_CLI) + "' stress s.toml --out " + out +
                                " > log 2>&1";
    std::system(command.c_str());  // 4 without a display
    return nlohmann::json::parse(contents(c / out / "report.json"))["stress"];
  };
  const auto one = run("", "one"),
             two = run("mpirun --allow-run-as-root --oversubscribe -n 2", "two");
  for (const char* key : {"max_displacement", "max_von_mises"})
    CHECK(two["cases"][0][key].get<double>() ==
          Approx(one["cases"][0][key].get<double>()).epsilon(1e-10));
  CHECK(two["frequencies"][1].get<double>() ==
        Approx(one["frequencies"][1].get<double>()).epsilon(1e-8));
  // Another solver rounds differently: of these numbers at least one has other bits.
  const auto rounded = [](const auto& s) {
    return std::vector<double>{s["cases"][0]["max_displacement"], s["cases"][0]["max_von_mises"],
                               s["frequencies"][0], s["frequencies"][1]};
  };
  CHECK(rounded(two) != rounded(one));
  // An insufficiently supported shell stops all processes.
  c.file("s.toml", plate(kSteel + "supports = [{curve = \"a\", type = \"pinned\"}]\npressure = 1"));
  const std::string refused = "cd '" + c.folder().string() +
                              "' && mpirun --allow-run-as-root --oversubscribe -n 2 '" +
                              std::string(BATTEN_CLI) + "' stress s.toml --out no > log 2>&1";
  CHECK(std::system(refused.c_str()) != 0);
  CHECK(contents(c / "log").find("the supports do not constrain the shell") != std::string::npos);
}

TEST_CASE("CalculiX is asked about the same shell, and a missing one is named", "[apps][stress]") {
  const CliCase c("stress_ccx");
  std::string scene = plate(kSteel + kClamped + "pressure = -1e-3");
  scene.replace(scene.find("edge_length = 20"), 16, "edge_length = 8");
  c.file("s.toml", scene);
  setenv("CCX", "/no/such/ccx", 1);
  const CliResult missing = c.run({"stress", "s.toml", "--out", "out", "--with-ccx"});
  unsetenv("CCX");
  CHECK(missing.code == 1);
  CHECK(missing.err.find("found no program '/no/such/ccx', expected CalculiX") !=
        std::string::npos);
  CHECK_FALSE(fs::exists(c / "out"));
  if (std::system("command -v ccx > /dev/null") != 0) {
    WARN("no ccx here: skipped");
    return;
  }
  const CliResult r = c.run({"stress", "s.toml", "--out", "out", "--with-ccx"});
  INFO(r.err);
  const auto found = nlohmann::json::parse(contents(c / "out/report.json"))["stress"]["cases"][0];
  CHECK(found["calculix"]["max_displacement"].get<double>() ==
        Approx(found["max_displacement"].get<double>()).epsilon(0.02));
  CHECK(fs::exists(c / "out/plate_loads_ccx.inp"));
  CHECK(fs::exists(c / "out/plate_loads_ccx.frd"));
  CHECK_FALSE(fs::exists(c / "out/spooles.out"));
}

TEST_CASE("a deck that cannot hold the loads of a scene is refused", "[apps][stress]") {
  const CliCase c("stress_deck");
  const std::string deck = "\n[output]\ncalculix = \"p.inp\"";
  c.file("s.toml", plate(kSteel + kClamped + "hinges = [\"a\"]\npressure = 1" + deck));
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  CHECK(r.code == 1);
  CHECK(r.err.find("which 'p.inp' cannot contain; use `batten stress`") != std::string::npos);
}

TEST_CASE("a plate without supports has six rigid-body modes and those of Leissa",
          "[apps][stress]") {
  const CliCase c("stress_free");
  const auto stress = stress_of(c, plate(kSteel + "modes = 6"));
  CHECK(stress["cases"].empty());
  REQUIRE(stress["frequencies"].size() == 12);
  for (int k = 0; k < 6; ++k) CHECK(stress["frequencies"][k] == 0);
  const double unit = std::sqrt(210000.0 / (12 * 0.91) / 7.85e-9) / (2 * std::acos(-1.0) * 1e4);
  const double roots[] = {13.468, 19.596, 24.270, 34.801, 34.801, 61.093};
  for (int k = 0; k < 6; ++k)
    CHECK(stress["frequencies"][6 + k].get<double>() == Approx(roots[k] * unit).epsilon(5e-3));
  CHECK(stress["mass"].get<double>() == Approx(7.85e-9 * 1e4));
  CHECK_FALSE(fs::exists(c / "out/plate_modes_1.gif"));
}

TEST_CASE("inertia relief gives the response of a free plate, whatever accelerates it",
          "[apps][stress]") {
  const CliCase c("stress_inertia_relief");
  const std::string push = "{point = [50, 50, 0], force = [0, 0, 1]}";
  const auto alone = stress_of(c, plate(kSteel + "inertia_relief = true\nloads = [" + push + "]"));
  const auto lifted = stress_of(
      c, plate(kSteel + "inertia_relief = true\nloads = [" + push + "]\ngravity = [0, 0, -9810]"));
  const auto of = [](const auto& s, const char* key) {
    return s["cases"][0][key].template get<double>();
  };
  CHECK(of(alone, "max_displacement") > 0);
  CHECK(of(alone, "max_displacement") == Approx(of(lifted, "max_displacement")).epsilon(1e-6));
  CHECK(of(alone, "equilibrium_residual") < 1e-8);
}

TEST_CASE("inertia relief needs a density, and no supports", "[apps][stress]") {
  const CliCase c("stress_inertia_refused");
  refused(c, kSteel + kClamped + "inertia_relief = true", 1, {"supports and inertia_relief"});
  refused(c, kSteel + "inertia_relief = true\npressure = 1\nsensitivities = true", 1,
          {"sensitivities"});
  refused(c, "thickness = 1\nyoung = 210e3\ninertia_relief = true\npressure = 1", 1, {"density"});
  refused(c, kSteel + "pressure = 1", 1, {"found no supports", "inertia_relief = true"});
}

TEST_CASE("a couple is in balance", "[apps][stress]") {
  const CliCase c("stress_couple");
  const auto stress = stress_of(
      c, plate(kSteel + kClamped +
               "loads = [{point = [0, 100, 0], force = [0, 0, -1]}, {point = [100, 100, 0], force "
               "= [0, 0, 1]}]"));
  CHECK(stress["cases"][0]["equilibrium_residual"].get<double>() < 1e-8);
}

TEST_CASE("an accuracy applies to the stress at a hole, and stresses that have no limit are named",
          "[apps][stress]") {
  const CliCase c("stress_hole");
  const auto side = [](const std::string& name, int x0, int y0, int x1, int y1) {
    const auto at = [](int x, int y) {
      return "[" + std::to_string(x) + ", " + std::to_string(y) + ", 0]";
    };
    return line_of(name, "[" + at(x0, y0) + ", " + at(x1, y1) + "]");
  };
  const std::string sheet = "name = \"sheet\"\nunit = \"mm\"\n" +
                            side("left", -200, -100, -200, 100) + side("top", -200, 100, 200, 100) +
                            side("right", 200, 100, 200, -100) +
                            side("bottom", 200, -100, -200, -100);
  c.file("hole.toml",
         sheet +
             "[[curve]]\nname = \"hole\"\ncircle = {centre = [0, 0, 0], radius = 10}\nrole = "
             "\"hole\"\n[stress]\n" +
             kSteel +
             "supports = [{point = [-200, -100, 0]}, {point = [-200, 100, 0], directions = [[1, 0, "
             "0], [0, 0, 1]]}, {point = [200, 100, 0], directions = [[0, 0, 1]]}]\n"
             "loads = [{curve = \"right\", force = [100, 0, 0]}, {curve = \"left\", force = [-100, "
             "0, 0]}]\n");
  const auto at = [&](const std::string& scene) {
    const CliResult r = c.run({"stress", scene + ".toml", "--out", "out", "--accuracy", "0.01"});
    INFO(r.err);
    CHECK((r.code == 0 || r.code == 4));
    return nlohmann::json::parse(contents(c / "out/report.json"));
  };
  const auto hole = at("hole");
  // Howland: 3.02 times the stress of the whole section.
  CHECK(hole["stress"]["cases"][0]["max_von_mises"].get<double>() == Approx(302).epsilon(0.015));
  CHECK(hole["stress"]["meshes"].back()["stress_error"].get<double>() <= 0.01);
  // A clamped end with free sides is singular at its corners.
  c.file("clamped.toml", sheet + "[stress]\n" + kSteel +
                             "supports = [{curve = \"left\"}]\nloads = [{curve = \"right\", force "
                             "= [100, 0, 0]}]\n");
  const auto clamped = at("clamped");
  CHECK(clamped["warnings"].dump().find("is singular") != std::string::npos);
}

TEST_CASE("loads that vary with the position", "[apps][stress]") {
  const CliCase c("stress_varying");
  const auto solved = [&](const std::string& load, const std::string& supports) {
    const auto found = stress_of(c, plate(kSteel + supports + "loads = [" + load + "]\n"));
    return found["cases"][0];
  };
  const auto number = [](const nlohmann::json& value) { return value.get<double>(); };
  const auto force = [&](const std::string& load) {
    const auto f = solved(load, kClamped)["force"];
    return Vec3(number(f[0]), number(f[1]), number(f[2]));
  };
  // Simply supported, sin sin: w = q a⁴ / (4 π⁴ D).
  const std::string pinned =
      "supports = [{curve = \"a\", type = \"pinned\"}, {curve = \"b\", type = \"pinned\"}, "
      "{curve = \"c\", type = \"pinned\"}, {curve = \"d\", type = \"pinned\"}]\n";
  const auto wave = solved("{pressure = \"1e-3 * sin(pi*x/100) * sin(pi*y/100)\"}", pinned);
  const double D = 210000.0 / (12 * 0.91), pi = std::acos(-1.0);
  CHECK(number(wave["max_displacement"]) ==
        Approx(1e-3 * 1e8 / (4 * std::pow(pi, 4) * D)).epsilon(5e-3));
  CHECK(number(wave["force"][2]) == Approx(1e-3 * 4e4 / (pi * pi)).epsilon(1e-6));
  // The same load in two ways.
  const auto depth = solved("{hydrostatic = 1e-6, level = 20}", kClamped);
  const auto formula = solved("{pressure = \"1e-6 * max(0, 20 - z)\"}", kClamped);
  CHECK(number(formula["max_displacement"]) ==
        Approx(number(depth["max_displacement"])).epsilon(1e-12));
  CHECK(force("{traction = [\"1e-6*x\", 0, \"-2e-6*y\"]}").isApprox(Vec3(0.5, 0, -1), 1e-9));
  CHECK(force("{curve = \"c\", force = [0, 0, \"1e-4*x\"]}").isApprox(Vec3(0, 0, 0.5), 1e-9));
  CHECK(force("{curve = \"c\", edge_force = \"1e-4*x\"}").isApprox(Vec3(0, 0.5, 0), 1e-9));
  const auto moment = solved("{curve = \"c\", moment = \"1e-2 * x\"}", kClamped);
  CHECK(number(moment["reactions"][0]["moment"][0]) == Approx(-50).epsilon(1e-6));

  const CliCase bad("stress_formulas");
  refused(bad, kSteel + kClamped + "loads = [{pressure = \"1e-3 * w\"}]", 1,
          {"s.toml:21:", "found 'w' in the formula '1e-3 * w'"});
  refused(bad, kSteel + kClamped + "loads = [{traction = [0, \"sin(\", 1]}]", 1,
          {"s.toml:21:", "'sin('"});
  refused(bad, kSteel + kClamped + "pressure = \"sqrt(-1 - x)\"", 1,
          {"s.toml:21:", "no finite value at ("});
  refused(bad, kSteel + kClamped + "loads = [{gravity = [0, 0, \"x\"]}]", 1, {"gravity"});
}
