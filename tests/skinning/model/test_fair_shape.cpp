// Shapes that lines alone give: spheres, cylinders, cones and tori come back.
#include "batten/skinning/model/fair_shape.h"

#include <cmath>

#include "batten/benchmarks/analytic_shapes.h"
#include "batten/core/errors.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/tests/catch.h"

using namespace batten;

namespace {

double distance(const bench::AnalyticShape& shape, const Surface& surface) {
  double worst = 0;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    for (const Vec3& L : {Vec3(1, 1, 1), Vec3(2.8, 0.1, 0.1), Vec3(0.1, 1.5, 1.4)})
      worst = std::max(worst, shape.surface.closest(surface.position({t, L / 3})).distance);
  return worst;
}

struct Made {
  ModelLayout model;
  Points bending;
  VariationSurface fair;
  double before, after;  // distance to the formula, over the size
};
Made make(const bench::AnalyticShape& shape) {
  SkinOptions options;
  options.edge_length = shape.coarse;
  options.tolerance = 0.01 * std::pow(shape.coarse, 4);
  ModelLayout model(RegionLayout(shape.name, shape.boundary(), options));
  const Points bending = model.least_energy(SurfaceStiffness::isotropic(0, 1));
  VariationSurface fair = fair_shape(model, bending, model.line_constraints());
  const double before = distance(shape, model.surface(bending)) / model.size(),
               after = distance(shape, model.surface(fair.dofs)) / model.size();
  return {std::move(model), bending, std::move(fair), before, after};
}

bench::AnalyticShape shape_named(const std::string& name) {
  for (const bench::AnalyticShape& shape : bench::analytic_shapes())
    if (shape.name == name) return shape;
  throw InputError("no shape '" + name + "'");
}

}  // namespace

TEST_CASE("boundary lines alone give back cylinders, spheres, tori and rings") {
  struct Expected {
    std::string name;
    double least_before, most_after;  // over the size
  };
  for (const auto& [name, before, after] : {Expected{"cylinder 90", 1e-2, 3e-4},
                                            {"cylinder 200", 5e-3, 3e-4},
                                            {"sphere octant", 5e-2, 1e-4},
                                            {"torus quarter", 0.1, 5e-4},
                                            {"rings, equal", 5e-3, 2e-4},
                                            {"rings, unequal", 5e-3, 2e-4}}) {
    INFO(name);
    const Made made = make(shape_named(name));
    CHECK(made.before > before);
    CHECK(made.after < after);
    CHECK(made.fair.converged);
    CHECK(made.fair.factorizations <= 10);
    CHECK(made.fair.max_residual < 1e-10 * made.model.size());
    CHECK(made.fair.functional < 0.05 * made.fair.start_functional);
  }
}

TEST_CASE("a fair shape does not depend on unit or place") {
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
    const Points start = model.least_energy(SurfaceStiffness::isotropic(0, 1));
    const Points fair = fair_shape(model, start, model.line_constraints()).dofs;
    return Points((fair - model.position_dofs() * place.transpose()) / unit);
  };
  const Points same = dofs(1, Vec3::Zero()), other = dofs(1000, Vec3(5000, -3000, 200));
  REQUIRE(same.rows() == other.rows());
  CHECK((same - other).cwiseAbs().maxCoeff() < 1e-6);
}
