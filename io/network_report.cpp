#include "batten/io/network_report.h"

#include <algorithm>

#include "batten/io/network_report_json.h"

namespace batten {
namespace {

const char* word(ModelJoin::Kind kind) {
  using Kind = ModelJoin::Kind;
  return kind == Kind::Rim      ? "rim"
         : kind == Kind::Crease ? "crease"
         : kind == Kind::Smooth ? "smooth"
                                : "branching";
}

const char* word(SurfaceFlaw::Kind kind) {
  using Kind = SurfaceFlaw::Kind;
  return kind == Kind::Jacobian   ? "jacobian"
         : kind == Kind::Fold     ? "fold"
         : kind == Kind::Crossing ? "crossing"
                                  : "area";
}

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

const char* word(NetworkFinding::Kind kind) {
  using Kind = NetworkFinding::Kind;
  switch (kind) {
    case Kind::EndsJoined:
      return "ends joined";
    case Kind::EndOnLine:
      return "end on line";
    case Kind::Crossing:
      return "crossing";
    case Kind::SelfCrossing:
      return "self-crossing";
    case Kind::Duplicate:
      return "duplicate";
    case Kind::Overlap:
      return "overlap";
    case Kind::NearMiss:
      return "near miss";
    case Kind::Dangling:
      return "dangling end";
    case Kind::Short:
      return "short line";
    case Kind::Apart:
      return "apart";
  }
  return "";
}

NetworkReport network_report(const CharacterLineNetwork& network, const FoundRegions& found,
                             const SurfaceModel& model, double fit_tolerance,
                             double join_tolerance_deg) {
  NetworkReport report;
  const auto arc = [&](int a) { return network.arcs()[static_cast<size_t>(a)].name; };
  const auto names = [&](const std::vector<int>& arcs) {
    std::vector<std::string> list;
    for (const int a : arcs) list.push_back(arc(a));
    return list;
  };
  const auto loops = [&](const std::vector<ArcLoop>& of) {
    std::vector<NetworkReport::LoopNames> list;
    for (const ArcLoop& loop : of) {
      list.emplace_back();
      for (const ArcUse& use : loop) list.back().push_back(arc(use.arc));
    }
    return list;
  };
  const auto regions = [&](const std::vector<int>& of) {
    std::vector<std::string> list;
    for (const int r : of) list.push_back(model.regions[static_cast<size_t>(r)].plan.name);
    return list;
  };

  report.lines = static_cast<int>(network.lines().size());
  report.arcs = static_cast<int>(network.arcs().size());
  report.nodes = static_cast<int>(network.nodes().size());
  report.size = network.size();
  report.tolerance = network.tolerance();
  report.fit_tolerance = fit_tolerance;
  report.join_tolerance_deg = join_tolerance_deg;
  report.findings = network.findings();
  report.optimal = found.optimal;
  report.rims = names(found.rims);
  report.bare = names(found.bare);
  for (const ModelRegion& r : model.regions) {
    NetworkReport::Region region;
    region.name = r.plan.name;
    region.loops = loops(r.plan.loops);
    region.inner = names(r.plan.inner);
    region.ring = r.plan.ring;
    region.asked = r.plan.asked;
    region.cost = r.plan.cost;
    region.skinned = r.skinned.has_value();
    region.plain_area = r.plain_area;
    region.why_not = r.why_not;
    region.warnings = r.warnings;
    if (r.skinned) {
      region.triangles = r.skinned->surface.mesh().triangle_count();
      region.dofs = r.skinned->surface.dof_map().count();
      region.size = r.skinned->size;
      region.quality = r.quality;
    }
    report.regions.push_back(std::move(region));
  }
  for (const ModelJoin& j : model.joins)
    report.joins.push_back({arc(j.arc), regions(j.regions), word(j.kind), j.asked, j.one_domain,
                            j.open, j.first_deg, j.max_deg, j.max_inside_deg, j.why});
  for (const RegionChoice& c : found.choices) {
    NetworkReport::Choice choice{c.text, c.where, c.arcs, loops(c.chosen), {}, c.margins};
    for (const auto& alternative : c.alternatives)
      choice.alternatives.push_back(loops(alternative));
    report.choices.push_back(std::move(choice));
  }
  for (const ModelShell& s : model.shells)
    report.shells.push_back({regions(s.regions), s.closed, s.orientable, s.area, s.volume});
  for (const SurfaceFlaw& f : model.flaws) {
    report.flaws.push_back({word(f.kind), regions(f.regions), f.where, f.value, f.text});
    for (const int r : f.regions) report.regions[static_cast<size_t>(r)].flaws.push_back(f.text);
  }
  return report;
}

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
