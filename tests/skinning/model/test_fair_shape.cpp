// SPDX-License-Identifier: MPL-2.0
// Shapes from curves alone: spheres, cylinders, cones and tori are reproduced.
#include "batten/skinning/model/model_shapes.h"

#include <cmath>
#include <numbers>

#include "batten/benchmarks/analytic_shapes.h"
#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/join.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_model_builder.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

double distance(const bench::AnalyticShape& shape, const Surface& surface) {
  double worst = 0;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    for (const Vec3& L : {Vec3(1, 1, 1), Vec3(2.8, 0.1, 0.1), Vec3(0.1, 1.5, 1.4)})
      worst = std::max(worst, shape.surface.closest(surface.position({t, L / 3})).distance);
  return worst;
}

struct FairedShape {
  ModelLayout model;
  Points bending;
  MinimumVariationSurface fair;
  double before, after;  // distance from the exact surface over the size
};
FairedShape make(const bench::AnalyticShape& shape) {
  SkinOptions options;
  options.edge_length = shape.coarse;
  options.tolerance = 0.01 * std::pow(shape.coarse, 4);
  ModelLayout model(RegionLayout(shape.name, shape.boundary(), options));
  const Points bending = model.minimize_energy(SurfaceStiffness::isotropic(0, 1));
  MinimumVariationSurface fair = fair_shape(model, bending, model.line_constraints());
  const double before = distance(shape, model.surface(bending)) / model.size(),
               after = distance(shape, model.surface(fair.dofs)) / model.size();
  return {std::move(model), bending, std::move(fair), before, after};
}

CharacterLine circle(const std::string& name, double radius, double z) {
  std::vector<Vec3> points;
  constexpr int pieces = 48;
  for (int i = 0; i <= pieces; ++i) {
    const double a = 2 * std::numbers::pi * (i % pieces) / pieces;
    points.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
  }
  return {name, curve_through_points(name, points)};
}

bench::AnalyticShape shape_named(const std::string& name) {
  for (const bench::AnalyticShape& shape : bench::analytic_shapes())
    if (shape.name == name) return shape;
  throw InputError("no shape '" + name + "'");
}

}  // namespace

TEST_CASE("boundary curves alone give back cylinders, spheres, tori and annuli",
          "[skinning][model]") {
  struct Expected {
    std::string name;
    double least_before, most_after;  // relative to the size
  };
  for (const auto& [name, before, after] : {Expected{"cylinder 90", 1e-2, 3e-4},
                                            {"cylinder 200", 5e-3, 3e-4},
                                            {"sphere octant", 5e-2, 1e-4},
                                            {"torus quarter", 0.1, 5e-4},
                                            {"rings, equal", 5e-3, 2e-4},
                                            {"rings, unequal", 5e-3, 2e-4}}) {
    INFO(name);
    const FairedShape made = make(shape_named(name));
    CHECK(made.before > before);
    CHECK(made.after < after);
    CHECK(made.fair.converged);
    CHECK(made.fair.factorizations <= 10);
    CHECK(made.fair.max_residual < 1e-10 * made.model.size());
    CHECK(made.fair.functional < 0.05 * made.fair.start_functional);
  }
}

