#include "batten/io/report/network_report_json.h"

namespace batten {
namespace {

Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

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
  Json json = {{"name", r.name},       {"loops", r.loops},          {"inner", r.inner},
               {"ring", r.ring},       {"asked", r.asked},          {"cost", r.cost},
               {"skinned", r.skinned}, {"plain_area", r.plain_area}};
  if (r.skinned) {
    json.update({{"triangles", r.triangles}, {"dofs", r.dofs}, {"size", r.size}});
    json.update(json_of(r.quality));
  } else {
    json["why_not"] = r.why_not;
  }
  json["flaws"] = r.flaws;
  json["warnings"] = r.warnings;
  return json;
}

Json json_of(const NetworkReport::Join& j) {
  Json json = {{"line", j.line}, {"regions", j.regions}, {"kind", j.kind}, {"asked", j.asked}};
  if (j.regions.size() == 2) {
    json["first_deg"] = j.first_deg;
    json["max_deg"] = j.max_deg;
    json["max_inside_deg"] = j.max_inside_deg;
  }
  if (j.kind == "smooth") {
    json["one_domain"] = j.one_domain;
    json["open_ends"] = j.open;
  }
  if (!j.why.empty()) json["why"] = j.why;
  return json;
}

}  // namespace

void add_network(Json& json, const NetworkReport& n) {
  Json findings = Json::array();
  for (const NetworkFinding& f : n.findings)
    findings.push_back({{"kind", word(f.kind)},
                        {"lines", f.lines},
                        {"where", json_of(f.where)},
                        {"distance", f.distance},
                        {"repaired", f.repaired},
                        {"text", f.text}});
  json["network"] = {{"lines", n.lines}, {"arcs", n.arcs},           {"nodes", n.nodes},
                     {"size", n.size},   {"tolerance", n.tolerance}, {"findings", findings}};
  const auto list = [&](const char* key, const auto& items, const auto& one) {
    json[key] = Json::array();
    for (const auto& item : items) json[key].push_back(one(item));
  };
  list("regions", n.regions, [](const NetworkReport::Region& r) { return json_of(r); });
  list("joins", n.joins, [](const NetworkReport::Join& j) { return json_of(j); });
  list("choices", n.choices, [](const NetworkReport::Choice& c) {
    return Json{{"text", c.text},     {"where", json_of(c.where)},      {"lines", c.lines},
                {"chosen", c.chosen}, {"alternatives", c.alternatives}, {"margins", c.margins}};
  });
  list("shells", n.shells, [](const NetworkReport::Shell& s) {
    return Json{{"regions", s.regions},
                {"closed", s.closed},
                {"orientable", s.orientable},
                {"area", s.area},
                {"volume", s.volume}};
  });
  list("flaws", n.flaws, [](const NetworkReport::Flaw& f) {
    return Json{{"kind", f.kind},
                {"regions", f.regions},
                {"where", json_of(f.where)},
                {"value", f.value},
                {"text", f.text}};
  });
  json["left_over"] = {{"rims", n.rims}, {"bare", n.bare}};
  json["optimal"] = n.optimal;
}

}  // namespace batten
