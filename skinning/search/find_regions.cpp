// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/search/find_regions.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/search/region_search.h"
#include "batten/skinning/search/region_surfaces.h"

namespace batten {
namespace {

/// User specifications, resolved to loops of edges.
struct ResolvedSpecs {
  FixedRegions fixed_regions;
  std::vector<NetworkRegion> regions;  ///< requested regions, in the order of the specifications
};

std::string quoted(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "'" : ", '") + name + "'";
  return all;
}

class SpecResolver {
 public:
  SpecResolver(const RegionGraph& graph, const RegionSearchOptions& options)
      : graph_(graph), options_(options) {}

  ResolvedSpecs resolve() {
    if (options_.max_faces_per_edge < 1)
      throw InputError("found max_faces_per_edge = " + std::to_string(options_.max_faces_per_edge) +
                       ", expected 1 or more");
    for (const RegionSpec& spec : options_.specs) {
      context_ = spec.where + (spec.name.empty() ? "requested face" : "face '" + spec.name + "'");
      if (spec.kind == RegionSpec::Kind::NoSurface) context_ = spec.where + "excluded face";
      if (spec.loops.empty())
        throw InputError(context_ + ": it names no curves, expected one loop or more");
      (spec.kind == RegionSpec::Kind::Surface ? surface(spec) : excluded(spec));
    }
    for (const auto& edges : resolved_.fixed_regions.excluded)
      if (const auto it = specified_.find(edges); it != specified_.end())
        throw InputError(it->second + ": the same loop is also excluded by surface = false");
    limit();
    auto& excluded = resolved_.fixed_regions.excluded;
    std::sort(excluded.begin(), excluded.end());
    return std::move(resolved_);
  }

 private:
  std::vector<int> edges(const std::string& name) const {
    const std::vector<int> found = graph_.edges_named(name);
    if (!found.empty()) return found;
    std::vector<std::string> names;
    for (const GraphEdge& edge : graph_.edges) {
      names.push_back(edge.name);
      names.push_back(edge.line);
    }
    throw InputError(context_ + ": the network has no curve '" + name + "'" +
                     did_you_mean(name, names));
  }

  // Chains the named edges into one closed trail (Hierholzer's algorithm). An edge occurs as often
  // as it is named.
  EdgeLoop chained(const std::vector<std::string>& names) const {
    if (names.empty()) throw InputError(context_ + ": a loop names no curves");
    std::vector<int> all;
    for (const std::string& name : names) {
      const std::vector<int> some = edges(name);
      all.insert(all.end(), some.begin(), some.end());
    }
    std::sort(all.begin(), all.end());
    std::map<int, std::vector<int>> at;  // for each node, the indices into `all` of its edges
    for (int i = 0; i < isize(all); ++i)
      for (const int node : graph_.edges[all[i]].nodes) at[node].push_back(i);
    for (const auto& [node, incidences] : at)
      if (incidences.size() % 2)
        throw InputError(context_ + ": curves " + quoted(names) + " do not form a closed loop: '" +
                         graph_.edges[all[incidences.back()]].name + "' has a free end at " +
                         format_point(graph_.nodes[node]));
    std::vector<char> used(all.size(), 0);
    std::map<int, size_t> next;
    struct Step {
      int node;
      OrientedEdge by;
    };
    std::vector<Step> path{{graph_.edges[all[0]].nodes[0], {-1, false}}};
    EdgeLoop loop;
    while (!path.empty()) {
      const Step here = path.back();
      auto& incidences = at[here.node];
      size_t& k = next[here.node];
      while (k < incidences.size() && used[incidences[k]]) ++k;
      if (k == incidences.size()) {
        path.pop_back();
        if (here.by.edge >= 0) loop.push_back(here.by);
        continue;
      }
      used[incidences[k]] = 1;
      const GraphEdge& edge = graph_.edges[all[incidences[k]]];
      const bool reversed = edge.nodes[0] != here.node;
      path.push_back({edge.nodes[!reversed], {all[incidences[k]], reversed}});
    }
    if (loop.size() != all.size())
      throw InputError(context_ + ": curves " + quoted(names) + " form more than one loop");
    std::reverse(loop.begin(), loop.end());
    return canonical(loop);
  }

