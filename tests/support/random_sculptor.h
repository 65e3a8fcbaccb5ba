// SPDX-License-Identifier: MPL-2.0
// Random operations on one session: constraints hold, undo and replay give the same bits, memory
// stays bounded.
#pragma once

#include <cstdio>
#include <functional>
#include <map>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/model/model_projector.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"

namespace batten_test {

inline SessionOptions small_history() {
  SessionOptions options;
  options.history_bytes = size_t(48) << 20;
  return options;
}

// Allocated bytes of the program; 0 if they are not counted.
inline size_t bytes_in_use() {
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
#else
  return 0;
#endif
}

/// The model and the operations to perform on it.
struct SculptorStage {
  std::function<ModelLayout()> layout;
  Vec3 up = Vec3::UnitZ();
  double step = 1;                          ///< model units: a small displacement
  Vec3 finger;                              ///< point of action of a point load
  Area stiff;                               ///< area of a stiffness field
  Area pressed = {};                        ///< of the pressure
  double swell = 20, push = 20, force = 5;  ///< ranges of the loads
  std::vector<std::string> whole, fading;   ///< curves that move as a whole, and with a fade
  std::string edited;                       ///< a curve whose shape is edited; "": none
  /// An inner curve on a shape of the model; null: none.
  std::function<std::vector<Vec3>(const SculptingSession&, Random&)> inner;
  double smallest = 15;  ///< edge of refinements
  /// Invariants after every update.
  std::function<void(const SculptingSession&)> invariants = {};
};

class Sculptor {
 public:
  Sculptor(const SculptorStage& stage, unsigned seed)
      : stage_(stage), random_(seed), session_(stage.layout(), small_history()) {
    session_.record(true);
    session_.add(Load{"swell", Load::Pressure{stage.pressed}});
    session_.add(Load{"push", Load::Uniform{stage.up, {}}});
    session_.add(Load{"finger", Load::Point{stage.finger, stage.up}});
    session_.add(StiffnessField{"stiff", StiffnessField::Kind::Bending, stage.stiff, {}});
    session_.solve_to_equilibrium();
    normal_size_ =
        (session_.dofs() - Points::Zero(session_.dofs().rows(), 3)).cwiseAbs().maxCoeff();
  }

  SculptingSession& session() { return session_; }
  const std::map<std::string, int>& done() const { return done_; }
  const std::map<std::string, int>& refused() const { return refused_; }
  double worst_residual() const { return worst_; }
  int undo_mismatches() const { return undo_mismatches_; }
  bool finite() const { return finite_; }
  int max_triangles() const { return most_triangles_; }

  void operate() {
    const std::string what = draw();
    try {
      perform(what);
      ++done_[what];
    } catch (const Error& e) {
      ++refused_[what];
      last_error_ = e.what();
    }
    worst_ = std::max(worst_, session_.residual());
    const Points x = session_.dofs();
    finite_ = finite_ && x.allFinite() && x.cwiseAbs().maxCoeff() < 100 * normal_size_;
    most_triangles_ = std::max(most_triangles_, session_.layout().mesh()->triangle_count());
    if (stage_.invariants) stage_.invariants(session_);
  }
  const std::string& last_error() const { return last_error_; }

 private:
  std::string draw() {
    static const std::vector<std::pair<std::string, double>> kinds = {
        {"load", 30},  {"weight", 3},   {"goal", 12},    {"move", 10},  {"add point", 5},
        {"normal", 3}, {"remove", 6},   {"add move", 3}, {"line", 4},   {"inner line", 2},
        {"refine", 2}, {"undo", 10},    {"redo", 4},     {"motion", 3}, {"springs", 2},
        {"settle", 4}, {"undo bits", 4}};
    double sum = 0;
    for (const auto& [name, weight] : kinds) sum += weight;
    double at = random_.between(0, sum);
    for (const auto& [name, weight] : kinds)
      if ((at -= weight) < 0) return name;
    return "load";
  }
  std::vector<std::string> of(const std::string& beginning) {
    std::vector<std::string> some;
    for (const std::string& name : session_.names())
      if (name.rfind(beginning, 0) == 0) some.push_back(name);
    return some;
  }
  template <class List>
  const auto& one_of(const List& list) {
    return list[static_cast<size_t>(random_.between(0, 0.9999) * static_cast<double>(list.size()))];
  }
  // On the current surface, inside the trim.
  Vec3 random_location() {
    const Surface shape = shape_of(session_);
    for (;;) {
      const Location where{
          static_cast<int>(random_.between(0, 0.9999) * shape.mesh().triangle_count()),
          Vec3::Constant(1.0 / 3)};
      if (!shape.trim() || shape.trim()->area_fraction(where.triangle) > 0.99)
        return shape.position(where);
    }
  }
  Vec3 normal_at(const Vec3& at) {
    const ModelProjector projector(session_.layout(), session_.dofs());
    const auto near = projector.nearest_inside(at);
    return projector.surface(near.at.region).jet(near.where).normal();
  }
  std::string unique_name(const std::string& beginning) {
    return beginning + std::to_string(count_++);
  }
  // Undo may have restored a motion.
  void solve_preview() {
    try {
      session_.solve_preview(3, 1e-6);
    } catch (const InputError&) {
      session_.stop_motion();
      session_.solve_preview(3, 1e-6);
    }
  }

