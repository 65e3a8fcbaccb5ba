// SPDX-License-Identifier: MPL-2.0
// Edits of a layout: local refinement, other shapes of curves, added and removed inner curves.
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_static_solver.h"
#include "batten/tests/support/sample_lines.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using namespace batten::reference_solver;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;
using Role = CharacterLine::Role;

CharacterLine flat_ellipse(const std::string& name, Role role, const Vec3& centre, double a,
                           double b) {
  return {name,
          curve_from_formula(0, 2 * pi,
                             [=](double t, int order) -> Vec3 {
                               const double s = t + order * pi / 2;
                               const Vec3 x(a * std::cos(s), b * std::sin(s), 0);
                               return order == 0 ? Vec3(centre + x) : x;
                             }),
          role};
}

CharacterLine straight(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, curve_through_points(name, {a, b}), Role::Inner};
}

SkinOptions coarse(double edge = 0.25, double tolerance = 2e-3) {
  SkinOptions options;
  options.edge_length = edge;
  options.tolerance = tolerance;
  return options;
}

// A small door: an outline with corners on mesh-aligned curves, a hole and a closed hollow, both
// embedded.
std::vector<CharacterLine> panel() {
  auto lines = polygon_lines({{0, 0, 0}, {2, 0, 0.2}, {2, 1.4, 0}, {0, 1.4, 0.2}});
  lines.push_back(flat_ellipse("hole", Role::Hole, {0.5, 0.7, 0.1}, 0.2, 0.25));
  lines.push_back(flat_ellipse("hollow", Role::Inner, {1.4, 0.7, 0.1}, 0.3, 0.2));
  return lines;
}

std::vector<CharacterLine> disc() {
  return {flat_ellipse("rim", Role::Outline, {0, 0, 0}, 1, 0.8),
          flat_ellipse("hole", Role::Hole, {0.4, 0, 0}, 0.2, 0.15),
          straight("rib", {-0.6, -0.3, 0}, {-0.1, 0.4, 0})};
}

std::vector<CharacterLine> ring() {
  return {flat_ellipse("lower", Role::Outline, {0, 0, 0}, 1, 1),
          flat_ellipse("upper", Role::Outline, {0, 0, 1.2}, 0.8, 0.7)};
}

Surface surface_of(const RegionLayout& layout) {
  return layout.region(sculpt(layout, layout.line_constraints(), {}, {}).dofs).surface;
}

std::vector<char> random_marks(const RegionLayout& layout, Random& random, double share) {
  std::vector<char> marks(layout.mesh()->triangle_count());
  for (char& m : marks) m = random.between(0, 1) < share;
  return marks;
}

bool same_rows(const ConstraintSet& a, const ConstraintSet& b, double tolerance, bool values) {
  if (a.dof_count() != b.dof_count() || a.constraints().size() != b.constraints().size() ||
      a.names() != b.names())
    return false;
  for (size_t r = 0; r < a.constraints().size(); ++r) {
    const auto &x = a.constraints()[r], &y = b.constraints()[r];
    if (x.name != y.name || x.entries.size() != y.entries.size()) return false;
    for (size_t i = 0; i < x.entries.size(); ++i)
      if (x.entries[i].dof != y.entries[i].dof ||
          !(std::abs(x.entries[i].coefficient - y.entries[i].coefficient) <= tolerance))
        return false;
    if (values && !((x.value - y.value).norm() <= tolerance)) return false;
  }
  return true;
}

void check_edge_aligned_lines(const RegionLayout& layout) {
  const ParametricMesh& mesh = *layout.mesh();
  for (const EdgeAlignedLine& aligned_line : layout.edge_aligned()) {
    REQUIRE(aligned_line.vertices.size() == aligned_line.parameters.size());
    REQUIRE(aligned_line.edges.size() + 1 == aligned_line.vertices.size());
    CHECK(aligned_line.parameters.front() == aligned_line.fitted.start());
    CHECK(aligned_line.parameters.back() == Approx(aligned_line.fitted.end()).epsilon(1e-14));
    for (size_t k = 0; k < aligned_line.edges.size(); ++k) {
      CHECK(aligned_line.parameters[k] < aligned_line.parameters[k + 1]);
      CHECK(aligned_line.edges[k] ==
            mesh.edge_between(aligned_line.vertices[k], aligned_line.vertices[k + 1]));
      CHECK(aligned_line.edges[k] >= 0);
    }
  }
}

HermiteCurve lifted(const HermiteCurve& curve, double height) {
  Points dofs = curve.dofs();
  for (int i = 0; i < curve.node_count(); ++i) dofs(curve.mesh().position_dof(i), 2) += height;
  return {curve.mesh(), dofs};
}

}  // namespace

