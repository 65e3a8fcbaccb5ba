// SPDX-License-Identifier: MPL-2.0
// Edits of a scene solved for changing values; derivatives, dimensions and requirements.
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include "batten/core/errors.h"
#include "batten/scenes/meshes/design_table.h"
#include "batten/scenes/meshes/dimension_requirements.h"
#include "batten/scenes/meshes/morph_derivatives.h"
#include "batten/scenes/meshes/morph_solver.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;

namespace {

const std::filesystem::path plate_folder = BATTEN_SOURCE_DIR "/examples/10-plate-with-holes";

/// A plate of 300 × 300 with five holes, its left and right sides, and the rules that follow.
DeformScene plate_scene(const std::string& rules) {
  return parse_deform_scene(
      "unit = \"mm\"\nmesh = \"plate.obj\"\n"
      "[[features]]\nof = \"hole-*\"\n"
      "[[select]]\nname = \"left\"\nbox = [[0, 0, -1], [0, 300, 1]]\ngrow = 1\n"
      "[[select]]\nname = \"right\"\nbox = [[300, 0, -1], [300, 300, 1]]\ngrow = 1\n" +
          rules,
      plate_folder / "scene.toml");
}

/// An edit that bends the plate, with features, a plane and a position constraint.
std::string bent_edit(const std::string& rotation_mode) {
  return "[[position_constraint]]\nname = \"corner\"\nat = [150, 300, 0]\nto = [145, 300, 45]\n"
         "weight = 1000\n"
         "[[constraint]]\nname = \"level\"\nof = \"hole-3\"\n"
         "plane = { normal = [0, 0, 1], origin = [0, 0, 50] }\n"
         "[[edit]]\nname = \"bend\"\nfixed = \"left\"\nrotation_mode = \"" +
         rotation_mode +
         "\"\n[[edit.handle]]\nname = \"right\"\ntranslate = [-40, 0, 110]\n"
         "rotate = { axis = [0, -1, 0], angle = 75 }\n"
         "[[edit.scale]]\nfeature = \"hole-1\"\nfactor = 1.1\n";
}
const std::string kMoved =
    "[[edit]]\nname = \"move\"\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\n"
    "translate = [20, 0, 0]\n";

Points solved(const DeformScene& scene, const MeshSource& source) {
  MorphSolver solver(scene, source);
  return solver.solve(scene);
}

double largest(const Points& p) { return p.cwiseAbs().maxCoeff(); }

/// Ridders' extrapolation of central differences: another formula, with other steps.
Points ridders(const std::function<Points(double)>& f, double h) {
  constexpr int levels = 4;
  std::array<Points, levels> table;
  for (int i = 0; i < levels; ++i, h /= 2) {
    Points next = (f(h) - f(-h)) / (2 * h);
    double factor = 1;
    for (int k = 0; k < i; ++k) {
      factor *= 4;
      Points better = (factor * next - table[k]) / (factor - 1);
      table[k] = std::move(next);
      next = std::move(better);
    }
    table[i] = std::move(next);
  }
  return table[levels - 1];
}

}  // namespace

TEST_CASE("values can change in any order", "[scenes][deform]") {
  const MeshSource source = read_source(plate_folder / "plate.obj");
  // Two edits, a scaled feature, a plane, and a position constraint that both edits share.
  const DeformScene scene = plate_scene(
      "[[position_constraint]]\nname = \"corner\"\nat = [300, 300, 0]\nto = [310, 300, 20]\n"
      "weight = 1000\n"
      "[[constraint]]\nname = \"level\"\nof = \"hole-3\"\n"
      "plane = { normal = [0, 0, 1], origin = [0, 0, 5] }\n"
      "[[edit]]\nname = \"first\"\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\n"
      "translate = [20, 0, 10]\n"
      "[[edit]]\nname = \"second\"\nfixed = \"left\"\n[[edit.scale]]\nfeature = \"hole-1\"\n"
      "factor = 1.1\n[[edit.handle]]\nname = \"right\"\nscale = 1.05\n");
  MorphSolver solver(scene, source);
  const double size = source.prepared.mesh.size();
  DeformScene other = scene;
  for (const auto& [name, value] : {std::pair{"second.hole-1.scale", 1.2},
                                    {"first.right.x", 30.0},
                                    {"corner.z", 40.0},
                                    {"level.z", -5.0},
                                    {"second.right.angle", 10.0},
                                    {"corner.z", 20.0}}) {
    INFO(name << " = " << value);
    other.set(name, value, "");
    const Points expected = solved(other, source);
    CHECK(largest(expected - solver.solve(other)) < 1e-11 * size);
    CHECK(largest(expected - solver.solve(scene)) > 1e-6 * size);
    CHECK(largest(solved(scene, source) - solver.shape()) < 1e-11 * size);
  }
}

