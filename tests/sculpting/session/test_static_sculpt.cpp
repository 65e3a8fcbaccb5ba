// SPDX-License-Identifier: MPL-2.0
// Loads: their definitions, and the follower pressure.
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/reference_static_solver.h"
#include "batten/tests/support/sample_lines.h"

using namespace batten_test;
using namespace batten::reference_solver;
using Catch::Matchers::Contains;

namespace {

SkinOptions coarse(double edge) {
  SkinOptions options;
  options.edge_length = edge;
  options.mesher = SkinOptions::Mesher::Fan;
  return options;
}

std::vector<CharacterLine> square(double side) {
  return polygon_lines({{0, 0, 0}, {side, 0, 0}, {side, side, 0}, {0, side, 0}});
}

}  // namespace

TEST_CASE("a small pressure is a uniform load along the normal", "[sculpting][statics]") {
  const RegionLayout layout("square", square(1), coarse(0.1));
  const auto constraints = layout.line_constraints();
  const auto pressed = sculpt(layout, constraints, {{"p", PressureLoad{1e-4}}}, {});
  const auto loaded = sculpt(layout, constraints, {{"f", UniformLoad{{0, 0, 1e-4}}}}, {});
  // Relative units scale the region to its diagonal, √2: the area of the domain is 1/2, as is the
  // area of the surface over the size squared.
  CHECK((pressed.dofs - loaded.dofs).cwiseAbs().maxCoeff() <
        1e-6 * (loaded.dofs.col(2).cwiseAbs().maxCoeff() + 1e-300));
}

TEST_CASE("absolute units: the simply held square plate of the handbook", "[sculpting][statics]") {
  // w_centre = 0.00406235 q a⁴ / D; beta is D, whatever the unit of length.
  for (const double a : {1.0, 250.0}) {
    const RegionLayout layout("square", square(a), coarse(a / 16));
    SculptOptions options;
    const double D = 3.5, q = 1e-3 / (a * a * a);
    options.material = SurfaceStiffness::isotropic(0, D);
    options.units = LoadUnits::Absolute;
    const auto result =
        sculpt(layout, layout.line_constraints(), {{"q", UniformLoad{{0, 0, q}}}}, options);
    const Surface surface(layout.mesh(), layout.element(), result.dofs);
    const double centre = surface.closest_point({a / 2, a / 2, 0}).where.triangle >= 0
                              ? surface.position(surface.closest_point({a / 2, a / 2, 0}).where).z()
                              : 0;
    CHECK(centre == Approx(0.00406235 * q * std::pow(a, 4) / D).epsilon(1e-3));
  }
}

TEST_CASE("pressure equilibrium: the fixed point satisfies K x = p ∬ N (x_u × x_v)",
          "[sculpting][statics]") {
  const RegionLayout layout("pentagon", curved_polygon(5, 0.2, 0.1), coarse(0.2));
  const auto constraints = layout.line_constraints();
  const double p = 60;
  const auto result = sculpt(layout, constraints, {{"p", PressureLoad{p}}}, {});
  CHECK(result.last_change < 1e-12);
  const SurfaceAssembler assembler(*layout.mesh(), layout.element());
  const SparseMatrix K = assembler.stiffness(SurfaceStiffness{});
  const Points F = p / layout.size() * assembler.pressure_load(result.dofs);
  const AffineReduction reduction(constraints);
  const Points unbalanced = K.selfadjointView<Eigen::Lower>() * result.dofs - F;
  // Rounding of K x is relative to the terms of its sums.
  const SparseMatrix sizes = K.cwiseAbs();
  const Points added = sizes.selfadjointView<Eigen::Lower>() * Points(result.dofs.cwiseAbs());
  CHECK((reduction.D().transpose() * unbalanced).cwiseAbs().maxCoeff() < 1e-13 * added.maxCoeff());
  CHECK(result.max_constraint_residual < 1e-13);
}

TEST_CASE("reactions balance the loads", "[sculpting][statics]") {
  const RegionLayout layout("square", square(2), coarse(0.2));
  const Vec3 f(0.3, -0.2, 1.5);
  SculptOptions options;
  options.units = LoadUnits::Absolute;
  for (const Load& load : {Load{"u", UniformLoad{f}}, Load{"p", PointLoad{{1, 1, 0}, f}}}) {
    const auto result = sculpt(layout, layout.line_constraints(), {load}, options);
    Vec3 sum = Vec3::Zero();
    for (const auto& r : result.reactions) sum += r.force;
    const Vec3 total = load.name == "u" ? Vec3(4 * f) : f;
    CHECK((sum + total).norm() < 1e-7);
  }
}

TEST_CASE("a pressure past its limit is reported with the value reached", "[sculpting][statics]") {
  const RegionLayout layout("square", square(1), coarse(0.2));
  SculptOptions options;
  options.material = SurfaceStiffness::isotropic(1, 0.01);
  CHECK_THROWS_AS(sculpt(layout, layout.line_constraints(), {{"p", PressureLoad{1e4}}}, options),
                  NoSolutionError);
  CHECK_THROWS_WITH(sculpt(layout, layout.line_constraints(), {{"p", PressureLoad{1e4}}}, options),
                    Contains("past its limit") && Contains("was reached"));
}

