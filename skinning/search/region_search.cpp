#include "batten/skinning/search/region_search.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace batten {
namespace {

double square(double x) { return x * x; }

// The uses of each arc by some loops.
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

// What the user asked for, measured.
struct RequestedLoops {
  std::vector<LoopCandidate> loops;
  std::vector<std::vector<int>> fixed_edges;  // of loops that are no items, ascending
  std::vector<std::vector<Use>> uses;         // of `loops`, by arc
};

// What was asked for takes its room first; its neighbours pay for the fold.
RequestedLoops fix_requested(const RegionGraph& graph, const FixedRegions& fixed_regions,
                             const LoopCosts& costs, std::vector<int>& capacity) {
  RequestedLoops requested{{}, fixed_regions.excluded, {}};
  for (const auto& loops : fixed_regions.requested)
    for (size_t k = 0; k < loops.size(); ++k) {
      requested.loops.push_back(measure_loop(graph, loops[k], costs));
      requested.fixed_edges.push_back(edges_of(loops[k]));
      for (const OrientedEdge& use : loops[k]) --capacity[use.edge];
      // The surface lies outside of a hole.
      if (k > 0)
        for (auto& side : requested.loops.back().side)
          for (double& angle : side) angle += EIGEN_PI;
    }
  for (int& r : capacity) r = std::max(r, 0);
  std::sort(requested.fixed_edges.begin(), requested.fixed_edges.end());
  requested.uses = uses_by_edge(requested.loops, graph.edges.size());
  return requested;
}

// The item of a loop; `gain` is that of the loop alone.
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

// Makes items of the loops that gain by themselves and have room.
void add_items(const RegionGraph& graph, const RequestedLoops& requested, const LoopCosts& costs,
               double fold_cost, std::vector<LoopCandidate>& traced, RegionSearchResult& search) {
  std::vector<int> loops_in_component(static_cast<size_t>(graph.component_count), 0);
  for (const LoopCandidate& c : traced) ++loops_in_component[graph.component[c.loop[0].edge]];
  for (LoopCandidate& c : traced) {
    if (std::binary_search(requested.fixed_edges.begin(), requested.fixed_edges.end(),
                           edges_of(c.loop)))
      continue;
    double gain = c.gain(costs);
    // The only loop of a part of the network bounds a surface, whatever it costs.
    constexpr double kSomeGain = 0.1;
    if (loops_in_component[graph.component[c.loop[0].edge]] == 1) gain = std::max(gain, kSomeGain);
    LoopSelectionProblem::Item item = make_item(c, gain, requested, fold_cost);
    if (!has_capacity(item, search.problem.capacity) || item.gain <= 1e-9) continue;
    search.problem.items.push_back(std::move(item));
    search.loops.push_back(std::move(c));
  }
}

// Prices of two loops on one arc.
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

constexpr double kFreeEdgeAngle = 120;  // degrees, the mean inside angle

// The loops that were traced in a graph, and the problem of choosing among them.
RegionSearchResult make_problem(const RegionGraph& graph, const FixedRegions& fixed_regions,
                                const LoopCosts& costs, const Progress& progress) {
  RegionSearchResult search;
  // 1. Trace loops. Each comes with its own cost.
  TracedLoops traced = trace_loops(graph, costs, progress);
  search.complete = traced.complete;
  progress.update("regions: choice", 0);

  // 2. What loops are worth: their gains, and the prices of pairs on one arc.
  const double fold_cost = costs.fold / std::max(1, fixed_regions.max_faces_per_edge - 1);
  search.problem.capacity.assign(graph.edges.size(), fixed_regions.max_faces_per_edge);
  const RequestedLoops requested =
      fix_requested(graph, fixed_regions, costs, search.problem.capacity);
  add_items(graph, requested, costs, fold_cost, traced.loops, search);
  add_pairs(graph, fold_cost, search);
  return search;
}

// Uses of each arc that are still free.
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

// Whether an arc that does not dangle is left without a loop.
bool has_unused_edges(const RegionSearchResult& search, const std::vector<bool>& core) {
  const std::vector<int> left = edges_with_free_side(search);
  for (size_t a = 0; a < left.size(); ++a)
    if (core[a] && search.problem.capacity[a] > 0 && left[a] == search.problem.capacity[a])
      return true;
  return false;
}

// Whether every arc that does not dangle has a loop, and loops for a free side that do not run like
// rims.
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
  // 3. Choose.
  search.selected = select_loops(search.problem);
  progress.update("regions: choice", 1);
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
  // Loops with the inside angles of plane ones, (n - 2) π in all, are worth more; others were chosen
  // before.
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
  // An edge of 2 degrees costs no more than one of 90; surfaces that lie on each other do.
  constexpr double kLiesOn = 179.5;
  const double most = costs.fold * square(kLiesOn / 90);
  for (auto& pair : search.problem.pairs)
    if (pair.pair_cost < most) pair.pair_cost = std::min(pair.pair_cost, costs.fold);
  search.selected = select_loops(search.problem);
  progress.update("regions: choice", 1);
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
  progress.update("regions: choice", 1);
  if (has_free_edges(search)) return std::nullopt;
  return search;
}

}  // namespace batten
