// What `batten deform` prints.
#include <algorithm>
#include <cmath>

#include "batten/apps/commands/meshes/run_deform.h"
#include "batten/apps/commands/runs/run_support.h"

namespace batten {

std::string summary(const DeformReport& report, const std::filesystem::path& folder) {
  const std::string unit = " " + report.unit;
  std::string text = report.name + "\n";
  text += summary_line("mesh", std::to_string(report.nodes) + " nodes, " +
                                   std::to_string(report.faces) + " faces, " + report.format);
  for (const auto& e : report.edits)
    text += summary_line("edit", e.name + ": " + std::to_string(e.unknowns) +
                                     " unknowns a coordinate, largest displacement " +
                                     format_number(e.largest_displacement) + unit + ", set-up " +
                                     format_number(1000 * e.setup_s) + " ms, edit " +
                                     format_number(1000 * e.edit_s) + " ms");
  double residual = 0, rigid = 0;
  for (const auto& e : report.edits) residual = std::max(residual, e.hard_residual);
  for (const auto& f : report.features) rigid = std::max(rigid, f.max_rigid_error);
  text += summary_line("held", "residual " + format_number(residual) + " of the size");
  if (!report.features.empty())
    text += summary_line("features", std::to_string(report.features.size()) + ", rigid to " +
                                         format_number(rigid) + " of their size");
  if (const auto& a = report.attached; !a.elements.empty()) {
    std::string words;
    for (const auto& [name, count] : a.elements)
      words += (words.empty() ? "" : ", ") + std::to_string(count) + " " + name;
    text += summary_line("attached", words + "; " + std::to_string(a.connections) +
                                         " connections rigid to " +
                                         format_number(a.max_rigid_error) + unit + ", " +
                                         std::to_string(a.moved_with_shells) + " nodes followed");
  }
  for (const auto& c : report.curves)
    text += summary_line("curve", c.name + ": " + std::to_string(c.vertices) +
                                      " nodes, faired by " + format_number(c.fairing.max) + unit +
                                      ", curvature extrema " + std::to_string(c.before.extrema) +
                                      " -> " + std::to_string(c.after.extrema) + ", moved by " +
                                      format_number(c.largest_shift) + unit + ", held to " +
                                      format_number(c.max_residual));
  if (!report.holes.empty()) {
    int kept = 0, round = 0;
    double radius = 0;
    for (const auto& h : report.holes) {
      if (h.feature.empty()) continue;
      ++kept;
      round += h.before.circular;
      radius = std::max(radius, std::abs(h.after.radius - h.before.radius) / h.before.radius);
    }
    text += summary_line(
        "holes", std::to_string(report.holes.size()) + " loops, " + std::to_string(kept) +
                     " in features" +
                     (kept == 0 ? ""
                                : " (" + std::to_string(round) + " round), radii changed by " +
                                      format_number(radius) + " of themselves at most"));
  }
  text += summary_line("quality", "aspect " + format_number(report.before.aspect.worst) + " -> " +
                                      format_number(report.after.aspect.worst) + ", warpage " +
                                      format_number(report.before.warpage_degrees.worst) + " -> " +
                                      format_number(report.after.warpage_degrees.worst) +
                                      " degrees, Jacobian " +
                                      format_number(report.before.jacobian.worst) + " -> " +
                                      format_number(report.after.jacobian.worst) + ", inverted " +
                                      std::to_string(report.inverted.size()));
  return text + summary_footer(report, folder);
}

}  // namespace batten
