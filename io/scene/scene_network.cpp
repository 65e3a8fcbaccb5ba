#include "batten/io/scene/scene_network.h"

#include <utility>

#include "batten/io/scene/scene_lines.h"
#include "batten/io/scene/scene_words.h"

namespace batten {
namespace {

using Refusals = std::vector<std::pair<const char*, const char*>>;

void refuse(const TomlTable& table, const std::string& what, const Refusals& refusals) {
  for (const auto& [key, reason] : refusals)
    if (table.has(key)) table.fail(key, "'" + std::string(key) + "' " + what, reason);
}

void refuse_what_does_not_fit(const TomlTable& root) {
  constexpr const char* found = "none: which lines bound a surface is found, or said by [[region]]";
  for (const TomlTable& t : root.tables("line", line_keys(true)))
    refuse(t, "in a network", {{"role", found}, {"treatment", "none: the domains decide"}});
  for (const TomlTable& t : root.tables("lines", lines_keys(true)))
    refuse(t, "in a network",
           {{"role", found},
            {"inner", found},
            {"holes", found},
            {"treatment", "none: the domains decide"}});
  for (const TomlTable& t : root.table("skin", skin_keys())) {
    constexpr const char* each = "none: each region of a network has the domain that suits it";
    refuse(t, "in a network",
           {{"domain", each}, {"settle", each}, {"mesher", each}, {"refine", "edge_length"}});
    for (const char* key : {"alpha", "beta"})
      if (t.has(key) && t.is_array(key))
        t.fail(key, "three numbers in a network",
               "one number: its regions have no direction of u in common");
  }
}

std::vector<std::string> loop_of(const TomlTable& table, const std::vector<PlacedWord>& words) {
  if (words.empty())
    table.fail("loops", "a loop without lines", "names of lines: loops = [[\"a\", \"b\", \"c\"]]");
  std::vector<std::string> names;
  for (const PlacedWord& word : words) names.push_back(word.text);
  return names;
}

RegionWord read_region(const TomlTable& table, Names& names) {
  RegionWord word;
  word.where = table.at("loops");
  word.kind =
      table.boolean("surface", true) ? RegionWord::Kind::Surface : RegionWord::Kind::Nothing;
  for (const auto& loop : table.word_rows("loops")) word.loops.push_back(loop_of(table, loop));
  if (word.loops.empty())
    table.fail("loops", "no loop", "one or more: loops = [[\"a\", \"b\", \"c\"]]");
  word.ring = table.boolean("ring", false);
  for (const PlacedWord& inner : table.words("inner")) word.inner.push_back(inner.text);
  if (word.kind == RegionWord::Kind::Nothing) {
    refuse(table, "of a loop without surface",
           {{"name", "none: what is not there has no name"},
            {"ring", "none"},
            {"inner", "none: nothing lies on it"}});
    if (word.loops.size() > 1)
      table.fail("loops", std::to_string(word.loops.size()) + " loops beside surface = false",
                 "one; a [[region]] for each");
    return word;
  }
  if (table.has("name")) {
    word.name = table.text("name");
    if (word.name.empty()) table.fail("name", "an empty name", "one with letters");
    names.add(table, "name", word.name);
  }
  if (word.ring && word.loops.size() != 2)
    table.fail("ring", "ring = true with " + std::to_string(word.loops.size()) + " loops",
               "2, its rims");
  return word;
}

}  // namespace

void read_network(const TomlTable& root, Scene& scene) {
  const auto networks = root.table(
      "network", {"tolerance", "straight_angle", "most_at_line", "smooth_below", "join_tolerance"});
  if (networks.empty()) {
    for (const char* key : {"region", "join"})
      if (root.has(key))
        root.fail(key, "[[" + std::string(key) + "]] without [network]",
                  "both: [network] makes surfaces between all lines");
    return;
  }
  refuse_what_does_not_fit(root);
  const TomlTable& table = networks.front();
  SceneNetwork network;
  network.place = table.place();
  network.tolerance = table.positive("tolerance", 0);
  const auto angle = [&](const std::string& key, double& degrees, double most) {
    degrees = table.has(key) ? table.number(key) : degrees;
    if (!(degrees >= 0 && degrees <= most))
      table.fail(key, number(degrees), "0 to " + number(most) + " degrees");
  };
  angle("straight_angle", network.straight_angle, 45);
  angle("smooth_below", network.smooth_below, 180);
  network.join_tolerance = table.positive("join_tolerance", network.join_tolerance);
  network.most_at_line = table.whole_number("most_at_line", 1, network.most_at_line);
  if (network.most_at_line > 16)
    table.fail("most_at_line", std::to_string(network.most_at_line), "1 to 16");

  Names names("region name");
  for (const TomlTable& t : root.tables("region", {"name", "loops", "inner", "ring", "surface"}))
    network.regions.push_back(read_region(t, names));
  for (const TomlTable& t : root.tables("join", {"lines", "kind"})) {
    const bool smooth = t.choice<bool>("kind", {{"crease", false}, {"smooth", true}});
    const auto lines = t.words("lines");
    if (lines.empty()) t.fail("lines", "no lines", "names: lines = [\"a\", \"b\"]");
    for (const PlacedWord& line : lines)
      network.joins.push_back({line.text, smooth, scene.at(line.place)});
  }
  scene.network = std::move(network);
}

}  // namespace batten
