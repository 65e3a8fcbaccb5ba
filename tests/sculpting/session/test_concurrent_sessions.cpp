// SPDX-License-Identifier: MPL-2.0
// Sessions inside other programs: several at a time, and many in succession.
#include <thread>

#include "batten/tests/support/random_sculptor.h"

using namespace batten_test;

namespace {

// A patch with a pressure, a fixed point, refinement and undo: typical operations of a user.
Points sculpted(double force) {
  SculptingSession session(ModelLayout(patch_layout(0.25)), small_history());
  session.add(Load{"swell", Load::Pressure{}});
  for (int n = 1; n <= 10; ++n) {
    session.set("swell", 0.1 * n * force);
    session.solve_preview(3, 1e-6);
  }
  const Surface shape = shape_of(session);
  const Vec3 at = shape.position({0, Vec3::Constant(1.0 / 3)});
  session.add(Constraint{"pin", Constraint::Point{at, at + 0.05 * Vec3::UnitZ()}});
  session.solve_to_equilibrium();
  session.undo();
  session.redo();
  session.solve_to_equilibrium();
  return session.dofs();
}

}  // namespace

TEST_CASE("sessions in threads of their own have the bits that each has alone",
          "[sculpting][session]") {
  constexpr int threads = 4;
  std::vector<Points> alone;
  for (int k = 0; k < threads; ++k) alone.push_back(sculpted(1 + k));
  CHECK_FALSE(same_bits(alone[0], alone[1]));
  for (int round = 0; round < 5; ++round) {
    std::vector<Points> beside(threads);
    std::vector<std::thread> all;
    for (int k = 0; k < threads; ++k) all.emplace_back([&, k] { beside[k] = sculpted(1 + k); });
    for (std::thread& thread : all) thread.join();
    for (int k = 0; k < threads; ++k) CHECK(same_bits(beside[k], alone[k]));
  }
}

TEST_CASE("ten thousand sessions that were made and dropped leave no memory behind",
          "[sculpting][session]") {
  size_t early = 0;
  for (int n = 0; n < 10000; ++n) {
    SculptingSession session(ModelLayout(square_layout(0.5)), small_history());
    session.add(Load{"swell", Load::Pressure{}});
    session.set("swell", 1);
    session.solve_preview(1, 1e-6);
    if (n == 1000) early = bytes_in_use();
  }
  // Less than a byte per session.
  CHECK(static_cast<double>(bytes_in_use()) <= static_cast<double>(early) + 8192);
}
