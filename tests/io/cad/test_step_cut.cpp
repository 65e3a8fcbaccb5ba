// SPDX-License-Identifier: MPL-2.0
// Models with some faces trimmed by embedded curves: these become fitted faces on the edges of the
// adjacent exact faces.
#include <STEPControl_Reader.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include <cstdlib>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/step/step.h"
#include "batten/tests/io/cad/step_models.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

fs::path cut_file(const std::string& name) { return scratch("step_cut") / (name + ".step"); }

bool is_cut(const SkinnedRegion* region) { return region->surface.trim() != nullptr; }

/// Of one curve: vertices of all exact faces split it; a closed curve between trimmed faces counts
/// as two edges.
int edges_along(const std::vector<const SkinnedRegion*>& regions, const std::string& line) {
  size_t most = 1;
  for (const SkinnedRegion* region : regions) {
    for (const EmbeddedLine& embedded : region->embedded)
      if (const HermiteCurve& curve = embedded.fitted;
          embedded.line.name == line &&
          (curve.position(0) - curve.evaluate(curve.end())).norm() == 0)
        most = std::max<size_t>(most, 2);
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
      if (!is_cut(region) && aligned_line.line.name == line)
        most = std::max(most, aligned_line.edges.size());
  }
  return static_cast<int>(most);
}

/// Of the model as one solid: edges of exact faces, and of curves between trimmed faces.
struct Count {
  int faces = 0, edges = 0, fitted = 0;
};
Count expected(const std::vector<const SkinnedRegion*>& regions) {
  Count count;
  std::set<std::string> lines;
  for (const SkinnedRegion* region : regions) {
    for (const auto& loop : region->boundary)
      for (const BoundarySegment& piece : loop) {
        const auto i = static_cast<size_t>(piece.index);
        lines.insert(piece.kind == BoundarySegment::Kind::EdgeAligned
                         ? region->edge_aligned[i].line.name
                         : region->embedded[i].line.name);
      }
    if (is_cut(region)) {
      ++count.fitted;
      continue;
    }
    const ParametricMesh& mesh = region->surface.mesh();
    count.faces += 3 * mesh.triangle_count();
    count.edges += 3 * mesh.triangle_count() + mesh.edge_count();
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
      count.edges -= static_cast<int>(aligned_line.edges.size());
  }
  for (const std::string& line : lines) count.edges += edges_along(regions, line);
  count.faces += count.fitted;
  return count;
}

/// `within`: relative tolerance of the volume; `apart`: distance of the curves that two faces have
/// for one curve, relative to the size.
void expect_cut_solid(const StepReport& r, const BuiltModel& made, double within,
                      double apart = 1e-9) {
  REQUIRE(made.model.shells.size() == 1);
  const auto regions = made.model.skinned();
  const Count count = expected(regions);
  CHECK(r.valid);
  CHECK(r.solids == 1);
  CHECK(r.shells == 1);
  CHECK(r.closed_shells == 1);
  CHECK(r.free_edges == 0);
  CHECK(r.faces == count.faces);
  CHECK(r.edges == count.edges);
  CHECK(r.unmeasured == 0);
  CHECK(*r.max_deviation <= 1e-13 * r.size);
  CHECK(r.reached);
  REQUIRE(static_cast<int>(r.patches.size()) == count.fitted);
  double line_gap = 0;
  for (const StepPatch& patch : r.patches) {
    CAPTURE(patch.region);
    CHECK(patch.reached);
    CHECK(patch.deviation <= r.tolerance);
    // Its edges are those of the exact faces.
    CHECK(patch.edge_deviation <= apart * r.size);
    line_gap = std::max(line_gap, patch.line_gap);
  }
  CHECK(r.max_gap <= r.tolerance + line_gap + apart * r.size);
  CHECK(r.max_tolerance <= 1.1 * r.max_gap + 1e-7 * r.size);
  const double volume = made.model.shells[0].volume;
  CAPTURE(r.volume, volume, r.volume / volume - 1);
  CHECK(std::abs(r.volume - volume) <= within * volume);
  INFO("deviation " << (r.patches.empty() ? 0 : r.patches[0].deviation) << ", gap " << r.max_gap);
  // Read back, and compared with closest points.
  const StepReport again = check_step(r.file, kMm, regions);
  CHECK(again.faces == r.faces);
}

