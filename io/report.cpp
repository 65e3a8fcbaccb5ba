#include "batten/io/report.h"

#include <cmath>

#include "batten/io/report_json.h"

namespace batten {
namespace {

const char* word(CharacterLine::Role role) {
  using Role = CharacterLine::Role;
  return role == Role::Inner ? "inner" : role == Role::Hole ? "hole" : "outline";
}

Json contents(const Report& r) {
  Json json;
  json["name"] = r.name;
  json["unit"] = r.unit;

  double max_deviation = 0;
  Json each = Json::array();
  for (const auto& line : r.lines) {
    // A number that is not one must win over those that are.
    if (!(line.deviation <= max_deviation)) max_deviation = line.deviation;
    each.push_back({{"name", line.name},
                    {"role", word(line.role)},
                    {"treatment", line.embedded ? "embedded" : "fitted"},
                    {"length", line.length},
                    {"deviation", line.deviation},
                    {"nodes", line.nodes}});
    if (line.embedded) {
      each.back()["points"] = line.points;
      each.back()["gap"] = line.gap;
    }
  }
  json["lines"] = {{"count", r.lines.size()}, {"max_deviation", max_deviation}, {"each", each}};
  if (!r.curves.empty()) json["curves"] = json_of(r.curves);

  const auto& s = r.surface;
  const auto& q = s.quality;
  json["surface"] = {{"regions", s.regions},
                     {"triangles", s.triangles},
                     {"dofs", s.dofs},
                     {"element", s.element},
                     {"hold", s.hold},
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
                     {"load_steps", s.load_steps},
                     {"iterations", s.iterations},
                     {"last_change", s.last_change}};
  if (r.step)
    json["step"] = {{"file", r.step->file},
                    {"form", r.step->form},
                    {"bytes", r.step->bytes},
                    {"faces", r.step->faces},
                    {"max_deviation", r.step->max_deviation},
                    {"max_gap", r.step->max_gap},
                    {"max_normal_jump_deg", r.step->max_normal_jump_deg},
                    {"valid", r.step->valid}};
  if (r.step && r.step->form == "face") {
    json["step"]["tolerance"] = r.step->tolerance;
    json["step"]["poles"] = {r.step->poles_u, r.step->poles_v};
  }

  if (r.comparison)
    json["comparison"] = {{"file", r.comparison->file},
                          {"points", r.comparison->points},
                          {"max", r.comparison->max},
                          {"rms", r.comparison->rms},
                          {"max_relative", r.comparison->max_relative},
                          {"rms_relative", r.comparison->rms_relative}};

  for (const auto& springs : r.springs)
    json["springs"].push_back({{"name", springs.name},
                               {"points", springs.points},
                               {"left_out", springs.left_out},
                               {"before_max", springs.before_max},
                               {"before_rms", springs.before_rms},
                               {"max", springs.max},
                               {"rms", springs.rms}});
  json["parameters"] = json_of(r.parameters);
  json["reactions"] = Json::array();
  for (const auto& reaction : r.reactions)
    json["reactions"].push_back(
        {{"name", reaction.name},
         {"force", {reaction.force[0], reaction.force[1], reaction.force[2]}}});
  add_ending(json, r);
  return json;
}

}  // namespace

std::vector<MissedPromise> numbers_that_failed(const Report& report) {
  Json json = contents(report);
  std::vector<MissedPromise> failed;
  name_failed_numbers(json, "", failed);
  return failed;
}

std::string to_json(const Report& report) { return report_text(contents(report), report.missed); }

}  // namespace batten
