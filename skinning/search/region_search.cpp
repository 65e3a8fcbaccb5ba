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
  size_t place;
};

std::vector<std::vector<Use>> uses_by_arc(const std::vector<LoopCandidate>& loops, size_t arcs) {
  std::vector<std::vector<Use>> all(arcs);
  for (size_t c = 0; c < loops.size(); ++c)
    for (size_t i = 0; i < loops[c].loop.size(); ++i)
      all[loops[c].loop[i].arc].push_back({static_cast<int>(c), i});
  return all;
}

// What the user asked for, measured.
struct AskedLoops {
  std::vector<LoopCandidate> loops;
  std::vector<std::vector<int>> settled_arcs;  // of loops that are no items, ascending
  std::vector<std::vector<Use>> uses;          // of `loops`, by arc
};

// What was asked for takes its room first; its neighbours pay for the fold.
AskedLoops settle_asked(const RegionGraph& graph, const SettledRegions& settled,
                        const LoopPrices& prices, std::vector<int>& room) {
  AskedLoops asked{{}, settled.nothing, {}};
  for (const auto& loops : settled.asked)
    for (size_t k = 0; k < loops.size(); ++k) {
      asked.loops.push_back(measured(graph, loops[k], prices));
      asked.settled_arcs.push_back(arcs_of(loops[k]));
      for (const ArcUse& use : loops[k]) --room[use.arc];
      // The surface lies outside of a hole.
      if (k > 0)
        for (auto& side : asked.loops.back().side)
          for (double& angle : side) angle += EIGEN_PI;
    }
  for (int& r : room) r = std::max(r, 0);
  std::sort(asked.settled_arcs.begin(), asked.settled_arcs.end());
  asked.uses = uses_by_arc(asked.loops, graph.arcs.size());
  return asked;
}

// The item of a loop; `gain` is that of the loop alone.
Selection::Item make_item(const LoopCandidate& c, double gain, const AskedLoops& asked,
                          double fold_price) {
  Selection::Item item;
  item.gain = gain;
  std::map<int, int> uses;
  for (size_t i = 0; i < c.loop.size(); ++i) {
    ++uses[c.loop[i].arc];
    for (const Use& other : asked.uses[c.loop[i].arc])
      item.gain -= fold_price * square(fold_deg(c, i, asked.loops[other.loop], other.place) / 90);
  }
  for (const auto& [arc, count] : uses) {
    item.arcs.push_back(arc);
    item.uses.push_back(count);
  }
  return item;
}

bool has_room(const Selection::Item& item, const std::vector<int>& room) {
  for (size_t i = 0; i < item.arcs.size(); ++i)
    if (item.uses[i] > room[item.arcs[i]]) return false;
  return true;
}

// Makes items of the loops that gain by themselves and have room.
void add_items(const RegionGraph& graph, const AskedLoops& asked, const LoopPrices& prices,
               double fold_price, std::vector<LoopCandidate>& traced, RegionSearch& search) {
  std::vector<int> loops_in_part(static_cast<size_t>(graph.part_count), 0);
  for (const LoopCandidate& c : traced) ++loops_in_part[graph.part[c.loop[0].arc]];
  for (LoopCandidate& c : traced) {
    if (std::binary_search(asked.settled_arcs.begin(), asked.settled_arcs.end(), arcs_of(c.loop)))
      continue;
    double gain = c.gain(prices);
    // The only loop of a part of the network bounds a surface, whatever it costs.
    constexpr double some_gain = 0.1;
    if (loops_in_part[graph.part[c.loop[0].arc]] == 1) gain = std::max(gain, some_gain);
    Selection::Item item = make_item(c, gain, asked, fold_price);
    if (!has_room(item, search.problem.room) || item.gain <= 1e-9) continue;
    search.problem.items.push_back(std::move(item));
    search.loops.push_back(std::move(c));
  }
}

// Prices of two loops on one arc.
void add_pairs(const RegionGraph& graph, double fold_price, RegionSearch& search) {
  const auto uses = uses_by_arc(search.loops, graph.arcs.size());
  for (size_t a = 0; a < uses.size(); ++a)
    for (size_t i = 0; i < uses[a].size(); ++i)
      for (size_t j = i + 1; j < uses[a].size(); ++j) {
        const auto [c, place] = uses[a][i];
        const auto [d, other] = uses[a][j];
        if (c == d) continue;
        const double fold = fold_deg(search.loops[c], place, search.loops[d], other);
        search.problem.pairs.push_back({static_cast<int>(a), c, d, fold_price * square(fold / 90)});
      }
}

bool was_chosen(const RegionSearch& open, const LoopCandidate& loop) {
  return std::any_of(open.loops.begin(), open.loops.end(), [&](const LoopCandidate& other) {
    return other.loop == loop.loop && open.selected.chosen[&other - open.loops.data()];
  });
}

constexpr double like_a_rim = 120;  // degrees, the mean inside angle