CharacterLine wave(const std::string& name, double radius, double z, double height, int times) {
  return {name, curve_from_formula(0, 2 * std::numbers::pi, [=](double t, int order) {
            const double c = std::cos(t), s = std::sin(t), n = times, h = height;
            return order == 0   ? Vec3(radius * c, radius * s, z + h * std::cos(n * t))
                   : order == 1 ? Vec3(-radius * s, radius * c, -n * h * std::sin(n * t))
                                : Vec3(-radius * c, -radius * s, -n * n * h * std::cos(n * t));
          })};
}

/// Four walls and four roofs on a closed curve of varying height; the faces below are trimmed.
std::vector<CharacterLine> house(double height) {
  constexpr double r = 20, z = 15, top = 25;
  std::vector<CharacterLine> lines{wave("base", r, 0, height, 2), wave("eaves", r, z, 0, 0)};
  for (int k = 0; k < 4; ++k) {
    const double a = k * std::numbers::pi / 2;
    const Vec3 foot(r * std::cos(a), r * std::sin(a), height * std::cos(2 * a));
    const Vec3 eaves(foot.x(), foot.y(), z);
    lines.push_back(straight("post " + std::to_string(k), foot, eaves));
    lines.push_back(straight("rafter " + std::to_string(k), eaves, {0, 0, top}));
  }
  return lines;
}

RegionSearchOptions surfaces(const std::vector<std::vector<std::string>>& loops) {
  RegionSearchOptions options;
  for (const auto& loop : loops) {
    RegionSpec spec;
    spec.name = "cut " + std::to_string(options.specs.size() + 1);
    spec.loops = {loop};
    options.specs.push_back(spec);
  }
  return options;
}

}  // namespace

TEST_CASE("the whole mouse is one solid on its flat side too, which Gmsh opens",
          "[io][step][mouse]") {
  const BuiltModel made = mouse(12, false);
  const fs::path file = cut_file("mouse");
  const StepReport r = write_step(file, made.model.skinned(), kMm, {.file = {.name = "mouse"}});
  expect_cut_solid(r, made, 1e-6);
  REQUIRE(r.patches.size() == 1);
  CHECK(r.patches[0].region == "bottom");
  CHECK(r.tolerance == Approx(1e-4 * r.size).epsilon(0.05));
  CHECK(r.max_gap <= 1e-6 * r.size);  // it is nearly a plane
  if (std::system("/usr/bin/python3 -c 'import gmsh' > /dev/null 2>&1") != 0) {
    WARN("skipped: Gmsh's Python module is not installed");
    return;
  }
  CHECK(std::system(("/usr/bin/python3 '" BATTEN_SOURCE_DIR "/tests/io/cad/gmsh_opens_step.py' '" +
                     file.string() + "' > /dev/null")
                        .c_str()) == 0);
}

TEST_CASE("a curved side that is cut keeps its tolerance, whatever that is", "[io][step]") {
  const BuiltModel made = build_model(house(3), surfaces({{"base"}}), 7);
  const auto regions = made.model.skinned();
  REQUIRE(regions.size() == 9);
  REQUIRE(std::count_if(regions.begin(), regions.end(), is_cut) == 1);
  for (const double tolerance : {0.0, 1e-3}) {
    CAPTURE(tolerance);
    const StepReport r = write_step(cut_file("house"), regions, kMm, {.tolerance = tolerance});
    expect_cut_solid(r, made, 1e-4);
    if (tolerance > 0) CHECK(r.tolerance == tolerance);
  }
}

