// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/load_edits.h"

#include <algorithm>

#include "batten/apps/documents/line_edits.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;
const SceneTable kStress{"stress", ""};

/// True if a list is a key of [stress] with inline tables, not tables [[stress.KEY]].
bool in_braces(const SceneText& scene, const std::string& key) {
  if (!scene.has(kStress)) return false;
  const auto values = scene.values(kStress);
  return std::any_of(values.begin(), values.end(),
                     [&](const auto& value) { return value.first == key; });
}

/// The inline tables of a list; empty if it has another form.
std::vector<toml::table> list_of(const SceneText& scene, const std::string& key) {
  std::vector<toml::table> tables;
  if (!in_braces(scene, key)) return tables;
  const std::string value = scene.value(kStress, key);
  const toml::table root = parse_toml("list = " + value, {}, "a list");
  const toml::array* list = root["list"].as_array();
  if (!list) return tables;
  for (const toml::node& one : *list)
    if (const toml::table* table = one.as_table())
      tables.push_back(*table);
    else if (const auto* name = one.as_string())  // the curve of a clamped support
      tables.push_back(toml::table{{"curve", name->get()}});
  return tables;
}

/// The inline tables of a list, as text.
std::vector<std::string> inline_tables(const SceneText& scene, const std::string& key) {
  std::vector<std::string> items;
  for (const toml::table& table : list_of(scene, key)) items.push_back(to_toml(table));
  return items;
}

DocumentCommand list_edit(const std::string& key, const std::vector<std::string>& items) {
  return {.kind = CommandKind::Set, .table = kStress, .key = key, .text = SceneText::list(items)};
}

/// The tables of a list, with one replaced by `words`, or removed if `words` is empty.
std::vector<DocumentCommand> with_item(const SceneText& scene, const StressPart& part,
                                       const std::string& words) {
  std::vector<std::string> items = inline_tables(scene, part.list);
  if (part.item >= static_cast<int>(items.size())) return {};
  const auto item = items.begin() + part.item;
  if (words.empty())
    items.erase(item);
  else
    *item = words;
  return {list_edit(part.list, items)};
}

bool is_of(const toml::table& support, const std::string& line) {
  return support["curve"].value_or(std::string()) == line;
}

}  // namespace

std::string support_of(const SceneText& scene, const std::string& line) {
  for (const toml::table& support : list_of(scene, "supports"))
    if (is_of(support, line)) return support["type"].value_or(std::string("clamped"));
  return "";
}

std::vector<DocumentCommand> support_edits(const SceneText& scene, const std::string& line,
                                           const std::string& kind) {
  const std::string support =
      "{ curve = " + SceneText::toml_value(line) + ", type = " + SceneText::toml_value(kind) + " }";
  if (!scene.has(kStress)) {
    const bool metres = scene.value({}, "unit") == "\"m\"";
    return {{.kind = CommandKind::Add,
             .table = {"[stress]", ""},
             .text = std::string("{ thickness = ") + (metres ? "0.001" : "1") +
                     ", material = \"steel\", supports = [" + support + "] }"}};
  }
  std::vector<std::string> items;
  for (const toml::table& other : list_of(scene, "supports"))
    if (!is_of(other, line)) items.push_back(to_toml(other));
  if (!in_braces(scene, "supports")) return {};
  if (!kind.empty()) items.push_back(support);
  return {list_edit("supports", items)};
}

std::vector<DocumentCommand> stress_load_edits(const SceneText& scene, const std::string& load) {
  const bool stated = scene.has(kStress) && !scene.value(kStress, "loads").empty();
  if (!scene.has(kStress) || (stated && !in_braces(scene, "loads"))) return {};
  std::vector<std::string> items = inline_tables(scene, "loads");
  items.push_back(load);
  return {list_edit("loads", items)};
}

