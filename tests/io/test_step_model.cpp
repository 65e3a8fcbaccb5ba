// A model is one shell in the file: faces that use the same edges, closed where the model is.
#include "batten/io/step_model.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/catch.h"
#include "batten/tests/reference.h"
#include "batten/tests/refusal.h"

using namespace batten;
using namespace batten_test;

namespace {

constexpr double kMm = 0.001;

CharacterLine straight(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, curve_through_points(name, {a, b})};
}

/// Edges of a box [0, size], every second one backwards: "x00", "y10", …
std::vector<CharacterLine> box(const Vec3& size, const std::string& prefix = "",
                               const Vec3& at = Vec3::Zero()) {
  std::vector<CharacterLine> lines;
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 4; ++k) {
      const int second = (axis + 1) % 3, third = (axis + 2) % 3;
      Vec3 from = at;
      from[second] += (k & 1) * size[second];
      from[third] += (k >> 1) * size[third];
      Vec3 to = from;
      to[axis] += size[axis];
      if (k & 1) std::swap(from, to);
      lines.push_back(straight(prefix + "xyz"[axis] + std::to_string(k), from, to));
    }
  return lines;
}

/// Circle around the z axis, closed, beginning at an angle.
CharacterLine circle(const std::string& name, double radius, double z, double from = 0) {
  return {name, curve_from_formula(from, from + 2 * std::numbers::pi, [=](double t, int order) {
            const double c = std::cos(t), s = std::sin(t);
            return order == 0   ? Vec3(radius * c, radius * s, z)
                   : order == 1 ? Vec3(-radius * s, radius * c, 0)
                                : Vec3(-radius * c, -radius * s, 0);
          })};
}

/// Quarter of a great circle from one axis direction to another.
CharacterLine quarter(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, curve_from_formula(0, std::numbers::pi / 2, [=](double t, int order) {
            const double c = std::cos(t), s = std::sin(t);
            return order == 0   ? Vec3(c * a + s * b)
                   : order == 1 ? Vec3(-s * a + c * b)
                                : Vec3(-c * a - s * b);
          })};
}

struct Made {
  CharacterLineNetwork network;
  SurfaceModel model;
};

Made make(const std::vector<CharacterLine>& lines, const RegionOptions& regions = {},
          double edge_length = 0) {
  CharacterLineNetwork network(lines);
  ModelOptions options;
  options.skin.edge_length = edge_length > 0 ? edge_length : network.size() / 10;
  SurfaceModel model = skin_network(network, find_regions(network, regions), options);
  return {std::move(network), std::move(model)};
}

StepModelReport written(const Made& made, const std::string& name, double tolerance) {
  StepFaceOptions options;
  options.tolerance = tolerance;
  return write_step_model(scratch("step_model") / (name + ".step"), made.network, made.model, kMm,
                          options);
}

}  // namespace

TEST_CASE("a box of twelve lines is one solid whose faces share the twelve edges", "[step_model]") {
  const Made made = make(box({40, 30, 20}));
  const StepModelReport r = written(made, "box", 1e-3);
  CHECK(r.valid);
  CHECK(r.faces == 6);
  CHECK(r.edges == 12);
  CHECK(r.free_edges == 0);
  CHECK(r.shells == 1);
  CHECK(r.closed_shells == 1);
  CHECK(r.solids == 1);
  CHECK(r.deviation < 1e-9 * 54);
  CHECK(r.edge_gap < 1e-9 * 54);
  CHECK(r.max_tolerance < 1e-6);
  REQUIRE(made.model.shells.size() == 1);
  CHECK(r.volume == Approx(24000.0).epsilon(1e-9));
  CHECK(made.model.shells[0].volume == Approx(24000.0).epsilon(1e-9));
  CHECK(r.area == Approx(5200.0).epsilon(1e-9));
}

TEST_CASE("without its lid a box is an open shell, whose free edges are the rim", "[step_model]") {
  RegionOptions regions;
  RegionWord word;
  word.kind = RegionWord::Kind::Nothing;
  word.loops = {{"x2", "x3", "y1", "y3"}};  // z = 20
  regions.words.push_back(word);
  const Made made = make(box({40, 30, 20}), regions);
  const StepModelReport r = written(made, "open_box", 1e-3);
  CHECK(r.valid);
  CHECK(r.faces == 5);
  CHECK(r.edges == 12);
  CHECK(r.free_edges == 4);
  CHECK(r.shells == 1);
  CHECK(r.closed_shells == 0);
  CHECK(r.solids == 0);
  CHECK(r.area == Approx(5200.0 - 1200).epsilon(1e-9));
}