TEST_CASE("wherever a layout is refined, its curves stay where they are", "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  Random random(3);
  for (const auto& lines : {patch_with_inner_line(), panel(), disc(), ring()}) {
    RegionLayout layout("region", lines, coarse());
    const double area = layout.trim() ? layout.trim()->area() : 0;
    for (int round = 0; round < 3; ++round) {
      const int before = layout.mesh()->triangle_count();
      REQUIRE(layout.refine(random_marks(layout, random, 0.2)));
      CHECK(layout.mesh()->triangle_count() > before);
      check_edge_aligned_lines(layout);
      const Surface shape = surface_of(layout);
      CHECK(layout.line_constraints().max_residual(shape.dofs()) <= 1e-12 * layout.size());
      const SkinQuality quality = measure(layout.region(shape.dofs()));
      CHECK(quality.max_line_residual <= 1e-10);
      CHECK(quality.max_line_gap <= 2 * layout.tolerance());
      CHECK(quality.max_normal_jump_deg < 1e-8);
      if (!layout.trim()) continue;
      CHECK(layout.trim()->area() == Approx(area).epsilon(1e-9));
      double sum = 0;
      for (int t = 0; t < layout.mesh()->triangle_count(); ++t)
        sum += layout.trim()->area_fraction(t) * layout.mesh()->shape(t).area;
      CHECK(sum == Approx(area).epsilon(1e-9));
    }
  }
}

TEST_CASE("no marks change nothing, and wrong counts are reported", "[skinning][layout]") {
  RegionLayout layout("region", curved_polygon(4, 0.1, 0.1), coarse());
  const auto mesh = layout.mesh();
  CHECK_FALSE(layout.refine(std::vector<char>(mesh->triangle_count(), 0)));
  CHECK_THROWS_AS(layout.refine(std::vector<char>(3, 1)), InputError);
  CHECK(layout.mesh() == mesh);
}

TEST_CASE("another shape of a curve changes values and keeps coefficients", "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  RegionLayout layout("region", panel(), coarse());
  for (const std::string name : {"side 1", "hollow", "hole"}) {
    const ConstraintSet before = layout.line_constraints();
    const HermiteCurve curve = lifted(layout.line(name), 0.05);
    layout.set_line(name, curve);
    CHECK(layout.line(name).dofs() == curve.dofs());
    const ConstraintSet after = layout.line_constraints();
    CHECK(same_rows(before, after, 0, false));
    CHECK_FALSE(same_rows(before, after, 0.01, true));
    // Only the equations of this curve have changed.
    for (size_t r = 0; r < after.constraints().size(); ++r) {
      const Vec3 moved = after.constraints()[r].value - before.constraints()[r].value;
      if (after.names()[static_cast<size_t>(after.constraints()[r].name)] != name)
        CHECK(moved.norm() == 0);
    }
  }
  // The inputs follow, so that quality is measured against the present curve.
  for (const EmbeddedLine& line : layout.embedded())
    CHECK(
        (line.line.curve->evaluate(line.fitted.start()) - line.fitted.evaluate(line.fitted.start()))
            .norm() < 1e-14);
}

TEST_CASE("a surface is on a curve that was lifted, before and after refinement",
          "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  RegionLayout layout("region", panel(), coarse());
  layout.set_line("hollow", lifted(layout.line("hollow"), 0.1));
  Random random(5);
  for (int round = 0; round < 2; ++round) {
    const Surface shape = surface_of(layout);
    CHECK(layout.line_constraints().max_residual(shape.dofs()) <= 1e-12);
    const SkinQuality quality = measure(layout.region(shape.dofs()));
    CHECK(quality.max_line_gap < 0.01);
    CHECK(quality.max_line_deviation < 0.01);
    REQUIRE(layout.refine(random_marks(layout, random, 0.3)));
  }
}

TEST_CASE("an inner curve that is added and removed leaves the layout as it was",
          "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  for (const auto& lines : {panel(), disc(), curved_polygon(5, 0.1, 0.02)}) {
    RegionLayout layout("region", lines, coarse());
    const Surface shape = surface_of(layout);
    const ConstraintSet before = layout.line_constraints();
    const bool flat = lines[0].name == "rim";
    // On the shape itself, from one of its points to another.
    const CharacterLine line =
        flat ? straight("new", {-0.7, 0.2, 0}, {-0.4, 0.45, 0})
             : straight("new", shape.position(shape.closest_point({0.2, 0.15, 0}).where),
                        shape.position(shape.closest_point({0.7, 0.2, 0}).where));
    CHECK_FALSE(layout.has_line("new"));
    layout.add_inner_line(line, shape);
    CHECK(layout.has_line("new"));
    const ConstraintSet with = layout.line_constraints();
    CHECK(with.constraints().size() > before.constraints().size());
    const Surface ribbed = surface_of(layout);
    CHECK(with.max_residual(ribbed.dofs()) <= 1e-12);
    double off = 0;
    const HermiteCurve& curve = layout.line("new");
    for (int i = 0; i <= 20; ++i) {
      const double t = curve.start() + (curve.end() - curve.start()) * i / 20;
      off = std::max(off, ribbed.closest_point(curve.evaluate(t)).distance);
    }
    CHECK(off < 3 * layout.tolerance());
    layout.remove_inner_line("new");
    CHECK_FALSE(layout.has_line("new"));
    CHECK(same_rows(layout.line_constraints(), before, 1e-13, true));
  }
}

