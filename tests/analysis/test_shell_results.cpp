// SPDX-License-Identifier: MPL-2.0
// Load cases of a shell: maxima and error estimates, evaluation during changes of the shape,
// adaptive refinement, sensitivities.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "batten/analysis/models/shell_evaluator.h"
#include "batten/analysis/models/shell_refinement.h"
#include "batten/analysis/models/shell_sensitivities.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

// A strip of length L, clamped at one end: a beam, because Poisson's ratio is 0.
struct Strip {
  static constexpr double L = 1, force = 1e-4;  // force per length at the tip
  std::shared_ptr<const ModelLayout> layout;
  Points shape;

  static ModelLayout made(double h) {
    Plates plates;
    plates.h = plates.builder.options.edge_length = h;
    plates.across("foot", {0, 0, 0}, {0, 0, 0});
    plates.across("tip", {L, 0, 0}, {L, 0, 0});
    plates.plate("foot", "tip");
    return plates.builder.model({});
  }
  explicit Strip(double h)
      : layout(std::make_shared<const ModelLayout>(made(h))),
        shape(layout->minimize_energy(SurfaceStiffness::isotropic(0, 1))) {}

  // Self-weight, and a force at the tip; `definitions` counts calls of definition().
  static ShellProblem problem(int* definitions = nullptr) {
    return {[definitions](const ModelLayout&, const Points&) {
              if (definitions) ++*definitions;
              return ShellDefinition{{{ShellMaterial::isotropic(Plates::E, 0, 1.0), Plates::t}},
                                     {LineSupport::clamped("foot")},
                                     {},
                                     {}};
            },
            [](const ModelLayout& layout, const Points& shape, const ShellDefinition& definition) {
              const Points weight = gravity_load(
                  layout, shape, triangle_sections(layout, definition), {0, 0, -Plates::q});
              return std::vector<ShellLoadCase>{
                  {"weight", weight}, {"tip", line_force(layout, shape, "tip", {0, 0, -force})}};
            }};
  }
  ShellModel shell() const { return {*layout, shape, problem().definition(*layout, shape)}; }
  static double tip_deflection() { return force * std::pow(L, 3) / (3 * Plates::EI); }
};

}  // namespace

TEST_CASE("load cases of a cantilever have the maxima of a beam, where the beam has them",
          "[analysis][results]") {
  const Strip strip(0.125);
  const ShellModel shell = strip.shell();
  std::vector<ShellLoadCase> cases =
      Strip::problem().load_cases(*strip.layout, strip.shape, shell.definition());
  cases.push_back({"minus twice", -2 * cases[1].load});
  std::vector<std::string> visited;
  VecX indicators;
  const auto results = evaluate_load_cases(
      shell, cases,
      [&](const ShellCaseResult& result, const ShellStresses& stresses) {
        visited.push_back(result.name);
        CHECK(stresses.peak().value == result.max_stress.value);
      },
      &indicators);
  CHECK(visited == std::vector<std::string>{"weight", "tip", "minus twice"});
  REQUIRE(results.size() == 3);
  const ShellCaseResult &tip = results[1], &opposite = results[2];
  CHECK(tip.max_displacement.value == Approx(Strip::tip_deflection()).epsilon(1e-3));
  CHECK(tip.max_displacement.vector.z() == Approx(-tip.max_displacement.value));
  CHECK(tip.max_displacement.at.x() == Approx(Strip::L));
  CHECK(tip.max_stress.value ==
        Approx(6 * Strip::force * Strip::L / (Plates::t * Plates::t)).epsilon(1e-2));
  CHECK(std::abs(tip.max_stress.at.x()) < 1e-9);
  CHECK(std::abs(tip.max_stress_point.z()) == Approx(Plates::t / 2));
  CHECK(2 * tip.energy == Approx(cases[1].load.cwiseProduct(tip.displacement).sum()).epsilon(1e-9));
  CHECK(opposite.max_displacement.value == Approx(2 * tip.max_displacement.value));
  CHECK(opposite.max_displacement.vector.z() > 0);
  CHECK(opposite.energy == Approx(4 * tip.energy));
  CHECK(opposite.energy_norm_error == Approx(tip.energy_norm_error));
  for (const ShellCaseResult& result : results) {
    CHECK(result.equilibrium_residual < 1e-8);
    CHECK_FALSE(result.near_singularity);
    REQUIRE(result.reactions.size() == 1);
    CHECK(result.reactions[0].resultant.force.z() == Approx(-result.load.force.z()));
  }
  // Two errors per case, each with the sum 1.
  CHECK(indicators.minCoeff() >= 0);
  CHECK(indicators.sum() == Approx(6));
}