  void surface(const RegionSpec& spec) {
    if (spec.annulus && spec.loops.size() != 2)
      throw InputError(context_ + ": found " + std::to_string(spec.loops.size()) +
                       " loops, expected two for an annulus");
    NetworkRegion region;
    region.name = spec.name;
    region.annulus = spec.annulus;
    region.skin = spec.skin;
    region.requested = true;
    for (const auto& names : spec.loops) region.loops.push_back(chained(names));
    std::vector<int> border;
    for (const EdgeLoop& loop : region.loops)
      for (const OrientedEdge& use : loop) border.push_back(use.edge);
    for (const std::string& name : spec.inner)
      for (const int edge : edges(name)) {
        if (std::find(border.begin(), border.end(), edge) != border.end())
          throw InputError(context_ + ": '" + name + "' is both an inner curve and a boundary");
        region.inner.push_back(edge);
      }
    std::sort(region.inner.begin(), region.inner.end());
    region.inner.erase(std::unique(region.inner.begin(), region.inner.end()), region.inner.end());
    std::sort(border.begin(), border.end());
    if (!specified_.try_emplace(border, context_).second)
      throw InputError(context_ + ": the same loop is requested twice");
    for (const NetworkRegion& other : resolved_.regions)
      if (!region.name.empty() && other.name == region.name)
        throw InputError(context_ + ": another face has this name");
    resolved_.fixed_regions.requested.push_back(region.loops);
    resolved_.regions.push_back(std::move(region));
  }

  void excluded(const RegionSpec& spec) {
    for (const auto& names : spec.loops)
      resolved_.fixed_regions.excluded.push_back(edges_of(chained(names)));
  }

  void limit() {
    resolved_.fixed_regions.max_faces_per_edge = options_.max_faces_per_edge;
    std::map<int, int> uses;
    for (const NetworkRegion& region : resolved_.regions)
      for (const EdgeLoop& loop : region.loops)
        for (const OrientedEdge& use : loop)
          if (++uses[use.edge] > options_.max_faces_per_edge)
            throw InputError(options_.specs.front().where + "requested faces: " +
                             std::to_string(uses[use.edge]) + " of them share '" +
                             graph_.edges[use.edge].name + "', expected at most " +
                             std::to_string(options_.max_faces_per_edge) + " (max_faces_per_edge)");
  }

  const RegionGraph& graph_;
  const RegionSearchOptions& options_;
  ResolvedSpecs resolved_;
  std::map<std::vector<int>, std::string> specified_;
  std::string context_;
};

/// Looks up the edges of each name and chains them into loops.
///
/// Throws InputError for: an unknown name (with the most similar one), edges that do not form one
/// closed loop, an annulus without two loops, an inner edge that is also a boundary, a loop that is
/// requested twice or both requested and excluded, and more regions on an edge than
/// `max_faces_per_edge`.
ResolvedSpecs resolve_specs(const RegionGraph& graph, const RegionSearchOptions& options) {
  return SpecResolver(graph, options).resolve();
}

class Finder {
 public:
  // `exact`: the graph with exact end tangents; null if there is none.
  Finder(const RegionGraph& graph, const RegionGraph* exact, const RegionSearchOptions& options,
         const Progress& progress)
      : graph_(graph), exact_(exact ? *exact : graph), progress_(progress) {
    for (const GraphEdge& edge : graph_.edges)
      for (const Vec3& p : edge.points)
        if (!p.allFinite())
          throw InputError("curve '" + edge.name + "' has points that are not finite");
    only_specs_ = options.only_specs;
    ResolvedSpecs resolved = resolve_specs(graph_, options);
    fixed_regions_ = std::move(resolved.fixed_regions);
    found_.regions = std::move(resolved.regions);
    // An edge that the user specifies as an inner edge is no boundary.
    for (const NetworkRegion& region : found_.regions)
      for (const int edge : region.inner) graph_.core[edge] = exact_.core[edge] = false;
  }

  FoundRegions find() {
    if (only_specs_)
      found_.optimal = true;
    else
      search();
    find_inner_lines(graph_, costs_, found_.regions);
    if (!found_.regions.empty()) assign_stated_inner_lines(graph_, found_.regions);
    std::tie(found_.unused_edges, found_.free_edges) = unused_and_free_edges();
    if (!only_specs_) {
      auto open = closable_free_edges(graph_, search_, found_.regions, found_.free_edges,
                                      fixed_regions_.excluded, costs_);
      found_.ambiguous_regions.insert(found_.ambiguous_regions.end(), open.begin(), open.end());
    }
    name_regions();
    return std::move(found_);
  }

 private:
  // Searches for the faces that the user has not specified.
  void search() {
    search_ = search_regions(graph_, fixed_regions_, costs_, progress_);
    if (auto closed = search_closed_model(search_, exact_, fixed_regions_, costs_, progress_)) {
      search_ = std::move(*closed);
      graph_ = exact_;
    } else if (auto sharp =
                   search_sharp_model(search_, exact_, fixed_regions_, costs_, progress_)) {
      search_ = std::move(*sharp);
      graph_ = exact_;
    }
    for (size_t i = 0; i < search_.loops.size(); ++i)
      if (search_.selected.chosen[i]) {
        NetworkRegion region;
        region.loops = {search_.loops[i].loop};
        region.cost = search_.loops[i].cost;
        found_.regions.push_back(std::move(region));
      }
    found_.optimal = search_.complete && search_.selected.optimal;
    found_.ambiguous_regions = find_ambiguous_regions(graph_, search_, costs_);
    if (!annulus()) islands();
    holes();
  }

