// SPDX-License-Identifier: MPL-2.0
// Motion of surfaces compared with closed-form solutions.
#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten_test;

namespace {

// A square plate bent by a uniform load that is then removed.
struct Released {
  SculptingSession session;
  Points still;
  Matrices matrices;
  explicit Released(double alpha = 0, double edge = 0.3)
      : session(square_layout(edge), with_material(alpha, 1)),
        still(session.dofs()),
        matrices(session.layout(), SurfaceStiffness::isotropic(alpha, 1)) {
    bend();
  }
  void bend() {
    session.add(Load{"push", Load::Uniform{{0.3, -0.2, 1}, {}}}, {slider("push", 500)});
    session.solve_to_equilibrium();
    session.remove("push");
  }
  void pull(double value) {
    session.add(Load{"pull", Load::Uniform{{0, 0.1, -1}, {}}}, {slider("pull", value)});
  }
};

}  // namespace

TEST_CASE("every mode of a plate follows the formula of the time integration scheme",
          "[sculpting][session]") {
  for (const double theta : {0.5, 0.75, 1.0}) {
    Released plate(0.5);
    const Modes modes(plate.session.layout().line_constraints(), plate.matrices.K,
                      plate.matrices.M);
    const MatX start = modes.of(plate.session.dofs() - plate.still);
    const Motion motion{.dt = 0.002, .density = 2, .damping = 3, .theta = theta};
    plate.session.start_motion(motion);
    std::vector<ModeSteps> reference_solver;
    for (long k = 0; k < start.rows(); ++k)
      for (int c = 0; c < 3; ++c)
        reference_solver.push_back(
            {motion.density, motion.damping, modes.lambda[k], motion.dt, theta, start(k, c)});
    const double scale = start.cwiseAbs().maxCoeff();
    double worst = 0;
    for (int n = 1; n <= 200; ++n) {
      plate.session.step();
      const MatX now = modes.of(plate.session.dofs() - plate.still);
      for (long k = 0; k < start.rows(); ++k)
        for (int c = 0; c < 3; ++c) {
          ModeSteps& mode = reference_solver[static_cast<size_t>(3 * k + c)];
          mode.step();
          worst = std::max(worst, std::abs(now(k, c) - mode.x));
        }
    }
    INFO("theta " << theta << ": " << worst / scale);
    CHECK(worst < 1e-9 * scale);
  }
}

TEST_CASE("frequency and damping of the first mode, first and second order in dt",
          "[sculpting][session]") {
  Released plate;
  const Modes modes(plate.session.layout().line_constraints(), plate.matrices.K, plate.matrices.M);
  const double lambda = modes.lambda[0];
  // The boundary of the plate of size 1 is fixed, sides of 1/√2: λ = (2π²/side²)² = (4π²)².
  CHECK(lambda == Approx(std::pow(4 * pi * pi, 2)).epsilon(2e-3));
  const double period = 2 * pi / std::sqrt(lambda), damping = 4;
  const double start = modes.of(plate.session.dofs() - plate.still)(0, 2);
  for (const double theta : {1.0, 0.5}) {
    std::vector<double> error;
    for (const int steps : {200, 400, 800}) {
      SculptingSession& session = plate.session;
      plate.bend();
      session.start_motion({.dt = 2 * period / steps, .damping = damping, .theta = theta});
      for (int n = 0; n < steps; ++n) session.step();
      const double now = modes.of(session.dofs() - plate.still)(0, 2);
      error.push_back(std::abs(now - ModeSteps::exact(1, damping, lambda, start, 2 * period)) /
                      std::abs(start));
      session.stop_motion();
    }
    const double order = std::log2(error[1] / error[2]);
    INFO("theta " << theta << " errors " << error[0] << " " << error[1] << " " << error[2]);
    CHECK(order == Approx(theta == 1 ? 1 : 2).margin(0.1));
    CHECK(error[2] < (theta == 1 ? 0.1 : 1e-3));
  }
}

TEST_CASE("the trapezoidal rule keeps a mode's energy, and all lose it by damping alone",
          "[sculpting][session]") {
  Released plate;
  plate.session.start_motion({.dt = 0.001, .damping = 0, .theta = 0.5});
  const double start = plate.session.total_energy();
  double largest = 0;
  for (int n = 0; n < 500; ++n) {
    plate.session.step();
    largest = std::max(largest, std::abs(plate.session.total_energy() / start - 1));
  }
  CHECK(largest < 1e-10);
}

TEST_CASE("energy never grows under a load that stands, whatever the step",
          "[sculpting][session]") {
  const double period = 2 * pi / std::pow(4 * pi * pi, 1);
  for (const double theta : {0.5, 1.0})
    for (const double dt : {0.01 * period, period, 1000 * period}) {
      Released plate;
      SculptingSession& session = plate.session;
      const double start = difference(session.dofs(), plate.still);
      plate.pull(1000);
      session.start_motion({.dt = dt, .density = 1, .damping = 0.5, .theta = theta});
      session.step();  // the load changes during the step
      double before = session.total_energy();
      const double scale = std::abs(before);
      double worst = -1e300, farthest = 0;
      for (int n = 0; n < 300; ++n) {
        session.step();
        const double now = session.total_energy();
        worst = std::max(worst, now - before);
        before = now;
        farthest = std::max(farthest, (session.dofs() - plate.still).cwiseAbs().maxCoeff());
      }
      INFO("theta " << theta << " dt " << dt << ": grew by " << worst / scale);
      CHECK(worst < 1e-10 * scale);
      CHECK(farthest < 8 * start);
    }
}

