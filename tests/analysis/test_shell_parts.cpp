// SPDX-License-Identifier: MPL-2.0
// Loads and supports in boxes, and variable thickness of shells.
#include <cmath>

#include "batten/analysis/models/shell_model.h"
#include "batten/core/errors.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

// A strip of length 1 along x.
struct Strip {
  Plates plates;
  ModelLayout layout;
  Points shape;
  static constexpr double L = 1, W = Plates::W, t = Plates::t, E = Plates::E;

  static Plates lines() {
    Plates p;
    p.across("foot", {0, 0, 0}, {0, 0, 0});
    p.across("tip", {L, 0, 0}, {L, 0, 0});
    p.plate("foot", "tip");
    return p;
  }
  Strip()
      : plates(lines()),
        layout(plates.builder.model({})),
        shape(layout.all_dofs(plates.builder.first)) {}

  ShellDefinition definition() const {
    return {{{ShellMaterial::isotropic(E, 0, 2), t}}, {}, {}, {}};
  }
  Vec3 moved(const Points& q, const Vec3& p) const {
    return layout.surface(q).position(nearest_location(layout, shape, p).where);
  }
};

constexpr double kLong = 10;
Box3 between(double x0, double x1) { return {Vec3(x0, -kLong, -kLong), Vec3(x1, kLong, kLong)}; }

Vec3 weight_down(const Vec3&, const Vec3&) { return {0, 0, -Plates::q}; }

}  // namespace

TEST_CASE("loads in a box are those of its part of the surface, or of a curve",
          "[analysis][assemblies]") {
  const Strip strip;
  // The boundaries of the box are not close to element edges.
  for (const auto& [from, to] : {std::pair(0.237, 0.681), {0.51, 0.532}}) {
    const Resultant sum = resultant(
        strip.layout, strip.shape,
        surface_traction(strip.layout, strip.shape, weight_down, {{}, between(from, to)}));
    CHECK(sum.force.z() == Approx(-Plates::q * Strip::W * (to - from)).margin(1e-3 * Plates::q));
    CHECK(sum.moment.y() ==
          Approx(Plates::q * Strip::W * (to * to - from * from) / 2).margin(1e-3 * Plates::q));
  }
  const Box3 half(Vec3(-1, 0, -1), Vec3(2, 0.25, 1));
  const auto force = [&](const Points& F) { return resultant(strip.layout, strip.shape, F); };
  CHECK(force(line_force(strip.layout, strip.shape, "tip", {0, 0, 3}, half)).force.z() ==
        Approx(3 * 0.25).epsilon(0.02));
  CHECK(force(line_moment(strip.layout, strip.shape, "tip", 3, half)).moment.y() ==
        Approx(3 * 0.25).epsilon(0.02));
  const Box3 away(Vec3(3, 3, 3), Vec3(4, 4, 4));
  CHECK_THROWS_WITH(surface_traction(strip.layout, strip.shape, weight_down, {{}, away}),
                    Contains("in the box from [3, 3, 3] to [4, 4, 4]"));
  CHECK_THROWS_WITH(line_force(strip.layout, strip.shape, "tip", {0, 0, 1}, away),
                    Contains("in the box"));
}

