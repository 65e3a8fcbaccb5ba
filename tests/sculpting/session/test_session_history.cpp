// SPDX-License-Identifier: MPL-2.0
// Undo, redo, record and replay: bit for bit.
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/random_sculptor.h"
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

namespace {

SessionOptions limited(size_t bytes) {
  SessionOptions options;
  options.history_bytes = bytes;
  return options;
}

// A surface with the curve "rib", and where its edits act.
struct Stage {
  ModelLayout layout;
  Vec3 up;
  double size;               // model units: a length that an edit affects
  std::vector<Vec3> around;  // ends of a curve that can be added
};
Stage patch() {
  return {patch_layout(0.3), Vec3::UnitZ(), 0.1, {{0.25, 0.25, 0.2}, {0.4, 0.25, 0.2}}};
}
Stage door() {  // of examples/05-door
  return {door_layout(250), Vec3::UnitY(), 100, {{-150, 60, 20}, {0, 60, 32}}};
}

// A session with two loads, whose history begins here.
SculptingSession session_on(const Stage& stage, size_t history_bytes) {
  SculptingSession session(stage.layout, limited(history_bytes));
  session.add(Load{"push", Load::Uniform{stage.up, {}}});
  session.add(Load{"swell", Load::Pressure{}}, {slider("swell", 1)});
  session.solve_to_equilibrium();
  session.clear_history();
  return session;
}

Vec3 any_point(const SculptingSession& session, int i) {
  const Surface shape = shape_of(session);
  const int t = 37 * (i + 1) % shape.mesh().triangle_count();
  return shape.position({t, Vec3::Constant(1.0 / 3)});
}

using Edit = std::function<void(SculptingSession&, int)>;

// Adds an item in even calls, and removes it in odd ones.
template <class Add>
Edit by_turns(const std::string& name, const Add& add) {
  return [=](SculptingSession& s, int i) {
    if (i % 2)
      s.remove(name);
    else
      add(s, i);
    s.solve_to_equilibrium();
  };
}

Edit slide(const std::string& parameter, double start, double step) {
  return [=](SculptingSession& s, int i) {
    s.set(parameter, start + step * (i + 1));
    s.solve_to_equilibrium();
  };
}

void add_swage(const Stage& stage, SculptingSession& s) {
  const Surface shape = shape_of(s);
  std::vector<Vec3> points;
  for (int i = 0; i <= 6; ++i) {
    const Vec3 at = stage.around[0] + i / 6.0 * (stage.around[1] - stage.around[0]);
    points.push_back(shape.position(shape.closest_point(at).where));
  }
  s.add(CharacterLine{"swage", curve_through_points("swage", points), CharacterLine::Role::Inner});
}

std::vector<std::pair<std::string, Edit>> kinds_of_edits(const Stage& stage) {
  using S = SculptingSession;
  const auto add_load = [=](S& s, int) {
    s.add(Load{"l", Load::Gravity{stage.up}}, {slider("l", 1)});
  };
  const auto add_field = [=](S& s, int i) {
    const Area area{Area::NearLine{"rib", stage.size}};
    s.add(StiffnessField{"f", StiffnessField::Kind::Bending, area, {}},
          {slider("f", 1 + 0.01 * i)});
  };
  const auto add_constraint = [=](S& s, int i) {
    s.add(Constraint{"c", Constraint::Normal{any_point(s, i), stage.up}});
  };
  const auto add_offset = [=](S& s, int i) {
    s.add(LineOffset{"o", "rib", stage.up, 0.2}, {slider("o", 1e-4 * i * stage.size)});
  };
  const auto edit_rib = [=](S& s, int i) {
    const HermiteCurve old = s.layout().line("rib");
    Points dofs = old.dofs();
    dofs.row(old.mesh().slope_out(0)) += 1e-4 * (i + 1) * stage.size * stage.up.transpose();
    s.set_line("rib", HermiteCurve(old.mesh(), dofs));
  };
  const auto refine = [=](S& s, int i) {
    s.refine({Refinement::Brush{{{any_point(s, i), 0.1 * stage.size, 1}}}, 0.01 * stage.size});
  };
  return {{"linear load", slide("push", 0, 0.1)},
          {"pressure", slide("swell", 1, 0.01)},
          {"stiffness", slide("beta", 1, 0.01)},
          {"load", by_turns("l", add_load)},
          {"stiffness field", by_turns("f", add_field)},
          {"constraint", by_turns("c", add_constraint)},
          {"offset", by_turns("o", add_offset)},
          {"curve", edit_rib},
          {"inner curve", by_turns("swage", [=](S& s, int) { add_swage(stage, s); })},
          {"refinement", refine}};
}

constexpr size_t kMegabyte = size_t(1) << 20;

void check_undo_and_redo(SculptingSession& session, int steps) {
  const Snapshot end(session);
  int undone = 0;
  while (session.undo()) ++undone;
  CHECK(undone == steps);
  while (session.redo()) --undone;
  CHECK(undone == 0);
  CHECK(Snapshot(session) == end);
}

}  // namespace