TEST_CASE("implicit Euler with a thousandfold step is the static solution at once",
          "[sculpting][session]") {
  Released plate;
  plate.pull(3);
  plate.session.start_motion({.dt = 1e8});
  plate.session.step();
  const Points moved = plate.session.dofs();
  plate.session.stop_motion();
  plate.session.solve_to_equilibrium();
  CHECK(difference(moved, plate.session.dofs()) < 1e-9);
}

TEST_CASE("motion comes to rest at the static shape, and that is the independent one",
          "[sculpting][session]") {
  const RegionLayout layout = patch_layout(0.3);
  const Vec3 force(0.4, -0.1, 2);
  const auto statics = reference_solver::sculpt(layout, layout.line_constraints(),
                                                {{"f", reference_solver::UniformLoad{force}}}, {});
  const Matrices matrices(layout);
  const Points direct = solve_constrained(layout.line_constraints(), matrices.K,
                                          matrices.assembler.load(Vec3(layout.size() * force)));
  SculptingSession session(layout, {});
  session.add(Load{"f", Load::Uniform{force, {}}}, {slider("f", 1)});
  const SolveReport report = session.solve_to_equilibrium();
  CHECK(report.converged);
  CHECK(difference(session.dofs(), statics.dofs) < 1e-9 * layout.size());
  CHECK(difference(session.dofs(), direct) < 1e-9 * layout.size());
  const Points settled = session.dofs();
  session.set("f", 0);
  session.solve_to_equilibrium();
  CHECK(difference(session.dofs(), settled) > 1e-4);
  session.set("f", 1);
  session.start_motion({.dt = 0.05, .damping = 20});
  for (int n = 0; n < 1500; ++n) session.step();
  CHECK(difference(session.dofs(), settled) < 1e-9 * layout.size());
  CHECK(session.residual() < 1e-12);
}

TEST_CASE("values over time drive a motion: a ramp ends at the equilibrium of its last value",
          "[sculpting][session]") {
  const RegionLayout layout = square_layout(0.3);
  SculptingSession session(layout, {});
  ScalarParameter ramp = slider("push");
  ramp.keyframes = {{0, 0}, {0.5, 4}};
  session.add(Load{"push", Load::Uniform{{0, 0, 1}, {}}}, {ramp});
  session.solve_to_equilibrium();
  const Points start = session.dofs();
  session.start_motion({.dt = 0.02, .damping = 30});
  double before = 0;
  for (int n = 1; n <= 25; ++n) {
    const SolveReport report = session.step();
    CHECK(report.time == Approx(0.02 * n));
    CHECK(session.parameters().value("push") == Approx(8 * 0.02 * n));
    const double now = difference(session.dofs(), start);
    CHECK(now > before);
    before = now;
  }
  for (int n = 0; n < 500; ++n) session.step();
  const Points moved = session.dofs();
  CHECK_THROWS_AS(session.set_time(0.25), InputError);
  session.stop_motion();
  session.solve_to_equilibrium();
  CHECK(difference(session.dofs(), moved) < 1e-9);
  session.set_time(0.25);
  session.solve_to_equilibrium();
  // Linear: half of the load, half of the displacement.
  CHECK(difference(2 * (session.dofs() - start), moved - start) < 1e-9);
}

TEST_CASE("a load that grows evenly: the exact motion, second order in dt",
          "[sculpting][session]") {
  // λ x + ẍ = f t, from rest: x = x₁ (t - sin ωt / ω), x₁ the static solution for f.
  std::vector<double> error;
  for (const int steps : {100, 200, 400}) {
    SculptingSession session(square_layout(0.3), with_material(0, 1));
    const Points still = session.dofs();
    const Modes modes(session.layout().line_constraints(), Matrices(session.layout()).K,
                      Matrices(session.layout()).M);
    session.add(Load{"push", Load::Uniform{{0, 0, 1}, {}}}, {slider("push", 1000)});
    session.solve_to_equilibrium();
    const double one = modes.of(session.dofs() - still)(0, 2);
    session.set("push", 0);
    session.solve_to_equilibrium();
    session.remove("push");
    ScalarParameter ramp = slider("push");
    ramp.keyframes = {{0, 0}, {10, 10000}};
    session.add(Load{"push", Load::Uniform{{0, 0, 1}, {}}}, {ramp});
    const double omega = std::sqrt(modes.lambda[0]), end = 2.3 * 2 * pi / omega;
    session.start_motion({.dt = end / steps, .density = 1, .damping = 0, .theta = 0.5});
    for (int n = 0; n < steps; ++n) session.step();
    const double exact = one * (end - std::sin(omega * end) / omega);
    error.push_back(std::abs(modes.of(session.dofs() - still)(0, 2) / exact - 1));
  }
  INFO("errors " << error[0] << " " << error[1] << " " << error[2]);
  CHECK(std::log2(error[1] / error[2]) == Approx(2).margin(0.1));
  CHECK(error[2] < 1e-3);
}

TEST_CASE("a motion with impossible numbers is refused and nothing moves", "[sculpting][session]") {
  SculptingSession session(square_layout(0.5), {});
  const Points before = session.dofs();
  CHECK_THROWS_AS(session.step(), InputError);
  for (const Motion& bad : {Motion{.dt = 0}, Motion{.dt = -1}, Motion{.dt = NAN},
                            Motion{.dt = 1, .density = -1}, Motion{.dt = 1, .damping = -0.1},
                            Motion{.dt = 1, .theta = 0.4}, Motion{.dt = 1, .theta = 1.1}})
    CHECK_THROWS_AS(session.start_motion(bad), InputError);
  CHECK_THROWS_AS(session.step(), InputError);
  CHECK(same_bits(before, session.dofs()));
}