TEST_CASE("eight octants are a ball within the tolerance, and so are its volume and edges",
          "[step_model]") {
  std::vector<CharacterLine> lines;
  const Vec3 axes[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  for (int a = 0; a < 3; ++a)
    for (int k = 0; k < 4; ++k) {
      const int b = (a + 1) % 3;
      lines.push_back(quarter("q" + std::to_string(4 * a + k), (k & 1 ? -1 : 1) * axes[a],
                              (k & 2 ? -1 : 1) * axes[b]));
    }
  const Made made = make(lines);
  constexpr double tolerance = 1e-3;
  const StepModelReport r = written(made, "ball", tolerance);
  CHECK(r.valid);
  CHECK(r.faces == 8);
  CHECK(r.edges == 12);
  CHECK(r.free_edges == 0);
  CHECK(r.solids == 1);
  CHECK(r.reached);
  CHECK(r.deviation <= tolerance);
  CHECK(r.edge_gap <= 1.1 * tolerance);
  CHECK(r.max_tolerance <= 1.1 * r.edge_gap);
  REQUIRE(made.model.shells.size() == 1);
  const double volume = made.model.shells[0].volume;
  CHECK(std::abs(r.volume - volume) < tolerance * made.model.area);
  // The surfaces of least bending are not quite the sphere.
  CHECK(volume == Approx(4.0 / 3 * std::numbers::pi).epsilon(0.1));
}

TEST_CASE("a ring and two discs close, although the seam cuts circles away from their nodes",
          "[step_model]") {
  RegionOptions regions;
  const auto say = [&](const std::vector<std::vector<std::string>>& loops, bool ring) {
    RegionWord word;
    word.name = "r" + std::to_string(regions.words.size());
    word.loops = loops;
    word.ring = ring;
    regions.words.push_back(word);
  };
  say({{"low"}, {"high"}}, true);
  say({{"low"}}, false);
  say({{"high"}}, false);
  const Made made = make({circle("low", 10, 0), circle("high", 10, 15, 1.0)}, regions, 4);
  for (const ModelRegion& region : made.model.regions) {
    INFO(region.plan.name << ": " << region.why_not);
    REQUIRE(region.skinned);
  }
  const StepModelReport r = written(made, "can", 0.01);
  CHECK(r.valid);
  CHECK(r.faces == 3);
  CHECK(r.free_edges == 0);
  CHECK(r.solids == 1);
  CHECK(r.closed_shells == 1);
  CHECK(r.deviation <= 0.01);
  CHECK(r.volume == Approx(made.model.shells[0].volume).epsilon(2e-3));
}

TEST_CASE("where three regions meet each is a shell of its own, and the report says so",
          "[step_model]") {
  std::vector<CharacterLine> lines = box({10, 10, 10}, "a");
  for (const CharacterLine& line : box({10, 10, 10}, "b", {10, 0, 0})) {
    const Vec3 middle = line.curve->evaluate(0.5 * (line.curve->start() + line.curve->end()));
    if (middle.x() > 10.1) lines.push_back(line);
  }
  RegionOptions regions;
  regions.most_at_arc = 3;
  const Made made = make(lines, regions);
  REQUIRE(made.model.regions.size() == 11);
  const StepModelReport r = written(made, "two_boxes", 1e-3);
  CHECK(r.faces == 11);
  CHECK(r.shells == 11);
  CHECK(r.solids == 0);
  REQUIRE(r.warnings.size() == 1);
  CHECK(r.warnings[0].find("three and more") != std::string::npos);
}

TEST_CASE("models and tolerances that cannot be written are refused", "[step_model]") {
  Made made = make(box({4, 3, 2}));
  StepFaceOptions options;
  const auto write = [&] {
    write_step_model(scratch("step_model_refused") / "m.step", made.network, made.model, kMm,
                     options);
  };
  CHECK(refusal(write).find("tolerance") != std::string::npos);
  options.tolerance = 1e-3;
  CHECK(refusal(write).empty());
  // Boundaries that are not the network's.
  const CharacterLineNetwork other(box({4, 3, 2}, "other"));
  CHECK(refusal([&] {
          write_step_model(scratch("step_model_refused") / "m.step", other, made.model, kMm,
                           options);
        }).find("no arc of the network") != std::string::npos);
  for (ModelRegion& region : made.model.regions) region.skinned.reset();
  CHECK(refusal(write).find("no region") != std::string::npos);
}