TEST_CASE("200 edits of each kind are undone to the origin and redone, bit for bit",
          "[sculpting][session]") {
  constexpr size_t limit = 6 * kMegabyte, of_one_state = 3 * kMegabyte;
  const Stage stage = patch();
  for (const auto& [kind, edit] : kinds_of_edits(stage)) {
    INFO(kind);
    SculptingSession session = session_on(stage, limit);
    const Snapshot origin(session);
    const int edits = kind == "refinement" ? 40 : 200;
    const size_t before = bytes_in_use();
    size_t most = 0;
    for (int i = 0; i < edits; ++i) {
      edit(session, i);
      most = std::max(most, session.history_bytes());
    }
    CHECK(most <= limit + of_one_state);
    CHECK(bytes_in_use() <= before + 2 * limit + of_one_state);
    check_undo_and_redo(session, edits);
    while (session.undo()) {
    }
    CHECK(Snapshot(session) == origin);
  }
}

TEST_CASE("100 edits of all kinds on the door are undone and redone, bit for bit",
          "[sculpting][session]") {
  const Stage stage = door();
  SculptingSession session = session_on(stage, 24 * kMegabyte);
  const Snapshot origin(session);
  const auto kinds = kinds_of_edits(stage);
  const int count = isize(kinds);
  for (int i = 0; i < 100; ++i) kinds[i % count].second(session, i / count);
  CHECK(session.history_bytes() <= 32 * kMegabyte);
  check_undo_and_redo(session, 100);
  while (session.undo()) {
  }
  CHECK(Snapshot(session) == origin);
}

TEST_CASE("solves after an undo do not depend on what the history has dropped",
          "[sculpting][session]") {
  const Stage stage = patch();
  SculptingSession full = session_on(stage, 256 * kMegabyte), light = session_on(stage, 1);
  const auto kinds = kinds_of_edits(stage);
  // A limit of one byte keeps one step, without matrices and factors.
  for (const auto& [kind, edit] : kinds) {
    INFO(kind);
    for (SculptingSession* s : {&full, &light}) {
      edit(*s, 0);
      REQUIRE(s->undo());
      s->set("push", s->parameters().value("push") + 0.5);
      s->solve_to_equilibrium();
    }
    CHECK(same_bits(full.dofs(), light.dofs()));
    for (SculptingSession* s : {&full, &light}) {
      slide("beta", s->parameters().value("beta"), 0.5)(*s, 0);
      s->add(Constraint{"pin", Constraint::Point{any_point(*s, 3), any_point(*s, 3)}});
      REQUIRE(s->undo());
    }
    CHECK(full.residual() == light.residual());
    CHECK(full.total_energy() == light.total_energy());
    const auto forces = full.reactions(), others = light.reactions();
    REQUIRE(forces.size() == others.size());
    for (size_t i = 0; i < forces.size(); ++i) CHECK(forces[i].force == others[i].force);
  }
  CHECK(full.undo());
  CHECK(full.undo());
  CHECK_FALSE(light.undo());
  // A load beyond its limit gives back the last equilibrium, also the one of a restored state.
  const Points equilibrium = light.dofs();
  slide("push", 0, 1)(light, 0);
  REQUIRE(light.undo());
  light.set("swell", 1e9);
  CHECK_THROWS_AS(light.solve_to_equilibrium(), NoSolutionError);
  CHECK(same_bits(light.dofs(), equilibrium));
}

TEST_CASE("the history begins where it was cleared, and a limit of 0 keeps none",
          "[sculpting][session]") {
  SculptingSession session(region(), {}), without(region(), limited(0));
  for (SculptingSession* s : {&session, &without})
    s->add(Load{"f", Load::Uniform{{0, 0, 1}, {}}}, {slider("f", 1)});
  session.clear_history();
  CHECK_FALSE(session.undo());
  CHECK_FALSE(without.undo());
  const Snapshot origin(session);
  session.set("f", 2);
  session.clear_history();
  session.set("f", 3);  // a step of its own
  REQUIRE(session.undo());
  CHECK(session.parameters().value("f") == 2);
  session.clear_history();
  CHECK_FALSE(session.redo());
}
