// SPDX-License-Identifier: MPL-2.0
// Whole models as exact STEP files: faces share edges and vertices, without sewing.
#include <STEPControl_Reader.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include <cstdlib>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/io/step/step.h"
#include "batten/tests/io/cad/step_models.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

fs::path exact_file(const std::string& name) { return scratch("step_exact") / (name + ".step"); }

int triangles_of(const std::vector<const SkinnedRegion*>& regions) {
  int count = 0;
  for (const SkinnedRegion* region : regions) count += region->surface.mesh().triangle_count();
  return count;
}

/// Vertices - edges + faces: 2 for a topological ball, 0 for a torus, 1 for a disc.
int euler_number(const fs::path& file) {
  STEPControl_Reader reader;
  REQUIRE(reader.ReadFile(file.string().c_str()) == IFSelect_RetDone);
  reader.TransferRoots();
  int count[3];
  const TopAbs_ShapeEnum kinds[] = {TopAbs_VERTEX, TopAbs_EDGE, TopAbs_FACE};
  for (int k = 0; k < 3; ++k) {
    TopTools_IndexedMapOfShape found;
    TopExp::MapShapes(reader.OneShape(), kinds[k], found);
    count[k] = found.Extent();
  }
  return count[0] - count[1] + count[2];
}

/// All checks for connected faces with an outside. `apart`: distance of the curves that two faces
/// have for one curve, relative to the size.
void expect_exact(const StepReport& r, const std::vector<const SkinnedRegion*>& regions,
                  double apart = 1e-13) {
  CHECK(r.valid);
  CHECK(r.shells == 1);
  CHECK(r.faces == 3 * triangles_of(regions));
  CHECK(r.unmeasured == 0);
  CHECK(r.max_gap <= apart * r.size);
  CHECK(*r.max_deviation <= 1e-13 * r.size);
  CHECK(r.max_normal_jump_deg <= 1e-8);
  CHECK(r.max_tolerance <= 1e-8 * r.size);
  double area = 0;
  for (const SkinnedRegion* region : regions) area += region->surface.area();
  CHECK(r.area == Approx(area).epsilon(1e-6));
}
void expect_solid(const StepReport& r, const BuiltModel& made, int euler, double apart = 1e-13) {
  REQUIRE(made.model.shells.size() == 1);
  expect_exact(r, made.model.skinned(), apart);
  CHECK(r.solids == 1);
  CHECK(r.closed_shells == 1);
  CHECK(r.free_edges == 0);
  CHECK(r.warnings.empty());
  CHECK(euler_number(r.file) == euler);
  const double volume = made.model.shells[0].volume;
  CAPTURE(r.volume / volume - 1);
  CHECK(std::abs(r.volume - volume) <= 1e-12 * volume);
}

/// The surface of a function over [0, 1]², with its four sides under the given names, all towards
/// +u or +v.
SkinnedRegion patch(const std::function<SurfaceJet(const Vec2&)>& formula, int n,
                    const std::array<std::string, 4>& names) {
  const auto mesh = std::make_shared<ParametricMesh>(ParametricMesh::unit_square(n));
  SkinnedRegion region{"patch", interpolated(mesh, TriangleElement::HCT, formula), {}, 1, {}, {}};
  region.boundary.resize(1);
  for (int s = 0; s < 4; ++s) {
    EdgeAlignedLine aligned_line;
    aligned_line.line.name = names[static_cast<size_t>(s)];
    Points x(n + 1, 3), d(n + 1, 3);
    for (int i = 0; i <= n; ++i) {
      const double t = double(i) / n;
      const Vec2 uv = s == 0 ? Vec2(t, 0) : s == 1 ? Vec2(1, t) : s == 2 ? Vec2(t, 1) : Vec2(0, t);
      const SurfaceJet jet = formula(uv);
      x.row(i) = jet.x;
      d.row(i) = s % 2 ? jet.x_v : jet.x_u;
      aligned_line.parameters.push_back(t);
      for (int v = 0; v < mesh->vertex_count(); ++v)
        if ((mesh->vertices()[v] - uv).norm() < 1e-9) aligned_line.vertices.push_back(v);
      if (i > 0)
        aligned_line.edges.push_back(
            mesh->edge_between(aligned_line.vertices[i - 1], aligned_line.vertices[i]));
    }
    aligned_line.fitted = HermiteCurve(aligned_line.parameters, x, d);
    region.edge_aligned.push_back(aligned_line);
    region.boundary[0].push_back({BoundarySegment::Kind::EdgeAligned, s, s >= 2});
  }
  return region;
}

