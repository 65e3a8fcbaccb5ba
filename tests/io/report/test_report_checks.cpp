// SPDX-License-Identifier: MPL-2.0
// Acceptance checks of the report of a shape.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "batten/io/report/report.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

/// The report of a face that passes all checks.
Report good_report() {
  Report report;
  report.surface.boundary = "curves";
  report.surface.size = 100;
  report.surface.quality.min_jacobian_ratio = 0.8;
  report.lines.emplace_back().name = "rim";
  return report;
}

std::vector<std::string> names_of(const std::vector<FailedCheck>& checks) {
  std::vector<std::string> names;
  for (const FailedCheck& check : checks) names.push_back(check.what);
  return names;
}

constexpr double kTolerance = 0.01;

}  // namespace

TEST_CASE("each number beyond its limit is a failed check with the path of the number",
          "[io][report]") {
  CHECK(failed_checks(good_report(), kTolerance).empty());
  const std::vector<std::pair<std::string, std::function<void(Report&)>>> faults = {
      {"curves.rim.deviation", [](Report& r) { r.lines[0].deviation = 1.1 * kTolerance; }},
      {"surface.max_constraint_residual",
       [](Report& r) { r.surface.max_constraint_residual = 2e-10; }},
      {"surface.max_normal_constraint_deg",
       [](Report& r) { r.surface.max_normal_constraint_deg = 2e-6; }},
      {"surface.max_curve_residual",
       [](Report& r) { r.surface.quality.max_line_residual = 2e-10; }},
      {"surface.max_curve_gap", [](Report& r) { r.surface.quality.max_line_gap = 0.02; }},
      {"surface.max_normal_jump_deg",
       [](Report& r) { r.surface.quality.max_normal_jump_deg = 2e-3; }},
      {"surface.min_jacobian_ratio",
       [](Report& r) { r.surface.quality.min_jacobian_ratio = 0.04; }},
      {"surface.singular_nodes", [](Report& r) { r.surface.quality.singular_nodes = 1; }},
      {"step.valid", [](Report& r) { r.step.emplace(); }},
      {"step.max_gap",
       [](Report& r) {
         r.step.emplace().valid = true;
         r.step->max_gap = 2e-7;  // 1e-9 of the size is allowed
       }},
      {"surface.area", [](Report& r) { r.surface.quality.area = std::nan(""); }},
  };
  for (const auto& [name, fault] : faults) {
    Report report = good_report();
    fault(report);
    INFO(name);
    CHECK(names_of(failed_checks(report, kTolerance)) == std::vector<std::string>{name});
  }
}

TEST_CASE("a curve may deviate by the tolerance, if it only trims by any distance",
          "[io][report]") {
  Report report = good_report();
  report.lines[0].deviation = kTolerance;
  CHECK(failed_checks(report, kTolerance).empty());
  report.lines[0].deviation = 10 * kTolerance;
  report.lines[0].constrains_surface = false;
  CHECK(failed_checks(report, kTolerance).empty());
  // Curves that are not fixed are not compared with the surface either.
  report.surface.quality.max_line_gap = 10 * kTolerance;
  CHECK(names_of(failed_checks(report, kTolerance)) ==
        std::vector<std::string>{"surface.max_curve_gap"});
  report.surface.boundary = "corners";
  CHECK(failed_checks(report, kTolerance).empty());
}

TEST_CASE("every face and every smooth edge of a network is checked", "[io][report]") {
  Report report = good_report();
  NetworkReport& network = report.network.emplace();
  network.fit_tolerance = kTolerance;
  network.join_tolerance_deg = 0.1;
  network.tolerance = 0.5;  // with which the ends of curves were joined
  report.lines[0].deviation = 0.5;
  NetworkReport::Region& face = network.regions.emplace_back();
  face.name = "front";
  face.skinned = true;
  face.quality.min_jacobian_ratio = 0.8;
  network.regions.emplace_back().name = "back";
  network.regions.back().rejection_reason = "its curves are too close to each other";
  NetworkReport::Join& edge = network.joins.emplace_back();
  edge.line = "rim";
  edge.kind = "smooth";
  edge.max_inside_deg = 0.12;
  CHECK(names_of(failed_checks(report, kTolerance)) ==
        std::vector<std::string>{"faces.back", "joins.rim.max_inside_deg"});
  report.is_sculpted = true;  // loads may open smooth edges by another 0.05°
  CHECK(names_of(failed_checks(report, kTolerance)) == std::vector<std::string>{"faces.back"});
  edge.kind = "G0";
  edge.requested = true;
  edge.why = "the tangents at its ends contradict each other";
  CHECK(names_of(failed_checks(report, kTolerance)) ==
        std::vector<std::string>{"faces.back", "joins.rim"});
}