  void perform(const std::string& what) {
    if (what == "load") {
      const std::vector<std::pair<std::string, double>> loads = {
          {"swell", stage_.swell}, {"push", stage_.push}, {"finger", stage_.force}};
      const auto& [name, range] = one_of(loads);
      for (int n = 0; n < 3; ++n) {
        session_.set(name, range * random_());
        solve_preview();
      }
    } else if (what == "weight") {
      session_.set("stiff", 20 * random_.between(0, 1));
      solve_preview();
    } else if (what == "goal") {
      const auto pins = of("pin");
      if (pins.empty()) return;
      const std::string axis = one_of(pins) + (stage_.up.y() == 1 ? ".y" : ".z");
      for (int n = 0; n < 3; ++n) {
        session_.set(axis, session_.parameters().value(axis) + stage_.step * random_());
        solve_preview();
      }
    } else if (what == "move") {
      const auto moves = of("raise");
      if (moves.empty()) return;
      session_.set(one_of(moves), 3 * stage_.step * random_());
      solve_preview();
    } else if (what == "add point") {
      if (of("pin").size() >= 6) return;
      const Vec3 at = random_location();
      session_.add(Constraint{unique_name("pin"),
                              Constraint::Point{at, at + stage_.step * random_() * stage_.up}});
    } else if (what == "normal") {
      if (of("lean").size() >= 3) return;
      const Vec3 at = random_location();
      const Vec3 tilt(0.1 * random_(), 0, 0.1 * random_());
      session_.add(Constraint{unique_name("lean"), Constraint::Normal{at, normal_at(at) + tilt}});
    } else if (what == "remove") {
      std::vector<std::string> all;
      for (const char* kind : {"pin", "lean", "raise", "bulge", "swage"})
        for (auto& name : of(kind)) all.push_back(name);
      if (!all.empty()) session_.remove(one_of(all));
    } else if (what == "add move") {
      if (of("raise").size() >= 3) return;
      const bool whole =
          !stage_.whole.empty() && random_.between(0, 1) * 3 < 1;  // otherwise a fading one
      const std::string& line = one_of(whole ? stage_.whole : stage_.fading);
      LineOffset move{unique_name("raise"), line, {}, whole ? 0 : 0.3};
      if (random_() > 0) move.direction = stage_.up;
      session_.add(move, {slider(move.name, stage_.step * random_())});
    } else if (what == "line") {
      if (stage_.edited.empty()) return;
      const HermiteCurve old = session_.layout().line(stage_.edited);
      Points dofs = old.dofs();
      const double height = 0.6 * stage_.step * random_();
      for (int i = 1; i + 1 < old.node_count(); ++i)
        dofs.row(old.mesh().position_dof(i)) +=
            height * std::sin(pi * i / (old.node_count() - 1)) * stage_.up.transpose();
      session_.set_line(stage_.edited, HermiteCurve(old.mesh(), dofs));
    } else if (what == "inner line") {
      if (!of("swage").empty()) return;
      if (!stage_.inner) return;
      const std::vector<Vec3> points = stage_.inner(session_, random_);
      const std::string name = unique_name("swage");
      session_.add(
          CharacterLine{name, curve_through_points(name, points), CharacterLine::Role::Inner});
    } else if (what == "refine") {
      Refinement refinement;
      if (random_() > 0)
        refinement.where = Refinement::Brush{{{random_location(), 4 * stage_.smallest, 1}}};
      else
        refinement.where = Refinement::JumpIndicator{0.05};
      refinement.smallest = stage_.smallest;
      refinement.max_triangles = kMostTriangles;
      session_.refine(refinement);
    } else if (what == "undo") {
      const int times = random_() > 0.8 ? 6 : 1;
      for (int n = 0; n < times; ++n) session_.undo();
    } else if (what == "redo") {
      session_.redo();
    } else if (what == "motion") {
      session_.start_motion({.dt = 0.02, .damping = 5, .theta = random_() > 0 ? 1.0 : 0.5});
      for (int n = 0; n < 3; ++n) session_.step();
      session_.stop_motion();
      solve_preview();
    } else if (what == "springs") {
      if (!of("bulge").empty()) return;
      Load::AttractorSprings springs;
      std::vector<Vec3> to;
      for (int n = 0; n < 4; ++n) {
        springs.at.push_back(random_location());
        to.push_back(springs.at.back() + 4 * stage_.step * stage_.up);
      }
      springs.target = Load::AttractorSprings::TargetPoints{to};
      const std::string name = unique_name("bulge");
      session_.add(Load{name, springs}, {slider(name, 2)});
      solve_preview();
    } else if (what == "settle") {
      session_.solve_to_equilibrium();
    } else {  // "undo bits"
      const Points before = session_.dofs();
      const auto values = session_.parameters().values();
      const Vec3 at = random_location();
      bool added = false;
      try {
        session_.add(Constraint{unique_name("pin"), Constraint::Point{at, at}});
        added = true;
      } catch (const ConflictError&) {
      }
      if (added) session_.undo();
      if (!same_bits(before, session_.dofs()) || values != session_.parameters().values())
        ++undo_mismatches_;
    }
  }

