// SPDX-License-Identifier: MPL-2.0
// Latency of a slider in a sculpting session: from a new value to points and normals on the screen.
// A drag of a point constraint changes the right-hand side arbitrarily. For comparison, on the
// session's own matrix: the triangular solves for three columns, those of CHOLMOD, and the memory
// bound (16 bytes per entry of the factor, divided by the bandwidth of a triad, as in solve.cpp).
#include <cmath>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/reusable_factorization.h"
#include "batten/core/errors.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/model/model_projector.h"
#include "batten/tests/support/mouse_model.h"
#include "batten/tests/support/session_scenes.h"
#include "bench.h"
#include "cases.h"
#ifdef BATTEN_BENCH_CHOLMOD
#include "batten/tests/support/cholmod_solver.h"
#endif

namespace {

using namespace batten;
using namespace batten::bench;
using namespace batten_test;

// Bytes per second of a = b + s c in arrays far larger than any cache: the best of several passes.
double triad_bandwidth() {
  constexpr size_t n = 8 << 20;
  static std::vector<double> a(n, 1), b(n, 2), c(n, 3);
  double best = 1e300;
  for (int pass = 0; pass < 7; ++pass)
    best = std::min(best, cpu_seconds_of([&] {
                      for (size_t i = 0; i < n; ++i) a[i] = b[i] + 0.5 * c[i];
                    }));
  return a[n / 2] == 3.5 ? 24.0 * n / best : 0;
}

std::string milliseconds(double seconds) { return text("%.3g", 1e3 * seconds); }

// With a Delaunay mesh.
RegionLayout plate(double edge) { return {"plate", arched_plate(), skin(edge, 1e-4)}; }

// The factor of a session of this layout.
struct SessionFactor {
  std::shared_ptr<const AffineReduction> reduction;
  SparseMatrix K;
  std::unique_ptr<ReusableFactorization> system;
  explicit SessionFactor(const RegionLayout& layout)
      : reduction(std::make_shared<AffineReduction>(layout.line_constraints(),
                                                    AffineReduction::RhsMode::Deferred)),
        K(SurfaceAssembler(*layout.mesh(), layout.element(), layout.trim())
              .stiffness(SurfaceStiffness())),
        system(
            std::make_unique<ReusableFactorization>(reduction, K, dof_vertices(*layout.mesh()))) {}
};

// Static shape with one fixed point, by a reduction of all constraint equations together,
// independently of the session.
Points solve_from_scratch(const RegionLayout& layout, const Location& where, const Vec3& goal,
                          const SparseMatrix& K) {
  ConstraintSet set = layout.line_constraints();
  const auto dof = DofMap(*layout.mesh()).triangle(*layout.mesh(), where.triangle);
  const Vec12 N =
      C1Triangle(layout.element(), layout.mesh()->shape(where.triangle)).evaluate(where.L).col(kW);
  std::vector<ConstraintSet::Entry> entries;
  for (int a = 0; a < 12; ++a)
    if (N[a] != 0) entries.push_back({dof[static_cast<size_t>(a)], N[a]});
  set.add("point", entries, goal);
  return solve_constrained(set, K, Points::Zero(K.rows(), 3));
}

struct DragTimes {
  double answer = 0, frame = 0;  // medians, seconds
  double iterations = 0;         // mean per update
  double whole() const { return answer + frame; }
};

// `set` moves sliders for event n; each event is solved once and displayed.
DragTimes dragged(SculptingSession& session, int events, const std::function<void(int)>& set) {
  std::vector<double> answers, frames;
  DragTimes drag;
  for (int n = -3; n < events; ++n) {
    SolveReport answer;
    const double a = cpu_seconds_of([&] {
      set(n);
      answer = session.solve_preview();
    });
    const double f = cpu_seconds_of([&] { session.frame(); });
    if (n < 0) continue;
    answers.push_back(a);
    frames.push_back(f);
    drag.iterations += static_cast<double>(answer.iterations) / events;
  }
  drag.answer = median(answers);
  drag.frame = median(frames);
  return drag;
}

struct Tables {
  Table drag, sliders, first;
};

void measure(const std::string& name, double edge, Tables& tables, Checks& checks,
             double& bandwidth) {
  std::optional<RegionLayout> layout;
  const double layout_time = cpu_seconds_of([&] { layout.emplace(plate(edge)); });
  const double size = layout->size();
  std::optional<SculptingSession> session;
  const double session_time = cpu_seconds_of([&] {
    session.emplace(*layout, SessionOptions());
    session->frame();
  });
  const SessionFactor peer(*layout);
  const long n = static_cast<long>(peer.system->free_count()),
             entries = peer.system->factor().factor_entries();
  const int events = entries > 3000000 ? 11 : 41;

  // Point.
  const Surface rest(layout->mesh(), layout->element(), session->dofs(), layout->trim());
  const auto foot = rest.closest_point({0.43, 0.57, 0});
  const Vec3 at = rest.position(foot.where);
  const double added = cpu_seconds_of([&] {
    session->add(Constraint{"pin", Constraint::Point{at, at}});
    session->frame();
  });
  const int x = session->parameters().index("pin.x"), y = session->parameters().index("pin.y"),
            z = session->parameters().index("pin.z");
  const auto goal = [&](int k) {
    return Vec3(at + 0.02 * size * Vec3(std::sin(k), std::cos(k), k % 5));
  };
  const auto drag_point = [&](int k) {
    session->set(x, goal(k).x());
    session->set(y, goal(k).y());
    session->set(z, goal(k).z());
  };
  bandwidth = std::max(bandwidth, triad_bandwidth());
  MatX b = MatX::Random(n, 3), solution = b;
#ifdef BATTEN_BENCH_CHOLMOD
  const SparseMatrix reduced = peer.reduction->reduce(peer.K);
  CholmodSolver cholmod(reduced, peer.system->factor().order(), n < CholmodSolver::small);
  cholmod.analyze();
  cholmod.factorize();
#endif
  // They alternate, so that a slow phase of the machine affects all of them.
  std::vector<double> answers, frames, solves, theirs;
  for (int k = -2; k < events; ++k) {
    // A burst of each; the first solve precedes the timing, so that a factor that fits in a cache
    // is there, as in a drag.
    constexpr int burst = 4;
    SolveReport answer;
    double a = 0, f = 0;
    for (int i = burst; i >= 0; --i) {
      const double answered = cpu_seconds_of([&] {
        drag_point(k + 100 * i);
        answer = session->solve_preview();
      });
      const double shown = cpu_seconds_of([&] { session->frame(); });
      if (i == burst) continue;
      a += answered / burst;
      f += shown / burst;
    }
    if (answer.iterations != 1) std::printf("ERROR: %d iterations\n", answer.iterations);
    const int repeats = entries < 100000 ? 20 : burst;
    const auto warm = [&](const std::function<void()>& work) {
      work();
      return cpu_seconds_of([&] {
               for (int i = 0; i < repeats; ++i) work();
             }) /
             repeats;
    };
    const double s = warm([&] { peer.system->factor().solve_in_place(solution); });
    solution = b;
#ifdef BATTEN_BENCH_CHOLMOD
    const double c = warm([&] { cholmod.solve(b); });
    if (k >= 0) theirs.push_back(c);
#endif
    if (k < 0) continue;
    answers.push_back(a);
    frames.push_back(f);
    solves.push_back(s);
  }
  bandwidth = std::max(bandwidth, triad_bandwidth());
  const double solve = median(solves), whole = median(answers) + median(frames);
  const double bound = 16.0 * static_cast<double>(entries) / bandwidth;
  const Points direct = solve_from_scratch(*layout, foot.where, goal(events - 1), peer.K);
  const double error = difference(direct, session->dofs()) / size;
  const double points = static_cast<double>(session->frame().points.size()) / 3;
  tables.drag.add(
      {name, text("%ld", n), text("%.2f", 1e-6 * static_cast<double>(entries)),
       milliseconds(median(answers)), milliseconds(median(frames)), text("%.0f", points),
       milliseconds(whole), milliseconds(solve),
       theirs.empty() ? "none" : milliseconds(median(theirs)), text("%.2f", whole / solve),
       text("%.0f %%", 100 * bound / solve), text("%.0f %%", 100 * bound / whole),
       theirs.empty() ? "none" : text("%.1f", median(theirs) / whole), text("%.0e", error)});
  checks.at_most(name + ": drag of a point over its solves", whole / solve, 1.5);
  checks.at_most(name + ": difference from a direct solution, over the size", error, 1e-9);
  checks.at_most(name + ": residual over the size", session->residual(), 1e-10);
  if (name != "1k")
    checks.at_least(name + ": fraction of the memory bound, solve", bound / solve,
                    name == "14k" ? 0.5 : 0.35);

  // Other sliders.
  const auto row = [&](const std::string& what, const DragTimes& d) {
    tables.sliders.add({name, what, milliseconds(d.answer), milliseconds(d.whole()),
                        text("%.2f", d.whole() / solve), text("%.1f", d.iterations)});
  };
  session->add(Load{"push", Load::Uniform{{0, 0, 1}, {}}});
  session->add(Load{"finger", Load::Point{{0.7, 0.3, 0}, {0, 0, 1}}});
  const int push = session->parameters().index("push"),
            finger = session->parameters().index("finger"),
            beta = session->parameters().index("beta");
  const DragTimes superposed =
      dragged(*session, events, [&](int k) { session->set(k % 2 ? push : finger, 0.1 * k); });
  row("superposed loads, two sliders", superposed);
  const Points quick = session->dofs();
  session->solve_to_equilibrium();
  checks.at_most(name + ": superposed loads, difference from a solve over the size",
                 difference(quick, session->dofs()) / size, 1e-12);
  const DragTimes material =
      dragged(*session, std::min(events, 7), [&](int k) { session->set(beta, 2 + 0.1 * k); });
  row("beta: new values in the factor", material);
  session->set(beta, 1);
  session->solve_to_equilibrium();
  session->add(Load{"pressure", Load::Pressure{}});
  const int pressure = session->parameters().index("pressure");
  double p = 5;
  const DragTimes following =
      dragged(*session, events, [&](int) { session->set(pressure, p += 0.2); });
  row("follower pressure", following);
  const Points warm_shape = session->dofs();
  session->solve_to_equilibrium();
  checks.at_most(name + ": pressure, last update of the drag, distance from convergence",
                 difference(warm_shape, session->dofs()) / size, 1e-4);
  session->set(pressure, 0);
  session->solve_to_equilibrium();

  const double second = cpu_seconds_of([&] {
    session->add(Constraint{"pin 2", Constraint::Point{{0.7, 0.7, 0}, {0.7, 0.7, 0.1}}});
    session->frame();
  });
  const double removed = cpu_seconds_of([&] {
    session->remove("pin 2");
    session->frame();
  });
  tables.first.add({name, milliseconds(layout_time), milliseconds(session_time),
                    milliseconds(added), milliseconds(second), milliseconds(removed),
                    milliseconds(material.answer)});
}

// A model with three sliders at once: a pressure, a curve that moves, a fixed point.
struct DragCase {
  const char* name;
  std::string line;
  double fade;
  Vec3 pin;     // a position close to the fixed point
  Vec3 up;      // the axis along which it moves
  double step;  // model units per event
};

// Updates per second.
double measure_drag(const DragCase& drag_case, const ModelLayout& layout, double layout_time,
                    Checks& checks) {
  const int triangles = layout.mesh()->triangle_count();
  std::optional<SculptingSession> session;
  const double session_time = cpu_seconds_of([&] {
    session.emplace(layout, SessionOptions());
    session->frame();
  });
  session->add(Load{"swell", Load::Pressure{}}, {slider("swell", 20)});
  session->add(LineOffset{"raise", drag_case.line, {}, drag_case.fade});
  const ModelProjector projector(layout, session->dofs());
  const auto near = projector.nearest_inside(drag_case.pin);
  const Vec3 at = projector.surface(near.at.region).position(near.where);
  session->add(Constraint{"pin", Constraint::Point{at, at}});
  session->solve_to_equilibrium();
  const std::string axis = drag_case.up.y() == 1 ? "pin.y" : "pin.z";
  const int swell = session->parameters().index("swell"),
            raise = session->parameters().index("raise"), pin = session->parameters().index(axis);
  const double start = session->parameters().value(pin);
  constexpr int events = 41;
  const DragTimes drag = dragged(*session, events, [&](int k) {
    session->set(swell, 20 + 0.5 * k);
    session->set(raise, 0.5 * drag_case.step * k);
    session->set(pin, start + drag_case.step * k);
  });
  // The triangular solves alone, on the session's own matrix.
  const auto reduction = std::make_shared<AffineReduction>(layout.line_constraints(),
                                                           AffineReduction::RhsMode::Deferred);
  const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
  SparseMatrix K = assembler.pattern();
  auto materials = layout.scale_to_regions({SurfaceStiffness()});
  materials.resize(static_cast<size_t>(triangles), materials[0]);
  assembler.stiffness(materials, K);
  const ReusableFactorization system(reduction, K, dof_vertices(*layout.mesh()));
  MatX b = MatX::Random(static_cast<long>(system.free_count()), 3);
  std::vector<double> solves;
  for (int k = 0; k < 11; ++k)
    solves.push_back(cpu_seconds_of([&] { system.factor().solve_in_place(b); }));
  const Points dragged_shape = session->dofs();
  const double residual = session->residual();
  const SolveReport settled = session->solve_to_equilibrium();
  const double missed = difference(dragged_shape, session->dofs()) / layout.size();
  const double answers_a_second = 1 / drag.whole();
  const std::string name = drag_case.name;
  Table table;
  table.add({"the " + name + ", three sliders at once", ""});
  table.add({"faces", std::to_string(layout.region_count())});
  table.add({"triangles", std::to_string(triangles)});
  table.add({"unknowns per coordinate", std::to_string(system.free_count())});
  table.add({"entries of the factor, M",
             text("%.2f", 1e-6 * static_cast<double>(system.factor().factor_entries()))});
  table.add({"display points", text("%zu", session->frame().points.size() / 3)});
  table.add({"layout, ms", milliseconds(layout_time)});
  table.add({"first update and frame, ms", milliseconds(session_time)});
  table.add({"one pair of solves, ms", milliseconds(median(solves))});
  table.add({"update, ms", milliseconds(drag.answer)});
  table.add({"display, ms", milliseconds(drag.frame)});
  table.add({"iterations per update", text("%.2f", drag.iterations)});
  table.add({"updates per second", text("%.1f", answers_a_second)});
  table.add({"last update, distance from convergence over the size", text("%.1e", missed)});
  table.add({"iterations to convergence", std::to_string(settled.iterations)});
  table.print();
  checks.at_least(name + ": triangles", triangles, 20000);
  checks.at_most(name + ": residual over the size", residual, 1e-10);
  checks.at_most(name + ": last update of the drag, distance from convergence over the size",
                 missed, 1e-4);
  return answers_a_second;
}

void measure_models(Checks& checks) {
  std::optional<ModelLayout> door, whole_mouse;
  const double door_time = cpu_seconds_of([&] { door.emplace(door_layout(7.3, 0.1)); });
  const double of_door = measure_drag({"door", "rib", 0.2, {250, 40, -60}, Vec3::UnitY(), 0.2},
                                      *door, door_time, checks);
  checks.at_least("door: updates per second, three sliders", of_door, 60);
  const double mouse_time = cpu_seconds_of([&] { whole_mouse.emplace(*mouse(1.22).model.layout); });
  const double of_mouse = measure_drag({"mouse", "spine.2", 0.3, {12, 25, 33}, Vec3::UnitZ(), 0.02},
                                       *whole_mouse, mouse_time, checks);
  checks.at_least("mouse: updates per second over the door's", of_mouse / of_door, 0.6);
}

}  // namespace

int main() {
  one_thread();
  Checks checks;
  Tables tables;
  tables.drag.add({"point, ms", "n", "entries (M)", "update", "display", "points", "total", "solve",
                   "CHOLMOD", "total/solve", "bound/solve", "bound/total", "CHOLMOD/total",
                   "error"});
  tables.sliders.add({"ms", "slider", "update", "total", "over a solve", "iterations"});
  tables.first.add({"ms", "layout", "first update and frame", "first point added", "one more",
                    "removed", "full refactorization"});
  double bandwidth = 0;
  try {
    measure("1k", 0.082, tables, checks, bandwidth);
    measure("14k", 0.0222, tables, checks, bandwidth);
    measure("100k", 0.0083, tables, checks, bandwidth);
    std::printf("One thread; triad %.1f GB/s; factor with %s\n\n", 1e-9 * bandwidth,
                SparseCholesky::backend());
    tables.drag.print();
    tables.sliders.print();
    tables.first.print();
    measure_models(checks);
  } catch (const Error& e) {
    std::printf("failed: %s\n", e.what());
    checks.at_most("failed", std::nullopt, 0);
  }
  checks.print("drag");
}
