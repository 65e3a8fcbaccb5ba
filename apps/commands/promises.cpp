#include "batten/apps/commands/promises.h"

#include <cmath>

#include "batten/io/fair_report.h"

namespace batten {

std::vector<MissedPromise> broken_promises(const Report& report, double tolerance) {
  std::vector<MissedPromise> missed = numbers_that_failed(report);
  const auto at_most = [&](const std::string& what, double value, double limit) {
    if (value > limit)
      missed.push_back({what, "is " + number(value) + ", promised at most " + number(limit)});
  };
  const auto& s = report.surface;
  for (const MissedPromise& m : broken_conditions(report.curves)) missed.push_back(m);
  for (const auto& line : report.lines)
    at_most("lines." + line.name + ".deviation", line.deviation, tolerance);
  if (s.hold == "lines") {
    at_most("surface.max_line_residual", s.quality.max_line_residual, 1e-10);
    at_most("surface.max_line_gap", s.quality.max_line_gap, tolerance);
    at_most("surface.max_line_deviation", s.quality.max_line_deviation, tolerance);
  }
  at_most("surface.max_constraint_residual", s.max_constraint_residual, 1e-10);
  at_most("surface.max_normal_constraint_deg", s.max_normal_constraint_deg, 1e-6);
  at_most("surface.max_normal_jump_deg", s.quality.max_normal_jump_deg, 1e-3);
  if (s.quality.min_jacobian_ratio < 0.05)
    missed.push_back({"surface.min_jacobian_ratio",
                      "is " + number(s.quality.min_jacobian_ratio) + ", promised at least 0.05"});
  at_most("surface.singular_nodes", s.quality.singular_nodes, 0);
  if (report.step && report.step->form == "face") {
    if (!report.step->valid) missed.push_back({"step.valid", "is false, promised true"});
    at_most("step.max_deviation", report.step->max_deviation, report.step->tolerance);
    if (s.hold == "lines")
      at_most("step.max_gap", report.step->max_gap, report.step->tolerance + tolerance);
  } else if (report.step) {
    if (!report.step->valid) missed.push_back({"step.valid", "is false, promised true"});
    if (s.element == "hct")
      at_most("step.max_deviation", report.step->max_deviation, 1e-9 * s.size);
    at_most("step.max_gap", report.step->max_gap, 1e-9 * s.size);
    at_most("step.max_normal_jump_deg", report.step->max_normal_jump_deg, 1e-3);
  }
  return missed;
}

std::vector<MissedPromise> broken_network_promises(const Report& report) {
  std::vector<MissedPromise> missed = numbers_that_failed(report);
  const auto at_most = [&](const std::string& what, double value, double limit) {
    if (value > limit)
      missed.push_back({what, "is " + number(value) + ", promised at most " + number(limit)});
  };
  const NetworkReport& n = *report.network;
  const double on_line = n.fit_tolerance, on_input = n.fit_tolerance + n.tolerance;
  for (const MissedPromise& m : broken_conditions(report.curves)) missed.push_back(m);
  for (const auto& line : report.lines)
    at_most("lines." + line.name + ".deviation", line.deviation, on_input);
  for (const auto& r : n.regions) {
    const std::string at = "regions." + r.name;
    if (!r.skinned) {
      missed.push_back({at, "is not skinned: " + r.why_not});
      continue;
    }
    at_most(at + ".max_line_residual", r.quality.max_line_residual, 1e-10);
    at_most(at + ".max_line_gap", r.quality.max_line_gap, on_line);
    at_most(at + ".max_line_deviation", r.quality.max_line_deviation, on_input);
    at_most(at + ".max_normal_jump_deg", r.quality.max_normal_jump_deg, 1e-3);
    if (r.quality.min_jacobian_ratio < 0.05)
      missed.push_back({at + ".min_jacobian_ratio",
                        "is " + number(r.quality.min_jacobian_ratio) + ", promised at least 0.05"});
    at_most(at + ".singular_nodes", r.quality.singular_nodes, 0);
  }
  for (const auto& flaw : n.flaws) {
    std::string where;
    for (const auto& region : flaw.regions) where += (where.empty() ? "" : ", ") + region;
    missed.push_back({"flaws." + flaw.kind + " in " + where, flaw.text});
  }
  for (const auto& j : n.joins) {
    const std::string at = "joins." + j.line;
    if (j.kind == "smooth") at_most(at + ".max_inside_deg", j.max_inside_deg, n.join_tolerance_deg);
    if (j.kind != "smooth" && j.asked && !j.why.empty())
      missed.push_back({at, "was asked for as smooth and is a " + j.kind + ": " + j.why});
  }
  if (report.step) {
    if (!report.step->valid) missed.push_back({"step.valid", "is false, promised true"});
    at_most("step.max_deviation", report.step->max_deviation, report.step->tolerance);
    at_most("step.max_gap", report.step->max_gap, report.step->tolerance + on_line);
  }
  return missed;
}

}  // namespace batten
