// SPDX-License-Identifier: MPL-2.0
// Surfaces under a follower pressure, compared with converged references (reference/inflation.py).
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

nlohmann::json inflation(const std::string& shape, const std::string& rim, double alpha) {
  const nlohmann::json all = reference("inflation.json");
  for (const auto& c : all["cases"])
    if (c["shape"] == shape && c["rim"] == rim && c["alpha"] == alpha) return c;
  throw std::runtime_error("no such reference");
}

SculptingSession inflated(RegionLayout layout, const nlohmann::json& reference) {
  SessionOptions options =
      with_material(reference["alpha"], reference["beta"], LoadUnits::Absolute);
  SculptingSession session(std::move(layout), options);
  if (reference["rim"] == "tangent plane")
    session.add(Constraint{"flat rim", Constraint::LineNormal{"rim", Vec3::UnitZ()}});
  session.add(Load{"p", Load::Pressure{}});
  return session;
}

// Largest relative error of volume and energy over all states of a reference.
double error(SculptingSession& session, const nlohmann::json& reference, double up_to) {
  double worst = 0;
  for (const auto& state : reference["states"]) {
    if (state["pressure"] > up_to) continue;
    session.set("p", state["pressure"]);
    REQUIRE(session.solve_to_equilibrium().converged);
    const SurfaceEnergy energy = session.energy();
    const double volume = state["volume"], all = state["energy"].get<double>() / 2;  // of qᵀK q
    worst = std::max(worst, std::abs(session.enclosed_volume() / volume - 1));
    // A bending energy of 1e-9 is rounding relative to the flat disc's own values.
    if (all > 1e-6)
      worst = std::max(worst, std::abs((energy.bending + energy.stretching) / all - 1));
  }
  return worst;
}

}  // namespace

TEST_CASE("a small pressure on a clamped disc is the plate of the handbook",
          "[sculpting][session]") {
  // z(0) = p/(64 beta), volume p π/(192 beta).
  SculptingSession session = inflated(disc_layout(0.2), inflation("disc", "tangent plane", 0));
  const double p = 1e-4;
  session.set("p", p);
  session.solve_to_equilibrium();
  CHECK(session.enclosed_volume() == Approx(p * pi / 192).epsilon(2e-3));
  const Surface shape = shape_of(session);
  const auto top = shape.closest_point({0, 0, 0});
  CHECK(shape.position(top.where).z() == Approx(p / 64).epsilon(2e-3));
  session.set("p", -p);
  session.solve_to_equilibrium();
  CHECK(session.enclosed_volume() == Approx(-p * pi / 192).epsilon(2e-3));
}

TEST_CASE("an inflated disc tends to the converged reference", "[sculpting][session]") {
  for (const char* rim : {"position", "tangent plane"}) {
    const auto reference = inflation("disc", rim, 0);
    const double most = 0.9 * reference["fold"]["pressure"].get<double>();
    std::vector<double> errors;
    for (const double edge : {0.4, 0.2}) {
      SculptingSession session = inflated(disc_layout(edge), reference);
      errors.push_back(error(session, reference, most));
      CHECK(session.residual() < 1e-10);
    }
    INFO(rim << ": " << errors[0] << ", " << errors[1]);
    CHECK(errors[1] < 2e-3);
    CHECK(errors[1] < 0.25 * errors[0]);
  }
}

TEST_CASE("an inflated tube tends to the converged reference", "[sculpting][session]") {
  for (const double alpha : {0.0, 2.0}) {
    const auto reference = inflation("tube", "position", alpha);
    const double most = 0.9 * reference["fold"]["pressure"].get<double>();
    std::vector<double> errors;
    for (const double edge : {0.5, 0.25}) {
      SculptingSession session = inflated(tube_layout(edge), reference);
      errors.push_back(error(session, reference, most));
      CHECK(session.residual() < 1e-12);
    }
    INFO("alpha " << alpha << ": " << errors[0] << ", " << errors[1]);
    CHECK(errors[1] < 5e-3);
    CHECK(errors[1] < 0.15 * errors[0]);  // O(h⁴) gives 1/16
  }
}

TEST_CASE("past the limit load the session reports the values reached, and stays there",
          "[sculpting][session]") {
  const auto reference = inflation("tube", "position", 0);
  const double fold = reference["fold"]["pressure"];
  SculptingSession session = inflated(tube_layout(0.35), reference);
  session.set("p", 0.9 * fold);
  session.solve_to_equilibrium();
  const Points good = session.dofs();
  session.set("p", 1.5 * fold);
  double reached = 0;
  try {
    session.solve_to_equilibrium();
    FAIL("1.5 times the limit");
  } catch (const NoSolutionError& e) {
    const std::string text = e.what();
    CHECK_THAT(text, Contains("'p'") && Contains("was reached"));
    reached = std::stod(text.substr(text.find('(') + 1));
  }
  CHECK(reached == Approx(fold).epsilon(0.01));
  // The last result that converged.
  CHECK(session.parameters().value("p") == 0.9 * fold);
  CHECK(same_bits(session.dofs(), good));
  // And further from there.
  session.set("p", 0.5 * fold);
  CHECK(session.solve_to_equilibrium().converged);
  SculptingSession fresh = inflated(tube_layout(0.35), reference);
  fresh.set("p", 0.5 * fold);
  fresh.solve_to_equilibrium();
  CHECK(difference(session.dofs(), fresh.dofs()) < 1e-9);
}

TEST_CASE("a drag of pressure, warm-started at each update, equals a cold solve",
          "[sculpting][session]") {
  const auto reference = inflation("tube", "position", 0);
  const double fold = reference["fold"]["pressure"];
  SculptingSession session = inflated(tube_layout(0.4), reference);
  int iterations = 0, answers = 0;
  for (double p = 0; p <= 0.8 * fold; p += 0.02 * fold) {
    session.set("p", p);
    SolveReport answer;
    do {
      answer = session.solve_preview(4, 1e-9);
      iterations += answer.iterations;
    } while (!answer.converged);
    ++answers;
    CHECK(answer.change <= 1e-9);
  }
  const Points warm = session.dofs();
  SculptingSession cold = inflated(tube_layout(0.4), reference);
  cold.set("p", session.parameters().value("p"));
  cold.solve_to_equilibrium();
  CHECK(difference(warm, cold.dofs()) < 1e-7);
  INFO("iterations an answer: " << static_cast<double>(iterations) / answers);
  CHECK(iterations <= 9 * answers);
}