TEST_CASE("a fair shape does not depend on unit or position", "[skinning][model]") {
  const bench::AnalyticShape shape = shape_named("sphere octant");
  const auto dofs = [&](double unit, const Vec3& place) {
    std::vector<CharacterLine> lines;
    for (const CharacterLine& line : shape.boundary()) {
      const auto curve = line.curve;
      lines.push_back({line.name,
                       curve_from_formula(curve->start(), curve->end(),
                                          [=](double t, int order) -> Vec3 {
                                            return unit * curve->evaluate(t, order) +
                                                   (order == 0 ? place : Vec3::Zero());
                                          }),
                       line.role});
    }
    SkinOptions options;
    options.edge_length = unit * shape.coarse;
    const ModelLayout model(RegionLayout("octant", lines, options));
    const Points start = model.minimize_energy(SurfaceStiffness::isotropic(0, 1));
    const Points fair = fair_shape(model, start, model.line_constraints()).dofs;
    return Points((fair - model.position_dofs() * place.transpose()) / unit);
  };
  const Points same = dofs(1, Vec3::Zero()), other = dofs(1000, Vec3(5000, -3000, 200));
  REQUIRE(same.rows() == other.rows());
  CHECK((same - other).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("a long can between two circles is a cylinder, a frustum a cone", "[skinning][model]") {
  struct Expected {
    double low, high, height;
  };
  for (const auto& [low, high, height] : {Expected{33, 33, 120}, Expected{40, 25, 60}}) {
    SkinOptions options;
    options.edge_length = 12;
    const ModelLayout model(
        RegionLayout("can", {circle("low", low, 0), circle("high", high, height)}, options));
    const Points bending = model.minimize_energy({});
    const MinimumVariationSurface fair = fair_shape(model, bending, model.line_constraints());
    const auto error = [&, low = low, high = high, height = height](const Points& dofs) {
      double worst = 0;
      const Surface surface = model.surface(dofs);
      for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
        const Vec3 x = surface.position({t, Vec3::Constant(1.0 / 3)});
        const double radius = low + (high - low) * x.z() / height;
        worst = std::max(worst, std::abs(std::hypot(x.x(), x.y()) - radius) / low);
      }
      return worst;
    };
    CHECK(error(bending) > 0.05);
    CHECK(error(fair.dofs) < 1e-3);
    CHECK(error(loft_shape(model, {})) < 1e-3);
  }
}

TEST_CASE("a loft is ruled between two sections, and passes through its curves",
          "[skinning][model]") {
  // Arches of different heights, not in parallel planes.
  const auto arch = [](const std::string& name, double y, double height, double width) {
    return CharacterLine{name, curve_from_formula(-1, 1, [=](double t, int order) -> Vec3 {
                           if (order == 0) return {width * t, y + 0.2 * t, height * (1 - t * t)};
                           return order == 1 ? Vec3(width, 0.2, -2 * height * t)
                                             : Vec3(0, 0, -2 * height);
                         })};
  };
  const auto straight = [](const std::string& name, const Vec3& a, const Vec3& b) {
    return CharacterLine{name, curve_through_points(name, {a, b})};
  };
  const std::vector<CharacterLine> lines{
      arch("front", 0, 0.5, 1), straight("right", {1, 0.2, 0}, {0.8, 3.2, 0}),
      arch("back", 3, 0.3, 0.8), straight("left", {-0.8, 2.8, 0}, {-1, -0.2, 0})};
  SkinOptions options;
  options.edge_length = 0.3;
  const ModelLayout model(RegionLayout("arch", lines, options));
  const Points loft = loft_shape(model, {"back"});
  CHECK(model.line_constraints().max_residual(loft) < 1e-10);
  double worst = 0;
  const Surface surface = model.surface(loft);
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    const Vec3 x = surface.position({t, Vec3::Constant(1.0 / 3)});
    // The ruled surface at the same x and y: height over the half-width there.
    const double f = x.y() / 3, width = 1 - 0.2 * f, height = 0.5 - 0.2 * f, s = x.x() / width;
    worst = std::max(worst, std::abs(x.z() - height * (1 - s * s)));
  }
  CHECK(worst < 0.02);
  CHECK_THROWS_WITH(loft_shape(model, {"bakc"}), Contains("'bakc' is neither a side of a face"));
  CHECK_THROWS_WITH(loft_shape(model, {}), Contains("nothing to loft"));
  CHECK_THROWS_WITH(loft_shape(model, {"back", "left"}),
                    Contains("on a side adjacent to the other sections"));
}

TEST_CASE("joined octants are a sphere whose curvature goes on across the join",
          "[skinning][model]") {
  const batten_test::TestModelBuilder patches = batten_test::octants(0.2);
  const JoinLine line = patches.join_line("zx", 0, 1);
  const ModelLayout model = patches.model({line});
  const MinimumVariationSurface fair =
      fair_shape(model, model.minimize_energy({}), model.line_constraints());
  double worst = 0;
  const Surface surface = model.surface(fair.dofs);
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    worst = std::max(worst, std::abs(surface.position({t, Vec3::Constant(1.0 / 3)}).norm() - 1));
  CHECK(worst < 1e-3);
  const SkinnedRegion a = model.skinned(0, fair.dofs), b = model.skinned(1, fair.dofs);
  const JoinQuality quality = measure_join({&a, &b}, line);
  CHECK(quality.max_gap < 1e-12);
  CHECK(quality.max_deg < 0.05);
  CHECK(quality.median_curvature_jump < 0.01);
}

namespace {

// An octant over a quarter of a cylinder, adjacent along "rim".
batten_test::TestModelBuilder cap_on_cylinder() {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ(), down = -1.2 * z;
  batten_test::TestModelBuilder p;
  p.options.edge_length = 0.2;
  const auto line = [&](const std::string& name, const std::shared_ptr<const InputCurve>& curve) {
    p.add(batten_test::prescribed_line(name, curve, 3, p.options.edge_length));
  };
  line("rim", batten_test::quarter(x, y));
  line("yz", batten_test::quarter(y, z));
  line("zx", batten_test::quarter(z, x));
  line("side1", curve_through_points("side1", {x, x + down}));
  line("side2", curve_through_points("side2", {y, y + down}));
  line("foot", curve_from_formula(0, std::numbers::pi / 2, [&](double t, int order) -> Vec3 {
         return batten_test::quarter(x, y)->evaluate(t, order) +
                (order == 0 ? down : Vec3(0, 0, 0));
       }));
  p.region({"rim", "yz", "zx"});
  p.region({"-rim", "side1", "foot", "side2"});
  return p;
}

JoinQuality faired_join(const batten_test::TestModelBuilder& patches, const JoinLine& join) {
  const ModelLayout model = patches.model({join});
  const Points dofs = fair_shape(model, model.minimize_energy({}), model.line_constraints()).dofs;
  const SkinnedRegion a = model.skinned(0, dofs), b = model.skinned(1, dofs);
  return measure_join({&a, &b}, join);
}

}  // namespace