TEST_CASE("a supported part clamps the rest, and follows its prescribed displacement",
          "[analysis][assemblies]") {
  const Strip strip;
  ShellDefinition definition = strip.definition();
  constexpr double held = 0.3;
  definition.areas = {
      {"jaw", {{}, between(-1, held)}, {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}}};
  const double EI = Strip::E * std::pow(Strip::t, 3) / 12, free = Strip::L - held;
  {
    const ShellModel shell(strip.layout, strip.shape, definition);
    const Points F =
        surface_traction(strip.layout, strip.shape, weight_down, {{}, between(held, 2)});
    const Points q = shell.solve(F);
    // Elements cut by the boundary are constrained by the supported part.
    CHECK(strip.moved(q, {Strip::L, 0.25, 0}).z() ==
          Approx(-Plates::q * std::pow(free, 4) / (8 * EI)).epsilon(2e-2));
    const auto reactions = shell.reactions(q, F);
    REQUIRE(reactions.size() == 1);
    CHECK(reactions[0].resultant.force.z() == Approx(Plates::q * Strip::W * free).epsilon(1e-3));
  }
  definition.areas[0].displacement = {0, 0, 0.05};
  const ShellModel lifted(strip.layout, strip.shape, definition);
  const Points none = Points::Zero(strip.shape.rows(), 3);
  CHECK(strip.moved(lifted.solve(none), {Strip::L, 0.25, 0}).z() == Approx(0.05).epsilon(1e-6));
  definition.areas[0].part.box = between(3, 4);
  CHECK_THROWS_WITH(ShellModel(strip.layout, strip.shape, definition),
                    Contains("'jaw' contains no part"));
}

TEST_CASE("half of a curve is supported in the same way as all of it", "[analysis][assemblies]") {
  const Strip strip;
  ShellDefinition definition = strip.definition();
  definition.lines = {LineSupport::clamped("foot")};
  const Points F = surface_traction(strip.layout, strip.shape, weight_down);
  const auto tip = [&] {
    return strip
        .moved(ShellModel(strip.layout, strip.shape, definition).solve(F), {Strip::L, 0.25, 0})
        .z();
  };
  const double rows = tip();
  definition.lines[0].box = between(-1, 2);  // whole line: springs instead of constraints
  CHECK(tip() == Approx(rows).epsilon(2e-3));
  definition.lines[0].box = Box3(Vec3(-1, 0.1, -1), Vec3(1, 0.4, 1));
  CHECK(tip() < 1.02 * rows);  // slightly larger deflection
  CHECK(tip() > 2 * rows);
}

TEST_CASE("thickness may change from vertex to vertex", "[analysis][assemblies]") {
  const Strip strip;
  ShellDefinition definition = strip.definition();
  definition.lines = {LineSupport::clamped("foot")};
  const ParametricMesh& mesh = *strip.layout.mesh();
  const Surface surface = strip.layout.surface(strip.shape);
  definition.nodal_thickness_offset = VecX::Zero(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v)  // double thickness at the foot
    definition.nodal_thickness_offset[v] = Strip::t * (1 - strip.shape(3 * v, 0) / Strip::L);
  const ShellModel shell(strip.layout, strip.shape, definition);
  // Under a moment m at the tip: w'' = 12 m / (E t³), with t = t0 (2 - x/L).
  constexpr double m = 1e-4;
  const Points q = shell.solve(line_moment(strip.layout, strip.shape, "tip", m));
  const double k = 12 * m / (Strip::E * std::pow(Strip::t, 3));
  // ∫ (L - x) k / (2 - x/L)³ dx over 0 … L, with s = 2 - x/L: ∫ (s - 1)/s³ ds over 1 … 2 = 1/8
  CHECK(-strip.moved(q, {Strip::L, 0.25, 0}).z() ==
        Approx(k * Strip::L * Strip::L / 8).epsilon(2e-3));
  const Points G = gravity_load(strip.layout, strip.shape,
                                triangle_sections(strip.layout, definition), {0, 0, -10});
  const Resultant sum = resultant(strip.layout, strip.shape, G);
  CHECK(sum.force.z() == Approx(-10 * 2 * 1.5 * Strip::t * Strip::W * Strip::L));
  CHECK(sum.moment.y() ==  // centre of mass at L (2/2 - 1/3)/1.5
        Approx(10 * 2 * Strip::t * Strip::W * Strip::L * Strip::L * (1 - 1.0 / 3)));
  definition.nodal_thickness_offset[0] = -Strip::t;
  CHECK_THROWS_WITH(ShellModel(strip.layout, strip.shape, definition), Contains("thickness = 0"));
  definition.nodal_thickness_offset.resize(3);
  CHECK_THROWS_WITH(ShellModel(strip.layout, strip.shape, definition), Contains("3 thicknesses"));
}