// The loops that were traced in a graph, and the problem of choosing among them.
RegionSearch make_problem(const RegionGraph& graph, const SettledRegions& settled,
                          const LoopPrices& prices, const Progress& progress) {
  RegionSearch search;
  // 1. Trace loops. Each comes with its own cost.
  TracedLoops traced = traced_loops(graph, prices, progress);
  search.complete = traced.complete;
  progress.at("regions: choice", 0);

  // 2. What loops are worth: their gains, and the prices of pairs on one arc.
  const double fold_price = prices.fold / std::max(1, settled.most_at_line - 1);
  search.problem.room.assign(graph.arcs.size(), settled.most_at_line);
  const AskedLoops asked = settle_asked(graph, settled, prices, search.problem.room);
  add_items(graph, asked, prices, fold_price, traced.loops, search);
  add_pairs(graph, fold_price, search);
  return search;
}

// Uses of each arc that are still free.
std::vector<int> arcs_with_a_free_side(const RegionSearch& search) {
  std::vector<int> left = search.problem.room;
  for (size_t i = 0; i < search.loops.size(); ++i)
    if (search.selected.chosen[i])
      for (const ArcUse& use : search.loops[i].loop) --left[use.arc];
  return left;
}

bool has_rims(const RegionSearch& search) {
  const std::vector<int> left = arcs_with_a_free_side(search);
  return std::any_of(left.begin(), left.end(), [](int sides) { return sides == 1; });
}

// Whether an arc that does not dangle is left without a loop.
bool has_bare_arcs(const RegionSearch& search, const std::vector<bool>& core) {
  const std::vector<int> left = arcs_with_a_free_side(search);
  for (size_t a = 0; a < left.size(); ++a)
    if (core[a] && search.problem.room[a] > 0 && left[a] == search.problem.room[a]) return true;
  return false;
}

// Whether every arc that does not dangle has a loop, and loops for a free side that do not run like
// rims.
bool may_close(const RegionSearch& search, const std::vector<bool>& core) {
  constexpr size_t most_arcs = 2000;
  std::vector<int> left = search.problem.room;
  if (left.size() > most_arcs) return false;
  const std::vector<int> free = arcs_with_a_free_side(search);
  for (size_t a = 0; a < free.size(); ++a)
    if (!core[a])
      left[a] = 0;
    else if (free[a] == 2)
      return false;
  for (size_t i = 0; i < search.loops.size(); ++i)
    if (search.selected.chosen[i] || search.loops[i].inside_deg <= like_a_rim)
      for (const ArcUse& use : search.loops[i].loop) --left[use.arc];
  return std::all_of(left.begin(), left.end(), [](int sides) { return sides <= 0; });
}

}  // namespace

RegionSearch search_regions(const RegionGraph& graph, const SettledRegions& settled,
                            const LoopPrices& prices, const Progress& progress) {
  RegionSearch search = make_problem(graph, settled, prices, progress);
  // 3. Choose.
  search.selected = select(search.problem);
  progress.at("regions: choice", 1);
  return search;
}

std::optional<RegionSearch> sharp_search(const RegionSearch& open, const RegionGraph& exact,
                                         const SettledRegions& settled, const LoopPrices& prices,
                                         const Progress& progress) {
  if (settled.most_at_line != 2 || !has_bare_arcs(open, exact.core)) return std::nullopt;
  RegionSearch search = make_problem(exact, settled, prices, progress);
  // Loops with the inside angles of plane ones, (n - 2) π in all, are worth more; others were chosen
  // before.
  constexpr double near_plane = 0.5, most_cost = 2;
  for (size_t i = 0; i < search.loops.size(); ++i) {
    const LoopCandidate& loop = search.loops[i];
    const auto n = static_cast<double>(loop.loop.size());
    double& gain = search.problem.items[i].gain;
    if (std::abs(loop.inside_deg * n / 180 - (n - 2)) <= near_plane &&
        loop.cost <= n - 2 + most_cost && loop.inside_deg <= like_a_rim + 1e-6)
      gain += prices.closed * n;
    else if (!was_chosen(open, loop))
      gain = -1;
  }
  // An edge of 2 degrees costs no more than one of 90; surfaces that lie on each other do.
  constexpr double lies_on = 179.5;
  const double most = prices.fold * square(lies_on / 90);
  for (auto& pair : search.problem.pairs)
    if (pair.price < most) pair.price = std::min(pair.price, prices.fold);
  search.selected = select(search.problem);
  progress.at("regions: choice", 1);
  if (has_rims(search) || has_bare_arcs(search, exact.core)) return std::nullopt;
  return search;
}

std::optional<RegionSearch> closed_search(const RegionSearch& open, const RegionGraph& exact,
                                          const SettledRegions& settled, const LoopPrices& prices,
                                          const Progress& progress) {
  if (settled.most_at_line != 2 || !has_rims(open) || !may_close(open, exact.core))
    return std::nullopt;
  RegionSearch search = make_problem(exact, settled, prices, progress);
  for (size_t i = 0; i < search.loops.size(); ++i) {
    const LoopCandidate& loop = search.loops[i];
    search.problem.items[i].gain += was_chosen(open, loop) || loop.inside_deg <= like_a_rim
                                        ? prices.closed * static_cast<double>(loop.loop.size())
                                        : -std::abs(search.problem.items[i].gain) - 1;
  }
  search.selected = select(search.problem);
  progress.at("regions: choice", 1);
  if (has_rims(search)) return std::nullopt;
  return search;
}

}  // namespace batten
