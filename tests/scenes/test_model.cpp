// SPDX-License-Identifier: MPL-2.0
// Models and sessions of <batten/batten.h>: what is added to a session is in the model that comes out.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <thread>

#include "batten/batten.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/tests/support/catch.h"

using namespace batten;
namespace fs = std::filesystem;

namespace {

/// Four curves around a square, two of them not straight.
std::vector<InputLine> saddle() {
  return {{"front", {{0, 0, 0}, {0.5, 0, 0.2}, {1, 0, 0}}},
          {"right", {{1, 0, 0}, {1, 1, 0.3}}},
          {"back", {{1, 1, 0.3}, {0.5, 1, 0.45}, {0, 1, 0.2}}},
          {"left", {{0, 1, 0.2}, {0, 0, 0}}}};
}

std::vector<InputLine> box() {
  const std::vector<Vec3> p = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {0, 2, 0},
                               {0, 0, 1}, {3, 0, 1}, {3, 2, 1}, {0, 2, 1}};
  const std::vector<std::pair<int, int>> edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                  {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  std::vector<InputLine> lines;
  for (const auto& [a, b] : edges)
    lines.push_back({std::to_string(a) + std::to_string(b),
                     {p[static_cast<size_t>(a)], p[static_cast<size_t>(b)]}});
  return lines;
}

fs::path scratch(const std::string& name) {
  const fs::path folder = fs::path(BATTEN_BINARY_DIR) / "scenes-test";
  fs::create_directories(folder);
  return folder / name;
}

/// A session with one item of each kind.
Session sculpted(const Model& model) {
  Session session(model);
  session.add_pressure("swell", {.value = 8, .min = -100, .max = 100});
  session.solve();
  session.add_force("push", {0.4, 0.5, 0.5}, {0, 0, 2}, {.value = 3});
  session.add_point_constraint("peak", {0.6, 0.6, 0.5}, {0.6, 0.6, 0.5});
  session.add_normal_constraint("level", {0.3, 0.3, 0.3}, {0, 0, 1});
  session.add_offset("raise", "right", {0, 0, 1}, 0.25, {.value = 0.02, .min = 0, .max = 0.1});
  session.add_parameter("master", {.value = 2, .max = 5});
  session.drive("push", {{"master", 1.5}}, 0.5);
  session.solve();
  return session;
}

}  // namespace

TEST_CASE("The same four curves give one surface by every door", "[scenes]") {
  const Model arrays = skin(saddle(), {.name = "panel"});
  const Model text = parse(arrays.scene());
  std::ofstream table(scratch("panel.csv"));
  table.precision(17);
  table << "line,x,y,z\n";
  for (const InputLine& line : saddle())
    for (const Vec3& p : line.points)
      table << line.name << ',' << p[0] << ',' << p[1] << ',' << p[2] << '\n';
  table.close();
  const Model file = load(scratch("panel.csv"));
  CHECK(arrays.save(scratch("panel.toml")).empty());
  const Model scene = load(scratch("panel.toml"));
  for (const Model* other : {&text, &file, &scene}) {
    CHECK(other->facets().points == arrays.facets().points);
    CHECK(other->curves() == arrays.curves());
    CHECK(other->name() == "panel");
  }
}

TEST_CASE("A curve of the kernel is the same curve in the scene of its model", "[scenes]") {
  Points at(3, 3), slopes(3, 3);
  at << 0, 0, 0, 0.5, 0, 0.1, 1, 0, 0;
  slopes << 0.5, 0, 0.3, 0.5, 0, 0, 0.5, 0, -0.2;
  std::vector<InputLine> lines = saddle();
  const auto curve = std::make_shared<const HermiteCurve>(std::vector<double>{0, 1, 2}, at, slopes);
  lines[0] = {"front", {}, curve};
  const Model model = skin(lines);
  for (int i = 0; i <= 20; ++i)
    CHECK((model.curve("front", 21)[static_cast<size_t>(i)] - curve->evaluate(0.1 * i)).norm() <
          1e-12);
}

