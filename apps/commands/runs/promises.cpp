#include "batten/apps/commands/runs/promises.h"

#include "batten/core/errors.h"
#include "batten/io/cad/step_face_options.h"
#include "batten/io/report/fair_report.h"

namespace batten {
namespace {

// What loads and moves may add to the angle across a smooth join, which is driven under its
// tolerance at rest.
constexpr double kSculptedJoinDeg = 0.05;

class Promises {
 public:
  explicit Promises(const Report& report) : missed(numbers_that_failed(report)) {}
  void at_most(const std::string& what, double value, double limit) {
    if (value > limit)
      missed.push_back({what, "is " + number(value) + ", promised at most " + number(limit)});
  }
  void surface(const std::string& at, const SkinQuality& q, bool lines, double on_line,
               double on_input) {
    if (lines) {
      at_most(at + ".max_line_residual", q.max_line_residual, 1e-10);
      at_most(at + ".max_line_gap", q.max_line_gap, on_line);
      at_most(at + ".max_line_deviation", q.max_line_deviation, on_input);
    }
    at_most(at + ".max_normal_jump_deg", q.max_normal_jump_deg, 1e-3);
    if (q.min_jacobian_ratio < 0.05)
      missed.push_back({at + ".min_jacobian_ratio",
                        "is " + number(q.min_jacobian_ratio) + ", promised at least 0.05"});
    at_most(at + ".singular_nodes", q.singular_nodes, 0);
  }
  void network(const NetworkReport& n, bool lines, bool sculpted, double on_input) {
    for (const auto& r : n.regions) {
      if (r.skinned)
        surface("regions." + r.name, r.quality, lines, n.fit_tolerance, on_input);
      else
        missed.push_back({"regions." + r.name, "is not skinned: " + r.why_not});
    }
    for (const auto& j : n.joins) {
      const std::string at = "joins." + j.line;
      if (j.kind == "smooth")
        at_most(at + ".max_inside_deg", j.max_inside_deg,
                n.join_tolerance_deg + (sculpted ? kSculptedJoinDeg : 0));
      if (j.kind != "smooth" && j.asked && !j.why.empty())
        missed.push_back({at, "was asked for as smooth and is a " + j.kind + ": " + j.why});
    }
  }
  void flaws(const std::vector<FlawReport>& flaws) {
    for (const auto& flaw : flaws) {
      std::string where;
      for (const auto& region : flaw.regions) where += (where.empty() ? "" : ", ") + region;
      missed.push_back({"flaws." + flaw.kind + " in " + where, flaw.text});
    }
  }
  void step(const Report& report, bool lines, double on_line) {
    const auto& step = *report.step;
    if (!step.valid) missed.push_back({"step.valid", "is false, promised true"});
    const double size = report.surface.size;
    if (step.form == "face") {
      at_most("step.max_deviation", step.max_deviation, step.tolerance);
      if (lines) at_most("step.max_gap", step.max_gap, step.tolerance + on_line);
      return;
    }
    if (report.surface.element == "hct")
      at_most("step.max_deviation", step.max_deviation, 1e-9 * size + step.tolerance);
    at_most("step.max_gap", step.max_gap, 1e-9 * size + step.tolerance);
    at_most("step.max_normal_jump_deg", step.max_normal_jump_deg, 1e-3);
  }
  std::vector<MissedPromise> missed;
};

}  // namespace

std::vector<MissedPromise> broken_promises(const Report& report, double tolerance) {
  Promises promises(report);
  const auto& s = report.surface;
  const bool lines = s.hold == "lines";
  // Lines of a network may have been moved where they were joined.
  const double on_input = tolerance + (report.network ? report.network->tolerance : 0);
  for (const MissedPromise& m : broken_conditions(report.curves)) promises.missed.push_back(m);
  for (const auto& line : report.lines)
    if (line.holds) promises.at_most("lines." + line.name + ".deviation", line.deviation, on_input);
  promises.at_most("surface.max_constraint_residual", s.max_constraint_residual, 1e-10);
  promises.at_most("surface.max_normal_constraint_deg", s.max_normal_constraint_deg, 1e-6);
  if (report.network)
    promises.network(*report.network, lines, report.is_sculpted, on_input);
  else
    promises.surface("surface", s.quality, lines, tolerance, on_input);
  promises.flaws(report.flaws);
  if (s.fairing && s.fairing->asked && !s.fairing->converged)
    promises.missed.push_back({"surface.fairing.converged", "is false, promised true"});
  if (report.step) promises.step(report, lines, tolerance);
  return promises.missed;
}

}  // namespace batten
