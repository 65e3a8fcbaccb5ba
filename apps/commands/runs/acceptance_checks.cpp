#include "batten/apps/commands/runs/acceptance_checks.h"

#include "batten/core/errors.h"
#include "batten/io/cad/step_face_options.h"
#include "batten/io/report/fair_report.h"

namespace batten {
namespace {

// What loads and moves may add to the angle across a smooth join, which is driven under its
// tolerance at rest.
constexpr double kSculptedJoinDeg = 0.05;

class AcceptanceChecks {
 public:
  explicit AcceptanceChecks(const Report& report) : failed_checks(non_finite_numbers(report)) {}
  void require_at_most(const std::string& what, double value, double limit) {
    if (value > limit)
      failed_checks.push_back(
          {what, "is " + format_number(value) + ", promised at most " + format_number(limit)});
  }
  void surface(const std::string& at, const SkinQuality& q, bool lines, double on_line,
               double on_input) {
    if (lines) {
      require_at_most(at + ".max_line_residual", q.max_line_residual, 1e-10);
      require_at_most(at + ".max_line_gap", q.max_line_gap, on_line);
      require_at_most(at + ".max_line_deviation", q.max_line_deviation, on_input);
    }
    require_at_most(at + ".max_normal_jump_deg", q.max_normal_jump_deg, 1e-3);
    if (q.min_jacobian_ratio < 0.05)
      failed_checks.push_back(
          {at + ".min_jacobian_ratio",
           "is " + format_number(q.min_jacobian_ratio) + ", promised at least 0.05"});
    require_at_most(at + ".singular_nodes", q.singular_nodes, 0);
  }
  void network(const NetworkReport& n, bool lines, bool sculpted, double on_input) {
    for (const auto& r : n.regions) {
      if (r.skinned)
        surface("regions." + r.name, r.quality, lines, n.fit_tolerance, on_input);
      else
        failed_checks.push_back({"regions." + r.name, "is not skinned: " + r.rejection_reason});
    }
    for (const auto& j : n.joins) {
      const std::string at = "joins." + j.line;
      if (j.kind == "smooth")
        require_at_most(at + ".max_inside_deg", j.max_inside_deg,
                        n.join_tolerance_deg + (sculpted ? kSculptedJoinDeg : 0));
      if (j.kind != "smooth" && j.requested && !j.why.empty())
        failed_checks.push_back({at, "was asked for as smooth and is a " + j.kind + ": " + j.why});
    }
  }
  void defects(const std::vector<DefectReport>& defects) {
    for (const auto& defect : defects) {
      std::string where;
      for (const auto& region : defect.regions) where += (where.empty() ? "" : ", ") + region;
      failed_checks.push_back({"flaws." + defect.kind + " in " + where, defect.text});
    }
  }
  void step(const Report& report, bool lines, double on_line) {
    const auto& step = *report.step;
    if (!step.valid) failed_checks.push_back({"step.valid", "is false, promised true"});
    const double size = report.surface.size;
    if (step.form == "face") {
      require_at_most("step.max_deviation", step.max_deviation, step.tolerance);
      if (lines) require_at_most("step.max_gap", step.max_gap, step.tolerance + on_line);
      return;
    }
    if (report.surface.element == "hct")
      require_at_most("step.max_deviation", step.max_deviation, 1e-9 * size + step.tolerance);
    require_at_most("step.max_gap", step.max_gap, 1e-9 * size + step.tolerance);
    require_at_most("step.max_normal_jump_deg", step.max_normal_jump_deg, 1e-3);
  }
  std::vector<FailedCheck> failed_checks;
};

}  // namespace

std::vector<FailedCheck> failed_checks(const Report& report, double tolerance) {
  AcceptanceChecks checks(report);
  const auto& s = report.surface;
  const bool lines = s.boundary == "lines";
  // Lines of a network may have been moved where they were joined.
  const double on_input = tolerance + (report.network ? report.network->tolerance : 0);
  for (const FailedCheck& m : failed_fairing_checks(report.curves))
    checks.failed_checks.push_back(m);
  for (const auto& line : report.lines)
    if (line.constrains_surface)
      checks.require_at_most("lines." + line.name + ".deviation", line.deviation, on_input);
  checks.require_at_most("surface.max_constraint_residual", s.max_constraint_residual, 1e-10);
  checks.require_at_most("surface.max_normal_constraint_deg", s.max_normal_constraint_deg, 1e-6);
  if (report.network)
    checks.network(*report.network, lines, report.is_sculpted, on_input);
  else
    checks.surface("surface", s.quality, lines, tolerance, on_input);
  checks.defects(report.defects);
  if (s.fairing && s.fairing->requested && !s.fairing->converged)
    checks.failed_checks.push_back({"surface.fairing.converged", "is false, promised true"});
  if (report.step) checks.step(report, lines, tolerance);
  return checks.failed_checks;
}

}  // namespace batten
