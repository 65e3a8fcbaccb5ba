// SPDX-License-Identifier: MPL-2.0
// Supports along curves that meet at almost a right or straight angle.
#include <cmath>

#include "batten/analysis/models/shell_model.h"
#include "batten/analysis/models/shell_results.h"
#include "batten/core/errors.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;

namespace {

struct Maxima {
  double displacement, stress;
};

LineSupport held(const std::string& line, const std::vector<Vec3>& directions) {
  return {line, line, directions, Vec3::Zero(), false};
}

// A plate under pressure on two opposite supports. `symmetric`: the curves between them, which lie
// in planes of symmetry.
Maxima bent(const Plates& plates, const std::vector<std::string>& symmetric) {
  const ModelLayout layout = plates.builder.model({});
  const Points shape = layout.all_dofs(plates.builder.first);
  ShellDefinition definition{{{ShellMaterial::isotropic(Plates::E, 0.3), Plates::t}}, {}, {}, {}};
  definition.lines = {held("a", {Vec3::UnitX(), Vec3::UnitZ()}), held("b", {Vec3::UnitZ()})};
  for (const std::string& name : symmetric)
    definition.lines.push_back(LineSupport::symmetric(name, Vec3::UnitY()));
  const ShellModel shell(layout, shape, definition);
  const Points F =
      surface_traction(layout, shape, [](const Vec3&, const Vec3& n) -> Vec3 { return -n; });
  const auto result = evaluate_load_cases(shell, {{"pressure", F}})[0];
  CHECK(result.equilibrium_residual < 1e-8);
  return {result.max_displacement.value, result.max_stress.value};
}

// A rectangle whose corner b is off by an angle.
Maxima tilted(double angle) {
  Plates p;
  const double L = 2 * Plates::W, off = -L * angle;
  p.across("a", {0, 0, 0}, {0, 0, 0});
  p.across("b", {L, off, 0}, {L, 0, 0});
  p.plate("a", "b");
  return bent(p, {"ab 0", "ab W"});
}

// A rectangle with a side that is kinked by an angle.
Maxima kinked(double angle) {
  Plates p;
  const double L = 2 * Plates::W;
  const Vec3 kink(L / 4, -L / 4 * angle, 0);
  p.across("a", {0, 0, 0}, {0, 0, 0});
  p.across("b", {L, 0, 0}, {L, 0, 0});
  p.line("s1", {0, 0, 0}, kink);
  p.line("s2", kink, {L, 0, 0});
  p.line("n", {0, Plates::W, 0}, {L, Plates::W, 0});
  p.builder.region({"a", "n", "b", "s2", "s1"});
  return bent(p, {"s1", "s2", "n"});
}

}  // namespace

TEST_CASE("supports at almost right or straight angles give the result of the exact angle",
          "[analysis][vertex]") {
  for (const auto& plate : {tilted, kinked}) {
    const Maxima exact = plate(0);
    for (const double angle : {1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3})
      for (const double sign : {1.0, -1.0}) {
        const Maxima near = plate(sign * angle);
        INFO(sign * angle << ": " << near.displacement / exact.displacement << ", "
                          << near.stress / exact.stress);
        CHECK(near.displacement == Approx(exact.displacement).epsilon(1e-3 + 4 * angle));
        // The meshes differ as well.
        CHECK(near.stress == Approx(exact.stress).epsilon(5e-3 + 4 * angle));
      }
    // Beyond, the result changes gradually.
    Maxima before = exact;
    for (double angle = 1e-3; angle < 0.3; angle *= 1.3) {
      const Maxima next = plate(angle);
      INFO(angle);
      CHECK(next.displacement == Approx(before.displacement).epsilon(0.15));
      before = next;
    }
  }
}

TEST_CASE("prescribed displacements that contradict each other at a vertex are reported",
          "[analysis][vertex]") {
  Plates p;
  p.across("a", {0, 0, 0}, {0, 0, 0});
  p.across("b", {1, 0, 0}, {1, 0, 0});
  p.plate("a", "b");
  const ModelLayout layout = p.builder.model({});
  const Points shape = layout.all_dofs(p.builder.first);
  ShellDefinition definition{{{ShellMaterial::isotropic(Plates::E, 0.3), Plates::t}},
                             {LineSupport::clamped("a"), LineSupport::pinned("ab 0")},
                             {},
                             {}};
  definition.lines[1].displacement = {0, 0, 0.01};
  CHECK_THROWS_AS(ShellModel(layout, shape, definition), ConflictError);
}
