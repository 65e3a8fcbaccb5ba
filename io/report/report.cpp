// SPDX-License-Identifier: MPL-2.0
#include "batten/io/report/report.h"

#include "batten/core/errors.h"
#include "batten/io/report/report_json.h"

namespace batten {
namespace {

using batten::json_of;

Json json_of(const SkinQuality& q) {
  return {{"area", q.area},
          {"max_curve_residual", q.max_line_residual},
          {"max_curve_gap", q.max_line_gap},
          {"max_curve_deviation", q.max_line_deviation},
          {"max_normal_jump_deg", q.max_normal_jump_deg},
          {"min_jacobian_ratio", q.min_jacobian_ratio},
          {"max_shear", q.max_shear},
          {"rms_strain", q.rms_strain},
          {"singular_nodes", q.singular_nodes}};
}

Json json_of(const NetworkReport::Region& r) {
  Json json = {{"name", r.name},           {"loops", r.loops},
               {"inner", r.inner},         {"annulus", r.annulus},
               {"requested", r.requested}, {"cost", r.cost},
               {"skinned", r.skinned},     {"hole_filling_area", r.filling_area}};
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
    json["rejection_reason"] = r.rejection_reason;
  }
  json["defects"] = r.defects;
  json["warnings"] = r.warnings;
  return json;
}

Json json_of(const NetworkReport::Join& j) {
  Json json = {
      {"edge", j.line}, {"faces", j.regions}, {"continuity", j.kind}, {"requested", j.requested}};
  if (!j.neighbours.empty()) json["neighbours"] = j.neighbours;
  if (j.regions.size() == 2 || !j.neighbours.empty()) {
    json["mean_deg"] = j.mean_deg;
    json["initial_deg"] = j.initial_deg;
    json["max_deg"] = j.max_deg;
    json["max_inside_deg"] = j.max_inside_deg;
    json["max_gap"] = j.max_gap;
  }
  if (j.kind == "smooth") {
    json["one_domain"] = j.one_domain;
    json["open_ends"] = j.open;
    json["curvature_continuous"] = j.curvature;
    json["median_curvature_jump"] = j.median_curvature_jump;
    json["max_curvature_jump"] = j.max_curvature_jump;
  }
  if (!j.why.empty()) json["reason"] = j.why;
  return json;
}

/// Writes the keys network, faces, joins, ambiguous_faces, shells, left_over, optimal.
void add_network(Json& json, const NetworkReport& n) {
  Json diagnostics = Json::array();
  for (const NetworkDiagnostic& f : n.diagnostics)
    diagnostics.push_back({{"kind", to_text(f.kind)},
                           {"curves", f.lines},
                           {"at", json_of(f.where)},
                           {"distance", f.distance},
                           {"repaired", f.repaired},
                           {"text", f.text}});
  json["network"] = {{"curves", n.lines},
                     {"edges", n.edges},
                     {"nodes", n.nodes},
                     {"added_curves", n.added_curves},
                     {"size", n.size},
                     {"gap_tolerance", n.tolerance},
                     {"joined_fraction", n.joined_fraction},
                     {"diagnostics", diagnostics}};
  const auto list = [&](const char* key, const auto& items, const auto& one) {
    json[key] = Json::array();
    for (const auto& item : items) json[key].push_back(one(item));
  };
  list("faces", n.regions, [](const NetworkReport::Region& r) { return json_of(r); });
  list("joins", n.joins, [](const NetworkReport::Join& j) { return json_of(j); });
  list("ambiguous_faces", n.ambiguous_regions, [](const NetworkReport::Choice& c) {
    return Json{{"text", c.text},     {"at", json_of(c.where)},         {"edges", c.lines},
                {"chosen", c.chosen}, {"alternatives", c.alternatives}, {"margins", c.margins}};
  });
  list("shells", n.shells, [](const NetworkReport::Shell& s) {
    return Json{{"faces", s.regions}, {"closed", s.closed}, {"orientable", s.orientable},
                {"area", s.area},     {"volume", s.volume}, {"normals", s.normals}};
  });
  json["left_over"] = {{"free_edges", n.free_edges}, {"unused_edges", n.unused_edges}};
  json["optimal"] = n.optimal;
}

Json json_of(const std::vector<DefectReport>& defects) {
  Json json = Json::array();
  for (const DefectReport& f : defects)
    json.push_back({{"kind", f.kind},
                    {"faces", f.regions},
                    {"at", json_of(f.where)},
                    {"value", f.value},
                    {"text", f.text}});
  return json;
}

const char* to_text(CharacterLine::Role role) {
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
  json["updates"] = Json::array();
  for (const auto& a : s.solves)
    json["updates"].push_back({{"operation", a.what},
                               {"iterations", a.iterations},
                               {"change", a.change},
                               {"factored", a.factored}});
  for (const auto& r : s.refinements)
    json["refinements"].push_back({{"triangles_before", r.triangles_before},
                                   {"triangles", r.triangles},
                                   {"max_displacement", r.max_displacement},
                                   {"energy_before", r.energy_before},
                                   {"energy_transferred", r.energy_transferred},
                                   {"energy_at_equilibrium", r.energy_at_equilibrium}});
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
                    {"role", to_text(line.role)},
                    {"alignment", line.embedded ? "embedded" : "aligned"},
                    {"length", line.length},
                    {"deviation", line.deviation},
                    {"nodes", line.nodes}});
    if (line.embedded) {
      each.back()["points"] = line.points;
      each.back()["gap"] = line.gap;
      each.back()["trim_only"] = !line.constrains_surface;
    }
  }
  return {{"count", lines.size()}, {"max_deviation", max_deviation}, {"each", each}};
}

