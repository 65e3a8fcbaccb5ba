#include "batten/skinning/search/ambiguous_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "batten/skinning/search/region_surfaces.h"

namespace batten {
namespace {

constexpr size_t kMaxAlternatives = 5;

std::string percent(double margin) {
  return std::to_string(static_cast<int>(std::lround(100 * std::max(margin, 0.0)))) + " %";
}

void write_text(const RegionGraph& graph, AmbiguousRegion& ambiguous) {
  const std::vector<EdgeLoop>& other = ambiguous.alternatives.front();
  const std::string cost = " costs " + percent(ambiguous.margins.front()) + " more";
  if (ambiguous.chosen.empty())
    ambiguous.text = "no surface was made in " + loops_as_text(graph, other) + "; to have it" +
                     cost + ": ask for a surface with these lines";
  else if (other.empty())
    ambiguous.text = "a surface was made in " + loops_as_text(graph, ambiguous.chosen) +
                     "; to leave it open" + cost + ": say that there is no surface in this loop";
  else
    ambiguous.text = "surfaces were made in " + loops_as_text(graph, ambiguous.chosen) +
                     "; to have them in " + loops_as_text(graph, other) + " instead" + cost +
                     ": ask for surfaces with these lines";
}

}  // namespace

std::string loops_as_text(const RegionGraph& graph, const std::vector<EdgeLoop>& loops) {
  constexpr size_t kMaxNamed = 6, kNamedOfMany = 3;
  std::string all;
  for (const EdgeLoop& loop : loops) {
    all += all.empty() ? "[" : ", [";
    const bool some = loop.size() > kMaxNamed;
    for (size_t i = 0; i < (some ? kNamedOfMany : loop.size()); ++i)
      all += (i ? ", '" : "'") + graph.edges[loop[i].edge].name + "'";
    if (some) all += ", … " + std::to_string(loop.size()) + " lines";
    all += "]";
  }
  return all;
}

void locate_ambiguous_region(const RegionGraph& graph, AmbiguousRegion& ambiguous) {
  std::set<int> edges;
  const auto add = [&](const std::vector<EdgeLoop>& loops) {
    for (const EdgeLoop& loop : loops)
      for (const OrientedEdge& use : loop) edges.insert(use.edge);
  };
  add(ambiguous.chosen);
  for (const auto& loops : ambiguous.alternatives) add(loops);
  ambiguous.edges.clear();
  ambiguous.where = Vec3::Zero();
  for (const int edge : edges) {
    ambiguous.edges.push_back(graph.edges[edge].name);
    ambiguous.where +=
        graph.edges[edge].points[GraphEdge::kPieces / 2] / static_cast<double>(edges.size());
  }
}

std::vector<AmbiguousRegion> find_ambiguous_regions(const RegionGraph& graph,
                                                    const RegionSearchResult& search,
                                                    const LoopCosts& costs, double most) {
  const std::vector<Alternative> all = find_alternatives(search.problem, search.selected);
  const auto worth = [&](const std::vector<int>& items) {
    double sum = 0;
    for (const int i : items)
      sum += costs.covered * static_cast<double>(search.loops[i].loop.size());
    return sum;
  };
  // Alternatives by the loops that they stand against; of a loop without rival, by itself.
  struct Rival {
    double margin;
    std::vector<int> in;
  };
  std::map<std::pair<std::vector<int>, int>, std::vector<Rival>> rivals;
  for (size_t i = 0; i < all.size(); ++i) {
    const auto& [loss, out, in] = all[i];
    if (!std::isfinite(loss)) continue;
    const double margin = loss / std::max(worth(out), worth(in));
    if (margin > most) continue;
    rivals[{out, out.empty() ? static_cast<int>(i) : -1}].push_back({margin, in});
  }
  std::vector<AmbiguousRegion> ambiguous_regions;
  for (auto& [key, some] : rivals) {
    std::sort(some.begin(), some.end(), [](const Rival& a, const Rival& b) {
      return a.margin != b.margin ? a.margin < b.margin : a.in < b.in;
    });
    AmbiguousRegion ambiguous;
    for (const int i : key.first) ambiguous.chosen.push_back(search.loops[i].loop);
    std::set<std::vector<int>> seen;
    for (const Rival& rival : some) {
      if (ambiguous.alternatives.size() == kMaxAlternatives || !seen.insert(rival.in).second)
        continue;
      ambiguous.alternatives.emplace_back();
      for (const int i : rival.in) ambiguous.alternatives.back().push_back(search.loops[i].loop);
      ambiguous.margins.push_back(rival.margin);
    }
    locate_ambiguous_region(graph, ambiguous);
    write_text(graph, ambiguous);
    ambiguous_regions.push_back(std::move(ambiguous));
  }
  return ambiguous_regions;
}

namespace {

// What a surface in a rim would have to do with the regions beside it.
struct CapFolds {
  double fold = 0;    // mean, degrees
  double price = 0;   // of all folds
  bool same = false;  // a region has these arcs already
};

CapFolds measure_folds(const RegionGraph& graph, const LoopCandidate& cap,
                       const std::vector<NetworkRegion>& regions, const LoopCosts& costs) {
  const std::vector<int> edges = edges_of(cap.loop);
  CapFolds result;
  const auto beside = [&](const EdgeLoop& loop) {
    return std::any_of(loop.begin(), loop.end(), [&](const OrientedEdge& use) {
      return std::binary_search(edges.begin(), edges.end(), use.edge);
    });
  };
  for (const NetworkRegion& region : regions) {
    for (size_t k = 0; k < region.loops.size(); ++k) {
      if (!beside(region.loops[k])) continue;
      if (region.loops.size() == 1 && edges_of(region.loops[0]) == edges) result.same = true;
      const LoopCandidate other = measure_loop(graph, region.loops[k], costs);
      for (size_t i = 0; i < cap.loop.size(); ++i)
        for (size_t j = 0; j < other.loop.size(); ++j)
          if (cap.loop[i].edge == other.loop[j].edge) {
            double degrees = fold_deg(cap, i, other, j);
            if (k > 0) degrees = 180 - degrees;
            result.fold += degrees / static_cast<double>(cap.loop.size());
            result.price += costs.fold * degrees * degrees / 8100;
          }
    }
  }
  return result;
}

}  // namespace

std::vector<AmbiguousRegion> closable_free_edges(const RegionGraph& graph,
                                                 const RegionSearchResult& search,
                                                 const std::vector<NetworkRegion>& regions,
                                                 const std::vector<int>& free_edges,
                                                 const std::vector<std::vector<int>>& excluded,
                                                 const LoopCosts& costs) {
  std::vector<AmbiguousRegion> ambiguous_regions;
  for (const EdgeLoop& loop : closed_chains(graph, free_edges)) {
    const LoopCandidate cap = measure_loop(graph, loop, costs);
    if (std::binary_search(excluded.begin(), excluded.end(), edges_of(cap.loop))) continue;
    const CapFolds folds = measure_folds(graph, cap, regions, costs);
    if (folds.same || folds.fold > 150) continue;
    AmbiguousRegion ambiguous;
    ambiguous.alternatives = {{cap.loop}};
    ambiguous.margins = {std::max(0.0, folds.price - cap.gain(costs)) /
                         (costs.covered * static_cast<double>(cap.loop.size()))};
    // Items that were left out are among the near choices, or far from them.
    const bool item = std::any_of(search.loops.begin(), search.loops.end(),
                                  [&](const LoopCandidate& c) { return c.loop == cap.loop; });
    if (item && ambiguous.margins[0] <= 0.15) continue;
    locate_ambiguous_region(graph, ambiguous);
    ambiguous.text = "the rim of " + std::to_string(cap.loop.size()) + " lines " +
                     loops_as_text(graph, ambiguous.alternatives[0]) +
                     " was left open; to close it, ask for a surface with these lines";
    ambiguous_regions.push_back(std::move(ambiguous));
  }
  return ambiguous_regions;
}

}  // namespace batten
