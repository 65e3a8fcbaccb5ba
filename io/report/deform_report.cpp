// SPDX-License-Identifier: MPL-2.0
#include "batten/io/report/deform_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/io/report/report_json.h"

namespace batten {
namespace {

Json hole_json(const HoleMeasure& m) {
  return {{"radius", m.radius},          {"equivalent_radius", m.equivalent_radius},
          {"centre", json_of(m.centre)}, {"axis", json_of(m.axis)},
          {"roundness", m.roundness},    {"flatness", m.flatness},
          {"perimeter", m.perimeter},    {"circular", m.circular}};
}

Json measure_json(const MeasureSummary& m) {
  return {
      {"worst", m.worst}, {"face", m.worst_face}, {"mean", m.mean}, {"violations", m.violations}};
}

Json quality_json(const QualitySummary& q) {
  return {{"aspect", measure_json(q.aspect)},
          {"warpage_deg", measure_json(q.warpage_degrees)},
          {"jacobian", measure_json(q.jacobian)},
          {"smallest_angle_deg", measure_json(q.smallest_angle_degrees)},
          {"largest_angle_deg", measure_json(q.largest_angle_degrees)}};
}

Json edits_json(const std::vector<DeformReport::Edit>& edits) {
  Json json = Json::array();
  for (const auto& [name, e] : edits)
    json.push_back({{"name", name},
                    {"moving_nodes", e.counts.moving},
                    {"unknowns", e.counts.unknowns},
                    {"soft_constraints", e.counts.soft_equations},
                    {"hard_constraints", e.counts.hard_constraints},
                    {"feature_constraints", e.counts.feature_constraints},
                    {"redundant_constraints", e.counts.redundant_count},
                    {"point_constraints", e.counts.point_equations},
                    {"largest_displacement", e.largest_displacement},
                    {"hard_residual", e.hard_residual},
                    {"last_correction", e.last_correction},
                    {"iterations", e.iterations},
                    {"converged", e.converged},
                    {"setup_s", e.setup_seconds},
                    {"edit_s", e.edit_seconds}});
  return json;
}

Json curves_json(const std::vector<DeformReport::Curve>& curves) {
  Json json = Json::array();
  for (const auto& c : curves)
    json.push_back({{"name", c.name},
                    {"nodes", c.vertices},
                    {"segments", c.segments},
                    {"fairing", {{"max", c.fairing.max}, {"rms", c.fairing.rms}}},
                    {"wavelength", c.wavelength},
                    {"largest_displacement", c.largest_shift},
                    {"max_residual", c.max_residual},
                    {"before", json_of(c.before)},
                    {"after", json_of(c.after)}});
  return json;
}

Json contents(const DeformReport& r) {
  Json json = report_header(r);
  json["mesh"] = {{"file", r.mesh_file},
                  {"format", r.format},
                  {"size", r.size},
                  {"nodes", r.nodes},
                  {"faces", r.faces}};

  double residual = 0;
  for (const auto& [name, e] : r.edits)
    if (!std::isnan(residual) && !(e.hard_residual <= residual)) residual = e.hard_residual;
  json["edits"] = edits_json(r.edits);
  json["hard_constraints"] = {{"max_residual", residual}};
  json["features"] = Json::array();
  for (const auto& f : r.features)
    json["features"].push_back({{"name", f.name},
                                {"nodes", f.vertices},
                                {"size", f.size},
                                {"max_rigid_error", f.max_rigid_error},
                                {"scale", f.scale},
                                {"rotation_deg", f.rotation_deg},
                                {"displacement", f.moved}});
  json["curves"] = curves_json(r.curves);
  json["dimensions"] = Json::array();
  for (const auto& d : r.dimensions)
    json["dimensions"].push_back({{"name", d.name},
                                  {"type", d.type},
                                  {"before", d.before},
                                  {"after", d.after},
                                  {"unit", d.unit},
                                  {"required", d.required}});
  if (!r.targets.empty()) json["targets"] = Json::array();
  for (const auto& t : r.targets)
    json["targets"].push_back({{"file", t.file},
                               {"nodes", t.followers},
                               {"ignored", t.ignored},
                               {"rms", t.rms},
                               {"largest", t.largest},
                               {"back_rms", t.back_rms},
                               {"back_largest", t.back_largest},
                               {"smoothing", t.smoothing}});
  if (r.variants)
    json["variants"] = {
        {"count", r.variants->count}, {"failed", r.variants->failed}, {"table", r.variants->table}};
  if (r.derivatives)
    json["derivatives"] = {{"files", r.derivatives->files},
                           {"parameters", r.derivatives->parameters},
                           {"largest_error", r.derivatives->largest_error}};
  json["holes"] = Json::array();
  for (const auto& h : r.holes)
    json["holes"].push_back({{"loop", h.loop},
                             {"nodes", h.vertices},
                             {"feature", h.feature},
                             {"before", hole_json(h.before)},
                             {"after", hole_json(h.after)}});
  json["attached"] = {{"elements", Json::object()},
                      {"connections", r.attached.connections},
                      {"max_rigid_error", r.attached.max_rigid_error},
                      {"worst_connection", r.attached.worst_connection},
                      {"moved_with_shells", r.attached.moved_with_shells},
                      {"inverted_solids", r.attached.inverted_solids}};
  for (const auto& [name, count] : r.attached.elements) json["attached"]["elements"][name] = count;
  json["quality"] = {{"before", quality_json(r.before)},
                     {"after", quality_json(r.after)},
                     {"inverted", r.inverted}};
  json["displacement"] = {{"largest", r.largest_displacement},
                          {"node", r.largest_displacement_node}};
  json["file_rounding"] = r.rounding;
  json["parameters"] = json_of(r.parameters);
  add_report_footer(json, r);
  return json;
}

}  // namespace

std::vector<FailedCheck> failed_checks(const DeformReport& report) {
  Json json = contents(report);
  std::vector<FailedCheck> failed_checks = replace_non_finite_numbers(json);
  const auto at_most = [&](const std::string& what, double value, double limit) {
    if (value > limit)
      failed_checks.push_back(
          {what, "is " + format_number(value) + ", expected at most " + format_number(limit)});
  };
  const auto limit = [&](double size) {
    const double rounding = 16 * std::numeric_limits<double>::epsilon() * report.largest_coordinate;
    return std::max(1e-12, size > 0 ? rounding / size : 0);
  };
  for (const auto& [name, e] : report.edits) {
    at_most("edits." + name + ".hard_residual", e.hard_residual, limit(report.size));
    at_most("edits." + name + ".last_correction", e.last_correction, 1e-9);
  }
  for (const auto& f : report.features)
    at_most("features." + f.name + ".max_rigid_error", f.max_rigid_error, limit(f.size));
  for (const auto& c : report.curves)
    at_most("curves." + c.name + ".max_residual", c.max_residual, limit(report.size));
  at_most("attached.max_rigid_error", report.attached.max_rigid_error,
          limit(report.size) * report.size);
  if (const auto& solids = report.attached.inverted_solids; !solids.empty())
    failed_checks.push_back(
        {"attached.inverted_solids", std::to_string(solids.size()) + " solids, the first is " +
                                         std::to_string(solids[0]) + ", expected none"});
  if (!report.inverted.empty())
    failed_checks.push_back(
        {"quality.inverted", std::to_string(report.inverted.size()) + " faces, the first is " +
                                 std::to_string(report.inverted[0]) + ", expected none"});
  return failed_checks;
}

std::string to_json(const DeformReport& report) { return report_text(contents(report), report); }

}  // namespace batten