Json json_of(const Report::Surface& s) {
  const SkinQuality& q = s.quality;
  Json json = {{"faces", s.regions},
               {"triangles", s.triangles},
               {"dofs", s.dofs},
               {"element", s.element},
               {"boundary", s.boundary},
               {"fair", s.fair},
               {"size", s.size},
               {"area", q.area},
               {"bending_energy", s.bending_energy},
               {"max_curve_residual", q.max_line_residual},
               {"max_curve_gap", q.max_line_gap},
               {"max_curve_deviation", q.max_line_deviation},
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
               {"max_displacement", s.moved}};
  if (s.fairing)
    json["fairing"] = {{"functional", s.fairing->functional},
                       {"start_functional", s.fairing->start_functional},
                       {"max_displacement", s.fairing->max_move},
                       {"iterations", s.fairing->iterations},
                       {"factorizations", s.fairing->factorizations},
                       {"converged", s.fairing->converged},
                       {"step_fraction", s.fairing->step_fraction},
                       {"unchanged_faces", s.fairing->unchanged_regions},
                       {"requested", s.fairing->requested},
                       {"faces", s.fairing->regions}};
  return json;
}

Json json_of(const Report::Target& t) {
  Json json = {{"files", t.files},
               {"fit_tolerance", t.tolerance},
               {"reached", t.reached},
               {"before", {{"rms", t.before_rms}, {"max", t.before_max}}},
               {"to_target",
                {{"rms", t.rms},
                 {"max", t.max},
                 {"at", {t.where.x(), t.where.y(), t.where.z()}},
                 {"points", t.points},
                 {"excluded", t.excluded}}},
               {"from_target",
                {{"rms", t.back_rms},
                 {"max", t.back_max},
                 {"points", t.back_points},
                 {"excluded", t.back_excluded}}},
               {"iterations", t.iterations},
               {"refinements", t.refinements},
               {"distant_curves", Json::array()},
               {"faces", Json::object()}};
  for (const auto& line : t.line_distances)
    json["distant_curves"].push_back({{"curve", line.name}, {"distance", line.distance}});
  for (const auto& [name, largest] : t.regions) json["faces"][name] = largest;
  return json;
}

Json json_of(const Report::Step& s, bool of_network) {
  Json json = {{"file", s.file},       {"form", s.form},
               {"bytes", s.bytes},     {"faces", s.faces},
               {"curves", s.lines},    {"max_deviation", s.max_deviation},
               {"max_gap", s.max_gap}, {"max_normal_jump_deg", s.max_normal_jump_deg},
               {"valid", s.valid}};
  if (s.form == "face") {
    json["tolerance"] = s.tolerance;
    json["poles"] = {s.poles_u, s.poles_v};
    json["faces_by_kind"] = s.faces_by_kind;
  }
  if (!s.source.empty()) json["source"] = s.source;
  if (s.neighbours)
    json["neighbours"] = {
        {"file", s.neighbours->file},       {"faces", s.neighbours->faces},
        {"edges", s.neighbours->edges},     {"smooth_edges", s.neighbours->smooth_edges},
        {"max_gap", s.neighbours->max_gap}, {"max_smooth_deg", s.neighbours->max_smooth_deg}};
  json["edges"] = {{"G0", s.creases},
                   {"G1", s.tangent},
                   {"G2", s.curvature},
                   {"max_smooth_deg", s.max_smooth_deg}};
  if (!s.joins.empty()) json["max_join_deg"] = s.max_join_deg;
  for (const auto& j : s.joins) {
    json["joins"].push_back({{"edge", j.line},
                             {"faces", j.regions},
                             {"angle_deg", j.angle_deg},
                             {"surface_deg", j.surface_deg},
                             {"exceeds_tolerance", j.exceeds_tolerance}});
    if (!j.why.empty()) json["joins"].back()["reason"] = j.why;
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
          {"excluded", s.left_out},
          {"before_max", s.before_max},
          {"before_rms", s.before_rms},
          {"max", s.max},
          {"rms", s.rms}};
}