TEST_CASE("bad materials and loads are refused", "[sculpting][statics]") {
  const RegionLayout layout("square", square(1), coarse(0.3));
  SculptOptions options;
  options.material = SurfaceStiffness::isotropic(0, -1);
  CHECK_THROWS_AS(sculpt(layout, layout.line_constraints(), {}, options), InputError);
  options.material.alpha << 1, 2, 2, 1;
  options.material.beta = Vec3::Ones();
  CHECK_THROWS_AS(sculpt(layout, layout.line_constraints(), {}, options), InputError);
  CHECK_THROWS_WITH(
      sculpt(layout, layout.line_constraints(), {{"push", PointLoad{{9, 9, 9}, {0, 0, 1}}}}, {}),
      Contains("'push'") && Contains("away"));
  CHECK_THROWS_WITH(sculpt(layout, layout.line_constraints(), {{"wind", PressureLoad{NAN}}}, {}),
                    Contains("'wind'"));
}

TEST_CASE("too few constraints: the free motion is reported, not a wrong shape",
          "[sculpting][statics]") {
  const RegionLayout layout("square", square(1), coarse(0.3));
  ConstraintSet set(DofMap(*layout.mesh()).count());
  set.fix("one point", 0, Vec3::Zero());
  CHECK_THROWS_AS(sculpt(layout, set, {}, {}), NoSolutionError);
}

TEST_CASE("a face far from the origin is the same shape with the same energy",
          "[sculpting][statics]") {
  const Vec3 far(1e6, -2e6, 5e5);
  const auto lines_at = [](const Vec3& offset) {
    return polygon_lines(
        {offset, offset + Vec3(100, 0, 20), offset + Vec3(100, 80, 0), offset + Vec3(0, 80, 20)});
  };
  const auto shape = [&](const Vec3& offset) {
    const RegionLayout layout("panel", lines_at(offset), coarse(10));
    const auto result = sculpt(layout, layout.line_constraints(), {{"p", PressureLoad{50}}}, {});
    return std::pair(layout.region(result.dofs), result);
  };
  const auto [near_region, near_result] = shape(Vec3::Zero());
  const auto [far_region, far_result] = shape(far);
  CHECK(far_result.energy.bending == Approx(near_result.energy.bending).epsilon(1e-7));
  REQUIRE(far_region.surface.dofs().rows() == near_region.surface.dofs().rows());
  const ParametricMesh& mesh = near_region.surface.mesh();
  double worst = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    worst = std::max(worst, (far_region.surface.dofs().row(3 * v) -
                             near_region.surface.dofs().row(3 * v) - far.transpose())
                                .norm());
  CHECK(worst < 1e-7);
}

TEST_CASE("the limit of a pressure is found whatever was asked for", "[sculpting][statics]") {
  const RegionLayout layout("square", square(1), coarse(0.2));
  std::vector<double> reached;
  for (const double p : {1e3, 1e6}) {
    try {
      sculpt(layout, layout.line_constraints(), {{"p", PressureLoad{p}}}, {});
      FAIL("a pressure of " << p << " should be past its limit");
    } catch (const NoSolutionError& e) {
      const std::string text = e.what();
      reached.push_back(std::stod(text.substr(text.find("limit: ") + 7)));
    }
  }
  CHECK(reached[0] > 10);
  CHECK(reached[1] == Approx(reached[0]).epsilon(0.05));
}

TEST_CASE("springs bring a surface to measured points, as stiffly as they are",
          "[sculpting][statics]") {
  // Points of a dome over a square; some are beyond its boundary.
  SpringLoad springs{{}, 0};
  for (double x = 0.05; x < 2; x += 0.1)
    for (double y = 0.05; y < 2; y += 0.1)
      springs.points.emplace_back(x, y, 0.3 * x * (2 - x) * y * (2 - y));
  springs.points.emplace_back(2.5, 1, 0);
  const RegionLayout layout("square", square(2), coarse(0.2));
  double before = 1e9;
  for (const double stiffness : {0.0, 1e3, 1e5, 1e7}) {
    springs.stiffness = stiffness;
    const SculptResult r = sculpt(layout, layout.line_constraints(), {{"scan", springs}}, {});
    REQUIRE(r.springs.size() == 1);
    CHECK(r.springs[0].points == 401);
    CHECK(r.springs[0].left_out == 1);
    INFO("stiffness " << stiffness << " rms " << r.springs[0].rms);
    CHECK(r.springs[0].rms < before);
    CHECK(r.springs[0].before_max == Approx(0.3 * 0.95 * 1.05 * 0.95 * 1.05).epsilon(0.01));
    CHECK(r.max_constraint_residual < 1e-12);
    before = r.springs[0].rms;
  }
  CHECK(before < 1e-3);
  springs.points[3].x() = std::nan("");
  CHECK_THROWS_WITH(sculpt(layout, layout.line_constraints(), {{"scan", springs}}, {}),
                    Contains("'scan'") && Contains("not finite"));
  springs.points.clear();
  CHECK_THROWS_WITH(sculpt(layout, layout.line_constraints(), {{"scan", springs}}, {}),
                    Contains("no points"));
}
