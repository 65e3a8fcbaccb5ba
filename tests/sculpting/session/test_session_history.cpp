// SPDX-License-Identifier: MPL-2.0
// Undo, redo, record and replay: bit for bit.
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten_test;

namespace {

RegionLayout region() { return patch_layout(0.3); }

// One operation of each type, each a step of the history.
std::vector<std::function<void(SculptingSession&)>> story() {
  const auto then = [](auto&& work) {
    return [work](SculptingSession& s) {
      work(s);
      s.solve_to_equilibrium();
    };
  };
  using S = SculptingSession;
  return {
      then([](S& s) {
        s.add(Load{"f", Load::Uniform{{0, 0, 1}, {}}});
      }),
      then([](S& s) { s.set("f", 3); }),
      then([](S& s) {
        s.add(Load{"p", Load::Pressure{}}, {slider("p", 4)});
      }),
      then([](S& s) {
        s.add(Constraint{"pin", Constraint::Point{{0.4, 0.6, 0.2}, {0.4, 0.6, 0.4}}});
      }),
      then([](S& s) { s.set("pin.z", 0.5); }),
      then([](S& s) {
        s.add(LineOffset{"raise", "rib", Vec3(0, 0, 1), 0.2}, {slider("raise", 0.05)});
      }),
      then([](S& s) { s.set("beta", 2); }),
      then([](S& s) {
        s.add(StiffnessField{"w", StiffnessField::Kind::Bending, {Area::NearLine{"rib", 0.4}}, {}},
              {slider("w", 5)});
      }),
      then([](S& s) { s.refine({Refinement::JumpIndicator{0.2}}); }),
      then([](S& s) { s.set("p", -2); }),
      then([](S& s) {
        s.change(Constraint{"pin", Constraint::Point{{0.5, 0.6, 0.2}, {0.5, 0.6, 0.3}}});
      }),
      then([](S& s) { s.remove("f"); }),
  };
}

struct Snapshot {
  Points dofs;
  std::vector<double> values;
  std::vector<std::string> names;
  int triangles;
  explicit Snapshot(const SculptingSession& s)
      : dofs(s.dofs()),
        values(s.parameters().values()),
        names(s.names()),
        triangles(s.layout().mesh()->triangle_count()) {}
  bool operator==(const Snapshot& other) const {
    return same_bits(dofs, other.dofs) && values == other.values && names == other.names &&
           triangles == other.triangles;
  }
};

}  // namespace

TEST_CASE("undo and redo go through a whole story bit for bit", "[sculpting][session]") {
  SculptingSession session(region(), with_material(0.1, 1));
  std::vector<Snapshot> stages{Snapshot(session)};
  for (const auto& work : story()) {
    work(session);
    CHECK(session.residual() < 1e-11);
    stages.emplace_back(session);
  }
  for (int round = 0; round < 2; ++round) {
    for (size_t k = stages.size() - 1; k-- > 0;) {
      REQUIRE(session.undo());
      const Snapshot now(session);
      INFO("stage " << k << ": off by " << difference(now.dofs, stages[k].dofs));
      CHECK(now.names == stages[k].names);
      CHECK(now.values == stages[k].values);
      CHECK(now == stages[k]);
    }
    CHECK_FALSE(session.undo());
    for (size_t k = 1; k < stages.size(); ++k) {
      REQUIRE(session.redo());
      INFO("stage " << k);
      // A shape that had not converged when it was undone is solved again.
      session.solve_to_equilibrium();
      CHECK(difference(session.dofs(), stages[k].dofs) < 1e-10);
      stages[k] = Snapshot(session);
    }
    CHECK_FALSE(session.redo());
    while (session.undo()) {
    }
    CHECK(Snapshot(session) == stages[0]);
    while (session.redo()) {
    }
    CHECK(session.names() == stages.back().names);
    CHECK(session.parameters().values() == stages.back().values);
  }
}

