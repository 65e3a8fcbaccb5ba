#include "batten/io/report/report.h"

#include "batten/core/errors.h"
#include "batten/io/report/report_json.h"

namespace batten {
namespace {

using batten::json_of;

Json json_of(const SkinQuality& q) {
  return {{"area", q.area},
          {"max_line_residual", q.max_line_residual},
          {"max_line_gap", q.max_line_gap},
          {"max_line_deviation", q.max_line_deviation},
          {"max_normal_jump_deg", q.max_normal_jump_deg},
          {"min_jacobian_ratio", q.min_jacobian_ratio},
          {"max_shear", q.max_shear},
          {"rms_strain", q.rms_strain},
          {"singular_nodes", q.singular_nodes}};
}

Json json_of(const NetworkReport::Region& r) {
  Json json = {{"name", r.name},       {"loops", r.loops},
               {"inner", r.inner},     {"ring", r.annulus},
               {"asked", r.requested}, {"cost", r.cost},
               {"skinned", r.skinned}, {"plain_area", r.filling_area}};
  if (r.skinned) {
    json.update({{"triangles", r.triangles}, {"dofs", r.dofs}, {"size", r.size}});
    json["domain"] = r.domain;
    if (!r.shape.empty()) {
      json["shape"] = r.shape;
      json["shape_deviation"] = r.shape_deviation;
    }
    if (r.radius > 0) json["radius"] = r.radius;
    if (r.major_radius > 0) json["major_radius"] = r.major_radius;
    if (r.half_angle_deg > 0) json["half_angle_deg"] = r.half_angle_deg;
    json.update(json_of(r.quality));
  } else {
    json["why_not"] = r.rejection_reason;
  }
  json["flaws"] = r.defects;
  json["warnings"] = r.warnings;
  return json;
}

Json json_of(const NetworkReport::Join& j) {
  Json json = {{"line", j.line}, {"regions", j.regions}, {"kind", j.kind}, {"asked", j.requested}};
  if (j.regions.size() == 2) {
    json["first_deg"] = j.initial_deg;
    json["max_deg"] = j.max_deg;
    json["max_inside_deg"] = j.max_inside_deg;
    json["max_gap"] = j.max_gap;
  }
  if (j.kind == "smooth") {
    json["one_domain"] = j.one_domain;
    json["open_ends"] = j.open;
    json["curvature"] = j.curvature;
    json["median_curvature_jump"] = j.median_curvature_jump;
    json["max_curvature_jump"] = j.max_curvature_jump;
  }
  if (!j.why.empty()) json["why"] = j.why;
  return json;
}

/// Writes the keys network, regions, joins, choices, shells, left_over, optimal.
void add_network(Json& json, const NetworkReport& n) {
  Json diagnostics = Json::array();
  for (const NetworkDiagnostic& f : n.diagnostics)
    diagnostics.push_back({{"kind", word(f.kind)},
                           {"lines", f.lines},
                           {"where", json_of(f.where)},
                           {"distance", f.distance},
                           {"repaired", f.repaired},
                           {"text", f.text}});
  json["network"] = {{"lines", n.lines},         {"arcs", n.edges},
                     {"nodes", n.nodes},         {"size", n.size},
                     {"tolerance", n.tolerance}, {"usual_share", n.joined_fraction},
                     {"findings", diagnostics}};
  const auto list = [&](const char* key, const auto& items, const auto& one) {
    json[key] = Json::array();
    for (const auto& item : items) json[key].push_back(one(item));
  };
  list("regions", n.regions, [](const NetworkReport::Region& r) { return json_of(r); });
  list("joins", n.joins, [](const NetworkReport::Join& j) { return json_of(j); });
  list("choices", n.ambiguous_regions, [](const NetworkReport::Choice& c) {
    return Json{{"text", c.text},     {"where", json_of(c.where)},      {"lines", c.lines},
                {"chosen", c.chosen}, {"alternatives", c.alternatives}, {"margins", c.margins}};
  });
  list("shells", n.shells, [](const NetworkReport::Shell& s) {
    return Json{{"regions", s.regions}, {"closed", s.closed}, {"orientable", s.orientable},
                {"area", s.area},       {"volume", s.volume}, {"normals", s.normals}};
  });
  json["left_over"] = {{"rims", n.free_edges}, {"bare", n.unused_edges}};
  json["optimal"] = n.optimal;
}

Json json_of(const std::vector<DefectReport>& defects) {
  Json json = Json::array();
  for (const DefectReport& f : defects)
    json.push_back({{"kind", f.kind},
                    {"regions", f.regions},
                    {"where", json_of(f.where)},
                    {"value", f.value},
                    {"text", f.text}});
  return json;
}

const char* word(CharacterLine::Role role) {
  using Role = CharacterLine::Role;
  return role == Role::Inner ? "inner" : role == Role::Hole ? "hole" : "outline";
}

Json json_of(const Report::Shape& s) {
  return {{"stretching_energy", s.stretching},
          {"bending_energy", s.bending},
          {"area", s.area},
          {"volume", s.volume},
          {"residual", s.residual}};
}

Json json_of(const Report::Sculpting& s) {
  Json json = json_of(s.shape);
  json["answers"] = Json::array();
  for (const auto& a : s.solves)
    json["answers"].push_back({{"what", a.what},
                               {"iterations", a.iterations},
                               {"change", a.change},
                               {"factored", a.factored}});
  for (const auto& r : s.refinements)
    json["refinements"].push_back({{"triangles_before", r.triangles_before},
                                   {"triangles", r.triangles},
                                   {"max_displacement", r.max_displacement},
                                   {"energy_before", r.energy_before},
                                   {"energy_carried", r.energy_transferred},
                                   {"energy_settled", r.energy_at_equilibrium}});
  for (const auto& sweep : s.sweeps) {
    Json rows = Json::array();
    for (const auto& row : sweep.rows) {
      rows.push_back({{"value", row.value}, {"iterations", row.iterations}});
      rows.back().update(json_of(row.shape));
      if (row.stress) {
        rows.back()["max_displacement"] = row.stress->displacement;
        rows.back()["max_von_mises"] = row.stress->von_mises;
      }
    }
    json["sweeps"].push_back({{"parameter", sweep.parameter}, {"rows", rows}});
    if (!sweep.stopped.empty()) json["sweeps"].back()["stopped"] = sweep.stopped;
  }
  if (s.motion) {
    Json rows = Json::array();
    for (const auto& row : s.motion->rows) {
      rows.push_back({{"time", row.value}, {"total_energy", row.total_energy}});
      rows.back().update(json_of(row.shape));
    }
    json["motion"] = {{"dt", s.motion->dt},
                      {"density", s.motion->density},
                      {"damping", s.motion->damping},
                      {"theta", s.motion->theta},
                      {"steps", s.motion->steps},
                      {"max_residual", s.motion->max_residual},
                      {"rows", rows}};
  }
  return json;
}

Json json_of(const std::vector<Report::Line>& lines) {
  double max_deviation = 0;
  Json each = Json::array();
  for (const auto& line : lines) {
    // Written so that NaN replaces any number and appears in the report.
    if (line.constrains_surface && !(line.deviation <= max_deviation))
      max_deviation = line.deviation;
    each.push_back({{"name", line.name},
                    {"role", word(line.role)},
                    {"treatment", line.embedded ? "embedded" : "fitted"},
                    {"length", line.length},
                    {"deviation", line.deviation},
                    {"nodes", line.nodes}});
    if (line.embedded) {
      each.back()["points"] = line.points;
      each.back()["gap"] = line.gap;
      each.back()["holds"] = line.constrains_surface;
    }
  }
  return {{"count", lines.size()}, {"max_deviation", max_deviation}, {"each", each}};
}

Json json_of(const Report::Surface& s) {
  const SkinQuality& q = s.quality;
  Json json = {{"regions", s.regions},
               {"triangles", s.triangles},
               {"dofs", s.dofs},
               {"element", s.element},
               {"hold", s.boundary},
               {"fair", s.fair},
               {"size", s.size},
               {"area", q.area},
               {"bending_energy", s.bending_energy},
               {"max_line_residual", q.max_line_residual},
               {"max_line_gap", q.max_line_gap},
               {"max_line_deviation", q.max_line_deviation},
               {"max_constraint_residual", s.max_constraint_residual},
               {"max_normal_constraint_deg", s.max_normal_constraint_deg},
               {"max_normal_jump_deg", q.max_normal_jump_deg},
               {"max_smooth_join_deg", s.max_smooth_join_deg},
               {"min_jacobian_ratio", q.min_jacobian_ratio},
               {"max_shear", q.max_shear},
               {"rms_strain", q.rms_strain},
               {"singular_nodes", q.singular_nodes},
               {"iterations", s.iterations},
               {"last_change", s.last_change},
               {"normals", s.normals},
               {"mean_normal", {s.mean_normal.x(), s.mean_normal.y(), s.mean_normal.z()}},
               {"moved", s.moved}};
  if (s.fairing)
    json["fairing"] = {{"functional", s.fairing->functional},
                       {"start_functional", s.fairing->start_functional},
                       {"max_move", s.fairing->max_move},
                       {"iterations", s.fairing->iterations},
                       {"factorizations", s.fairing->factorizations},
                       {"converged", s.fairing->converged},
                       {"share", s.fairing->step_fraction},
                       {"kept", s.fairing->unchanged_regions},
                       {"asked", s.fairing->requested},
                       {"regions", s.fairing->regions}};
  return json;
}

Json json_of(const Report::Target& t) {
  Json json = {{"files", t.files},
               {"tolerance", t.tolerance},
               {"reached", t.reached},
               {"before", {{"rms", t.before_rms}, {"max", t.before_max}}},
               {"to_target",
                {{"rms", t.rms},
                 {"max", t.max},
                 {"at", {t.where.x(), t.where.y(), t.where.z()}},
                 {"points", t.points},
                 {"beyond", t.excluded}}},
               {"from_target",
                {{"rms", t.back_rms},
                 {"max", t.back_max},
                 {"points", t.back_points},
                 {"beyond", t.back_excluded}}},
               {"rounds", t.iterations},
               {"halvings", t.refinements},
               {"off_lines", Json::array()},
               {"regions", Json::object()}};
  for (const auto& line : t.line_distances)
    json["off_lines"].push_back({{"line", line.name}, {"distance", line.distance}});
  for (const auto& [name, largest] : t.regions) json["regions"][name] = largest;
  return json;
}

Json json_of(const Report::Step& s, bool of_network) {
  Json json = {{"file", s.file},       {"form", s.form},
               {"bytes", s.bytes},     {"faces", s.faces},
               {"lines", s.lines},     {"max_deviation", s.max_deviation},
               {"max_gap", s.max_gap}, {"max_normal_jump_deg", s.max_normal_jump_deg},
               {"valid", s.valid}};
  if (s.form == "face") {
    json["tolerance"] = s.tolerance;
    json["poles"] = {s.poles_u, s.poles_v};
    json["faces_by_kind"] = s.faces_by_kind;
  }
  json["edges"] = {{"creases", s.creases},
                   {"tangent", s.tangent},
                   {"curvature", s.curvature},
                   {"max_smooth_deg", s.max_smooth_deg}};
  if (!s.joins.empty()) json["max_join_deg"] = s.max_join_deg;
  for (const auto& j : s.joins) {
    json["joins"].push_back({{"line", j.line},
                             {"regions", j.regions},
                             {"angle_deg", j.angle_deg},
                             {"surface_deg", j.surface_deg},
                             {"missed", j.exceeds_tolerance}});
    if (!j.why.empty()) json["joins"].back()["why"] = j.why;
  }
  if (of_network)
    json.update({{"shells", s.shells},
                 {"solids", s.solids},
                 {"free_edges", s.free_edges},
                 {"volume", s.volume}});
  return json;
}

Json json_of(const Report::Comparison& c) {
  return {{"file", c.file},
          {"points", c.points},
          {"max", c.max},
          {"rms", c.rms},
          {"max_relative", c.max_relative},
          {"rms_relative", c.rms_relative}};
}

Json json_of(const PointCloudDistances& s) {
  return {{"name", s.name},
          {"points", s.points},
          {"left_out", s.left_out},
          {"before_max", s.before_max},
          {"before_rms", s.before_rms},
          {"max", s.max},
          {"rms", s.rms}};
}

Json json_of(const StressReport::Case& c) {
  Json json = {{"name", c.name},
               {"combination", c.combination},
               {"force", json_of(c.force)},
               {"max_displacement", c.displacement},
               {"displacement", json_of(c.displacement_vector)},
               {"displacement_at", json_of(c.max_displacement_at)},
               {"displacement_region", c.max_displacement_region},
               {"max_von_mises", c.stress},
               {"stress_at", json_of(c.max_stress_at)},
               {"stress_region", c.max_stress_region},
               {"stress_side", c.side},
               {"stress_spread", c.spread},
               {"stress_at_a_point", c.near_singularity},
               {"strain_energy", c.energy},
               {"error_estimate", c.error},
               {"max_displacement_error", c.displacement_error},
               {"balance", c.equilibrium_residual}};
  if (c.safety > 0) json["safety"] = c.safety;
  if (c.buckling_requested) json["buckling_factors"] = c.buckling;
  if (c.calculix)
    json["calculix"] = {{"elements", c.calculix->elements},
                        {"max_displacement", c.calculix->displacement},
                        {"max_von_mises", c.calculix->stress},
                        {"displacement_there", c.calculix->displacement_there},
                        {"von_mises_there", c.calculix->stress_there}};
  json["reactions"] = Json::array();
  for (const auto& r : c.reactions)
    json["reactions"].push_back(
        {{"support", r.support}, {"force", json_of(r.force)}, {"moment", json_of(r.moment)}});
  return json;
}

Json json_of(const StressReport& s) {
  Json json = {{"unknowns", s.unknowns},
               {"thickness_over_radius", s.thickness_over_radius},
               {"edge_over_bend", s.edge_over_boundary_layer}};
  if (!s.material.empty()) json["material"] = s.material;
  if (s.yield > 0) json["yield"] = s.yield;
  json["cases"] = Json::array();
  for (const auto& c : s.cases) json["cases"].push_back(json_of(c));
  for (const auto& m : s.meshes)
    json["meshes"].push_back({{"edge_length", m.edge_length},
                              {"unknowns", m.unknowns},
                              {"max_displacement", m.displacement},
                              {"max_von_mises", m.stress},
                              {"displacement_error", m.error}});
  for (const auto& d : s.sensitivities)
    json["sensitivities"].push_back({{"parameter", d.parameter},
                                     {"case", d.load_case},
                                     {"max_displacement", d.displacement},
                                     {"compliance", d.compliance}});
  if (!s.frequencies.empty()) json["frequencies"] = s.frequencies;
  return json;
}

Json contents(const Report& r) {
  Json json = report_header(r);
  json["lines"] = json_of(r.lines);
  if (!r.curves.empty()) json["curves"] = json_of(r.curves);
  if (!r.reading_notes.empty()) json["lines_read"] = r.reading_notes;
  json["surface"] = json_of(r.surface);
  json["flaws"] = json_of(r.defects);
  if (r.network) add_network(json, *r.network);
  if (r.step) json["step"] = json_of(*r.step, r.network.has_value());
  if (r.comparison) json["comparison"] = json_of(*r.comparison);
  if (r.target) json["target"] = json_of(*r.target);
  for (const auto& scan : r.scans) json["scans"].push_back(json_of(scan));
  if (r.sculpting) json["sculpting"] = json_of(*r.sculpting);
  if (r.stress) json["stress"] = json_of(*r.stress);
  json["parameters"] = json_of(r.parameters);
  json["reactions"] = Json::array();
  for (const auto& reaction : r.reactions)
    json["reactions"].push_back({{"name", reaction.name}, {"force", json_of(reaction.force)}});
  add_report_footer(json, r);
  return json;
}

}  // namespace

std::vector<FailedCheck> non_finite_numbers(const Report& report) {
  Json json = contents(report);
  return replace_non_finite_numbers(json);
}

std::string to_json(const Report& report) { return report_text(contents(report), report); }

namespace {

Json contents(const FairReport& r) {
  Json json = report_header(r);
  json["curves"] = json_of(r.curves);
  json["parameters"] = json_of(r.parameters);
  add_report_footer(json, r);
  return json;
}

}  // namespace

Json json_of(const Fairness& f) {
  return {{"length", f.length},
          {"bending", f.bending},
          {"variation", f.variation},
          {"largest_curvature", f.largest_curvature},
          {"largest_jump", f.largest_jump},
          {"extrema", f.extrema},
          {"inflections", f.inflections}};
}

Json json_of(const std::vector<FairedLine>& curves) {
  Json list = Json::array();
  for (const FairedLine& c : curves) {
    Json outliers = Json::array();
    for (const int i : c.outliers) outliers.push_back(i + 1);
    list.push_back(
        {{"name", c.name},
         {"points", c.points},
         {"segments", c.segments},
         {"closed", c.closed},
         {"faired", c.faired},
         {"deviation",
          {{"max", c.deviation.max}, {"rms", c.deviation.rms}, {"between", c.deviation.between}}},
         {"noise", c.noise},
         {"outliers", outliers},
         {"wavelength", c.wavelength},
         {"freedom", c.effective_dofs},
         {"rounds", c.rounds},
         {"settled", c.converged},
         {"max_residual", c.max_residual},
         {"before", c.before ? json_of(*c.before) : Json()},
         {"after", c.after ? json_of(*c.after) : Json()},
         {"seconds", c.seconds}});
  }
  return list;
}

std::vector<FailedCheck> failed_fairing_checks(const std::vector<FairedLine>& curves) {
  std::vector<FailedCheck> failed_checks;
  for (const FairedLine& c : curves) {
    if (c.exceeded_deviation)
      failed_checks.push_back(
          {"curves." + c.name + ".deviation",
           "is " + format_number(c.exceeded_deviation->second) +
               " after the stage that states at most " +
               format_number(c.exceeded_deviation->first) +
               ": is there a corner that is not one, or a condition against it?"});
    if (c.max_residual > 1e-12)
      failed_checks.push_back({"curves." + c.name + ".max_residual",
                               "is " + format_number(c.max_residual) + ", promised at most 1e-12"});
  }
  return failed_checks;
}

std::vector<FailedCheck> failed_checks(const FairReport& report) {
  Json json = contents(report);
  std::vector<FailedCheck> failed_checks = replace_non_finite_numbers(json);
  const auto conditions = failed_fairing_checks(report.curves);
  failed_checks.insert(failed_checks.end(), conditions.begin(), conditions.end());
  return failed_checks;
}

std::string to_json(const FairReport& report) { return report_text(contents(report), report); }

}  // namespace batten