TEST_CASE("an inner curve that is removed from between others leaves the boundary in order",
          "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  RegionLayout layout("region", disc(), coarse());
  layout.add_inner_line(straight("second", {-0.7, 0.2, 0}, {-0.4, 0.45, 0}), surface_of(layout));
  layout.remove_inner_line("rib");
  CHECK(layout.has_line("second"));
  const SkinnedRegion region = layout.region(surface_of(layout).dofs());
  for (const auto& loop : region.boundary)
    for (const BoundarySegment& piece : loop)
      CHECK(region.embedded[static_cast<size_t>(piece.index)].line.role != Role::Inner);
  Random random(1);
  REQUIRE(layout.refine(random_marks(layout, random, 0.3)));
  CHECK(layout.trim()->area() * layout.size() * layout.size() ==
        Approx(pi * (0.8 - 0.03)).epsilon(1e-3));
}

TEST_CASE("a curve with corners is added and removed by its own name", "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  RegionLayout layout("region", curved_polygon(5, 0.0, 0.02), coarse());
  const ConstraintSet before = layout.line_constraints();
  const CharacterLine bent{"bent",
                           curve_through_points("bent", {{-0.3, 0, 0}, {0.1, 0.3, 0}, {0.4, 0, 0}}),
                           Role::Inner};
  layout.add_inner_line(bent, surface_of(layout));
  CHECK(layout.has_line("bent.1"));
  CHECK(layout.has_line("bent.2"));
  CHECK_THAT(error_message([&] { layout.add_inner_line(bent, surface_of(layout)); }),
             Contains("two curves have the name 'bent.1'"));
  layout.remove_inner_line("bent");
  CHECK(same_rows(layout.line_constraints(), before, 1e-13, true));
}

TEST_CASE("invalid edits are refused with the reason, and leave the layout as it was",
          "[skinning][layout]") {
  if (!have_delaunay_mesher()) return;
  RegionLayout layout("region", panel(), coarse());
  const Surface shape = surface_of(layout);
  const ConstraintSet before = layout.line_constraints();
  const auto mesh = layout.mesh();
  const auto trim = layout.trim();
  const auto line = [](const Vec3& a, const Vec3& b) { return straight("new", a, b); };
  const auto add = [&](const CharacterLine& l) {
    return error_message([&] { layout.add_inner_line(l, shape); });
  };
  CHECK_THAT(add(line({1.2, 1.2, 0.1}, {3, 1.2, 0.1})), Contains("leaves the face"));
  CHECK_THAT(add(line({0.1, 0.7, 0.1}, {0.9, 0.7, 0.1})), Contains("leaves the face"));
  CHECK_THAT(add(line({1, 1, 9}, {1.2, 1, 9})), Contains("away from the face"));
  CHECK_THAT(add(line({1.4, 0.4, 0.4}, {1.4, 1, 0.4})), Contains("'hollow' and 'new' intersect"));
  CHECK_THAT(add({"hollow", line({1, 1, 0.1}, {1.2, 1, 0.1}).curve, Role::Inner}),
             Contains("two curves have the name 'hollow'"));
  CHECK_THAT(add({"new", line({1, 1, 0.1}, {1.2, 1, 0.1}).curve, Role::Outline}),
             Contains("not an inner curve"));
  CHECK_THAT(add({"new", nullptr, Role::Inner}), Contains("has no geometry"));
  const auto nowhere =
      curve_from_formula(0, 1, [](double t, int) { return Vec3(t, 0.2, std::sqrt(0.5 - t)); });
  CHECK_THAT(add({"new", nowhere, Role::Inner}), Contains("not finite"));
  const RegionLayout other("other", panel(), coarse(0.4));
  CHECK_THAT(error_message([&] {
               layout.add_inner_line(line({1, 1, 0.1}, {1.2, 1, 0.1}), surface_of(other));
             }),
             Contains("does not have the mesh"));

  CHECK_THAT(error_message([&] { layout.line("holow"); }), Contains("did you mean 'hollow'"));
  CHECK_THAT(error_message([&] { layout.remove_inner_line("holow"); }),
             Contains("did you mean 'hollow'"));
  CHECK_THAT(error_message([&] { layout.remove_inner_line("hole"); }),
             Contains("cannot be removed"));
  CHECK_THAT(error_message([&] { layout.remove_inner_line("side 1"); }),
             Contains("cannot be removed"));
  const HermiteCurve hollow = layout.line("hollow");
  CHECK_THAT(error_message([&] { layout.set_line("holow", hollow); }), Contains("did you mean"));
  CHECK_THAT(error_message([&] { layout.set_line("hollow", hollow.with_scaled_parameter(2)); }),
             Contains("same nodes"));
  CHECK_THAT(error_message([&] { layout.set_line("side 1", hollow); }), Contains("same nodes"));

  CHECK(layout.mesh() == mesh);
  CHECK(layout.trim() == trim);
  CHECK(same_rows(layout.line_constraints(), before, 0, true));

  RegionLayout tube("tube", ring(), coarse());
  CHECK_THAT(error_message([&] {
               tube.add_inner_line(straight("new", {1, 0, 0.4}, {1, 0, 9}), surface_of(tube));
             }),
             Contains("'new'"));
  CHECK_FALSE(tube.has_line("new"));
}
