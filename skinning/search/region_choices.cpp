#include "batten/skinning/search/region_choices.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "batten/skinning/search/region_surfaces.h"

namespace batten {
namespace {

constexpr size_t kMostAlternatives = 5;

std::string percent(double margin) {
  return std::to_string(static_cast<int>(std::lround(100 * std::max(margin, 0.0)))) + " %";
}

void write_text(const RegionGraph& graph, RegionChoice& choice) {
  const std::vector<ArcLoop>& other = choice.alternatives.front();
  const std::string cost = " costs " + percent(choice.margins.front()) + " more";
  if (choice.chosen.empty())
    choice.text = "no surface was made in " + said(graph, other) + "; to have it" + cost +
                  ": ask for a surface with these lines";
  else if (other.empty())
    choice.text = "a surface was made in " + said(graph, choice.chosen) + "; to leave it open" +
                  cost + ": say that there is no surface in this loop";
  else
    choice.text = "surfaces were made in " + said(graph, choice.chosen) + "; to have them in " +
                  said(graph, other) + " instead" + cost + ": ask for surfaces with these lines";
}

}  // namespace

std::string said(const RegionGraph& graph, const std::vector<ArcLoop>& loops) {
  constexpr size_t most_named = 6, named = 3;
  std::string all;
  for (const ArcLoop& loop : loops) {
    all += all.empty() ? "[" : ", [";
    const bool some = loop.size() > most_named;
    for (size_t i = 0; i < (some ? named : loop.size()); ++i)
      all += (i ? ", '" : "'") + graph.arcs[loop[i].arc].name + "'";
    if (some) all += ", … " + std::to_string(loop.size()) + " lines";
    all += "]";
  }
  return all;
}

void place_choice(const RegionGraph& graph, RegionChoice& choice) {
  std::set<int> arcs;
  const auto add = [&](const std::vector<ArcLoop>& loops) {
    for (const ArcLoop& loop : loops)
      for (const ArcUse& use : loop) arcs.insert(use.arc);
  };
  add(choice.chosen);
  for (const auto& loops : choice.alternatives) add(loops);
  choice.arcs.clear();
  choice.where = Vec3::Zero();
  for (const int arc : arcs) {
    choice.arcs.push_back(graph.arcs[arc].name);
    choice.where +=
        graph.arcs[arc].points[RegionArc::kPieces / 2] / static_cast<double>(arcs.size());
  }
}

std::vector<RegionChoice> near_choices(const RegionGraph& graph, const RegionSearch& search,
                                       const LoopPrices& prices, double most) {
  const std::vector<Otherwise> all = otherwise(search.problem, search.selected);
  const auto worth = [&](const std::vector<int>& items) {
    double sum = 0;
    for (const int i : items)
      sum += prices.covered * static_cast<double>(search.loops[i].loop.size());
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
  std::vector<RegionChoice> choices;
  for (auto& [key, some] : rivals) {
    std::sort(some.begin(), some.end(), [](const Rival& a, const Rival& b) {
      return a.margin != b.margin ? a.margin < b.margin : a.in < b.in;
    });
    RegionChoice choice;
    for (const int i : key.first) choice.chosen.push_back(search.loops[i].loop);
    std::set<std::vector<int>> seen;
    for (const Rival& rival : some) {
      if (choice.alternatives.size() == kMostAlternatives || !seen.insert(rival.in).second)
        continue;
      choice.alternatives.emplace_back();
      for (const int i : rival.in) choice.alternatives.back().push_back(search.loops[i].loop);
      choice.margins.push_back(rival.margin);
    }
    place_choice(graph, choice);
    write_text(graph, choice);
    choices.push_back(std::move(choice));
  }
  return choices;
}

namespace {

// What a surface in a rim would have to do with the regions beside it.
struct CapFolds {
  double fold = 0;    // mean, degrees
  double price = 0;   // of all folds
  bool same = false;  // a region has these arcs already
};

CapFolds measure_folds(const RegionGraph& graph, const LoopCandidate& cap,
                       const std::vector<NetworkRegion>& regions, const LoopPrices& prices) {
  const std::vector<int> arcs = arcs_of(cap.loop);
  CapFolds result;
  const auto beside = [&](const ArcLoop& loop) {
    return std::any_of(loop.begin(), loop.end(), [&](const ArcUse& use) {
      return std::binary_search(arcs.begin(), arcs.end(), use.arc);
    });
  };
  for (const NetworkRegion& region : regions) {
    for (size_t k = 0; k < region.loops.size(); ++k) {
      if (!beside(region.loops[k])) continue;
      if (region.loops.size() == 1 && arcs_of(region.loops[0]) == arcs) result.same = true;
      const LoopCandidate other = measured(graph, region.loops[k], prices);
      for (size_t i = 0; i < cap.loop.size(); ++i)
        for (size_t j = 0; j < other.loop.size(); ++j)
          if (cap.loop[i].arc == other.loop[j].arc) {
            double degrees = fold_deg(cap, i, other, j);
            if (k > 0) degrees = 180 - degrees;
            result.fold += degrees / static_cast<double>(cap.loop.size());
            result.price += prices.fold * degrees * degrees / 8100;
          }
    }
  }
  return result;
}

}  // namespace

std::vector<RegionChoice> rim_choices(const RegionGraph& graph, const RegionSearch& search,
                                      const std::vector<NetworkRegion>& regions,
                                      const std::vector<int>& rims,
                                      const std::vector<std::vector<int>>& nothing,
                                      const LoopPrices& prices) {
  std::vector<RegionChoice> choices;
  for (const ArcLoop& loop : closed_chains(graph, rims)) {
    const LoopCandidate cap = measured(graph, loop, prices);
    if (std::binary_search(nothing.begin(), nothing.end(), arcs_of(cap.loop))) continue;
    const CapFolds folds = measure_folds(graph, cap, regions, prices);
    if (folds.same || folds.fold > 150) continue;
    RegionChoice choice;
    choice.alternatives = {{cap.loop}};
    choice.margins = {std::max(0.0, folds.price - cap.gain(prices)) /
                      (prices.covered * static_cast<double>(cap.loop.size()))};
    // Items that were left out are among the near choices, or far from them.
    const bool item = std::any_of(search.loops.begin(), search.loops.end(),
                                  [&](const LoopCandidate& c) { return c.loop == cap.loop; });
    if (item && choice.margins[0] <= 0.15) continue;
    place_choice(graph, choice);
    choice.text = "the rim of " + std::to_string(cap.loop.size()) + " lines " +
                  said(graph, choice.alternatives[0]) +
                  " was left open; to close it, ask for a surface with these lines";
    choices.push_back(std::move(choice));
  }
  return choices;
}

}  // namespace batten
