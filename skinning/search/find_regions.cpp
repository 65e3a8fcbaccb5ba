#include "batten/skinning/search/find_regions.h"

#include <algorithm>
#include <set>

#include "batten/core/errors.h"
#include "batten/skinning/search/region_choices.h"
#include "batten/skinning/search/region_surfaces.h"
#include "batten/skinning/search/region_words.h"

namespace batten {
namespace {

class Finder {
 public:
  Finder(const RegionGraph& graph, const RegionOptions& options, const Progress& progress)
      : graph_(graph), progress_(progress) {
    for (const RegionArc& arc : graph_.arcs)
      for (const Vec3& p : arc.points)
        if (!p.allFinite())
          throw InputError("line '" + arc.name + "' has points that are not finite");
    SpokenRegions spoken = resolved_words(graph_, options);
    settled_ = std::move(spoken.settled);
    found_.regions = std::move(spoken.regions);
    // A line that is said to lie inside of a surface is no border.
    for (const NetworkRegion& region : found_.regions)
      for (const int arc : region.inner) graph_.core[arc] = false;
  }

  FoundRegions find() {
    search_ = search_regions(graph_, settled_, prices_, progress_);
    for (size_t i = 0; i < search_.loops.size(); ++i)
      if (search_.selected.chosen[i]) {
        NetworkRegion region;
        region.loops = {search_.loops[i].loop};
        region.cost = search_.loops[i].cost;
        found_.regions.push_back(std::move(region));
      }
    found_.optimal = search_.complete && search_.selected.optimal;
    found_.choices = near_choices(graph_, search_, prices_);
    if (!ring()) islands();
    find_inner_lines(graph_, prices_, found_.regions);
    count_uses();
    auto open =
        rim_choices(graph_, search_, found_.regions, found_.rims, settled_.nothing, prices_);
    found_.choices.insert(found_.choices.end(), open.begin(), open.end());
    name_regions();
    return std::move(found_);
  }

 private:
  // Two loops and nothing else.
  bool ring() {
    auto& regions = found_.regions;
    if (graph_.part_count != 2 || regions.size() != 2 || regions[0].asked || regions[1].asked)
      return false;
    const ArcLoop a = regions[0].loops[0], b = regions[1].loops[0];
    if (a.size() + b.size() != graph_.arcs.size() || graph_.part[a[0].arc] == graph_.part[b[0].arc])
      return false;
    if (!like_rims(graph_, a, b)) return false;
    regions[0].loops = {a, b};
    regions[0].ring = true;
    regions[0].cost += regions[1].cost;
    regions.pop_back();
    RegionChoice choice;
    choice.chosen = {a, b};
    choice.alternatives = {{a}, {b}};
    choice.margins = {0, 0};
    place_choice(graph_, choice);
    choice.text = "the two loops " + said(graph_, {a, b}) +
                  " are taken for the rims of a ring; for two discs ask for a surface with each";
    found_.choices = {choice};
    return true;
  }

  // Loops that are apart on the surface of another region are neither holes nor patches unasked.
  void islands() {
    std::vector<char> gone(found_.regions.size(), 0);
    for (const auto& [region, on] : find_islands(graph_, found_.regions)) {
      const ArcLoop loop = found_.regions[region].loops[0];
      const ArcLoop outline = found_.regions[on].loops[0];
      if (gone[on]) continue;
      gone[region] = 1;
      RegionChoice choice;
      choice.alternatives = {{outline, loop}, {loop}};
      choice.margins = {0, 0};
      place_choice(graph_, choice);
      choice.text = "the loop " + said(graph_, {loop}) + " lies on the surface in " +
                    said(graph_, {outline}) +
                    ", apart from its border, and was left bare; for a hole ask for a surface with "
                    "both loops, for a patch for a surface with this one";
      found_.choices.push_back(std::move(choice));
    }
    const auto is_gone = [&](const ArcLoop& loop) {
      for (size_t i = 0; i < gone.size(); ++i)
        if (gone[i] && found_.regions[i].loops[0] == loop) return true;
      return false;
    };
    std::erase_if(found_.choices, [&](const RegionChoice& choice) {
      return std::any_of(choice.chosen.begin(), choice.chosen.end(), is_gone);
    });
    size_t kept = 0;
    for (size_t i = 0; i < gone.size(); ++i)
      if (!gone[i]) {
        if (kept != i) found_.regions[kept] = std::move(found_.regions[i]);
        ++kept;
      }
    found_.regions.resize(kept);
  }

  void count_uses() {
    std::vector<int> uses(graph_.arcs.size(), 0);
    for (const NetworkRegion& region : found_.regions) {
      for (const ArcLoop& loop : region.loops)
        for (const ArcUse& use : loop) ++uses[use.arc];
      for (const int arc : region.inner) uses[arc] += 2;
    }
    for (size_t a = 0; a < uses.size(); ++a) {
      if (uses[a] == 0) found_.bare.push_back(static_cast<int>(a));
      if (uses[a] == 1) found_.rims.push_back(static_cast<int>(a));
    }
  }

  void name_regions() {
    std::set<std::string> taken;
    for (const NetworkRegion& region : found_.regions) taken.insert(region.name);
    int number = 0;
    for (NetworkRegion& region : found_.regions)
      while (region.name.empty()) {
        const std::string name = "region " + std::to_string(++number);
        if (!taken.count(name)) region.name = name;
      }
  }

  RegionGraph graph_;
  const Progress& progress_;
  LoopPrices prices_;
  SettledRegions settled_;
  RegionSearch search_;
  FoundRegions found_;
};

}  // namespace

FoundRegions find_regions(const RegionGraph& graph, const RegionOptions& options,
                          const Progress& progress) {
  return Finder(graph, options, progress).find();
}

FoundRegions find_regions(const CharacterLineNetwork& network, const RegionOptions& options,
                          const Progress& progress) {
  return Finder(RegionGraph(network), options, progress).find();
}

}  // namespace batten
