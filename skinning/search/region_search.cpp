// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/search/region_search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "batten/skinning/search/region_surfaces.h"

namespace batten {
namespace {

double square(double x) { return x * x; }

// The use of an edge by a loop.
struct Use {
  int loop;
  size_t position;
};

std::vector<std::vector<Use>> uses_by_edge(const std::vector<LoopCandidate>& loops, size_t edges) {
  std::vector<std::vector<Use>> all(edges);
  for (size_t c = 0; c < loops.size(); ++c)
    for (size_t i = 0; i < loops[c].loop.size(); ++i)
      all[loops[c].loop[i].edge].push_back({static_cast<int>(c), i});
  return all;
}

// Measured loops of the requested surfaces.
struct RequestedLoops {
  std::vector<LoopCandidate> loops;
  std::vector<std::vector<int>> fixed_edges;  // edges of loops that must not become items, sorted
  std::vector<std::vector<Use>> uses;         // of `loops`, by edge
};

// Requested surfaces occupy their edges first; their neighbours pay the fold costs.
RequestedLoops fix_requested(const RegionGraph& graph, const FixedRegions& fixed_regions,
                             const LoopCosts& costs, std::vector<int>& capacity) {
  RequestedLoops requested{{}, fixed_regions.excluded, {}};
  for (const auto& loops : fixed_regions.requested)
    for (size_t k = 0; k < loops.size(); ++k) {
      requested.loops.push_back(measure_loop(graph, loops[k], costs));
      requested.fixed_edges.push_back(edges_of(loops[k]));
      for (const OrientedEdge& use : loops[k]) --capacity[use.edge];
      // The surface lies outside a hole.
      if (k > 0)
        for (auto& side : requested.loops.back().side)
          for (double& angle : side) angle += EIGEN_PI;
    }
  for (int& r : capacity) r = std::max(r, 0);
  std::sort(requested.fixed_edges.begin(), requested.fixed_edges.end());
  requested.uses = uses_by_edge(requested.loops, graph.edges.size());
  return requested;
}

// Makes the item of a loop; `gain` is that of the loop alone.
LoopSelectionProblem::Item make_item(const LoopCandidate& c, double gain,
                                     const RequestedLoops& requested, double fold_cost) {
  LoopSelectionProblem::Item item;
  item.gain = gain;
  std::map<int, int> uses;
  for (size_t i = 0; i < c.loop.size(); ++i) {
    ++uses[c.loop[i].edge];
    for (const Use& other : requested.uses[c.loop[i].edge])
      item.gain -=
          fold_cost * square(fold_deg(c, i, requested.loops[other.loop], other.position) / 90);
  }
  for (const auto& [edge, count] : uses) {
    item.edges.push_back(edge);
    item.uses.push_back(count);
  }
  return item;
}

bool has_capacity(const LoopSelectionProblem::Item& item, const std::vector<int>& capacity) {
  for (size_t i = 0; i < item.edges.size(); ++i)
    if (item.uses[i] > capacity[item.edges[i]]) return false;
  return true;
}

// Makes items of the loops with a positive gain for which there is capacity.
void add_items(const RegionGraph& graph, const RequestedLoops& requested, const LoopCosts& costs,
               double fold_cost, std::vector<LoopCandidate>& traced, RegionSearchResult& search) {
  std::vector<int> loops_in_component(static_cast<size_t>(graph.component_count), 0);
  for (const LoopCandidate& c : traced) ++loops_in_component[graph.component[c.loop[0].edge]];
  for (LoopCandidate& c : traced) {
    if (std::binary_search(requested.fixed_edges.begin(), requested.fixed_edges.end(),
                           edges_of(c.loop)))
      continue;
    double gain = c.gain(costs);
    // If a component has only one loop, it bounds a surface at any cost.
    constexpr double kSomeGain = 0.1;
    if (loops_in_component[graph.component[c.loop[0].edge]] == 1) gain = std::max(gain, kSomeGain);
    LoopSelectionProblem::Item item = make_item(c, gain, requested, fold_cost);
    if (!has_capacity(item, search.problem.capacity) || item.gain <= 1e-9) continue;
    search.problem.items.push_back(std::move(item));
    search.loops.push_back(std::move(c));
  }
}

// Adds the fold costs of pairs of loops on a common edge.
void add_pairs(const RegionGraph& graph, double fold_cost, RegionSearchResult& search) {
  const auto uses = uses_by_edge(search.loops, graph.edges.size());
  for (size_t a = 0; a < uses.size(); ++a)
    for (size_t i = 0; i < uses[a].size(); ++i)
      for (size_t j = i + 1; j < uses[a].size(); ++j) {
        const auto [c, position] = uses[a][i];
        const auto [d, other] = uses[a][j];
        if (c == d) continue;
        const double fold = fold_deg(search.loops[c], position, search.loops[d], other);
        search.problem.pairs.push_back({static_cast<int>(a), c, d, fold_cost * square(fold / 90)});
      }
}

bool was_chosen(const RegionSearchResult& open, const LoopCandidate& loop) {
  return std::any_of(open.loops.begin(), open.loops.end(), [&](const LoopCandidate& other) {
    return other.loop == loop.loop && open.selected.chosen[&other - open.loops.data()];
  });
}

// Mean interior angle in degrees; larger: looks like a free boundary.
constexpr double kFreeEdgeAngle = 120;

// Traces the loops of a graph and sets up the selection problem.
RegionSearchResult make_problem(const RegionGraph& graph, const FixedRegions& fixed_regions,
                                const LoopCosts& costs, const Progress& progress) {
  RegionSearchResult search;
  // 1. Trace loops; each comes with its own cost.
  TracedLoops traced = trace_loops(graph, costs, progress);
  search.complete = traced.complete;
  progress.update("faces: selection", 0);

  // 2. Gains of loops, and costs of pairs on a common edge.
  const double fold_cost = costs.fold / std::max(1, fixed_regions.max_faces_per_edge - 1);
  search.problem.capacity.assign(graph.edges.size(), fixed_regions.max_faces_per_edge);
  const RequestedLoops requested =
      fix_requested(graph, fixed_regions, costs, search.problem.capacity);
  add_items(graph, requested, costs, fold_cost, traced.loops, search);
  add_pairs(graph, fold_cost, search);
  return search;
}

// Remaining capacity of each edge.
std::vector<int> edges_with_free_side(const RegionSearchResult& search) {
  std::vector<int> left = search.problem.capacity;
  for (size_t i = 0; i < search.loops.size(); ++i)
    if (search.selected.chosen[i])
      for (const OrientedEdge& use : search.loops[i].loop) --left[use.edge];
  return left;
}

bool has_free_edges(const RegionSearchResult& search) {
  const std::vector<int> left = edges_with_free_side(search);
  return std::any_of(left.begin(), left.end(), [](int sides) { return sides == 1; });
}

// True if an edge that does not dangle is left without a loop.
bool has_unused_edges(const RegionSearchResult& search, const std::vector<bool>& core) {
  const std::vector<int> left = edges_with_free_side(search);
  for (size_t a = 0; a < left.size(); ++a)
    if (core[a] && search.problem.capacity[a] > 0 && left[a] == search.problem.capacity[a])
      return true;
  return false;
}

// True if every edge that does not dangle has a loop, and each of its free sides a candidate loop
// that does not look like a free boundary.
bool may_close(const RegionSearchResult& search, const std::vector<bool>& core) {
  constexpr size_t kMaxEdges = 2000;
  std::vector<int> left = search.problem.capacity;
  if (left.size() > kMaxEdges) return false;
  const std::vector<int> free = edges_with_free_side(search);
  for (size_t a = 0; a < free.size(); ++a)
    if (!core[a])
      left[a] = 0;
    else if (free[a] == 2)
      return false;
  for (size_t i = 0; i < search.loops.size(); ++i)
    if (search.selected.chosen[i] || search.loops[i].inside_deg <= kFreeEdgeAngle)
      for (const OrientedEdge& use : search.loops[i].loop) --left[use.edge];
  return std::all_of(left.begin(), left.end(), [](int sides) { return sides <= 0; });
}

}  // namespace

RegionSearchResult search_regions(const RegionGraph& graph, const FixedRegions& fixed_regions,
                                  const LoopCosts& costs, const Progress& progress) {
  RegionSearchResult search = make_problem(graph, fixed_regions, costs, progress);
  // 3. Select.
  search.selected = select_loops(search.problem);
  progress.update("faces: selection", 1);
  return search;
}

std::optional<RegionSearchResult> search_sharp_model(const RegionSearchResult& open,
                                                     const RegionGraph& exact,
                                                     const FixedRegions& fixed_regions,
                                                     const LoopCosts& costs,
                                                     const Progress& progress) {
  if (fixed_regions.max_faces_per_edge != 2 || !has_unused_edges(open, exact.core))
    return std::nullopt;
  RegionSearchResult search = make_problem(exact, fixed_regions, costs, progress);
  // Loops with the interior angles of planar ones, (n - 2) π in total, gain more. Other loops are
  // excluded unless they were selected before.
  constexpr double kNearPlane = 0.5, kMaxCost = 2;
  for (size_t i = 0; i < search.loops.size(); ++i) {
    const LoopCandidate& loop = search.loops[i];
    const auto n = static_cast<double>(loop.loop.size());
    double& gain = search.problem.items[i].gain;
    if (std::abs(loop.inside_deg * n / 180 - (n - 2)) <= kNearPlane &&
        loop.cost <= n - 2 + kMaxCost && loop.inside_deg <= kFreeEdgeAngle + 1e-6)
      gain += costs.closed * n;
    else if (!was_chosen(open, loop))
      gain = -1;
  }
  // A fold of 2° costs no more than one of 90°, unless the surfaces lie on each other.
  constexpr double kLiesOn = 179.5;
  const double most = costs.fold * square(kLiesOn / 90);
  for (auto& pair : search.problem.pairs)
    if (pair.pair_cost < most) pair.pair_cost = std::min(pair.pair_cost, costs.fold);
  search.selected = select_loops(search.problem);
  progress.update("faces: selection", 1);
  if (has_free_edges(search) || has_unused_edges(search, exact.core)) return std::nullopt;
  return search;
}

std::optional<RegionSearchResult> search_closed_model(const RegionSearchResult& open,
                                                      const RegionGraph& exact,
                                                      const FixedRegions& fixed_regions,
                                                      const LoopCosts& costs,
                                                      const Progress& progress) {
  if (fixed_regions.max_faces_per_edge != 2 || !has_free_edges(open) ||
      !may_close(open, exact.core))
    return std::nullopt;
  RegionSearchResult search = make_problem(exact, fixed_regions, costs, progress);
  for (size_t i = 0; i < search.loops.size(); ++i) {
    const LoopCandidate& loop = search.loops[i];
    search.problem.items[i].gain += was_chosen(open, loop) || loop.inside_deg <= kFreeEdgeAngle
                                        ? costs.closed * static_cast<double>(loop.loop.size())
                                        : -std::abs(search.problem.items[i].gain) - 1;
  }
  search.selected = select_loops(search.problem);
  progress.update("faces: selection", 1);
  if (has_free_edges(search)) return std::nullopt;
  return search;
}

namespace {

constexpr size_t kMaxAlternatives = 5;

std::string percent(double margin) {
  return std::to_string(static_cast<int>(std::lround(100 * std::max(margin, 0.0)))) + " %";
}

void write_text(const RegionGraph& graph, AmbiguousRegion& ambiguous) {
  const std::vector<EdgeLoop>& other = ambiguous.alternatives.front();
  const std::string cost = " (cost +" + percent(ambiguous.margins.front()) + ")";
  if (ambiguous.chosen.empty())
    ambiguous.text = "no face was created in " + loops_as_text(graph, other) + "; to create it" +
                     cost + ", add a [[face]] with these curves";
  else if (other.empty())
    ambiguous.text = "a face was created in " + loops_as_text(graph, ambiguous.chosen) +
                     "; to leave it open" + cost + ", add a [[face]] with surface = false";
  else
    ambiguous.text = "faces were created in " + loops_as_text(graph, ambiguous.chosen) +
                     "; to create them in " + loops_as_text(graph, other) + " instead" + cost +
                     ", add a [[face]] for each of these loops";
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
    if (some) all += ", … " + std::to_string(loop.size()) + " curves";
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
  // Group the alternatives by the loops that they replace; those that replace none stay separate.
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

// Folds between a surface that would cap a boundary loop and the adjacent regions.
struct CapFolds {
  double fold = 0;    // mean, degrees
  double price = 0;   // total cost of all folds
  bool same = false;  // a region with these edges exists already
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
    // Candidates of the selection with a small margin are listed by find_ambiguous_regions().
    const bool item = std::any_of(search.loops.begin(), search.loops.end(),
                                  [&](const LoopCandidate& c) { return c.loop == cap.loop; });
    if (item && ambiguous.margins[0] <= 0.15) continue;
    locate_ambiguous_region(graph, ambiguous);
    ambiguous.text = "the " + std::to_string(cap.loop.size()) + " free edges " +
                     loops_as_text(graph, ambiguous.alternatives[0]) +
                     " were left open; to close them, add a [[face]] with these curves";
    ambiguous_regions.push_back(std::move(ambiguous));
  }
  return ambiguous_regions;
}

}  // namespace batten