TEST_CASE("A curve with a corner is the whole curve in the scene of its model", "[scenes]") {
  Points dofs(7, 3);  // position and derivative; at the corner two derivatives; and again one
  dofs << 0, 0, 0, 0.5, 0, 0.1, 0.5, 0, 0.1, 0.5, 0, 0.1, 0.5, 0, -0.1, 1, 0, 0, 0.5, 0, -0.1;
  std::vector<InputLine> lines = saddle();
  const auto curve = std::make_shared<const HermiteCurve>(CurveMesh({0, 1, 2}, {}, {1}), dofs);
  lines[0] = {"front", {}, curve};
  const Model model = skin(lines);
  CHECK((model.curve("front", 3)[1] - Vec3(0.5, 0, 0.1)).norm() < 1e-12);
  CHECK((model.curve("front", 2)[1] - Vec3(1, 0, 0)).norm() < 1e-12);
  CHECK(model.faces().size() == 1);
}

TEST_CASE("A session of a session's model has the same shape and loads to the last bit",
          "[scenes]") {
  Session session = sculpted(skin(saddle()));
  const Model model = session.model();
  Session again(model);
  CHECK(again.dofs() == session.dofs());
  CHECK(again.parameters() == session.parameters());
  CHECK(again.names() == session.names());
  CHECK(again.model().scene() == model.scene());
  // Both answer the same edit in the same way.
  for (Session* one : {&session, &again}) {
    one->set("swell", 12);
    one->solve();
  }
  CHECK((again.dofs() - session.dofs()).norm() < 1e-9 * session.dofs().norm());
}

TEST_CASE("What was added to a session is in the scene of its model", "[scenes]") {
  Session session = sculpted(skin(saddle()));
  const Model model = session.model();
  const Model read = parse(model.scene());
  CHECK(read.parameters() == model.parameters());
  CHECK((read.nearest({0.5, 0.5, 0}).position - model.nearest({0.5, 0.5, 0}).position).norm() <
        1e-8);
  const Points a = session.dofs(), b = Session(read).dofs();
  CHECK((a - b).cwiseAbs().maxCoeff() < 1e-7 * a.cwiseAbs().maxCoeff());
  CHECK(model.report().find("swell") != std::string::npos);
}

TEST_CASE("Items that were removed or undone are not in the model", "[scenes]") {
  Session session = sculpted(skin(saddle()));
  const Model with_items = session.model();
  Session second(with_items);
  second.remove("level");
  CHECK(second.model().scene().find("level") == std::string::npos);
  CHECK(second.undo());
  CHECK(second.model().scene() == with_items.scene());
  second.remove("raise");
  second.add_offset("raise", "left", {0, 0, 1}, 0.25, {.value = 0.01});
  const std::string scene = second.model().scene();
  CHECK(scene.find("curve = \"left\"") != std::string::npos);
  CHECK(scene.find("curve = \"right\"") == std::string::npos);
}

TEST_CASE("Values of a model are values of its scene", "[scenes]") {
  const Model model = sculpted(skin(saddle())).model();
  const Model other = model.with_values({{"swell", 20}, {"peak.z", 0.55}});
  CHECK(other.parameters().at("swell") == 20);
  CHECK(parse(other.scene()).parameters() == other.parameters());
  CHECK(model.parameters().at("swell") == 8);
  CHECK_THROWS_WITH(model.with_values({{"swel", 1}}), Catch::Contains("did you mean 'swell'"));
}

TEST_CASE("A point of the surface is found again by its parameters", "[scenes]") {
  const Model model = skin(saddle());
  for (const Vec3& p : {Vec3(0.2, 0.7, 1), Vec3(0.5, 0.5, 0), Vec3(2, 0.3, 0), Vec3(0, 0, 0)}) {
    const SurfacePoint near = model.nearest(p);
    const SurfacePoint same = model.at(near.face, near.u, near.v);
    CHECK((near.position - same.position).norm() < 1e-9);
    CHECK(std::abs(near.distance - (p - near.position).norm()) < 1e-14);
    CHECK(std::abs(near.normal.norm() - 1) < 1e-14);
  }
  CHECK_THROWS_WITH(model.at(model.faces().front(), 1e3, 0), Catch::Contains("expected a point"));
  CHECK_THROWS_WITH(model.at("nothing", 0, 0), Catch::Contains("face"));
  CHECK_THROWS_AS(model.volume(), InputError);
}

