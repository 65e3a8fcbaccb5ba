// SPDX-License-Identifier: MPL-2.0
// A model is one shell in the file: faces share edges, and the shell is closed if the model is.
#include "batten/io/step/step.h"

#include <cmath>
#include <map>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/io/cad/step_models.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using namespace batten_test;

namespace {

StepReport written(const BuiltModel& made, const std::string& name, double tolerance) {
  StepFaceOptions options;
  options.tolerance = tolerance;
  return write_step_faces(scratch("step_model") / (name + ".step"), made.model.skinned(), kMm,
                          options);
}

}  // namespace

TEST_CASE("a box of twelve curves is one solid whose faces share the twelve edges", "[io][step]") {
  const BuiltModel made = build_model(box({40, 30, 20}));
  const StepReport r = written(made, "box", 1e-3);
  CHECK(r.valid);
  CHECK(r.faces == 6);
  CHECK(r.edges == 12);
  CHECK(r.free_edges == 0);
  CHECK(r.shells == 1);
  CHECK(r.closed_shells == 1);
  CHECK(r.solids == 1);
  CHECK(*r.max_deviation < 1e-9 * 54);
  CHECK(r.max_gap < 1e-9 * 54);
  CHECK(r.max_tolerance < 1e-6);
  REQUIRE(made.model.shells.size() == 1);
  CHECK(r.volume == Approx(24000.0).epsilon(1e-9));
  CHECK(made.model.shells[0].volume == Approx(24000.0).epsilon(1e-9));
  CHECK(r.area == Approx(5200.0).epsilon(1e-9));
}

TEST_CASE("without its lid a box is an open shell with four free edges", "[io][step]") {
  RegionSearchOptions regions;
  RegionSpec spec;
  spec.kind = RegionSpec::Kind::NoSurface;
  spec.loops = {{"x2", "x3", "y1", "y3"}};  // z = 20
  regions.specs.push_back(spec);
  const BuiltModel made = build_model(box({40, 30, 20}), regions);
  const StepReport r = written(made, "open_box", 1e-3);
  CHECK(r.valid);
  CHECK(r.faces == 5);
  CHECK(r.edges == 12);
  CHECK(r.free_edges == 4);
  CHECK(r.shells == 1);
  CHECK(r.closed_shells == 0);
  CHECK(r.solids == 0);
  CHECK(r.area == Approx(5200.0 - 1200).epsilon(1e-9));
}

TEST_CASE("a solid beside an open shell is measured face by face in both forms", "[io][step]") {
  // The open shell is first in the model, the solid is first in the file.
  std::vector<CharacterLine> lines = box({40, 30, 20}, "a_");
  for (const CharacterLine& line : box({10, 10, 10}, "", {100, 0, 0})) lines.push_back(line);
  RegionSearchOptions regions;
  RegionSpec spec;
  spec.kind = RegionSpec::Kind::NoSurface;
  spec.loops = {{"a_x2", "a_x3", "a_y1", "a_y3"}};
  regions.specs.push_back(spec);
  const BuiltModel made = build_model(lines, regions, 40);
  REQUIRE(made.model.shells.size() == 2);
  CHECK_FALSE(made.model.shells[0].closed);
  const StepReport r = written(made, "box_and_open_box", 1e-3);
  CHECK(r.faces == 11);
  CHECK(r.solids == 1);
  CHECK(*r.max_deviation < 1e-9 * 120);
  const StepReport exact =
      write_step(scratch("step_model") / "exact.step", made.model.skinned(), kMm);
  CHECK(*exact.max_deviation < 1e-9 * 120);
}

TEST_CASE("eight octants are a ball within the tolerance, and so are its volume and edges",
          "[io][step]") {
  const BuiltModel made = build_model(octants());
  constexpr double tolerance = 1e-3;
  const StepReport r = written(made, "ball", tolerance);
  CHECK(r.valid);
  CHECK(r.faces == 8);
  CHECK(r.edges == 12);
  CHECK(r.free_edges == 0);
  CHECK(r.solids == 1);
  CHECK(r.reached);
  CHECK(*r.max_deviation <= tolerance);
  CHECK(r.max_gap <= 1.1 * tolerance);
  CHECK(r.max_tolerance <= 1.1 * r.max_gap);
  REQUIRE(made.model.shells.size() == 1);
  const double volume = made.model.shells[0].volume;
  CHECK(std::abs(r.volume - volume) < tolerance * made.model.area);
  // The surfaces of minimum bending energy are not exactly the sphere.
  CHECK(volume == Approx(4.0 / 3 * std::numbers::pi).epsilon(0.1));
}