std::vector<StressPart> stress_parts(const SceneText& scene) {
  std::vector<StressPart> parts;
  for (const char* list : {"supports", "loads"}) {
    int item = 0;
    for (const toml::table& table : list_of(scene, list)) {
      const bool support = list == std::string("supports");
      StressPart part{list, item++, support ? "clamped" : "load", ""};
      for (const auto& [key, node] : table) {
        const std::string name(key.str());
        part.values.emplace_back(name, to_toml(node));
        if (name == "type") part.kind = node.value_or(part.kind);
        if (name == "curve" || name == "face") part.of = node.value_or(std::string());
        constexpr const char* acting[] = {
            "pressure", "force",      "moment",      "gravity",      "hydrostatic",
            "traction", "edge_force", "total_force", "total_moment", "angular_velocity"};
        if (!support && std::find(std::begin(acting), std::end(acting), name) != std::end(acting))
          part.kind = name;
      }
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

std::vector<DocumentCommand> stress_part_edits(const SceneText& scene, const StressPart& part,
                                               const std::string& key, const std::string& value) {
  const std::vector<toml::table> tables = list_of(scene, part.list);
  if (part.item >= static_cast<int>(tables.size())) return {};
  toml::table changed = tables[static_cast<size_t>(part.item)];
  const toml::table given = parse_toml("value = " + value, {}, "a value");
  changed.insert_or_assign(key, *given.get("value"));
  return with_item(scene, part, to_toml(changed));
}

std::vector<DocumentCommand> remove_stress_part(const SceneText& scene, const StressPart& part) {
  return with_item(scene, part, "");
}

namespace {

/// An entry of a list of strokes: position, radius, and its text.
struct Stroke {
  BrushDab dab;
  std::string words;
};

std::vector<Stroke> strokes_of(const SceneText& scene, const SceneTable& table) {
  std::vector<Stroke> strokes;
  const std::string value = scene.has(table) ? scene.value(table, "paint") : "";
  if (value.empty()) return strokes;
  const toml::table root = parse_toml("paint = " + value, {}, "strokes");
  const toml::array* list = root["paint"].as_array();
  for (size_t i = 0; list && i < list->size(); ++i) {
    const toml::table* stroke = list->get(i)->as_table();
    const toml::array* at = stroke ? (*stroke)["at"].as_array() : nullptr;
    if (!at || at->size() != 3) continue;
    BrushDab dab;
    for (size_t k = 0; k < 3; ++k) dab.at[static_cast<long>(k)] = at->get(k)->value_or(0.0);
    dab.radius = (*stroke)["radius"].value_or(0.0);
    strokes.push_back({dab, to_toml(*stroke)});
  }
  return strokes;
}

std::string dab_to_toml(const BrushDab& dab) {
  return "{ at = " + SceneText::toml_value(dab.at) +
         ", radius = " + SceneText::toml_value(dab.radius) + " }";
}

}  // namespace

bool is_painted(const SceneText& scene, const SceneTable& table) {
  if (!scene.has(table) || !scene.value(table, "near").empty()) return false;
  const std::string type = scene.value(table, "type");
  return table.kind == "stiffness" ||
         (table.kind == "load" && (type == "\"pressure\"" || type == "\"uniform\""));
}

std::vector<BrushDab> painted_dabs(const SceneText& scene, const SceneTable& table) {
  std::vector<BrushDab> dabs;
  for (const Stroke& stroke : strokes_of(scene, table)) dabs.push_back(stroke.dab);
  return dabs;
}

std::vector<DocumentCommand> paint_edits(const SceneText& scene, const SceneTable& table,
                                         const std::vector<BrushDab>& dabs, bool erases) {
  std::vector<std::string> words;
  const std::vector<Stroke> strokes = strokes_of(scene, table);
  for (const Stroke& stroke : strokes) {
    const bool covered = std::any_of(dabs.begin(), dabs.end(), [&](const BrushDab& dab) {
      return (stroke.dab.at - dab.at).norm() < dab.radius;
    });
    if (!erases || !covered) words.push_back(stroke.words);
  }
  if (erases && words.size() == strokes.size()) return {};
  if (words.empty() && erases) return {{.kind = CommandKind::Remove, .table = table}};
  for (const BrushDab& dab : dabs)
    if (!erases) words.push_back(dab_to_toml(dab));
  return {
      {.kind = CommandKind::Set, .table = table, .key = "paint", .text = SceneText::list(words)}};
}

DocumentCommand new_paint(const std::string& name, const std::string& kind,
                          const std::vector<BrushDab>& dabs) {
  std::vector<std::string> words;
  for (const BrushDab& dab : dabs) words.push_back(dab_to_toml(dab));
  const bool load = kind == "pressure";
  return {.kind = CommandKind::Add,
          .table = {load ? "load" : "stiffness", ""},
          .text = "{ name = " + SceneText::toml_value(name) +
                  ", type = " + SceneText::toml_value(kind) + ", value = 0" +
                  (load ? "" : ", min = 0") + ", paint = " + SceneText::list(words) + " }"};
}

}  // namespace batten
