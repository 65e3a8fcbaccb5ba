// SPDX-License-Identifier: MPL-2.0
// Properties of the models of other tests: conforming, oriented, no folded quads, round holes.
#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "batten/tests/support/catch.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten_test;

namespace {

const std::vector<std::pair<std::string, MeshModel>>& models() {
  static const std::vector<std::pair<std::string, MeshModel>> all = {
      {"plate with holes", plate_with_holes()},
      {"door panel", door_panel()},
      {"grill", grill()},
      {"sheet with cavities", sheet_with_cavities()},
      {"holed panel", holed_panel(3300)},
      {"larger holed panel", holed_panel(14000)},
      {"panel", panel()}};
  return all;
}

Vec3 point(const MeshModel& model, int v) { return model.shells.points.row(v).transpose(); }

/// Number of times that each edge is used, per direction.
std::map<std::pair<int, int>, int> directed_edges(const MeshModel& model) {
  std::map<std::pair<int, int>, int> count;
  for (int f = 0; f < model.shells.face_count(); ++f) {
    const auto face = model.shells.face(f);
    for (size_t a = 0; a < face.size(); ++a) ++count[{face[a], face[(a + 1) % face.size()]}];
  }
  return count;
}

int holes_of(const MeshModel& model) {
  const auto edges = directed_edges(model);
  return static_cast<
      int>(std::count_if(model.rims.begin(), model.rims.end(), [&](const NamedSet& rim) {
    return !edges.count({rim.items[0], rim.items[1]}) || !edges.count({rim.items[1], rim.items[0]});
  }));
}

/// Largest deviation of a loop's vertices from a planar circle, relative to the model's size, on
/// which the rounding of coordinates depends.
double out_of_round(const MeshModel& model, const std::vector<int>& loop) {
  Vec3 middle = Vec3::Zero();
  for (const int v : loop) middle += point(model, v) / static_cast<double>(loop.size());
  const double radius = (point(model, loop[0]) - middle).norm();
  const Vec3 normal = (point(model, loop[0]) - middle)
                          .cross(point(model, loop[loop.size() / 4]) - middle)
                          .normalized();
  double worst = 0;
  for (const int v : loop) {
    const Vec3 arm = point(model, v) - middle;
    worst = std::max({worst, std::abs(arm.norm() - radius), std::abs(arm.dot(normal))});
  }
  const Points& all = model.shells.points;
  return worst / (all.colwise().maxCoeff() - all.colwise().minCoeff()).norm();
}

}  // namespace

TEST_CASE("models are conforming, oriented and in one piece", "[mesh][models]") {
  for (const auto& [name, model] : models()) {
    INFO(name);
    CHECK(model.shells.points.allFinite());
    CHECK(model.flat.size() == static_cast<size_t>(model.shells.node_count()));
    const auto edges = directed_edges(model);
    int border = 0, inner = 0;
    for (const auto& [edge, count] : edges) {
      CHECK(count == 1);  // adjacent faces use an edge in opposite directions
      (edges.count({edge.second, edge.first}) ? inner : border) += 1;
    }
    // Euler characteristic: one sheet with its holes, and no other boundary.
    CHECK(model.shells.node_count() - (inner / 2 + border) + model.shells.face_count() ==
          1 - holes_of(model));
    std::set<int> used;
    std::set<std::array<double, 3>> places;
    for (int f = 0; f < model.shells.face_count(); ++f)
      for (const int v : model.shells.face(f)) used.insert(v);
    for (const int v : used)
      places.insert({point(model, v).x(), point(model, v).y(), point(model, v).z()});
    CHECK(used.size() == static_cast<size_t>(model.shells.node_count()));
    CHECK(places.size() == used.size());
    size_t faces = 0;
    for (const auto& part : model.parts) faces += part.items.size();
    CHECK(faces == static_cast<size_t>(model.shells.face_count()));
  }
}

TEST_CASE("no quad of a model is folded or thin", "[mesh][models]") {
  for (const auto& [name, model] : models()) {
    INFO(name);
    double worst_sine = 1, worst_normal = 1;
    for (int f = 0; f < model.shells.face_count(); ++f) {
      const auto quad = model.shells.face(f);
      REQUIRE(quad.size() == 4);
      const auto p = [&](size_t a) { return point(model, quad[a % 4]); };
      const Vec3 normal = (p(2) - p(0)).cross(p(3) - p(1)).normalized();
      for (size_t a = 0; a < 4; ++a) {
        const Vec3 to = (p(a + 1) - p(a)).normalized(), from = (p(a + 3) - p(a)).normalized();
        worst_sine = std::min(worst_sine, to.cross(from).dot(normal));
        worst_normal = std::min(worst_normal, to.cross(from).normalized().dot(normal));
      }
    }
    CHECK(worst_sine > 0.25);    // Jacobian relative to the lengths of the sides
    CHECK(worst_normal > 0.95);  // nearly planar
  }
}

TEST_CASE("holes are round, and the parts of models exist", "[mesh][models]") {
  const std::map<std::string, std::array<int, 3>> expected{// forms, holes, vertices
                                                           {"plate with holes", {5, 5, 2784}},
                                                           {"door panel", {1, 0, 2982}},
                                                           {"grill", {21, 0, 3200}},
                                                           {"sheet with cavities", {16, 0, 3009}},
                                                           {"holed panel", {16, 16, 3457}},
                                                           {"larger holed panel", {16, 16, 14409}},
                                                           {"panel", {7, 6, 5437}}};
  const std::set<std::string> long_forms{"recess", "bead", "slot", "opening"};
  for (const auto& [name, model] : models()) {
    INFO(name);
    const auto& [forms, holes, vertices] = expected.at(name);
    CHECK(static_cast<int>(model.features.size()) == forms);
    CHECK(holes_of(model) == holes);
    CHECK(model.shells.node_count() == vertices);
    CHECK(!model.fixed.empty());
    CHECK(!model.handle.empty());
    std::set<int> taken;
    for (const auto* list : {&model.fixed, &model.handle})
      for (const int v : *list) CHECK(taken.insert(v).second);
    for (size_t i = 0; i < model.features.size(); ++i) {
      const auto& [form, rim] = model.rims[i];
      for (const int v : model.features[i].items) CHECK(taken.insert(v).second);
      for (const int v : rim)
        CHECK(std::count(model.features[i].items.begin(), model.features[i].items.end(), v) == 1);
      if (name != "grill" && !long_forms.count(form)) CHECK(out_of_round(model, rim) < 1e-15);
    }
  }
}

TEST_CASE("feature lines are chains of edges across the sheet", "[mesh][models]") {
  for (const auto& [model, lines] : {std::pair{door_panel(), 2}, std::pair{panel(), 1}}) {
    REQUIRE(static_cast<int>(model.lines.size()) == lines);
    const auto edges = directed_edges(model);
    for (const auto& line : model.lines)
      for (size_t i = 1; i < line.items.size(); ++i)
        CHECK(edges.count({line.items[i - 1], line.items[i]}) == 1);
  }
}

TEST_CASE("the panel for benchmarks comes near the wanted size", "[mesh][models]") {
  for (const int wanted : {3300, 14000, 101000})
    CHECK(holed_panel(wanted).shells.node_count() == Approx(wanted).epsilon(0.06));
}