Json json_of(const StressReport::Case::Result::Range& range) {
  return {{"min", range.least}, {"mean", range.mean}, {"max", range.largest}};
}

Json json_of(const StressReport::Case::Result& r) {
  Json json = {{"name", r.name}, {"kind", r.kind}};
  if (!r.point) {
    json[r.kind == "curve" ? "length" : "area"] = r.size;
    json["displacement"] = json_of(r.displacement);
    json["von_mises"] = json_of(r.von_mises);
    return json;
  }
  const auto tensor = [](const Mat3& s) {
    return Json{s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2)};
  };
  json["at"] = json_of(r.point->at);
  json["face"] = r.point->face;
  json["displacement_vector"] = json_of(r.point->displacement);
  json["von_mises_top_middle_bottom"] = r.point->von_mises;
  json["principal_top_middle_bottom"] = r.point->principal;
  for (const Vec3& d : r.point->principal_directions)
    json["principal_directions_top_middle_bottom"].push_back(json_of(d));
  json["von_mises_membrane"] = r.point->membrane;
  json["von_mises_bending"] = r.point->bending;
  if (!r.point->hoop.empty()) {
    json["hoop_top_middle_bottom"] = r.point->hoop;
    json["meridional_top_middle_bottom"] = r.point->meridional;
    json["shear_top_middle_bottom"] = r.point->shear;
  }
  json["forces"] = tensor(r.point->forces);
  json["moments"] = tensor(r.point->moments);
  return json;
}

Json json_of(const StressReport::Case::StiffenerValues& s) {
  return {{"name", s.name},
          {"max_stress", s.stress},
          {"stress_at", json_of(s.at)},
          {"axial_force", s.axial},
          {"bending_moment", s.bending},
          {"lateral_bending_moment", s.lateral_bending},
          {"torque", s.torque}};
}

Json json_of(const StressReport::Case& c) {
  Json json = {{"name", c.name},
               {"combination", c.combination},
               {"force", json_of(c.force)},
               {"max_displacement", c.displacement},
               {"displacement", json_of(c.displacement_vector)},
               {"displacement_at", json_of(c.max_displacement_at)},
               {"displacement_face", c.max_displacement_region},
               {"max_von_mises", c.stress},
               {"stress_at", json_of(c.max_stress_at)},
               {"stress_face", c.max_stress_region},
               {"stress_side", c.side},
               {"stress_spread", c.spread},
               {"near_singularity", c.near_singularity},
               {"singular_places", Json::array()},
               {"strain_energy", c.energy},
               {"error_estimate", c.error},
               {"max_displacement_error", c.displacement_error},
               {"equilibrium_residual", c.equilibrium_residual},
               {"nonlinearity", c.nonlinearity},
               {"shear_energy_share", c.shear_share}};
  for (const auto& place : c.singular_places)
    json["singular_places"].push_back({{"at", json_of(place.at)}, {"radius", place.radius}});
  if (c.safety > 0) json["safety_factor"] = c.safety;
  if (c.ply > 0) json["stress_ply"] = c.ply;
  for (const auto& r : c.reserves)
    json["reserve_factors"].push_back({{"criterion", r.criterion},
                                       {"factor", r.factor},
                                       {"ply", r.ply},
                                       {"at", json_of(r.at)},
                                       {"face", r.region}});
  for (const auto& r : c.results) json["results"].push_back(json_of(r));
  for (const auto& v : c.vibrations)
    json["harmonic"].push_back(
        {{"point", v.point}, {"frequency", v.frequency}, {"amplitude", v.amplitude}});
  for (const auto& s : c.stiffeners) json["stiffeners"].push_back(json_of(s));
  if (c.buckling_requested) json["buckling_factors"] = c.buckling;
  if (c.calculix)
    json["calculix"] = {{"elements", c.calculix->elements},
                        {"max_displacement", c.calculix->displacement},
                        {"max_von_mises", c.calculix->stress},
                        {"displacement_at_same_point", c.calculix->displacement_there},
                        {"von_mises_at_same_point", c.calculix->stress_there}};
  if (c.calculix && !c.calculix->buckling.empty())
    json["calculix"]["buckling_factors"] = c.calculix->buckling;
  json["reactions"] = Json::array();
  for (const auto& r : c.reactions)
    json["reactions"].push_back(
        {{"support", r.support}, {"force", json_of(r.force)}, {"moment", json_of(r.moment)}});
  return json;
}

