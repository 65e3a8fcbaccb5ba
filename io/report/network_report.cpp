// SPDX-License-Identifier: MPL-2.0
#include "batten/io/report/network_report.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "batten/core/containers.h"

namespace batten {
namespace {

const char* to_text(const ModelJoin& join) {
  using Kind = ModelJoin::Kind;
  const Kind kind = join.kind;
  return kind == Kind::FreeEdge ? (join.neighbour ? "G0" : "free edge")
         : kind == Kind::Crease ? "G0"
         : kind == Kind::Smooth ? "smooth"
                                : "non-manifold";
}

const char* to_text(SurfaceDefect::Kind kind) {
  using Kind = SurfaceDefect::Kind;
  return kind == Kind::Jacobian   ? "jacobian"
         : kind == Kind::Fold     ? "fold"
         : kind == Kind::Crossing ? "self-intersection"
                                  : "area";
}

const char* to_text(SkinOptions::Domain domain) {
  using Domain = SkinOptions::Domain;
  return domain == Domain::Polygon       ? "polygon"
         : domain == Domain::Projected   ? "projected"
         : domain == Domain::Developable ? "developable"
         : domain == Domain::Annulus     ? "annulus"
                                         : "auto";
}

}  // namespace

const char* to_text(NetworkDiagnostic::Kind kind) {
  using Kind = NetworkDiagnostic::Kind;
  switch (kind) {
    case Kind::EndsJoined:
      return "ends joined";
    case Kind::EndOnLine:
      return "end on curve";
    case Kind::Crossing:
      return "intersection";
    case Kind::SelfCrossing:
      return "self-intersection";
    case Kind::Duplicate:
      return "duplicate";
    case Kind::Overlap:
      return "overlap";
    case Kind::NearMiss:
      return "near miss";
    case Kind::Dangling:
      return "dangling end";
    case Kind::Short:
      return "short curve";
    case Kind::Disconnected:
      return "disconnected";
  }
  return "";
}

namespace {

/// Looks up the names of network and model entities.
struct ReportNames {
  const CurveNetwork& network;
  const SurfaceModel& model;

