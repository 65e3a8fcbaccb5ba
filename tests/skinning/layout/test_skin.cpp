// SPDX-License-Identifier: MPL-2.0
// Faces as surfaces: curves are interpolated exactly, the surface is C1, and the result is
// independent of the unit.
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/reference_static_solver.h"
#include "batten/tests/support/sample_lines.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;
using namespace batten::reference_solver;
using Catch::Matchers::Contains;

namespace {

SkinnedRegion skinned(const std::vector<CharacterLine>& lines, SkinOptions options = {},
                      const std::vector<Load>& loads = {}) {
  if (!have_delaunay_mesher()) options.mesher = SkinOptions::Mesher::Fan;
  const RegionLayout layout("region", lines, options);
  return layout.region(sculpt(layout, layout.line_constraints(), loads, {}).dofs);
}

void check_skin(const SkinnedRegion& region, double tolerance) {
  const SkinQuality q = measure(region);
  CHECK(q.max_line_residual <= 1e-12);
  CHECK(q.max_line_deviation <= tolerance);
  CHECK(q.max_normal_jump_deg <= 1e-9);
  CHECK(q.min_jacobian_ratio >= 0.05);
  CHECK(q.singular_nodes == 0);
}

}  // namespace

TEST_CASE("faces of 3, 4, 5 and 11 sides pass through their curves to rounding",
          "[skinning][layout]") {
  for (const int sides : {3, 4, 5, 11})
    for (const auto element : {TriangleElement::HCT, TriangleElement::Z12}) {
      INFO(sides << " sides");
      SkinOptions options;
      options.element = element;
      options.edge_length = 0.2;
      check_skin(skinned(curved_polygon(sides, 0.2, 0.3 / sides / sides), options), 1e-12);
      check_skin(skinned(curved_polygon(sides, 0.2, 0.3 / sides / sides), options,
                         {{"p", PressureLoad{20}}}),
                 1e-12);
    }
}

TEST_CASE("an L-shaped face with a reflex corner", "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  check_skin(
      skinned(polygon_lines({{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 2, 0.4}, {0, 2, 0}})),
      1e-12);
}

TEST_CASE("a flat outline makes a flat surface without bending energy", "[skinning][layout]") {
  const SkinnedRegion region = skinned(polygon_lines({{0, 0, 0}, {3, 0, 0}, {4, 2, 0}, {1, 3, 0}}));
  CHECK(region.surface.dofs().col(2).cwiseAbs().maxCoeff() < 1e-13);
  CHECK(measure(region).area == Approx(0.5 * (3 * 2 - 0 + 4 * 3 - 1 * 2)).epsilon(1e-9));
}

TEST_CASE("the first curve's direction decides the side of the normal", "[skinning][layout]") {
  auto lines = polygon_lines({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  CHECK(skinned(lines).surface.jet({0, Vec3::Constant(1.0 / 3)}).normal().z() == Approx(1));
  std::reverse(lines.begin(), lines.end());
  CHECK(skinned(lines).surface.jet({0, Vec3::Constant(1.0 / 3)}).normal().z() == Approx(1));
  lines = polygon_lines({{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}});
  CHECK(skinned(lines).surface.jet({0, Vec3::Constant(1.0 / 3)}).normal().z() == Approx(-1));
}

TEST_CASE("the surface passes through an inner curve as exactly as through the outline",
          "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  const auto lines = patch_with_inner_line();
  const SkinnedRegion region = skinned(lines, {}, {{"p", PressureLoad{30}}});
  check_skin(region, 1e-12);
  // The rib is inside: both sides have triangles.
  for (const int e : region.edge_aligned.back().edges)
    CHECK_FALSE(region.surface.mesh().edges()[e].boundary());
}

TEST_CASE(
    "inner curves that cannot be straight runs are embedded, or refused if they must be aligned",
    "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  auto lines = patch_with_inner_line();
  const auto a = lines[0].curve->evaluate(0.3), b = lines[2].curve->evaluate(0.3);
  const auto rib = lines[4].curve;
  using Role = CharacterLine::Role;
  using MeshAlignment = CharacterLine::MeshAlignment;
  const auto gap_of = [](const std::vector<CharacterLine>& l, size_t edge_aligned) {
    const RegionLayout layout("region", l, {});
    CHECK(layout.edge_aligned().size() == edge_aligned);
    CHECK(layout.embedded().size() == l.size() - edge_aligned);
    const SkinnedRegion region =
        layout.region(sculpt(layout, layout.line_constraints(), {}, {}).dofs);
    const SkinQuality q = measure(region);
    CHECK(q.max_line_residual < 1e-12);
    CHECK(q.max_line_deviation <= layout.tolerance());
    CHECK(q.max_line_gap <= layout.tolerance());
    return q.max_line_gap;
  };
  // Across the rib, through one of its points: the rib stays mesh-aligned, this curve crosses its
  // elements.
  auto crossing = lines;
  crossing.push_back(
      {"second",
       curve_through_points(
           "second",
           {lines[1].curve->evaluate(0.5), rib->evaluate(0.5), lines[3].curve->evaluate(0.5)}, 180),
       Role::Inner});
  CHECK(gap_of(crossing, 5) > 0);
  crossing.back().mesh_alignment = MeshAlignment::EdgeAligned;
  CHECK_THROWS_WITH(
      RegionLayout("region", crossing, {}),
      Contains("'second' cannot be mesh-aligned") && Contains("intersects curve 'rib'"));
  auto embedded = lines;
  embedded.back().mesh_alignment = MeshAlignment::Embedded;
  gap_of(embedded, 4);
  auto loose = lines;
  loose.push_back({"loose", curve_through_points("loose", {a, Vec3(0.7 * a + 0.3 * b)}),
                   Role::Inner, MeshAlignment::EdgeAligned});
  CHECK_THROWS_WITH(RegionLayout("region", loose, {}),
                    Contains("'loose' cannot be mesh-aligned") && Contains("away from curve"));
  // The same position at two heights.
  auto bent = lines;
  bent.push_back({"bent", curve_through_points("bent", {a, Vec3(0.5 * (a + b) + Vec3(0, 0, 1)), b}),
                  Role::Inner});
  CHECK_THROWS_WITH(RegionLayout("region", bent, {}),
                    Contains("'rib'") && Contains("'bent.1'") && Contains("apart"));
}

TEST_CASE("curves that are not cubic are met within the tolerance, in both directions",
          "[skinning][layout]") {
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 4; ++i)
    lines.push_back(
        {"wave " + std::to_string(i), curve_from_formula(0, 1, [i](double t, int order) -> Vec3 {
           const Vec3 corner[5] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 0}};
           const double k = 2 * std::numbers::pi;
           const Vec3 side = corner[i + 1] - corner[i];
           if (order == 0) return corner[i] + t * side + Vec3(0, 0, 0.1 * std::sin(k * t));
           if (order == 1) return side + Vec3(0, 0, 0.1 * k * std::cos(k * t));
           return Vec3(0, 0, -0.1 * k * k * std::sin(k * t));
         })});
  for (const double tolerance : {1e-3, 1e-6}) {
    SkinOptions options;
    options.tolerance = tolerance;
    const SkinnedRegion region = skinned(lines, options);
    check_skin(region, tolerance);
    CHECK(measure(region).max_line_deviation > 1e-4 * tolerance);
  }
}

