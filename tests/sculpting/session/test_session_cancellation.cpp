// SPDX-License-Identifier: MPL-2.0
// Sessions that are cancelled at any poll: they throw, and keep a valid state.
#include <functional>

#include "batten/core/cancellation.h"
#include "batten/core/parallel.h"
#include "batten/tests/support/random_sculptor.h"

using namespace batten_test;

namespace {

/// A Progress that counts its polls, and cancels from a given poll on.
struct PollCounter {
  long polls = 0, cancelled_from = 1L << 40;
  Progress progress() {
    return {[](std::string_view, double) {}, [this] { return ++polls >= cancelled_from; }};
  }
};

long polls_of_construction(const ModelLayout& layout) {
  PollCounter counter;
  SculptingSession session(layout, small_history(), counter.progress());
  return counter.polls;
}

}  // namespace

TEST_CASE("a session that is cancelled while it is made throws at once",
          "[sculpting][session][cancellation]") {
  const ModelLayout layout(patch_layout(0.2));
  const Points shape = SculptingSession(layout, small_history()).dofs();
  // The number of polls depends on time while a library call is waited for.
  int cancelled = 0;
  for (long at = 1;; at += 1 + at / 4) {
    PollCounter counter;
    counter.cancelled_from = at;
    try {
      const SculptingSession session(layout, small_history(), counter.progress());
      CHECK(counter.polls < at);
      break;
    } catch (const CancelledError&) {
      CHECK(counter.polls <= at + 1);
      ++cancelled;
    }
  }
  CHECK(cancelled > 5);
  PollCounter counter;
  CHECK(same_bits(SculptingSession(layout, small_history(), counter.progress()).dofs(), shape));
}

TEST_CASE("a larger model is polled more often", "[sculpting][session][cancellation]") {
  const ModelLayout coarse(patch_layout(0.2)), fine(patch_layout(0.025));
  CHECK(fine.mesh()->triangle_count() > 30 * coarse.mesh()->triangle_count());
  CHECK(polls_of_construction(fine) > 3 * polls_of_construction(coarse));
}

TEST_CASE("a session that is cancelled during a solve keeps its shape and continues",
          "[sculpting][session][cancellation]") {
  const ModelLayout layout(patch_layout(0.2));
  PollCounter counter;
  SculptingSession session(layout, small_history(), counter.progress());
  SculptingSession twin(layout, small_history());
  const auto prepare = [](SculptingSession& one) {
    one.add(Load{"swell", Load::Pressure{}});
    one.solve_to_equilibrium();
    one.set("swell", 2);
  };
  prepare(session);
  prepare(twin);
  const Points before = session.dofs();
  const std::vector<std::function<void(SculptingSession&)>> calls = {
      [](SculptingSession& one) { one.solve_to_equilibrium(); },
      [](SculptingSession& one) { one.solve_preview(3, 1e-6); },
      [](SculptingSession& one) {
        one.add(Constraint{"pin", Constraint::Point{Vec3(0.5, 0.5, 0), Vec3(0.5, 0.5, 0.1)}});
      },
      [](SculptingSession& one) {
        one.refine({.where = Refinement::JumpIndicator{}, .max_triangles = 4000});
      }};
  for (const auto& call : calls) {
    const std::vector<std::string> names = session.names();
    int cancelled = 0;
    for (long at = 1; at < 4000; at += 1 + at / 3) {
      counter.cancelled_from = 1L << 40;
      SculptingSession one(*session.snapshot(), counter.progress());
      counter.polls = 0;
      counter.cancelled_from = at;
      try {
        call(one);
        break;
      } catch (const CancelledError&) {
        ++cancelled;
        counter.cancelled_from = 1L << 40;
        CHECK(one.names() == names);
        CHECK(same_bits(one.dofs(), before));
        CHECK(one.parameters().value("swell") == 2);
        one.solve_to_equilibrium();
        CHECK(one.residual() < 1e-9);
      }
    }
    CHECK(cancelled > 0);
  }
  counter.cancelled_from = 1L << 40;
  session.solve_to_equilibrium();
  twin.solve_to_equilibrium();
  CHECK(same_bits(session.dofs(), twin.dofs()));
}

TEST_CASE("parallel loops end with the cancellation", "[core][cancellation]") {
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    PollCounter counter;
    counter.cancelled_from = 5;
    std::atomic<int> done{0};
    const auto loop = [&] {
      const Progress progress = counter.progress();
      const ProgressScope scope(progress);
      parallel_for(1000, [&](int) {
        ++done;
        throw_if_cancelled();
      });
    };
    CHECK_THROWS_AS(loop(), CancelledError);
    CHECK(done < 1000);
  }
  set_thread_count(0);
}