TEST_CASE("a maximum beside a point force or a point support is near a singularity",
          "[analysis][results]") {
  const Strip strip(0.125);
  const ShellModel shell = strip.shell();
  const Vec3 at(0.5, 0.25, 0);
  const ShellLocation knob = nearest_location(*strip.layout, strip.shape, at);
  const Points F = point_force(*strip.layout, knob, {0, 0, -1});
  const Points bent =
      Strip::problem().load_cases(*strip.layout, strip.shape, shell.definition())[1].load;
  const auto near = [](const ShellModel& supported, const ShellLoadCase& one) {
    return evaluate_load_cases(supported, {one})[0].near_singularity;
  };
  CHECK_FALSE(near(shell, {"far", bent, {at}}));
  CHECK(near(shell, {"at the foot", bent, {Vec3(0.1, 0.25, 0)}}));
  // Clamped all around, the plate has its largest stress at the force.
  ShellDefinition frame = shell.definition();
  for (const char* edge : {"tip", "foottip 0", "foottip W"})
    frame.lines.push_back(LineSupport::clamped(edge));
  CHECK(near(ShellModel(*strip.layout, strip.shape, frame), {"point", F, {at}}));
  frame.lines.resize(1);
  frame.points = {
      {"pin", nearest_location(*strip.layout, strip.shape, {0.05, 0.25, 0}), {Vec3::UnitZ()}}};
  CHECK(near(ShellModel(*strip.layout, strip.shape, frame), {"pin", bent, {}}));
}

TEST_CASE("ratios of thickness and edges follow the size of a shape, and are zero on a plane",
          "[analysis][results]") {
  const ModelLayout layout = octants(0.2).model({});
  const Points shape = layout.minimize_energy(SurfaceStiffness::isotropic(0, 1));
  const double t = 0.03;
  const ShellDefinition definition{
      {{ShellMaterial::isotropic(1, 0.3), t}}, {LineSupport::clamped("xy")}, {}, {}};
  const ThinShellRatios one = thin_shell_ratios(ShellModel(layout, shape, definition));
  CHECK(one.thickness_over_radius > 0.5 * t);
  const ThinShellRatios large = thin_shell_ratios(ShellModel(layout, 10 * shape, definition));
  CHECK(large.thickness_over_radius == Approx(one.thickness_over_radius / 10));
  CHECK(large.edge_over_boundary_layer == Approx(one.edge_over_boundary_layer * std::sqrt(10.0)));
  const ThinShellRatios flat = thin_shell_ratios(Strip(0.25).shell());
  CHECK(flat.thickness_over_radius < 1e-9);
}