Json json_of(const StressReport::Spectrum& s) {
  Json json = {{"modes", s.modes},
               {"mass_fraction", s.mass_fraction},
               {"max_displacement", s.displacement},
               {"displacement_at", json_of(s.displacement_at)},
               {"displacement_face", s.displacement_region},
               {"max_von_mises", s.stress},
               {"stress_at", json_of(s.stress_at)},
               {"stress_face", s.stress_region}};
  for (const auto& point : s.points)
    json["points"].push_back({{"name", point.name},
                              {"displacement", json_of(point.displacement)},
                              {"von_mises", point.von_mises}});
  json["reactions"] = Json::array();
  for (const auto& r : s.reactions)
    json["reactions"].push_back(
        {{"support", r.support}, {"force", json_of(r.force)}, {"moment", json_of(r.moment)}});
  return json;
}

Json json_of(const StressReport& s) {
  Json json = {{"unknowns", s.unknowns},
               {"thickness_over_radius", s.thickness_over_radius},
               {"edge_over_boundary_layer", s.edge_over_boundary_layer}};
  if (!s.material.empty()) json["material"] = s.material;
  if (s.yield > 0) json["yield"] = s.yield;
  json["cases"] = Json::array();
  for (const auto& c : s.cases) json["cases"].push_back(json_of(c));
  for (const auto& m : s.meshes)
    json["meshes"].push_back({{"edge_length", m.edge_length},
                              {"unknowns", m.unknowns},
                              {"max_displacement", m.displacement},
                              {"max_von_mises", m.stress},
                              {"displacement_error", m.error},
                              {"stress_error", m.stress_error}});
  for (const auto& d : s.sensitivities)
    json["sensitivities"].push_back({{"parameter", d.parameter},
                                     {"case", d.load_case},
                                     {"max_displacement", d.displacement},
                                     {"compliance", d.compliance}});
  if (s.spectrum) json["spectrum"] = json_of(*s.spectrum);
  if (s.frequencies.empty()) return json;
  json["frequencies"] = s.frequencies;
  if (!s.calculix_frequencies.empty()) json["calculix_frequencies"] = s.calculix_frequencies;
  json["mass"] = s.mass;
  for (const Vec3& factor : s.participation) {
    json["participation_factors"].push_back(json_of(factor));
    json["effective_masses"].push_back(json_of(factor.cwiseAbs2()));
  }
  return json;
}

