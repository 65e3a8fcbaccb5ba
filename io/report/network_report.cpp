#include "batten/io/report/network_report.h"

#include <algorithm>
#include <map>
#include <numbers>

#include "batten/core/groups.h"
#include "batten/core/index.h"

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

const char* word(SkinOptions::Domain domain) {
  using Domain = SkinOptions::Domain;
  return domain == Domain::Polygon ? "polygon"
         : domain == Domain::Plane ? "plane"
         : domain == Domain::Sheet ? "sheet"
         : domain == Domain::Ring  ? "ring"
                                   : "auto";
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

namespace {

/// The names of what is reported.
struct ReportNames {
  const CharacterLineNetwork& network;
  const SurfaceModel& model;

  const std::string& arc(int a) const { return network.arcs()[a].name; }
  std::vector<std::string> arcs(const std::vector<int>& of) const {
    std::vector<std::string> list;
    for (const int a : of) list.push_back(arc(a));
    return list;
  }
  std::vector<NetworkReport::LoopNames> loops(const std::vector<ArcLoop>& of) const {
    std::vector<NetworkReport::LoopNames> list;
    for (const ArcLoop& loop : of) {
      list.emplace_back();
      for (const ArcUse& use : loop) list.back().push_back(arc(use.arc));
    }
    return list;
  }
  std::vector<std::string> regions(const std::vector<int>& of) const {
    std::vector<std::string> list;
    for (const int r : of) list.push_back(model.regions[r].plan.name);
    return list;
  }
};

NetworkReport::Region describe_region(const ModelRegion& r, const ReportNames& names) {
  NetworkReport::Region region;
  region.name = r.plan.name;
  region.loops = names.loops(r.plan.loops);
  region.inner = names.arcs(r.plan.inner);
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
    region.domain = word(names.model.layout->region(r.in_layout).domain());
    region.quality = r.quality;
    region.shape = word_for(r.shape.kind);
    region.radius = r.shape.radius;
    region.major_radius = r.shape.major_radius;
    region.half_angle_deg = r.shape.half_angle * 180 / std::numbers::pi;
    region.shape_deviation = r.shape.deviation;
  }
  return region;
}

NetworkReport::Choice describe_choice(const RegionChoice& c, const ReportNames& names) {
  NetworkReport::Choice choice{c.text, c.where, c.arcs, names.loops(c.chosen), {}, c.margins};
  for (const auto& alternative : c.alternatives)
    choice.alternatives.push_back(names.loops(alternative));
  return choice;
}

// The findings, but for lines that lie apart from the others and are joined to them by a region, as
// the rims of a ring and holes are.
std::vector<NetworkFinding> findings_that_stand(const CharacterLineNetwork& network,
                                                const FoundRegions& found) {
  Groups nodes(network.nodes().size());
  const auto first_node = [&](int arc) { return network.arcs()[arc].nodes[0]; };
  for (const NetworkArc& arc : network.arcs()) nodes.join(arc.nodes[0], arc.nodes[1]);
  for (const NetworkRegion& region : found.regions) {
    const int own = first_node(region.loops.front().front().arc);
    for (const ArcLoop& loop : region.loops) nodes.join(own, first_node(loop.front().arc));
    for (const int arc : region.inner) nodes.join(own, first_node(arc));
  }
  std::map<int, int> sizes;  // arcs of each part
  for (int a = 0; a < count_of(network.arcs()); ++a) ++sizes[nodes.of(first_node(a))];
  const auto largest = std::max_element(
      sizes.begin(), sizes.end(), [](const auto& p, const auto& q) { return p.second < q.second; });
  std::vector<NetworkFinding> stand;
  for (const NetworkFinding& f : network.findings()) {
    const bool joined =
        f.kind == NetworkFinding::Kind::Apart &&
        nodes.of(first_node(network.arcs_of(f.lines.front()).front())) == largest->first;
    if (!joined) stand.push_back(f);
  }
  return stand;
}

}  // namespace

NetworkReport network_report(const CharacterLineNetwork& network, const FoundRegions& found,
                             const SurfaceModel& model, double fit_tolerance,
                             double join_tolerance_deg) {
  const ReportNames names{network, model};
  NetworkReport report;
  report.lines = count_of(network.lines());
  report.arcs = count_of(network.arcs());
  report.nodes = count_of(network.nodes());
  report.size = network.size();
  report.tolerance = network.tolerance();
  report.usual_share = network.usual_share();
  report.fit_tolerance = fit_tolerance;
  report.join_tolerance_deg = join_tolerance_deg;
  report.findings = findings_that_stand(network, found);
  report.optimal = found.optimal;
  report.rims = names.arcs(found.rims);
  report.bare = names.arcs(found.bare);
  for (const ModelRegion& r : model.regions) report.regions.push_back(describe_region(r, names));
  for (const ModelJoin& j : model.joins)
    report.joins.push_back({names.arc(j.arc), names.regions(j.regions), word(j.kind), j.asked,
                            j.one_domain, j.open, j.first_deg, j.max_deg, j.max_inside_deg,
                            j.max_gap, j.median_curvature_jump, j.max_curvature_jump, j.curvature,
                            j.why});
  for (const RegionChoice& c : found.choices) report.choices.push_back(describe_choice(c, names));
  for (const ModelShell& s : model.shells)
    report.shells.push_back({names.regions(s.regions), s.closed, s.orientable, s.area, s.volume,
                             s.orientable ? s.normals.text() : ""});
  for (const SurfaceFlaw& f : model.flaws)
    for (const int r : f.regions) report.regions[r].flaws.push_back(f.text);
  return report;
}

std::vector<FlawReport> flaw_reports(const SurfaceModel& model) {
  std::vector<FlawReport> list;
  for (const SurfaceFlaw& f : model.flaws) {
    list.push_back({word(f.kind), {}, f.where, f.value, f.text});
    for (const int r : f.regions) list.back().regions.push_back(model.regions[r].plan.name);
  }
  return list;
}

}  // namespace batten