/// A strip of width 1 around a circle, with `half_turns` half twists.
SurfaceJet strip(const Vec2& p, int half_turns) {
  const auto x = [half_turns](double u, double v) -> Vec3 {
    const double a = 2 * std::numbers::pi * u, b = std::numbers::pi * half_turns * u,
                 r = 2 + (v - 0.5) * std::sin(b);
    return {r * std::cos(a), r * std::sin(a), (v - 0.5) * std::cos(b)};
  };
  constexpr double h = 1e-5;
  SurfaceJet j{};
  j.x = x(p.x(), p.y());
  j.x_u = (x(p.x() + h, p.y()) - x(p.x() - h, p.y())) / (2 * h);
  j.x_v = (x(p.x(), p.y() + h) - x(p.x(), p.y() - h)) / (2 * h);
  return j;
}

}  // namespace

TEST_CASE("a box is one exact solid, and its creases are no jumps of normals", "[io][step]") {
  const BuiltModel made = build_model(box({40, 30, 20}), {}, 12);
  const StepReport r =
      write_step(exact_file("box"), made.model.skinned(), kMm, {.file = {.name = "box"}});
  expect_solid(r, made, 2);
  CHECK(r.volume == Approx(24000.0).epsilon(1e-12));
  // Without its faces, the file has the edges of any other file.
  CHECK(check_step(r.file, kMm).max_normal_jump_deg == Approx(90));
}

TEST_CASE("annuli are connected along closed curves that begin at different angles", "[io][step]") {
  const BuiltModel made = build_model(
      {circle_line("a", 10, 0), circle_line("b", 10, 15, 1), circle_line("c", 6, 0, 2),
       circle_line("d", 6, 15, 3)},
      region_specs({{{"a"}, {"b"}}, {{"a"}, {"c"}}, {{"b"}, {"d"}}, {{"c"}, {"d"}}}), 6);
  for (const ModelRegion& region : made.model.regions) {
    INFO(region.plan.name << ": " << region.rejection_reason);
    REQUIRE(region.skinned);
  }
  // Annular faces fit their boundaries themselves.
  expect_solid(write_step(exact_file("pipe"), made.model.skinned(), kMm), made, 0, 1e-9);
}

TEST_CASE("two faces of a plate with a smooth curve between them are one open shell",
          "[io][step]") {
  const auto arch = [](const std::string& name, double y) -> CharacterLine {
    return {name, curve_through_points(name, {{0, y, 0}, {10, y, 2}, {20, y, 3}})};
  };
  const BuiltModel made = build_model(
      {arch("left", 0), arch("middle", 10), arch("right", 20),
       straight("start 1", {0, 0, 0}, {0, 10, 0}), straight("start 2", {0, 20, 0}, {0, 10, 0}),
       straight("end 1", {20, 0, 3}, {20, 10, 3}), straight("end 2", {20, 10, 3}, {20, 20, 3})});
  const auto regions = made.model.skinned();
  REQUIRE(regions.size() == 2);
  const StepReport r = write_step(exact_file("plate"), regions, kMm);
  expect_exact(r, regions);
  CHECK(r.solids == 0);
  CHECK(r.closed_shells == 0);
  CHECK(r.volume == 0);
  int rim = 0;
  for (const SkinnedRegion* region : regions)
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
      if (aligned_line.line.name != "middle") rim += static_cast<int>(aligned_line.edges.size());
  CHECK(r.free_edges == rim);
  CHECK(euler_number(r.file) == 1);
  CHECK(check_step(r.file, kMm).max_normal_jump_deg < 0.1);
}

