// SPDX-License-Identifier: MPL-2.0
// Operation counts of a session: a drag is one solve.
#include "batten/core/op_counter.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten;
using namespace batten_test;

namespace {

/// Only solves.
void check_solves_only(const ScopedOpCount& work, int solves) {
  INFO(work.text());
  CHECK(work.of(OpCounter::Solve) == solves);
  CHECK(work.of(OpCounter::Analysis) == 0);
  CHECK(work.of(OpCounter::Factorization) == 0);
  CHECK(work.of(OpCounter::AssembledElement) == 0);
  CHECK(work.of(OpCounter::Triangulation) == 0);
  CHECK(work.of(OpCounter::HoleTriangulation) == 0);
}

}  // namespace

TEST_CASE("the first update of a session: one assembly, one analysis, one factorization",
          "[work][sculpting]") {
  const RegionLayout layout = patch_layout(0.2);
  const ScopedOpCount work;
  SculptingSession session(layout, {});
  session.frame();
  INFO(work.text());
  CHECK(work.of(OpCounter::Analysis) == 1);
  CHECK(work.of(OpCounter::Factorization) == 1);
  CHECK(work.of(OpCounter::AssembledElement) == layout.mesh()->triangle_count());
  CHECK(work.of(OpCounter::Solve) == 1);
  CHECK(work.of(OpCounter::Triangulation) == 0);
}

TEST_CASE("a drag of a point is one solve per update, and no allocation", "[work][sculpting]") {
  SculptingSession session(patch_layout(0.2), {});
  session.add(Constraint{"pin", Constraint::Point{{0.5, 0.7, 0.2}, {0.5, 0.7, 0.3}}});
  const int pin = session.parameters().index("pin.z");
  for (const double z : {0.31, 0.32, 0.33}) {
    session.set(pin, z);
    session.solve_preview();
    session.frame();
  }
  const ScopedOpCount work;
  constexpr int answers = 10;
  for (int n = 0; n < answers; ++n) {
    session.set(pin, 0.3 + 0.01 * n);
    session.solve_preview();
    session.frame();
  }
  const std::int64_t allocations = work.of(OpCounter::Allocation);
  check_solves_only(work, answers);
  if (counts_allocations()) CHECK(allocations == 0);
}

TEST_CASE("sliders of linear loads need no solve but their first", "[work][sculpting]") {
  SculptingSession session(patch_layout(0.2), {});
  session.add(Load{"push", Load::Uniform{{0, 0, 1}, {}}});
  session.add(Load{"lean", Load::Uniform{{1, 0, 0}, {}}});
  const int push = session.parameters().index("push"), lean = session.parameters().index("lean");
  // The response to a slider is computed at its first change.
  for (const int slider : {push, lean, push, lean}) {
    session.set(slider, session.parameters().value(slider) + 1);
    session.solve_preview();
  }
  const ScopedOpCount work;
  for (int n = 0; n < 10; ++n) {
    session.set(n % 2 ? push : lean, 0.1 * n);
    session.solve_preview();
  }
  check_solves_only(work, 0);
}

TEST_CASE("a slider of the material is a factorization, without analysis", "[work][sculpting]") {
  SculptingSession session(patch_layout(0.2), {});
  const int beta = session.parameters().index("beta");
  session.set(beta, 2);
  session.solve_preview();
  const ScopedOpCount work;
  session.set(beta, 3);
  session.solve_preview();
  INFO(work.text());
  CHECK(work.of(OpCounter::Factorization) == 1);
  CHECK(work.of(OpCounter::Analysis) == 0);
}

TEST_CASE("a constraint that comes is one solve, one that goes none, the factor stays",
          "[work][sculpting]") {
  SculptingSession session(patch_layout(0.2), {});
  session.add(Constraint{"first", Constraint::Point{{0.5, 0.7, 0.2}, {0.5, 0.7, 0.3}}});
  session.solve_to_equilibrium();
  const ScopedOpCount coming;
  session.add(Constraint{"second", Constraint::Point{{0.2, 0.3, 0.1}, {0.2, 0.3, 0.2}}});
  INFO(coming.text());
  CHECK(coming.of(OpCounter::Factorization) == 0);
  CHECK(coming.of(OpCounter::Analysis) == 0);
  const ScopedOpCount going;
  session.remove("second");
  INFO(going.text());
  CHECK(going.of(OpCounter::Factorization) == 0);
  CHECK(going.of(OpCounter::Analysis) == 0);
}

TEST_CASE("undo factors nothing", "[work][sculpting]") {
  SculptingSession session(patch_layout(0.2), {});
  const int beta = session.parameters().index("beta");
  session.set(beta, 2);
  session.solve_to_equilibrium();
  session.add(Constraint{"pin", Constraint::Point{{0.5, 0.7, 0.2}, {0.5, 0.7, 0.3}}});
  session.solve_to_equilibrium();
  const ScopedOpCount work;
  REQUIRE(session.undo());
  INFO(work.text());
  CHECK(work.of(OpCounter::Factorization) == 0);
  CHECK(work.of(OpCounter::Analysis) == 0);
}