  // Merges two loops into an annulus if there is nothing else in the network.
  bool annulus() {
    auto& regions = found_.regions;
    if (graph_.component_count != 2 || regions.size() != 2 || regions[0].requested ||
        regions[1].requested)
      return false;
    const EdgeLoop a = regions[0].loops[0], b = regions[1].loops[0];
    if (a.size() + b.size() != graph_.edges.size() ||
        graph_.component[a[0].edge] == graph_.component[b[0].edge])
      return false;
    if (!are_boundary_circles(exact_, a, b)) return false;
    regions[0].loops = {a, b};
    regions[0].annulus = true;
    regions[0].cost += regions[1].cost;
    regions.pop_back();
    AmbiguousRegion ambiguous;
    ambiguous.chosen = {a, b};
    ambiguous.alternatives = {{a}, {b}};
    ambiguous.one_surface = true;
    ambiguous.margins = {0, 0};
    locate_ambiguous_region(graph_, ambiguous);
    ambiguous.text = "the two loops " + loops_as_text(graph_, {a, b}) +
                     " became the boundaries of one annular face; for two separate faces, add a "
                     "[[face]] with each loop";
    found_.ambiguous_regions = {ambiguous};
    return true;
  }

  // Disconnected loops on the surface of another region become neither holes nor patches by
  // default.
  void islands() {
    std::vector<char> gone(found_.regions.size(), 0);
    for (const auto& [region, on] : find_islands(graph_, found_.regions)) {
      const EdgeLoop loop = found_.regions[region].loops[0];
      const EdgeLoop outline = found_.regions[on].loops[0];
      if (gone[on]) continue;
      gone[region] = 1;
      AmbiguousRegion ambiguous;
      ambiguous.alternatives = {{outline, loop}, {loop}};
      ambiguous.one_surface = true;
      ambiguous.margins = {0, 0};
      locate_ambiguous_region(graph_, ambiguous);
      ambiguous.text =
          "the loop " + loops_as_text(graph_, {loop}) + " lies inside of the face with the loop " +
          loops_as_text(graph_, {outline}) +
          " and was not used; for a hole, add a [[face]] with both loops; for a separate face, "
          "add a [[face]] with this loop";
      found_.ambiguous_regions.push_back(std::move(ambiguous));
    }
    const auto is_gone = [&](const EdgeLoop& loop) {
      for (size_t i = 0; i < gone.size(); ++i)
        if (gone[i] && found_.regions[i].loops[0] == loop) return true;
      return false;
    };
    std::erase_if(found_.ambiguous_regions, [&](const AmbiguousRegion& ambiguous) {
      return std::any_of(ambiguous.chosen.begin(), ambiguous.chosen.end(), is_gone);
    });
    size_t kept = 0;
    for (size_t i = 0; i < gone.size(); ++i)
      if (!gone[i]) {
        if (kept != i) found_.regions[kept] = std::move(found_.regions[i]);
        ++kept;
      }
    found_.regions.resize(kept);
  }

  // A part that stands on a planar face, or passes through it, makes a hole there.
  void holes() {
    for (PlanarHole& hole :
         find_planar_holes(graph_, found_.regions, unused_and_free_edges().second))
      found_.regions[hole.on].loops.push_back(std::move(hole.loop));
  }

  // Edges without a region, and edges with one.
  std::pair<std::vector<int>, std::vector<int>> unused_and_free_edges() const {
    std::vector<int> uses(graph_.edges.size(), 0), unused_edges, free_edges;
    for (const NetworkRegion& region : found_.regions) {
      for (const EdgeLoop& loop : region.loops)
        for (const OrientedEdge& use : loop) ++uses[use.edge];
      for (const int edge : region.inner) uses[edge] += 2;
    }
    for (size_t a = 0; a < uses.size(); ++a)
      if (uses[a] < 2) (uses[a] == 0 ? unused_edges : free_edges).push_back(static_cast<int>(a));
    return {unused_edges, free_edges};
  }

  void name_regions() {
    std::set<std::string> taken;
    for (const NetworkRegion& region : found_.regions) taken.insert(region.name);
    int number = 0;
    for (NetworkRegion& region : found_.regions)
      while (region.name.empty()) {
        const std::string name = "face " + std::to_string(++number);
        if (!taken.count(name)) region.name = name;
      }
  }

  RegionGraph graph_, exact_;
  const Progress& progress_;
  bool only_specs_ = false;
  LoopCosts costs_;
  FixedRegions fixed_regions_;
  RegionSearchResult search_;
  FoundRegions found_;
};

}  // namespace

FoundRegions find_regions(const RegionGraph& graph, const RegionSearchOptions& options,
                          const Progress& progress) {
  return Finder(graph, nullptr, options, progress).find();
}

FoundRegions find_regions(const CurveNetwork& network, const RegionSearchOptions& options,
                          const Progress& progress) {
  const RegionGraph exact(network, RegionGraph::EndTangents::OfCurve);
  return Finder(RegionGraph(network), &exact, options, progress).find();
}

}  // namespace batten
