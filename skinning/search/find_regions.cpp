#include "batten/skinning/search/find_regions.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/skinning/search/region_choices.h"
#include "batten/skinning/search/region_search.h"
#include "batten/skinning/search/region_surfaces.h"

namespace batten {
namespace {

/// What the user's words ask for, as loops.
struct SpokenRegions {
  SettledRegions settled;
  std::vector<NetworkRegion> regions;  ///< those asked for, in the order of the words
};

std::string quoted(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "'" : ", '") + name + "'";
  return all;
}

class Words {
 public:
  Words(const RegionGraph& graph, const RegionOptions& options)
      : graph_(graph), options_(options) {}

  SpokenRegions resolve() {
    if (options_.most_at_line < 1)
      throw InputError("most_at_line is " + std::to_string(options_.most_at_line) +
                       "; at least one region must be let at an arc");
    for (const RegionWord& word : options_.words) {
      who_ = word.where + (word.name.empty() ? "a surface" : "surface '" + word.name + "'");
      if (word.kind == RegionWord::Kind::Nothing) who_ = word.where + "no surface";
      if (word.loops.empty()) throw InputError(who_ + ": no lines are named");
      (word.kind == RegionWord::Kind::Surface ? surface(word) : nothing(word));
    }
    for (const auto& arcs : spoken_.settled.nothing)
      if (const auto it = said_.find(arcs); it != said_.end())
        throw InputError(it->second + ": the same loop is also said to be no surface");
    limit();
    auto& nothing = spoken_.settled.nothing;
    std::sort(nothing.begin(), nothing.end());
    return std::move(spoken_);
  }

 private:
  std::vector<int> arcs(const std::string& name) const {
    const std::vector<int> found = graph_.named(name);
    if (!found.empty()) return found;
    std::vector<std::string> names;
    for (const RegionArc& arc : graph_.arcs) {
      names.push_back(arc.name);
      names.push_back(arc.line);
    }
    const std::string near = nearest_word(name, names);
    throw InputError(who_ + ": there is no line '" + name + "' in the network" +
                     (near.empty() ? "" : "; '" + near + "' is meant?"));
  }

  // One closed trail through all arcs (Hierholzer), each as often as it is named.
  ArcLoop chained(const std::vector<std::string>& names) const {
    if (names.empty()) throw InputError(who_ + ": a loop has no lines");
    std::vector<int> all;
    for (const std::string& name : names) {
      const std::vector<int> some = arcs(name);
      all.insert(all.end(), some.begin(), some.end());
    }
    std::sort(all.begin(), all.end());
    std::map<int, std::vector<int>> at;  // places in `all`, at each node
    for (int i = 0; i < count_of(all); ++i)
      for (const int node : graph_.arcs[all[i]].nodes) at[node].push_back(i);
    for (const auto& [node, places] : at)
      if (places.size() % 2)
        throw InputError(who_ + ": lines " + quoted(names) + " do not close a loop: '" +
                         graph_.arcs[all[places.back()]].name + "' is loose at " +
                         batten::at(graph_.nodes[node]));
    std::vector<char> used(all.size(), 0);
    std::map<int, size_t> next;
    struct Step {
      int node;
      ArcUse by;
    };
    std::vector<Step> path{{graph_.arcs[all[0]].nodes[0], {-1, false}}};
    ArcLoop loop;
    while (!path.empty()) {
      const Step here = path.back();
      auto& places = at[here.node];
      size_t& k = next[here.node];
      while (k < places.size() && used[places[k]]) ++k;
      if (k == places.size()) {
        path.pop_back();
        if (here.by.arc >= 0) loop.push_back(here.by);
        continue;
      }
      used[places[k]] = 1;
      const RegionArc& arc = graph_.arcs[all[places[k]]];
      const bool reversed = arc.nodes[0] != here.node;
      path.push_back({arc.nodes[!reversed], {all[places[k]], reversed}});
    }
    if (loop.size() != all.size())
      throw InputError(who_ + ": lines " + quoted(names) + " make more than one loop");
    std::reverse(loop.begin(), loop.end());
    return canonical(loop);
  }

  void surface(const RegionWord& word) {
    if (word.ring && word.loops.size() != 2)
      throw InputError(who_ + ": a ring has two rims, and there are " +
                       std::to_string(word.loops.size()) + " loops");
    NetworkRegion region;
    region.name = word.name;
    region.ring = word.ring;
    region.skin = word.skin;
    region.asked = true;
    for (const auto& names : word.loops) region.loops.push_back(chained(names));
    std::vector<int> border;
    for (const ArcLoop& loop : region.loops)
      for (const ArcUse& use : loop) border.push_back(use.arc);
    for (const std::string& name : word.inner)
      for (const int arc : arcs(name)) {
        if (std::find(border.begin(), border.end(), arc) != border.end())
          throw InputError(who_ + ": '" + name + "' is an inner line and a border");
        region.inner.push_back(arc);
      }
    std::sort(region.inner.begin(), region.inner.end());
    region.inner.erase(std::unique(region.inner.begin(), region.inner.end()), region.inner.end());
    std::sort(border.begin(), border.end());
    if (!said_.try_emplace(border, who_).second)
      throw InputError(who_ + ": the same loop is asked for twice");
    for (const NetworkRegion& other : spoken_.regions)
      if (!region.name.empty() && other.name == region.name)
        throw InputError(who_ + ": another surface has this name");
    spoken_.settled.asked.push_back(region.loops);
    spoken_.regions.push_back(std::move(region));
  }