TEST_CASE("Facets of a cylinder have its curvatures", "[scenes]") {
  constexpr double radius = 2, full = 2 * std::numbers::pi;
  std::vector<InputLine> circles = {{"low", {}}, {"high", {}}};
  constexpr int count = 72;
  for (int i = 0; i <= count; ++i) {
    const double angle = full * (i % count) / count;
    const Vec3 p(radius * std::cos(angle), radius * std::sin(angle), 0);
    circles[0].points.push_back(p);
    circles[1].points.push_back(p + Vec3(0, 0, 5));
  }
  const Model cylinder = skin(circles);
  const Facets& facets = cylinder.facets();
  REQUIRE(facets.curvatures.size() / 2 == facets.points.size() / 3);
  for (size_t i = 0; i < facets.curvatures.size() / 2; ++i) {
    const double k1 = facets.curvatures[2 * i], k2 = facets.curvatures[2 * i + 1];
    const Vec3 outwards(facets.points[3 * i], facets.points[3 * i + 1], 0);
    // Negative where the surface bends away from its normal.
    const double sign =
        outwards.dot(Eigen::Map<const Vec3>(facets.normals.data() + 3 * i)) > 0 ? -1 : 1;
    CHECK(k1 + k2 == Approx(sign / radius).margin(0.01));
    CHECK(k1 * k2 == Approx(0).margin(0.01));
    CHECK(k1 >= k2);
  }
}

TEST_CASE("A closed model has the area, volume and edges of a box", "[scenes]") {
  const Model model = skin(box());
  CHECK(model.faces().size() == 6);
  CHECK(std::abs(model.area() - 22) < 1e-9);
  CHECK(std::abs(model.volume() - 6) < 1e-9);
  CHECK((model.bounds().max() - Vec3(3, 2, 1)).norm() < 1e-9);
  CHECK(model.edges().size() == 12);
  for (const ModelEdge& edge : model.edges()) {
    CHECK(edge.faces.size() == 2);
    CHECK(edge.continuity == "G0");
    CHECK(std::abs(edge.angle_deg - 90) < 1e-6);
  }
}

TEST_CASE("Volume and edges are those of the sculpted shape", "[scenes]") {
  const Model flat = skin(box());
  Session session(flat);
  session.add_pressure("swell", {.value = -20});
  session.solve();
  const Model model = session.model();
  CHECK(model.volume() < 5.9);
  CHECK(std::abs(model.volume() - std::abs(session.volume())) < 1e-9);
  double largest = 0;
  for (const ModelEdge& edge : model.edges()) largest = std::max(largest, edge.angle_deg);
  CHECK(largest > 91);  // the faces bend inwards
}

TEST_CASE("Sessions of one model run in several threads with the same bits", "[scenes]") {
  const Model model = sculpted(skin(saddle())).model();
  std::vector<Points> shapes(4);
  std::vector<std::thread> threads;
  for (Points& shape : shapes)
    threads.emplace_back([&] {
      Session session(model);
      session.set("swell", 30);
      session.solve();
      shape = session.dofs();
    });
  for (std::thread& thread : threads) thread.join();
  for (const Points& shape : shapes) CHECK(shape == shapes.front());
}

TEST_CASE("Settings of skin() have the line numbers of their text in messages", "[scenes]") {
  SkinSettings settings{.name = "panel", .fit_tolerance = 1e-3};
  settings.settings = "\n[skin]\nalpha = 1\nbeta = \"soft\"\n";
  CHECK_THROWS_WITH(skin(saddle(), settings), Catch::Contains("skin():4:"));
  settings.settings = "[[curve]]\nname = \"x\"\npoints = [[0, 0, 0], [1, 0, 0]]\n";
  CHECK_THROWS_WITH(skin(saddle(), settings), Catch::Contains("settings: found a [[curve]]"));
  std::vector<InputLine> twice = saddle();
  twice[1].name = "front";
  CHECK_THROWS_WITH(skin(twice), Catch::Contains("'front' twice"));
  CHECK_THROWS_WITH(skin(saddle(), {.crease = {"frond"}}), Catch::Contains("did you mean 'front'"));
}
