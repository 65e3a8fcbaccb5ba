// SPDX-License-Identifier: MPL-2.0
// Whole models in a session: the mouse of the examples, and real sketches.
#include <cstdio>

#include "batten/io/lines/drawing.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/mouse_model.h"
#include "batten/tests/support/random_sculptor.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;

namespace {

// Invariants of a model after every update.
class SessionInvariants {
 public:
  explicit SessionInvariants(const SurfaceModel& model) : model_(model) {
    for (const ModelJoin& join : model.joins)
      if (join.kind == ModelJoin::Kind::Smooth) rest_angles_[join.line] = join.max_inside_deg;
  }
  void operator()(const SculptingSession& session) {
    const auto made = session.regions();
    std::vector<const SkinnedRegion*> all;
    for (const auto& r : made) all.push_back(&r);
    for (const auto& [line, rest] : rest_angles_) {
      const JoinPlan* plan = session.layout().join_plan(line);
      REQUIRE(plan);
      const double angle =
          measure_join(all, plan->join_line, {plan->ends[0].open, plan->ends[1].open})
              .max_inside_deg;
      if (!(angle - rest <= max_angle_increase_)) {
        max_angle_increase_ = angle - rest;
        worst_line_ = line;
      }
      largest_ = std::max(largest_, angle);
    }
    max_deviation_ = std::max(max_deviation_, session.residual());
    // Both sides of a curve agree: deviation of the surfaces' edges from the curves.
    const Points& x = session.dofs();
    for (const ModelLine& line : session.layout().lines()) {
      const HermiteCurve curve = session.line(line.name);
      for (const LineSide& side : line.sides) {
        if (side.embedded) continue;
        const EdgeAlignedLine& aligned_line =
            made[static_cast<size_t>(side.region)].edge_aligned[static_cast<size_t>(side.index)];
        const DofOffsets& dof_offsets = session.layout().dof_offsets(side.region);
        for (size_t i = 0; i < aligned_line.vertices.size(); ++i) {
          const Vec3 at = x.row(dof_offsets(3 * aligned_line.vertices[i]));
          max_deviation_ =
              std::max(max_deviation_, (at - curve.evaluate(aligned_line.parameters[i])).norm() /
                                           session.layout().size());
        }
      }
    }
    ++updates_;
  }
  double max_angle_increase() const { return max_angle_increase_; }
  double largest() const { return largest_; }
  double max_deviation() const { return max_deviation_; }
  std::string text() const {
    return std::to_string(updates_) + " answers: joins at most " + format_number(largest_) +
           " degrees, worse than at rest by " + format_number(max_angle_increase_) + " ('" +
           worst_line_ + "'), off lines by " + format_number(max_deviation_) + " of the size";
  }