  void nothing(const RegionWord& word) {
    for (const auto& names : word.loops) spoken_.settled.nothing.push_back(arcs_of(chained(names)));
  }

  void limit() {
    spoken_.settled.most_at_line = options_.most_at_line;
    std::map<int, int> uses;
    for (const NetworkRegion& region : spoken_.regions)
      for (const ArcLoop& loop : region.loops)
        for (const ArcUse& use : loop)
          if (++uses[use.arc] > options_.most_at_line)
            throw InputError(options_.words.front().where +
                             "surfaces that are asked for: " + std::to_string(uses[use.arc]) +
                             " of them meet at '" + graph_.arcs[use.arc].name +
                             "', and most_at_line is " + std::to_string(options_.most_at_line));
  }

  const RegionGraph& graph_;
  const RegionOptions& options_;
  SpokenRegions spoken_;
  std::map<std::vector<int>, std::string> said_;
  std::string who_;
};

/// Finds the arcs of each name and chains them into loops. Throws InputError: a name that is not
/// there (with the nearest one), arcs that do not close one loop, a ring without two rims, an inner
/// line that is also a border, one loop said twice or to be both a surface and none, more regions
/// on an arc than `most_at_line`.
SpokenRegions resolved_words(const RegionGraph& graph, const RegionOptions& options) {
  return Words(graph, options).resolve();
}

class Finder {
 public:
  // `exact`: the graph with the curves' own tangents; null: there is none.
  Finder(const RegionGraph& graph, const RegionGraph* exact, const RegionOptions& options,
         const Progress& progress)
      : graph_(graph), exact_(exact ? *exact : graph), progress_(progress) {
    for (const RegionArc& arc : graph_.arcs)
      for (const Vec3& p : arc.points)
        if (!p.allFinite())
          throw InputError("line '" + arc.name + "' has points that are not finite");
    SpokenRegions spoken = resolved_words(graph_, options);
    settled_ = std::move(spoken.settled);
    found_.regions = std::move(spoken.regions);
    // A line that is said to lie inside of a surface is no border.
    for (const NetworkRegion& region : found_.regions)
      for (const int arc : region.inner) graph_.core[arc] = exact_.core[arc] = false;
  }

  FoundRegions find() {
    search_ = search_regions(graph_, settled_, prices_, progress_);
    if (auto closed = closed_search(search_, exact_, settled_, prices_, progress_)) {
      search_ = std::move(*closed);
      graph_ = exact_;
    } else if (auto sharp = sharp_search(search_, exact_, settled_, prices_, progress_)) {
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
    found_.choices = near_choices(graph_, search_, prices_);
    if (!ring()) islands();
    holes();
    find_inner_lines(graph_, prices_, found_.regions);
    if (!found_.regions.empty()) place_stated(graph_, found_.regions);
    std::tie(found_.bare, found_.rims) = bare_and_rims();
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
    if (!like_rims(exact_, a, b)) return false;
    regions[0].loops = {a, b};
    regions[0].ring = true;
    regions[0].cost += regions[1].cost;
    regions.pop_back();
    RegionChoice choice;
    choice.chosen = {a, b};
    choice.alternatives = {{a}, {b}};
    choice.one_surface = true;
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
      choice.one_surface = true;
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

  // What stands on a plane face, or goes through it, has its rim there.
  void holes() {
    for (PlaneHole& hole : find_plane_holes(graph_, found_.regions, bare_and_rims().second))
      found_.regions[hole.on].loops.push_back(std::move(hole.loop));
  }

  // The arcs without a region, and those with one.
  std::pair<std::vector<int>, std::vector<int>> bare_and_rims() const {
    std::vector<int> uses(graph_.arcs.size(), 0), bare, rims;
    for (const NetworkRegion& region : found_.regions) {
      for (const ArcLoop& loop : region.loops)
        for (const ArcUse& use : loop) ++uses[use.arc];
      for (const int arc : region.inner) uses[arc] += 2;
    }
    for (size_t a = 0; a < uses.size(); ++a)
      if (uses[a] < 2) (uses[a] == 0 ? bare : rims).push_back(static_cast<int>(a));
    return {bare, rims};
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

  RegionGraph graph_, exact_;
  const Progress& progress_;
  LoopPrices prices_;
  SettledRegions settled_;
  RegionSearch search_;
  FoundRegions found_;
};

}  // namespace

FoundRegions find_regions(const RegionGraph& graph, const RegionOptions& options,
                          const Progress& progress) {
  return Finder(graph, nullptr, options, progress).find();
}

FoundRegions find_regions(const CharacterLineNetwork& network, const RegionOptions& options,
                          const Progress& progress) {
  const RegionGraph exact(network, RegionGraph::EndTangents::OfCurve);
  return Finder(RegionGraph(network), &exact, options, progress).find();
}

}  // namespace batten