Json contents(const Report& r) {
  Json json = report_header(r);
  json["curves"] = json_of(r.lines);
  if (!r.curves.empty()) json["faired_curves"] = json_of(r.curves);
  if (!r.reading_notes.empty()) json["curves_read"] = r.reading_notes;
  json["surface"] = json_of(r.surface);
  json["defects"] = json_of(r.defects);
  if (r.network) add_network(json, *r.network);
  if (r.mesh)
    json["mesh"] = {{"file", r.mesh->file},
                    {"faces", r.mesh->faces},
                    {"given_faces", r.mesh->given_faces},
                    {"joined_openings", r.mesh->joined_loops},
                    {"free_edges", r.mesh->free_edges}};
  if (r.step) json["step"] = json_of(*r.step, r.network.has_value());
  if (r.comparison) json["comparison"] = json_of(*r.comparison);
  if (r.target) json["target"] = json_of(*r.target);
  for (const auto& scan : r.scans) json["point_clouds"].push_back(json_of(scan));
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

std::vector<FailedCheck> non_finite_numbers(const StressReport& stress) {
  Json json = {{"stress", json_of(stress)}};
  return replace_non_finite_numbers(json);
}

namespace {

// Amount by which loads and moves may increase the angle of a smooth join, which is reduced below
// its tolerance in the unloaded shape.
constexpr double kSculptedJoinDeg = 0.05;

class AcceptanceChecks {
 public:
  explicit AcceptanceChecks(const Report& report) : failed_checks(non_finite_numbers(report)) {}
  void require_at_most(const std::string& what, double value, double limit) {
    if (value > limit)
      failed_checks.push_back(
          {what, "is " + format_number(value) + ", expected at most " + format_number(limit)});
  }
  void surface(const std::string& at, const SkinQuality& q, bool lines, double on_line,
               double on_input) {
    if (lines) {
      require_at_most(at + ".max_curve_residual", q.max_line_residual, 1e-10);
      require_at_most(at + ".max_curve_gap", q.max_line_gap, on_line);
      require_at_most(at + ".max_curve_deviation", q.max_line_deviation, on_input);
    }
    require_at_most(at + ".max_normal_jump_deg", q.max_normal_jump_deg, 1e-3);
    if (q.min_jacobian_ratio < 0.05)
      failed_checks.push_back(
          {at + ".min_jacobian_ratio",
           "is " + format_number(q.min_jacobian_ratio) + ", expected at least 0.05"});
    require_at_most(at + ".singular_nodes", q.singular_nodes, 0);
  }
  void network(const NetworkReport& n, bool lines, bool sculpted, double on_input) {
    for (const auto& r : n.regions) {
      if (r.skinned)
        surface("faces." + r.name, r.quality, lines, n.fit_tolerance, on_input);
      else
        failed_checks.push_back({"faces." + r.name, "has no surface: " + r.rejection_reason});
    }
    for (const auto& j : n.joins) {
      const std::string at = "joins." + j.line;
      if (j.kind == "smooth")
        require_at_most(at + ".max_inside_deg", j.max_inside_deg,
                        n.join_tolerance_deg + (sculpted ? kSculptedJoinDeg : 0));
      // Beside given faces, edges are smooth unless they meet at a large angle.
      const bool expected_smooth = j.requested || !j.neighbours.empty();
      if (j.kind != "smooth" && expected_smooth && !j.why.empty())
        failed_checks.push_back(
            {at, "is " + std::string(j.kind == "free edge" ? "a free edge" : j.kind) +
                     ", expected a smooth edge: " + j.why});
    }
  }
  void defects(const std::vector<DefectReport>& defects) {
    for (const auto& defect : defects) {
      std::string where;
      for (const auto& region : defect.regions) where += (where.empty() ? "" : ", ") + region;
      failed_checks.push_back({"defects." + defect.kind + " in " + where, defect.text});
    }
  }
  void step(const Report& report, bool lines, double on_line) {
    const auto& step = *report.step;
    if (!step.valid) failed_checks.push_back({"step.valid", "is false, expected true"});
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
  const bool lines = s.boundary == "curves";
  // Network lines may have moved when they were joined.
  const double on_input = tolerance + (report.network ? report.network->tolerance : 0);
  for (const FailedCheck& m : failed_fairing_checks(report.curves))
    checks.failed_checks.push_back(m);
  for (const auto& line : report.lines)
    if (line.constrains_surface)
      checks.require_at_most("curves." + line.name + ".deviation", line.deviation, on_input);
  checks.require_at_most("surface.max_constraint_residual", s.max_constraint_residual, 1e-10);
  checks.require_at_most("surface.max_normal_constraint_deg", s.max_normal_constraint_deg, 1e-6);
  if (report.network)
    checks.network(*report.network, lines, report.is_sculpted, on_input);
  else
    checks.surface("surface", s.quality, lines, tolerance, on_input);
  checks.defects(report.defects);
  if (s.fairing && s.fairing->requested && !s.fairing->converged)
    checks.failed_checks.push_back({"surface.fairing.converged", "is false, expected true"});
  if (report.step) checks.step(report, lines, tolerance);
  return checks.failed_checks;
}

std::string to_json(const Report& report) { return report_text(contents(report), report); }

std::string to_json(const StressReport& stress) {
  Json json = json_of(stress);
  replace_non_finite_numbers(json);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

namespace {

Json contents(const FairReport& r) {
  Json json = report_header(r);
  json["faired_curves"] = json_of(r.curves);
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
         {"effective_dofs", c.effective_dofs},
         {"iterations", c.rounds},
         {"converged", c.converged},
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
          {"faired_curves." + c.name + ".deviation",
           "is " + format_number(c.exceeded_deviation->second) +
               " after its stage, expected at most " + format_number(c.exceeded_deviation->first) +
               ": check for a false corner, or for a condition that prevents it"});
    if (c.exceeded_movement)
      failed_checks.push_back(
          {"faired_curves." + c.name + ".deviation",
           "is " + format_number(c.exceeded_movement->second) +
               " (RMS) after its stage, expected at most " +
               format_number(c.exceeded_movement->first) +
               ", twice the noise of the points: state a deviation or a noise"});
    if (c.max_residual > 1e-12)
      failed_checks.push_back({"faired_curves." + c.name + ".max_residual",
                               "is " + format_number(c.max_residual) + ", expected at most 1e-12"});
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