TEST_CASE("a face meets itself along a curve, with an outside or without", "[io][step]") {
  constexpr int n = 12;
  for (const int half_turns : {0, 1}) {
    CAPTURE(half_turns);
    const auto formula = [=](const Vec2& p) { return strip(p, half_turns); };
    // A Möbius strip has one boundary of two curves that continue each other.
    const SkinnedRegion region = patch(formula, n, {"low", "seam", "high", "seam"});
    const StepReport r = write_step(exact_file("strip"), {&region}, 1);
    CHECK(r.valid);
    CHECK(r.shells == 1);
    CHECK(r.solids == 0);
    CHECK(r.free_edges == 2 * n);
    CHECK(r.max_gap <= 1e-9 * r.size);
    CHECK(euler_number(r.file) == 0);
  }
}

TEST_CASE("where three faces meet each is a shell of its own", "[io][step]") {
  RegionSearchOptions regions;
  regions.max_faces_per_edge = 3;
  const BuiltModel made = build_model(two_boxes(), regions, 5);
  REQUIRE(made.model.regions.size() == 11);
  const StepReport r = write_step(exact_file("two_boxes"), made.model.skinned(), kMm);
  CHECK(r.valid);
  CHECK(r.shells == 11);
  CHECK(r.solids == 0);
  CHECK(r.max_normal_jump_deg <= 1e-8);
  CHECK(euler_number(r.file) == 11);  // OpenCASCADE writes the edges of each shell separately
  REQUIRE(r.warnings.size() == 1);
  CHECK_THAT(r.warnings[0], Catch::Contains("more than two faces at an edge"));
}

TEST_CASE("the mouse is one exact solid, which Gmsh opens", "[io][step][mouse]") {
  const BuiltModel made = mouse(12, true);
  REQUIRE(made.model.skinned().size() == 14);
  const fs::path file = exact_file("mouse");
  expect_solid(write_step(file, made.model.skinned(), kMm, {.file = {.name = "mouse"}}), made, 2);
  if (std::system("/usr/bin/python3 -c 'import gmsh' > /dev/null 2>&1") != 0) {
    WARN("skipped: Gmsh's Python module is not installed");
    return;
  }
  CHECK(std::system(("/usr/bin/python3 '" BATTEN_SOURCE_DIR "/tests/io/cad/gmsh_opens_step.py' '" +
                     file.string() + "' > /dev/null")
                        .c_str()) == 0);
}

TEST_CASE("where two meshes meet on a curve, vertices of each split the edges of the other",
          "[io][step]") {
  const BuiltModel made = build_model(box({40, 30, 20}), {}, 9);
  const BuiltModel finer = build_model(box({40, 30, 20}), {}, 4);
  auto regions = made.model.skinned();
  regions[2] = finer.model.skinned()[2];
  const StepReport r = write_step(exact_file("two_meshes"), regions, kMm);
  expect_exact(r, regions);
  CHECK(r.solids == 1);
  CHECK(r.free_edges == 0);
  CHECK(euler_number(r.file) == 2);
  CHECK(r.volume == Approx(24000.0).epsilon(1e-12));
}

TEST_CASE("faces without an exact form are refused by name", "[io][step]") {
  const fs::path file = exact_file("refused");
  const auto error_of = [&](const std::vector<const SkinnedRegion*>& regions) {
    return error_message([&] { write_step(file, regions, kMm); });
  };
  const BuiltModel a_box = build_model(box({4, 3, 2}));
  auto regions = a_box.model.skinned();
  SkinnedRegion embeds = *regions[2];
  EmbeddedLine line;
  line.line.name = regions[0]->edge_aligned[0].line.name;
  line.fitted = regions[0]->edge_aligned[0].fitted;
  embeds.embedded.push_back(line);
  regions[2] = &embeds;
  CHECK_THAT(error_of(regions), Catch::Contains("'" + line.line.name + "'") &&
                                    Catch::Contains("'" + embeds.name + "'") &&
                                    Catch::Contains("step_form = \"face\""));

  CHECK(!fs::exists(file));
}