TEST_CASE("a failed solution leaves the last one", "[scenes][deform]") {
  const MeshSource source = read_source(plate_folder / "plate.obj");
  const DeformScene scene = plate_scene(
      "[[constraint]]\nname = \"level\"\nof = \"right\"\n"
      "plane = { normal = [1, 0, 0], origin = [300, 0, 0] }\n"
      "[[edit]]\nname = \"up\"\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\n"
      "translate = [0, 0, 10]\n"
      "[[edit]]\nname = \"again\"\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\n"
      "translate = [0, 0, 10]\n");
  MorphSolver solver(scene, source);
  DeformScene level = scene;  // the handle is on the plane: the mean of its two columns
  level.set("level.x", solver.mesh().points()(0, 0), "");
  DeformScene valid = scene;
  const VertexCombination centre =
      VertexCombination::mean_of(solver.select().of(LocatedString{"right", {}}));
  valid.set("level.x", centre.at(solver.mesh().points()).x(), "");
  const Points before = solver.solve(valid);
  DeformScene contradictory = valid;
  contradictory.set("again.right.x", 5, "");
  CHECK_THROWS_AS(solver.solve(contradictory), ConflictError);
  CHECK(solver.shape() == before);
  CHECK(solver.scene().edits[1].handles[0].translate.x() == 0);
  contradictory = valid;
  contradictory.set("up.right.x", 5, "");
  CHECK_THROWS_AS(solver.solve(contradictory), ConflictError);
  CHECK(largest(solver.shape() - before) < 1e-12);
  CHECK(solver.edits().size() == 2);
  CHECK(solver.solve(valid) == solver.shape());
}

TEST_CASE("derivatives agree with other differences for every kind of parameter",
          "[scenes][deform]") {
  const MeshSource source = read_source(plate_folder / "plate.obj");
  const std::string mode = GENERATE("estimated", "harmonic", "dual", "nonlinear");
  INFO(mode);
  const DeformScene scene =
      plate_scene(bent_edit(mode) +
                  "[[dimension]]\nname = \"gap\"\ntype = \"distance\"\n"
                  "of = [\"hole-1\", \"hole-2\"]\n"
                  "[[dimension]]\nname = \"bore\"\ntype = \"radius\"\nof = \"hole-1\"\n");
  MorphSolver solver(scene, source, kDerivativeTolerance);
  solver.solve(scene);
  const std::vector<MeshDimension> dimensions =
      mesh_dimensions(scene, solver.shared().features, solver.select(), solver.mesh());
  const double size = solver.mesh().size(), bore = dimensions[1].value(solver.mesh().points());
  std::vector<Parameter> parameters = scene.parameters();
  REQUIRE(parameters.size() == 3 + 3 + 5 + 1);
  // The iterations of these modes take half a minute: one parameter of each kind.
  if (mode == "dual" || mode == "nonlinear")
    std::erase_if(parameters, [](const Parameter& p) {
      return p.name.ends_with(".x") || p.name.ends_with(".y");
    });
  const auto derivatives = morph_derivatives(solver, scene, parameters, dimensions);
  REQUIRE(derivatives.size() == parameters.size());
  for (const MorphDerivative& d : derivatives) {
    INFO(d.parameter.name);
    REQUIRE(d.missing.empty());
    CHECK(d.error < 1e-8);
    const double h = 16 * parameter_step(d.parameter, size);
    const Points expected = ridders(
        [&](double change) {
          DeformScene other = scene;
          other.set(d.parameter.name, d.parameter.value + change, "");
          return solver.solve(other);
        },
        h);
    CHECK(largest(d.rate - expected) < 1e-7 * std::max(largest(expected), 1e-2));
    if (d.parameter.name == "corner.z") CHECK(largest(d.rate) > 0.1);
    // The radius of a rigid hole changes with its own scale only.
    const bool own = d.parameter.name == "bend.hole-1.scale";
    CHECK(std::abs(d.dimensions[1] - (own ? bore : 0)) < 1e-7 * bore);
  }
}

