#include "batten/skinning/search/region_words.h"

#include <algorithm>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/words.h"

namespace batten {
namespace {

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
    if (options_.most_at_arc < 1)
      throw InputError("most_at_arc is " + std::to_string(options_.most_at_arc) +
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
    spoken_.settled.most_at_arc = options_.most_at_arc;
    std::map<int, int> uses;
    for (const NetworkRegion& region : spoken_.regions)
      for (const ArcLoop& loop : region.loops)
        for (const ArcUse& use : loop)
          if (++uses[use.arc] > options_.most_at_arc)
            throw InputError(options_.words.front().where +
                             "surfaces that are asked for: " + std::to_string(uses[use.arc]) +
                             " of them meet at '" + graph_.arcs[use.arc].name +
                             "', and most_at_arc is " + std::to_string(options_.most_at_arc));
  }

  const RegionGraph& graph_;
  const RegionOptions& options_;
  SpokenRegions spoken_;
  std::map<std::vector<int>, std::string> said_;
  std::string who_;
};

}  // namespace

SpokenRegions resolved_words(const RegionGraph& graph, const RegionOptions& options) {
  return Words(graph, options).resolve();
}

}  // namespace batten