TEST_CASE("two trimmed sides have the closed curve between them in common as two edges",
          "[io][step]") {
  std::vector<CharacterLine> lines = house(2);
  lines.push_back(wave("drain", 8, 1, 0.5, 2));
  RegionSearchOptions specs = surfaces({{"base"}, {"drain"}});
  specs.specs[0].loops.push_back({"drain"});
  const BuiltModel made = build_model(lines, specs, 5);
  for (const ModelRegion& region : made.model.regions) {
    INFO(region.plan.name << ": " << region.rejection_reason);
    REQUIRE(region.skinned);
  }
  const auto regions = made.model.skinned();
  REQUIRE(regions.size() == 10);
  REQUIRE(std::count_if(regions.begin(), regions.end(), is_cut) == 2);
  const StepReport r = write_step(cut_file("drain"), regions, kMm);
  expect_cut_solid(r, made, 1e-4);
}

TEST_CASE("an annulus ends in discs that are trimmed along closed curves", "[io][step]") {
  const BuiltModel made =
      build_model({circle_line("low", 10, 0), circle_line("high", 10, 15, 1)},
                  region_specs({{{"low"}, {"high"}}, {{"low"}}, {{"high"}}}), 3);
  const auto regions = made.model.skinned();
  REQUIRE(regions.size() == 3);
  REQUIRE(std::count_if(regions.begin(), regions.end(), is_cut) == 2);
  expect_cut_solid(write_step(cut_file("can"), regions, kMm), made, 1e-4,
                   1e-6);  // annular faces fit their boundaries
}

TEST_CASE("a box with a hole through it is exact but for the two sides with the hole",
          "[io][step]") {
  std::vector<CharacterLine> lines = box({40, 30, 20}, "", {-20, -15, 0});
  lines.push_back(circle_line("low", 8, 0));
  lines.push_back(circle_line("high", 8, 20, 1));
  RegionSearchOptions specs = region_specs({{{"low"}, {"high"}}});
  for (const auto& [outline, hole] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"x0", "x1", "y0", "y2"}, "low"}, {{"x2", "x3", "y1", "y3"}, "high"}}) {
    RegionSpec spec;
    spec.name = "side " + hole;
    spec.loops = {outline, {hole}};
    specs.specs.push_back(spec);
  }
  const BuiltModel made = build_model(lines, specs, 4);
  for (const ModelRegion& region : made.model.regions) {
    INFO(region.plan.name << ": " << region.rejection_reason);
    REQUIRE(region.skinned);
  }
  const auto regions = made.model.skinned();
  REQUIRE(regions.size() == 7);
  REQUIRE(std::count_if(regions.begin(), regions.end(), is_cut) == 2);
  const StepReport r = write_step(cut_file("hole"), regions, kMm);
  expect_cut_solid(r, made, 1e-6, 1e-6);
}

TEST_CASE("trimmed faces that cannot share edges with exact ones are refused", "[io][step]") {
  const fs::path file = cut_file("refused");
  const auto error_of = [&](const std::vector<const SkinnedRegion*>& regions,
                            const StepOptions& options = {}) {
    return error_message([&] { write_step(file, regions, kMm, options); });
  };
  const BuiltModel made = build_model(house(3), surfaces({{"base"}}), 8);
  auto regions = made.model.skinned();
  const auto cut = std::find_if(regions.begin(), regions.end(), is_cut);
  REQUIRE(cut != regions.end());
  CHECK_THAT(error_of({*cut}),
             Catch::Contains("'" + (*cut)->name + "'") && Catch::Contains("step_form = \"face\""));
  CHECK_THAT(error_of(regions, {.tolerance = -1}), Catch::Contains("tolerance"));

  SkinnedRegion nameless = **cut;
  nameless.embedded[0].line.name.clear();
  const SkinnedRegion* whole = std::exchange(*cut, &nameless);
  CHECK_THAT(error_of(regions), Catch::Contains("without a name"));
  *cut = whole;
  CHECK(!fs::exists(file));
}