TEST_CASE("a cap on a cylinder: the curves across its edge show the cap's curvature jump",
          "[skinning][model]") {
  const batten_test::TestModelBuilder patches = cap_on_cylinder();
  JoinLine join = patches.join_line("rim", 0, 1);
  CHECK_FALSE(is_curvature_continuous(patches.model({join}), patches.plan({join}).front()));
  const JoinQuality quality = faired_join(patches, join);
  CHECK(quality.max_deg < 0.05);
  CHECK(quality.median_curvature_jump == Approx(1).epsilon(0.02));

  join.curvature = true;
  CHECK(is_curvature_continuous(patches.model({join}), patches.plan({join}).front()));
  const JoinQuality requested = faired_join(patches, join);
  CHECK(requested.max_deg < 0.05);
  CHECK(requested.median_curvature_jump < 0.1);
}

TEST_CASE("where curvature goes on, its jump is ten times smaller than where it may jump",
          "[skinning][model]") {
  // A free form: two adjacent wavy strips.
  batten_test::TestModelBuilder p;
  p.options.edge_length = 0.15;
  const auto wave = [&](const std::string& name, double y, double tilt) {
    p.add(batten_test::prescribed_line(
        name,
        curve_from_formula(0, 1,
                           [=](double t, int order) -> Vec3 {
                             const double k = 2;
                             if (order == 0) return {t, y, tilt * std::sin(k * t)};
                             if (order == 1) return {1, 0, tilt * k * std::cos(k * t)};
                             return {0, 0, -tilt * k * k * std::sin(k * t)};
                           }),
        3, p.options.edge_length));
  };
  const auto across = [&](const std::string& name, double x, double from, double z0, double z1) {
    p.add(batten_test::prescribed_line(name,
                                       curve_from_formula(from, from + 1,
                                                          [=](double t, int order) -> Vec3 {
                                                            // One parabola for both strips, from z0
                                                            // over y = -1 and 1 to z1 at 0.
                                                            if (order == 0)
                                                              return {x, t, z1 + (z0 - z1) * t * t};
                                                            if (order == 1)
                                                              return {0, 1, 2 * (z0 - z1) * t};
                                                            return {0, 0, 2 * (z0 - z1)};
                                                          }),
                                       3, p.options.edge_length));
  };
  const double s = std::sin(2.0);
  wave("low", -1, 0.1);
  wave("middle", 0, 0.3);
  wave("high", 1, 0.1);
  for (const double from : {-1.0, 0.0}) {
    const std::string which = from < 0 ? "1" : "2";
    across("start" + which, 0, from, 0, 0);
    across("end" + which, 1, from, 0.1 * s, 0.3 * s);
  }
  p.region({"low", "end1", "middle", "start1"});
  p.region({"middle", "end2", "high", "start2"});
  JoinLine join = p.join_line("middle", 0, 1);
  CHECK(is_curvature_continuous(p.model({join}), p.plan({join}).front()));
  const JoinQuality goes_on = faired_join(p, join);
  join.curvature = false;
  const JoinQuality jumps = faired_join(p, join);
  CHECK(goes_on.max_deg < 0.1);
  CHECK(goes_on.median_curvature_jump < 0.1 * jumps.median_curvature_jump);
}

TEST_CASE("strength and maximum displacement stop fairing early, where every curve still holds",
          "[skinning][model]") {
  const FairedShape made = make(shape_named("cylinder 90"));
  const ConstraintSet rows = made.model.line_constraints();
  MinimumVariationOptions half;
  half.strength = 0.5;
  const MinimumVariationSurface middle = fair_shape(made.model, made.bending, rows, half);
  CHECK((middle.dofs - 0.5 * (made.bending + made.fair.dofs)).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(middle.max_residual < 1e-10 * made.model.size());
  CHECK(middle.functional > made.fair.functional);
  CHECK(middle.functional < made.fair.start_functional);
  MinimumVariationOptions little;
  little.largest_move = 0.1 * made.fair.max_move;
  const MinimumVariationSurface near = fair_shape(made.model, made.bending, rows, little);
  CHECK(near.max_move == Approx(little.largest_move));
  CHECK(near.fraction == Approx(0.1));
  half.strength = 0;
  CHECK_THROWS_AS(fair_shape(made.model, made.bending, rows, half), InputError);
}