 private:
  const SurfaceModel& model_;
  std::map<std::string, double> rest_angles_;
  double max_angle_increase_ = -180, largest_ = 0, max_deviation_ = 0;
  std::string worst_line_;
  int updates_ = 0;
};

// The longest mesh-aligned or embedded curve that is not closed.
std::string longest(const SurfaceModel& model, ModelJoin::Kind kind) {
  std::string best;
  double most = 0;
  for (const ModelJoin& join : model.joins) {
    if (join.kind != kind || !model.layout->has_line(join.line)) continue;
    const ModelLine& line = model.layout->model_line(join.line);
    const HermiteCurve& curve = model.layout->line(join.line);
    const bool embedded =
        std::any_of(line.sides.begin(), line.sides.end(), [](const auto& s) { return s.embedded; });
    if (embedded || curve.closed() || line.sides.size() < 2 || !(curve.length() > most)) continue;
    most = curve.length();
    best = join.line;
  }
  return best;
}

// Pressure on one face and on all, shared curves that move, a fixed point, a stiffness field across
// a shared edge, motion.
void drag(const SurfaceModel& model, SessionInvariants& invariants) {
  const double size = model.layout->size();
  SculptingSession session(*model.layout, {});
  const std::string smooth = longest(model, ModelJoin::Kind::Smooth),
                    crease = longest(model, ModelJoin::Kind::Crease);
  REQUIRE_FALSE(smooth.empty());
  REQUIRE_FALSE(crease.empty());
  const ModelLine& join = session.layout().model_line(smooth);
  const int r = join.sides[0].region;
  const HermiteCurve line = session.line(smooth);
  const Vec3 middle = line.evaluate(0.5 * (line.start() + line.end()));
  session.add(
      Load{"one", Load::Pressure{Area{Area::Everywhere{}, {session.layout().region(r).name()}}}});
  session.add(Load{"all", Load::Pressure{}});
  session.add(StiffnessField{
      "stiff", StiffnessField::Kind::Bending, {Area::Painted{{{middle, 0.1 * size, 1}}}}, {}});
  session.add(LineOffset{"ridge", smooth, {}, 0.4});
  session.add(LineOffset{"edge", crease, Vec3::UnitZ(), 0.4});
  const Vec3 held =
      session.region(r).surface.position({session.region(r).surface.mesh().triangle_count() / 2});
  session.add(Constraint{"pin", Constraint::Point{held, held}});
  for (int i = 1; i <= 3; ++i) {
    session.set("one", 10 * i);
    session.solve_preview(2);
    invariants(session);
    session.set("ridge", 0.003 * i * size);
    session.solve_preview(2);
    invariants(session);
    session.set("edge", 0.003 * i * size);
    session.solve_preview(2);
    invariants(session);
    session.set("stiff", 3 * i);
    session.solve_preview(2);
    invariants(session);
    session.set("pin.z", held.z() + 0.002 * i * size);
    session.solve_preview(2);
    invariants(session);
    session.set("all", 5 * i);
    session.solve_preview(2);
    invariants(session);
  }
  session.solve_to_equilibrium();
  invariants(session);
  session.start_motion({.dt = 0.05, .damping = 2});
  session.set("all", -10);
  for (int i = 0; i < 6; ++i) {
    session.step();
    invariants(session);
  }
  session.stop_motion();
}

void check(const std::string& name, const SurfaceModel& model) {
  REQUIRE(model.layout);
  SessionInvariants invariants(model);
  drag(model, invariants);
  std::printf("%s: %s\n", name.c_str(), invariants.text().c_str());
  INFO(invariants.text());
  CHECK(invariants.max_angle_increase() <= 0.05);
  CHECK(invariants.max_deviation() <= 1e-10);
}

SculptorStage mouse_stage() {
  static const NetworkModel made = mouse(10);
  SculptorStage stage;
  stage.layout = [] { return *made.model.layout; };
  stage.step = 0.6;
  stage.finger = {0, 5, 38};
  stage.stiff = {Area::Painted{{{Vec3(0, 20, 36), 15, 1}}}};
  stage.fading = {"spine.2", "spine.3", "across.1", "wall left", "join_line.1"};
  stage.edited = "";
  stage.smallest = 2;
  stage.inner = [](const SculptingSession& session, Random& random) {
    const ModelProjector projector(session.layout(), session.dofs());
    const Vec3 from(8 + 2 * random(), 25 + 4 * random(), 34);
    std::vector<Vec3> points;
    for (int i = 0; i <= 6; ++i) {
      const auto near = projector.nearest_inside(from + Vec3(0.2 * i, 2 * i, 0));
      points.push_back(projector.surface(near.at.region).position(near.where));
    }
    return points;
  };
  return stage;
}

}  // namespace

TEST_CASE("the mouse is sculpted live, joins and curves hold at every update",
          "[io][sessions][mouse]") {
  check("mouse", mouse(4).model);
}

TEST_CASE("sketches are sculpted live, joins and curves hold at every update",
          "[io][sessions][data]") {
  const std::string name = GENERATE("computer-mouse", "vacuum");
  const auto file = optional_data("sketch-cassie/sketch_graph/" + name + ".json");
  if (file.empty()) {
    WARN("no sketches here");
    return;
  }
  const NetworkModel model = made(read_sketch_graph(file), {}, {}, {});
  check(name, model.model);
}

TEST_CASE("two hundred operations at random on the mouse", "[io][sessions][mouse]") {
  sculpt_at_random(mouse_stage(), 200, 3);
}

TEST_CASE("ten thousand operations at random on the mouse", "[io][sessions][mouse][.long]") {
  sculpt_at_random(mouse_stage(), 10000, 11);
}