TEST_CASE("curves that continue each other smoothly share one side", "[skinning][layout]") {
  // A square whose lower side consists of two curves, one of them reversed.
  std::vector<CharacterLine> lines = {
      {"left half", bezier_curve({1, 0, 0.2}, {0.7, 0, 0.2}, {0.3, 0, 0.1}, {0, 0, 0})},
      {"right half", bezier_curve({1, 0, 0.2}, {1.3, 0, 0.2}, {1.7, 0, 0.1}, {2, 0, 0})},
      {"right", curve_through_points("right", {{2, 0, 0}, {2, 2, 0}})},
      {"top", curve_through_points("top", {{2, 2, 0}, {0, 2, 0}})},
      {"left", curve_through_points("left", {{0, 2, 0}, {0, 0, 0}})}};
  if (!have_delaunay_mesher()) return;
  SkinOptions options;
  options.tolerance = 1e-4;
  const RegionLayout layout("region", lines, options);
  CHECK(layout.corners().size() == 4);
  CHECK(layout.edge_aligned().size() == 5);
  const auto region = layout.region(sculpt(layout, layout.line_constraints(), {}, {}).dofs);
  check_skin(region, 1e-4);
}

TEST_CASE("the same face in mm and in m is the same shape", "[skinning][layout]") {
  SkinOptions mm, m;
  mm.edge_length = 150;
  m.edge_length = 0.15;
  mm.tolerance = 0.01;
  m.tolerance = 1e-5;
  const auto a = skinned(curved_polygon(5, 0.3, 0.1, 1000), mm, {{"p", PressureLoad{25}}});
  const auto b = skinned(curved_polygon(5, 0.3, 0.1, 1), m, {{"p", PressureLoad{25}}});
  REQUIRE(a.surface.dofs().rows() == b.surface.dofs().rows());
  CHECK((a.surface.dofs() / 1000 - b.surface.dofs()).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("one thread and two give the same bits", "[skinning][layout]") {
  SkinOptions options;
  options.edge_length = 0.08;
  const auto shape = [&] {
    return skinned(curved_polygon(5, 0.3, 0.1), options, {{"p", PressureLoad{25}}}).surface.dofs();
  };
  const ThreadGuard guard(1);
  const Points one = shape();
  set_thread_count(2);
  const Points two = shape();
  CHECK((one.array() == two.array()).all());
}

TEST_CASE("the fan of a pentagon without refinement is the paper's five triangles",
          "[skinning][layout]") {
  SkinOptions options;
  options.mesher = SkinOptions::Mesher::Fan;
  options.fan_refinements = 0;
  const RegionLayout layout("pentagon", curved_polygon(5, 0, 0), options);
  CHECK(layout.mesh()->triangle_count() == 5);
  CHECK(DofMap(*layout.mesh()).count() == 28);
  CHECK(layout.corner_constraints().constraints().size() == 5);
  options.tolerance = 1e-8;
  const auto circle_arcs = [] {
    std::vector<CharacterLine> lines;
    for (int i = 0; i < 5; ++i)
      lines.push_back(
          {"arc " + std::to_string(i), curve_from_formula(0, 1, [i](double t, int order) -> Vec3 {
             const double w = 2 * std::numbers::pi / 5,
                          a = w * (i + t) + order * std::numbers::pi / 2;
             return std::pow(w, order) * Vec3(std::cos(a), std::sin(a), 0) +
                    (order == 0   ? Vec3(0, 0, 0.5 * t * (1 - t))
                     : order == 1 ? Vec3(0, 0, 0.5 - t)
                                  : Vec3(0, 0, -1));
           })});
    return lines;
  };
  CHECK_THROWS_WITH(RegionLayout("pentagon", circle_arcs(), options),
                    Contains("has no nodes for curve 'arc 0' with refine = 0"));
}