TEST_CASE("an evaluator that follows a shape finds what a new one finds", "[analysis][results]") {
  const Strip strip(0.25);
  int definitions = 0;
  ShellEvaluator moving(Strip::problem(&definitions));
  CHECK_THROWS_WITH(moving.field({}), Contains("found no shape"));
  CHECK_THROWS_WITH(moving.mode_shapes({}, 1), Contains("found no shape"));
  std::vector<Location> vertices;
  for (int t = 0; t < strip.layout->mesh()->triangle_count(); ++t)
    for (int i = 0; i < 3; ++i) vertices.push_back({t, Vec3::Unit(i)});
  double before = 0;
  for (const double length : {1.0, 1.2, 1.5}) {
    Points shape = strip.shape;
    shape.col(0) *= length;
    const auto largest = moving.at(*strip.layout, shape);
    const auto anew = ShellEvaluator(Strip::problem()).at(*strip.layout, shape);
    CHECK(largest.displacement == Approx(anew.displacement).epsilon(1e-9));
    CHECK(largest.von_mises == Approx(anew.von_mises).epsilon(1e-9));
    CHECK(largest.displacement > before);
    before = largest.displacement;
    const ShellEvaluator::Field field = moving.field(vertices);
    CHECK(field.load_case == "tip");
    REQUIRE(field.von_mises.size() == vertices.size());
    REQUIRE(field.displacement.size() == 3 * vertices.size());
    CHECK(*std::max_element(field.von_mises.begin(), field.von_mises.end()) ==
          Approx(largest.von_mises).epsilon(1e-5));
  }
  CHECK(definitions == 3);
  // Shapes close to one another are solved with the factorization of the first one.
  for (int k = 1; k <= 20; ++k) {
    Points shape = strip.shape;
    shape.col(0) *= 1.5 + 0.005 * k;
    for (long m = 0; m < shape.rows(); ++m) shape(m, 2) += 0.002 * k * shape(m, 0);
    const auto largest = moving.at(*strip.layout, shape);
    ShellEvaluator anew(Strip::problem());
    const auto expected = anew.at(*strip.layout, shape);
    CHECK(largest.displacement == Approx(expected.displacement).epsilon(1e-7));
    CHECK(largest.von_mises == Approx(expected.von_mises).epsilon(1e-6));
    if (k % 10 != 0) continue;
    const auto modes = moving.mode_shapes(vertices, 2), other = anew.mode_shapes(vertices, 2);
    CHECK(modes.frequencies[1] == Approx(other.frequencies[1]).epsilon(1e-9));
    CHECK(moving.field(vertices).von_mises[0] ==
          Approx(anew.field(vertices).von_mises[0]).epsilon(1e-5));
  }
  CHECK(definitions == 23);
  const Strip finer(0.125);
  moving.at(*finer.layout, finer.shape);
  CHECK(definitions == 24);
  const ShellEvaluator::ModeShapes modes = moving.mode_shapes(vertices, 3);
  REQUIRE(modes.frequencies.size() == 3);
  CHECK(std::is_sorted(modes.frequencies.begin(), modes.frequencies.end()));
  const double beam = 1.875104 * 1.875104 / (2 * std::acos(-1.0) * Strip::L * Strip::L) *
                      std::sqrt(Plates::EI / Plates::t);
  CHECK(modes.frequencies[0] == Approx(beam).epsilon(5e-3));
  ShellProblem none = Strip::problem();
  none.load_cases = [](const auto&, const auto&, const auto&) {
    return std::vector<ShellLoadCase>();
  };
  CHECK_THROWS_WITH(ShellEvaluator(none).at(*strip.layout, strip.shape),
                    Contains("found no load case"));
}

TEST_CASE("refinement stops at the accuracy, on the same surface, and errors fall until then",
          "[analysis][results]") {
  const Strip strip(0.25);
  ShellRefinementOptions options;
  options.accuracy = 0.5;
  const RefinedShell first = refine_shell(strip.layout, strip.shape, Strip::problem(), options);
  CHECK(first.converged);
  REQUIRE(first.meshes.size() == 1);
  CHECK(first.layout == strip.layout);
  CHECK(first.shape == strip.shape);

  options.accuracy = 0.1 * first.meshes[0].error;
  const RefinedShell finer = refine_shell(strip.layout, strip.shape, Strip::problem(), options);
  CHECK(finer.converged);
  REQUIRE(finer.meshes.size() > 1);
  CHECK(finer.meshes[0].error == first.meshes[0].error);
  CHECK(finer.meshes.back().error <= options.accuracy);
  CHECK(finer.meshes.back().error < finer.meshes[0].error);
  CHECK(finer.meshes.back().edge_length < finer.meshes[0].edge_length);
  CHECK(finer.meshes.back().unknowns > finer.meshes[0].unknowns);
  const double tip = Strip::tip_deflection();
  CHECK(std::abs(finer.meshes.back().displacement - tip) <=
        std::abs(finer.meshes[0].displacement - tip) + 1e-9 * tip);
  // The plane remains planar.
  CHECK(finer.shape.rows() == DofMap(*finer.layout->mesh()).count());
  CHECK(finer.shape.col(2).cwiseAbs().maxCoeff() < 1e-12);

  options.accuracy = 1e-12;
  options.max_meshes = 3;
  const RefinedShell cut = refine_shell(strip.layout, strip.shape, Strip::problem(), options);
  CHECK_FALSE(cut.converged);
  CHECK(cut.meshes.size() == 3);
  for (const auto& change : {+[](ShellRefinementOptions& o) { o.accuracy = 0; },
                             +[](ShellRefinementOptions& o) { o.max_meshes = 0; },
                             +[](ShellRefinementOptions& o) { o.bulk_fraction = 1.5; }}) {
    ShellRefinementOptions bad;
    change(bad);
    CHECK_THROWS_WITH(refine_shell(strip.layout, strip.shape, Strip::problem(), bad),
                      Contains("expected"));
  }
}