  static constexpr int kMostTriangles = 2000;
  const SculptorStage& stage_;
  Random random_;
  SculptingSession session_;
  std::map<std::string, int> done_, refused_;
  std::string last_error_;
  double worst_ = 0, normal_size_ = 0;
  int count_ = 0, undo_mismatches_ = 0, most_triangles_ = 0;
  bool finite_ = true;
};

/// Residual, bits after undo, memory, and replay.
inline void sculpt_at_random(const SculptorStage& stage, int operations, unsigned seed) {
  Sculptor sculptor(stage, seed);
  size_t bytes_early = 0, bytes_late = 0;
  for (int n = 1; n <= operations; ++n) {
    sculptor.operate();
    INFO("operation " << n << ": residual " << sculptor.worst_residual());
    REQUIRE(sculptor.worst_residual() <= 1e-10);
    REQUIRE(sculptor.finite());
    if (n == operations / 5) bytes_early = bytes_in_use();
    if (n == operations) bytes_late = bytes_in_use();
  }
  CHECK(sculptor.undo_mismatches() == 0);
  CHECK(sculptor.max_triangles() <= 2000);
  int done = 0, refused = 0;
  std::string table;
  for (const auto& [what, count] : sculptor.done()) {
    done += count;
    table += what + " " + std::to_string(count) + ", ";
  }
  table += "refused: ";
  for (const auto& [what, count] : sculptor.refused()) {
    refused += count;
    table += what + " " + std::to_string(count) + ", ";
  }
  INFO(table << sculptor.last_error());
  CHECK(refused < operations / 5);
  CHECK(sculptor.done().size() >= 15);
  if (operations >= 1000) {
    std::printf("%s\nresidual %.2e, bytes %zu then %zu, most triangles %d\n", table.c_str(),
                sculptor.worst_residual(), bytes_early, bytes_late, sculptor.max_triangles());
    // The history is full in both cases.
    CHECK(static_cast<double>(bytes_late) <= 1.2 * static_cast<double>(bytes_early) + (16 << 20));
  }
  SculptingSession again(stage.layout(), small_history());
  again.replay(sculptor.session().recorded());
  CHECK(same_bits(again.dofs(), sculptor.session().dofs()));
  CHECK(again.parameters().values() == sculptor.session().parameters().values());
  CHECK(again.names() == sculptor.session().names());
}

}  // namespace batten_test