TEST_CASE("after undo the surface can be sculpted on as if nothing had been",
          "[sculpting][session]") {
  SculptingSession session(region(), {}), reference_session(region(), {});
  for (SculptingSession* s : {&session, &reference_session}) {
    s->add(Load{"f", Load::Uniform{{0, 0, 1}, {}}}, {slider("f", 1)});
    s->solve_to_equilibrium();
  }
  session.add(Constraint{"pin", Constraint::Point{{0.4, 0.6, 0.2}, {0.4, 0.6, 0.4}}});
  session.refine({Refinement::JumpIndicator{0.3}});
  REQUIRE(session.undo());
  REQUIRE(session.undo());
  for (SculptingSession* s : {&session, &reference_session}) {
    s->set("f", 2.5);
    s->solve_to_equilibrium();
    s->add(Constraint{"pin", Constraint::Point{{0.6, 0.6, 0.2}, {0.6, 0.6, 0.4}}});
  }
  CHECK(same_bits(session.dofs(), reference_session.dofs()));
  CHECK_FALSE(session.redo());
}

TEST_CASE("a drag of one parameter is undone as a whole, and so is a run of steps",
          "[sculpting][session]") {
  SculptingSession session(region(), {});
  session.add(Load{"f", Load::Uniform{{0, 0, 1}, {}}});
  session.solve_to_equilibrium();
  const Points rest = session.dofs();
  for (int n = 1; n <= 30; ++n) {
    session.set("f", 0.1 * n);
    session.solve_preview();
  }
  REQUIRE(session.undo());
  CHECK(same_bits(rest, session.dofs()));
  CHECK(session.parameters().value("f") == 0);
  REQUIRE(session.redo());
  CHECK(session.parameters().value("f") == Approx(3));
  session.solve_to_equilibrium();
  session.start_motion({.dt = 0.01});
  session.set("f", 0);
  const Points before = session.dofs();
  for (int n = 0; n < 20; ++n) session.step();
  CHECK(difference(before, session.dofs()) > 1e-5);
  REQUIRE(session.undo());
  CHECK(same_bits(before, session.dofs()));
}

TEST_CASE("a recorded session plays again bit for bit", "[sculpting][session]") {
  SculptingSession session(region(), with_material(0.1, 1));
  session.record(true);
  std::vector<Snapshot> stages;
  Random random(2);
  for (const auto& work : story()) {
    work(session);
    stages.emplace_back(session);
  }
  session.undo();
  session.undo();
  session.solve_to_equilibrium();
  session.set("pin.z", 0.45);
  for (int n = 0; n < 10; ++n) {
    session.set("p", 3 * random());
    session.solve_preview(2, 1e-4);
  }
  session.start_motion({.dt = 0.01});
  for (int n = 0; n < 10; ++n) session.step();
  session.stop_motion();
  // A failed operation in between is replayed, too.
  CHECK_THROWS_AS(session.add(Constraint{"bad", Constraint::Point{{9, 9, 9}, {0, 0, 0}}}),
                  InputError);
  session.set("p", 1);
  session.solve_to_equilibrium();
  SculptingSession again(region(), with_material(0.1, 1));
  again.replay(session.recorded());
  CHECK(Snapshot(session) == Snapshot(again));
  // From there both continue identically.
  session.set("p", -1);
  again.set("p", -1);
  session.solve_preview(3, 1e-9);
  again.solve_preview(3, 1e-9);
  CHECK(same_bits(session.dofs(), again.dofs()));
}

TEST_CASE("the history keeps to its bytes", "[sculpting][session]") {
  SessionOptions options;
  options.history_bytes = 2 << 20;
  SculptingSession session(patch_layout(0.15), options);
  session.add(Load{"f", Load::Uniform{{0, 0, 1}, {}}});
  session.add(Load{"g", Load::Uniform{{0, 1, 0}, {}}});
  size_t most = 0;
  for (int n = 0; n < 200; ++n) {
    session.set(n % 2 ? "f" : "g", n);
    session.solve_preview();
    most = std::max(most, session.history_bytes());
  }
  CHECK(most > (1 << 20));
  CHECK(most <= options.history_bytes + (1 << 20));  // one step more than the limit
  CHECK(session.undo());
}