TEST_CASE("the solution is affine in translations, and so are its derivatives",
          "[scenes][deform]") {
  const MeshSource source = read_source(plate_folder / "plate.obj");
  DeformScene scene = plate_scene(kMoved);
  scene.edits[0].rotation_mode = RotationMode::Harmonic;
  MorphSolver solver(scene, source);
  const Points here = solver.solve(scene);
  const auto derivatives = morph_derivatives(solver, scene, scene.parameters(), {});
  CHECK(solver.shape() == here);
  DeformScene far = scene;
  far.set("move.right.x", 20 + 500, "");
  const Points expected = here + 500 * derivatives[0].rate;
  CHECK(largest(solver.solve(far) - expected) < 1e-9);
}

TEST_CASE("dimensions have the values of geometry", "[scenes][deform]") {
  const MeshSource source = read_source(plate_folder / "plate.obj");
  const DeformScene scene = plate_scene(
      kMoved +
      "[[dimension]]\nname = \"length\"\ntype = \"distance\"\nof = [\"left\", \"right\"]\n"
      "direction = [2, 0, 0]\n"
      "[[dimension]]\nname = \"back\"\ntype = \"distance\"\nof = [\"right\", \"left\"]\n"
      "direction = [1, 0, 0]\n"
      "[[dimension]]\nname = \"bore\"\ntype = \"radius\"\nof = \"hole-3\"\n"
      "[[dimension]]\nname = \"tilt\"\ntype = \"angle\"\nof = [\"hole-1\", \"right\"]\n"
      "[[dimension]]\nname = \"area\"\ntype = \"area\"\n"
      "[[dimension]]\nname = \"mass\"\ntype = \"mass\"\nthickness = 2\ndensity = 3\n");
  MorphSolver solver(scene, source);
  solver.solve(scene);
  const auto d = mesh_dimensions(scene, solver.shared().features, solver.select(), solver.mesh());
  const Points& before = solver.mesh().points();
  CHECK(d[0].value(solver.shape()) - d[0].value(before) == Approx(20).epsilon(1e-12));
  CHECK(d[1].value(before) == Approx(-d[0].value(before)).epsilon(1e-14));
  CHECK(d[2].value(before) == Approx(42).epsilon(1e-9));
  CHECK(d[3].value(before) < 1e-6);
  CHECK(d[5].value(before) == Approx(6 * d[4].value(before)).epsilon(1e-14));
  // Rotations and scalings of the whole mesh.
  const Mat3 R = Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Points turned = 1.5 * before * R.transpose();
  for (const auto& [k, power] : {std::pair{2, 1}, {3, 0}, {4, 2}, {5, 2}})
    CHECK(d[k].value(turned) ==
          Approx(std::pow(1.5, power) * d[k].value(before)).epsilon(1e-9).margin(1e-5));
  const auto refused = [&](const std::string& rules) {
    return error_message([&] {
      const DeformScene bad = plate_scene(kMoved + rules);
      mesh_dimensions(bad, solver.shared().features, solver.select(), solver.mesh());
    });
  };
  CHECK(refused("[[dimension]]\nname = \"v\"\ntype = \"volume\"\n").find("not closed") !=
        std::string::npos);
  CHECK(refused("[[dimension]]\nname = \"r\"\ntype = \"radius\"\nof = \"left\"\n")
            .find("expected a circular hole") != std::string::npos);
  CHECK(refused("[[dimension]]\nname = \"r\"\ntype = \"radius\"\nof = \"hole-9\"\n")
            .find("did you mean") != std::string::npos);
  CHECK(refused("[[dimension]]\nname = \"r\"\ntype = \"distance\"\nof = \"left\"\n")
            .find("expected two names") != std::string::npos);
}