TEST_CASE("an annulus and two discs close, although the seam splits circles away from their nodes",
          "[io][step]") {
  const RegionSearchOptions regions = region_specs({{{"low"}, {"high"}}, {{"low"}}, {{"high"}}});
  const BuiltModel made =
      build_model({circle_line("low", 10, 0), circle_line("high", 10, 15, 1.0)}, regions, 4);
  for (const ModelRegion& region : made.model.regions) {
    INFO(region.plan.name << ": " << region.rejection_reason);
    REQUIRE(region.skinned);
  }
  const StepReport r = written(made, "can", 0.01);
  CHECK(r.valid);
  CHECK(r.faces == 3);
  CHECK(r.free_edges == 0);
  CHECK(r.solids == 1);
  CHECK(r.closed_shells == 1);
  CHECK(*r.max_deviation <= 0.01);
  CHECK(r.volume == Approx(made.model.shells[0].volume).epsilon(2e-3));
}

TEST_CASE("boundaries of any shape are one edge for an annulus and its lids, wherever they begin",
          "[io][step]") {
  const RegionSearchOptions regions = region_specs({{{"low"}, {"high"}}, {{"low"}}, {{"high"}}});
  const BuiltModel made =
      build_model({oval_line("low", 0, 0), oval_line("high", 15, 1.0)}, regions, 4);
  std::map<std::string, HermiteCurve> carried;
  for (const ModelRegion& region : made.model.regions) {
    INFO(region.plan.name << ": " << region.rejection_reason);
    REQUIRE(region.skinned);
    for (const auto& loop : region.skinned->boundary)
      for (const BoundarySegment& piece : loop) {
        const bool aligned_line = piece.kind == BoundarySegment::Kind::EdgeAligned;
        const std::string name = aligned_line ? region.skinned->edge_aligned[piece.index].line.name
                                              : region.skinned->embedded[piece.index].line.name;
        const HermiteCurve& curve = aligned_line ? region.skinned->edge_aligned[piece.index].fitted
                                                 : region.skinned->embedded[piece.index].fitted;
        const auto [it, first] = carried.emplace(name, curve);
        if (first) continue;
        const auto off = [&](const HermiteCurve& other) {
          return curve.dofs().rows() != other.dofs().rows()
                     ? 1
                     : (curve.dofs() - other.dofs()).cwiseAbs().maxCoeff();
        };
        CHECK(std::min(off(it->second), off(it->second.backwards())) < 1e-12);
      }
  }
  const StepReport r = written(made, "oval", 0.01);
  CHECK(r.valid);
  CHECK(r.faces == 3);
  CHECK(r.free_edges == 0);
  CHECK(r.solids == 1);
  CHECK(*r.max_deviation <= 0.01);
  CHECK(r.volume == Approx(made.model.shells[0].volume).epsilon(2e-3));
}

TEST_CASE("where three faces meet each is a shell of its own, and the report says so",
          "[io][step]") {
  RegionSearchOptions regions;
  regions.max_faces_per_edge = 3;
  const BuiltModel made = build_model(two_boxes(), regions);
  REQUIRE(made.model.regions.size() == 11);
  const StepReport r = written(made, "two_boxes", 1e-3);
  CHECK(r.faces == 11);
  CHECK(r.shells == 11);
  CHECK(r.solids == 0);
  REQUIRE(r.warnings.size() == 1);
  CHECK(r.warnings[0].find("more than two faces at an edge") != std::string::npos);
}

TEST_CASE("models and tolerances that cannot be written are refused", "[io][step]") {
  const BuiltModel made = build_model(box({4, 3, 2}));
  StepFaceOptions options;
  const auto write = [&](const std::vector<const SkinnedRegion*>& regions) {
    return error_message(
        [&] { write_step_faces(scratch("step_model_refused") / "m.step", regions, kMm, options); });
  };
  auto regions = made.model.skinned();
  CHECK(write(regions).find("tolerance") != std::string::npos);
  options.tolerance = 1e-3;
  CHECK(write(regions).empty());
  // Another curve of the same name.
  const BuiltModel other = build_model(box({4, 3, 1}));
  regions.push_back(other.model.skinned()[0]);
  CHECK(write(regions).find("expected one curve, or two names") != std::string::npos);
  regions.pop_back();
  SkinnedRegion nameless = *regions[0];
  nameless.edge_aligned[0].line.name.clear();
  regions[0] = &nameless;
  CHECK(write(regions).find("without a name") != std::string::npos);
  CHECK(write({}).find("no face to write") != std::string::npos);
}
