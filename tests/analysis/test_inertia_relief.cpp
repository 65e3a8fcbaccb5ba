// SPDX-License-Identifier: MPL-2.0
// Static response of free shells.
#include "batten/analysis/models/inertia_relief.h"
#include "batten/analysis/models/shell_results.h"
#include "batten/core/errors.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;

TEST_CASE("a free beam under a force bends as one under its inertia forces",
          "[analysis][inertia]") {
  Plates p;
  const double L = 6 * Plates::W, P = 1e-3;
  p.across("a", {0, 0, 0}, {0, 0, 0});
  p.across("middle", {L / 2, 0, 0}, {L / 2, 0, 0});
  p.across("b", {L, 0, 0}, {L, 0, 0});
  p.plate("a", "middle");
  p.plate("middle", "b");
  const ModelLayout layout = p.builder.model({});
  const Points shape = layout.all_dofs(p.builder.first);
  ShellDefinition definition{
      {{ShellMaterial::isotropic(Plates::E, 0, 0.3), Plates::t}}, {}, {}, {}};
  definition.inertia_relief = true;
  const ShellModel shell(layout, shape, definition);
  const InertiaRelief relief(layout, shape, shell.mass());
  const Points F = line_force(layout, shape, "middle", {0, 0, P / Plates::W});
  const Points balanced = relief.balanced(F);
  const Resultant sum = resultant(layout, shape, balanced);
  CHECK(sum.force.norm() < 1e-12 * P);
  CHECK(sum.moment.norm() < 1e-12 * P * L);
  CHECK((relief.balanced(balanced) - balanced).norm() < 1e-12 * F.norm());

  const auto result = evaluate_load_cases(shell, {{"push", balanced}})[0];
  CHECK(result.equilibrium_residual < 1e-8);
  const auto z = [&](double x) {
    const ShellLocation at = nearest_location(layout, shape, {x, Plates::W / 2, 0});
    return layout.surface(result.displacement).position(at.where).z();
  };
  // Each half is a cantilever under the uniform inertia forces P/L.
  const double exact = P * L * L * L / (128 * Plates::EI * Plates::W);
  CHECK(z(L / 2) - z(0) == Approx(exact).epsilon(1e-3));
  CHECK(z(0) == Approx(z(L)).epsilon(1e-6));
  // No rigid-body motion, and the same response to any rigid acceleration in addition.
  CHECK((relief.without_rigid_motion(result.displacement) - result.displacement).norm() <
        1e-9 * result.displacement.norm());

  definition.sections[0].material.density = 0;
  CHECK_THROWS_WITH(InertiaRelief(layout, shape, ShellModel(layout, shape, definition).mass()),
                    Contains("density"));
}
