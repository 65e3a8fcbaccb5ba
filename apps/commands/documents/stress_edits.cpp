#include "batten/apps/commands/documents/stress_edits.h"

#include <algorithm>

#include "batten/io/scene/scene_words.h"

namespace batten {
namespace {

using Verb = DocumentCommand::Verb;
const SceneTable kStress{"stress", ""};

/// Whether a list stands as a key of [stress], not in tables [[stress.KEY]] of its own.
bool in_braces(const SceneText& scene, const std::string& key) {
  if (!scene.has(kStress)) return false;
  const auto values = scene.values(kStress);
  return std::any_of(values.begin(), values.end(),
                     [&](const auto& value) { return value.first == key; });
}

/// The tables of a list in braces; none when it has another form.
std::vector<toml::table> list_of(const SceneText& scene, const std::string& key) {
  std::vector<toml::table> tables;
  if (!in_braces(scene, key)) return tables;
  const std::string value = scene.value(kStress, key);
  const toml::table root = parse_toml("list = " + value, {}, "a list");
  if (const toml::array* list = root["list"].as_array())
    for (const toml::node& one : *list)
      if (const toml::table* table = one.as_table()) tables.push_back(*table);
  return tables;
}

DocumentCommand list_edit(const std::string& key, const std::vector<std::string>& items) {
  return {.verb = Verb::Set, .table = kStress, .key = key, .text = SceneText::list(items)};
}

bool is_of(const toml::table& support, const std::string& line) {
  return support["line"].value_or(std::string()) == line;
}

}  // namespace

std::string support_of(const SceneText& scene, const std::string& line) {
  for (const toml::table& support : list_of(scene, "supports"))
    if (is_of(support, line)) return support["kind"].value_or(std::string("clamped"));
  return "";
}

std::vector<DocumentCommand> support_edits(const SceneText& scene, const std::string& line,
                                           const std::string& kind) {
  const std::string support =
      "{ line = " + SceneText::word(line) + ", kind = " + SceneText::word(kind) + " }";
  if (!scene.has(kStress)) {
    const bool metres = scene.value({}, "unit") == "\"m\"";
    return {{.verb = Verb::Add,
             .table = {"[stress]", ""},
             .text = std::string("{ thickness = ") + (metres ? "0.001" : "1") +
                     ", material = \"steel\", supports = [" + support + "] }"}};
  }
  std::vector<std::string> items;
  for (const toml::table& other : list_of(scene, "supports"))
    if (!is_of(other, line)) items.push_back(toml_words(other));
  if (!in_braces(scene, "supports")) return {};
  if (!kind.empty()) items.push_back(support);
  return {list_edit("supports", items)};
}

std::vector<DocumentCommand> stress_load_edits(const SceneText& scene, const std::string& load) {
  const bool stated = scene.has(kStress) && !scene.value(kStress, "loads").empty();
  if (!scene.has(kStress) || (stated && !in_braces(scene, "loads"))) return {};
  std::vector<std::string> items;
  for (const toml::table& other : list_of(scene, "loads")) items.push_back(toml_words(other));
  items.push_back(load);
  return {list_edit("loads", items)};
}

}  // namespace batten