TEST_CASE("a cube has its volume, and the angles of its faces", "[scenes][deform]") {
  // Two triangles a side, outwards.
  ShellMesh cube;
  cube.points.resize(8, 3);
  for (int v = 0; v < 8; ++v) cube.points.row(v) << (v & 1) + 1e4, (v >> 1 & 1) * 2, (v >> 2) * 3;
  for (const auto& quad : {std::array{0, 2, 3, 1},
                           {4, 5, 7, 6},
                           {0, 1, 5, 4},
                           {2, 6, 7, 3},
                           {0, 4, 6, 2},
                           {1, 3, 7, 5}})
    cube.add_face(std::vector<int>(quad.begin(), quad.end()));
  const MeshSource source{MeshFile::from_shells(cube), prepare(cube)};
  const DeformScene scene = parse_deform_scene(
      "unit = \"mm\"\nmesh = \"cube.obj\"\n"
      "[[select]]\nname = \"low\"\nbox = [[9999, -1, -1], [10009, 9, 0.5]]\n"
      "[[select]]\nname = \"side\"\nbox = [[9999, -1, -1], [10000.5, 9, 9]]\n"
      "[[select]]\nname = \"high\"\nbox = [[9999, -1, 2.5], [10009, 9, 9]]\n"
      "[[dimension]]\nname = \"v\"\ntype = \"volume\"\n"
      "[[dimension]]\nname = \"square\"\ntype = \"angle\"\nof = [\"low\", \"side\"]\n"
      "[[dimension]]\nname = \"opposite\"\ntype = \"angle\"\nof = [\"low\", \"high\"]\n"
      "[[dimension]]\nname = \"a\"\ntype = \"area\"\nof = \"side\"\n"
      "[[edit]]\nfixed = \"low\"\n",
      "cube.toml");
  VertexSelector select(scene, source.file, source.prepared.mesh);
  const auto d = mesh_dimensions(scene, {}, select, source.prepared.mesh);
  const Points& p = source.prepared.mesh.points();
  CHECK(d[0].value(p) == Approx(6).epsilon(1e-10));
  CHECK(d[1].value(p) == Approx(90).epsilon(1e-10));
  CHECK(d[2].value(p) == Approx(180).epsilon(1e-10));
  CHECK(d[3].value(p) == Approx(6).epsilon(1e-10));
}