  const std::string& edge(int a) const { return network.edges()[a].name; }
  std::vector<std::string> edges(const std::vector<int>& of) const {
    std::vector<std::string> list;
    for (const int a : of) list.push_back(edge(a));
    return list;
  }
  std::vector<NetworkReport::LoopNames> loops(const std::vector<EdgeLoop>& of) const {
    std::vector<NetworkReport::LoopNames> list;
    for (const EdgeLoop& loop : of) {
      list.emplace_back();
      for (const OrientedEdge& use : loop) list.back().push_back(edge(use.edge));
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
  region.inner = names.edges(r.plan.inner);
  region.annulus = r.plan.annulus;
  region.requested = r.plan.requested;
  region.cost = r.plan.cost;
  region.skinned = r.skinned.has_value();
  region.filling_area = r.filling_area;
  region.rejection_reason = r.rejection_reason;
  region.warnings = r.warnings;
  if (r.skinned) {
    region.triangles = r.skinned->surface.mesh().triangle_count();
    region.dofs = r.skinned->surface.dof_map().count();
    region.size = r.skinned->size;
    region.domain = to_text(names.model.layout->region(r.layout_index).domain());
    region.quality = r.quality;
    region.shape = primitive_name(r.shape.kind);
    region.radius = r.shape.radius;
    region.major_radius = r.shape.major_radius;
    region.half_angle_deg = r.shape.half_angle * 180 / std::numbers::pi;
    region.shape_deviation = r.shape.deviation;
  }
  return region;
}

NetworkReport::Choice describe_choice(const AmbiguousRegion& c, const ReportNames& names) {
  NetworkReport::Choice choice{c.text, c.where, c.edges, names.loops(c.chosen), {}, c.margins};
  for (const auto& alternative : c.alternatives)
    choice.alternatives.push_back(names.loops(alternative));
  return choice;
}

// The diagnostics without those about detached lines that a region connects to the others, such as
// the boundaries of an annulus and holes.
std::vector<NetworkDiagnostic> remaining_diagnostics(const CurveNetwork& network,
                                                     const FoundRegions& found,
                                                     const SurfaceModel& model) {
  DisjointSets nodes(network.nodes().size());
  const auto first_node = [&](int edge) { return network.edges()[edge].nodes[0]; };
  for (const NetworkEdge& edge : network.edges()) nodes.unite(edge.nodes[0], edge.nodes[1]);
  for (const NetworkRegion& region : found.regions) {
    const int own = first_node(region.loops.front().front().edge);
    for (const EdgeLoop& loop : region.loops) nodes.unite(own, first_node(loop.front().edge));
    for (const int edge : region.inner) nodes.unite(own, first_node(edge));
  }
  std::map<int, int> sizes;  // number of edges per component
  for (int a = 0; a < isize(network.edges()); ++a) ++sizes[nodes.find(first_node(a))];
  const auto largest = std::max_element(
      sizes.begin(), sizes.end(), [](const auto& p, const auto& q) { return p.second < q.second; });
  // Faces that continue given surfaces need no other connection.
  std::set<int> beside_given;
  for (const ModelJoin& join : model.joins)
    if (join.neighbour) beside_given.insert(nodes.find(first_node(join.edge)));
  std::vector<NetworkDiagnostic> stand;
  for (const NetworkDiagnostic& f : network.diagnostics()) {
    if (f.kind != NetworkDiagnostic::Kind::Disconnected) {
      stand.push_back(f);
      continue;
    }
    const int component = nodes.find(first_node(network.edges_of(f.lines.front()).front()));
    if (component != largest->first && !beside_given.count(component)) stand.push_back(f);
  }
  return stand;
}

}  // namespace

NetworkReport network_report(const CurveNetwork& network, const FoundRegions& found,
                             const SurfaceModel& model, double fit_tolerance,
                             double join_tolerance_deg) {
  const ReportNames names{network, model};
  NetworkReport report;
  report.lines = isize(network.lines());
  report.edges = isize(network.edges());
  report.nodes = isize(network.nodes());
  report.size = network.size();
  report.tolerance = network.tolerance();
  report.joined_fraction = network.joined_fraction();
  report.fit_tolerance = fit_tolerance;
  report.join_tolerance_deg = join_tolerance_deg;
  report.diagnostics = remaining_diagnostics(network, found, model);
  report.optimal = found.optimal;
  report.free_edges = names.edges(found.free_edges);
  report.unused_edges = names.edges(found.unused_edges);
  for (const ModelRegion& r : model.regions) report.regions.push_back(describe_region(r, names));
  for (const ModelJoin& j : model.joins)
    report.joins.push_back({names.edge(j.edge), names.regions(j.regions), to_text(j), j.requested,
                            j.one_domain, j.open, j.initial_deg, j.max_deg, j.max_inside_deg,
                            j.max_gap, j.median_curvature_jump, j.max_curvature_jump, j.curvature,
                            j.why, j.neighbour ? j.neighbour->names() : std::vector<std::string>(),
                            j.mean_deg});
  for (const AmbiguousRegion& c : found.ambiguous_regions)
    report.ambiguous_regions.push_back(describe_choice(c, names));
  for (const ModelShell& s : model.shells)
    report.shells.push_back({names.regions(s.regions), s.closed, s.orientable, s.area, s.volume,
                             s.orientable ? s.normals.text() : ""});
  for (const SurfaceDefect& f : model.defects)
    for (const int r : f.regions) report.regions[r].defects.push_back(f.text);
  return report;
}

std::vector<DefectReport> defect_reports(const SurfaceModel& model) {
  std::vector<DefectReport> list;
  for (const SurfaceDefect& f : model.defects) {
    list.push_back({to_text(f.kind), {}, f.where, f.value, f.text});
    for (const int r : f.regions) list.back().regions.push_back(model.regions[r].plan.name);
  }
  return list;
}

}  // namespace batten