TEST_CASE("refinement stops before a mesh that does not fit into memory, but not at other errors",
          "[analysis][results]") {
  const Strip strip(0.25);
  ShellRefinementOptions options;
  options.accuracy = 1e-12;
  const ShellProblem problem = Strip::problem();
  int meshes = 0;
  const auto failing_on_mesh = [&](int number, const auto& fail) {
    meshes = 0;
    ShellProblem failing = problem;
    failing.load_cases = [&, number, fail](const ModelLayout& layout, const Points& shape,
                                           const ShellDefinition& definition) {
      if (++meshes == number) fail();
      return problem.load_cases(layout, shape, definition);
    };
    return failing;
  };
  const auto too_large = [] { require_memory(1e300, "this mesh"); };
  const RefinedShell cut =
      refine_shell(strip.layout, strip.shape, failing_on_mesh(3, too_large), options);
  CHECK_FALSE(cut.converged);
  CHECK(cut.meshes.size() == 2);
  CHECK(meshes == 3);
  CHECK_THROWS_AS(refine_shell(strip.layout, strip.shape, failing_on_mesh(1, too_large), options),
                  MemoryError);
  const auto wrong = [] { throw InputError("found a load outside of the face"); };
  CHECK_THROWS_WITH(refine_shell(strip.layout, strip.shape, failing_on_mesh(3, wrong), options),
                    "found a load outside of the face");
}

TEST_CASE("a longer cantilever deflects with the third power of its length",
          "[analysis][results]") {
  const Strip strip(0.125);
  using Goals = std::vector<ShellSensitivities::Goal>;
  const Vec3 end(Strip::L, 0.25, 0);
  const ShellSensitivities sensitivities(
      *strip.layout, strip.shape, Strip::problem(),
      Goals{{"tip", end, {0, 0, -2}}, {"weight", end, {0, 0, -1}}});
  Points rate = Points::Zero(strip.shape.rows(), 3);
  rate.col(0) = strip.shape.col(0);
  const auto derivatives = sensitivities.along(rate);
  REQUIRE(derivatives.size() == 2);
  const double w = Strip::tip_deflection(), F = Strip::force * Plates::W;
  CHECK(derivatives[0].displacement == Approx(3 * w).epsilon(2e-3));
  CHECK(derivatives[0].compliance == Approx(3 * F * w).epsilon(2e-3));
  // Under self-weight, the deflection is proportional to the fourth power, and the work to the
  // fifth.
  const double p = Plates::t * Plates::q, L = Strip::L;
  CHECK(derivatives[1].displacement ==
        Approx(4 * p * std::pow(L, 4) / (8 * Plates::EI)).epsilon(2e-3));
  CHECK(derivatives[1].compliance ==
        Approx(5 * p * p * Plates::W * std::pow(L, 5) / (20 * Plates::EI)).epsilon(2e-3));
  for (const auto& still : sensitivities.along(Points::Zero(strip.shape.rows(), 3))) {
    CHECK(still.displacement == 0);
    CHECK(still.compliance == 0);
  }
  CHECK_THROWS_WITH(sensitivities.along(Points::Zero(3, 3)), Contains("3 dofs"));
  const auto refused = [&](const Goals& goals) {
    return ShellSensitivities(*strip.layout, strip.shape, Strip::problem(), goals);
  };
  CHECK_THROWS_WITH(refused({{"tipp", end, {0, 0, 1}}}), Contains("did you mean 'tip'"));
  CHECK_THROWS_WITH(refused({{"tip", end, {0, 0, 0}}}), Contains("length 0"));
}