TEST_CASE("requirements are met by their parameters", "[scenes][deform]") {
  const MeshSource source = read_source(plate_folder / "plate.obj");
  const std::string dimensions =
      "[[dimension]]\nname = \"gap\"\ntype = \"distance\"\nof = [\"hole-1\", \"hole-2\"]\n"
      "[[dimension]]\nname = \"rise\"\ntype = \"distance\"\nof = [\"left\", \"hole-3\"]\n"
      "direction = [0, 0, 1]\n";
  const auto met = [&](const std::string& rules) {
    DeformScene scene = plate_scene(kMoved + dimensions + rules);
    MorphSolver solver(scene, source);
    solver.solve(scene);
    const auto d = mesh_dimensions(scene, solver.shared().features, solver.select(), solver.mesh());
    meet_requirements(solver, scene, d);
    CHECK(unmet_requirements(scene, d, solver.mesh(), solver.shape()).empty());
    CHECK(solved(scene, source) == solver.shape());
    return std::pair{scene, std::vector{d[0].value(solver.shape()), d[1].value(solver.shape())}};
  };
  const auto value = [](const DeformScene& scene, const std::string& name) {
    for (const Parameter& p : scene.parameters())
      if (p.name == name) return p.value;
    return std::nan("");
  };
  const double free_gap = met("").second[0];
  const std::string rise =
      "[[require]]\ndimension = \"rise\"\nequal = 30\nadjust = \"move.right.z\"\n";
  SECTION("two equations together") {
    const auto [scene, values] =
        met(rise + "[[require]]\ndimension = \"gap\"\nequal = 225\nadjust = \"move.right.x\"\n");
    CHECK(values[0] == Approx(225).epsilon(1e-9));
    CHECK(values[1] == Approx(30).epsilon(1e-9));
  }
  SECTION("an inequality that holds changes nothing") {
    const auto [scene, values] =
        met("[[require]]\ndimension = \"gap\"\nat_most = 1000\nadjust = \"move.right.x\"\n");
    CHECK(value(scene, "move.right.x") == 20);
    CHECK(values[0] == free_gap);
  }
  SECTION("one that does not hold becomes an equation") {
    const auto [scene, values] =
        met("[[require]]\ndimension = \"gap\"\nat_least = " + std::to_string(free_gap + 5) +
            "\nadjust = \"move.right.x\"\n");
    CHECK(values[0] == Approx(free_gap + 5).epsilon(1e-8));
    CHECK(value(scene, "move.right.x") > 20);
  }
  const auto unsolved = [&](const std::string& dimension, double required) {
    try {
      met("[[require]]\ndimension = \"" + dimension + "\"\nequal = " + std::to_string(required) +
          "\nadjust = \"move.right.x\"\n");
    } catch (const NoSolutionError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  SECTION("an impossible one states the nearest value") {
    const std::string message = unsolved("gap", -5);
    CHECK(message.find("scene.toml") != std::string::npos);
    CHECK(message.find("found no value of 'move.right.x'") != std::string::npos);
    CHECK(message.find("the nearest is") != std::string::npos);
  }
  SECTION("a parameter without effect is refused") {
    CHECK(unsolved("rise", 5).find("found no value of 'move.right.x'") != std::string::npos);
  }
}

TEST_CASE("designs of experiments", "[scenes][deform]") {
  const std::vector<ParameterSweep> ranges = {{"a", "", -1, 3, 5}, {"b", "", 10, 0, 2}};
  SECTION("a Latin hypercube has one value in each part of a range") {
    const DesignTable design = design_table("lhs:40", ranges);
    REQUIRE(design.rows.size() == 40);
    for (size_t p = 0; p < 2; ++p) {
      std::set<int> parts;
      for (const auto& row : design.rows)
        parts.insert(static_cast<int>(
            std::floor(40 * (row[p] - ranges[p].from) / (ranges[p].to - ranges[p].from))));
      CHECK(parts.size() == 40);
      CHECK(*parts.begin() == 0);
      CHECK(*parts.rbegin() == 39);
    }
    CHECK(design.rows == design_table("lhs:40:1", ranges).rows);
    CHECK(design.rows != design_table("lhs:40:2", ranges).rows);
  }
  SECTION("a grid has all combinations") {
    const DesignTable design = design_table("grid", ranges);
    REQUIRE(design.rows.size() == 10);
    CHECK(design.rows[0] == std::vector{-1.0, 10.0});
    CHECK(design.rows[1] == std::vector{-1.0, 0.0});
    CHECK(design.rows[9] == std::vector{3.0, 0.0});
    CHECK(std::set(design.rows.begin(), design.rows.end()).size() == 10);
  }
  for (const std::string text : {"lhs:0", "lhs:", "lhs:2.5", "lhs:1e9", "lhs:3:x", "latin"}) {
    INFO(text);
    CHECK(error_message([&] { design_table(text, ranges); }).find("expected lhs:N") !=
          std::string::npos);
  }
  CHECK(error_message([&] { design_table("grid", {}); }).find("--range") != std::string::npos);
}
