#include "batten/apps/commands/documents/paint_edits.h"

#include <algorithm>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;

/// One entry of a list of strokes: its place, its radius, and its words.
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
  return "{ at = " + point_to_toml(dab.at) + ", radius = " + SceneText::word(dab.radius) + " }";
}

}  // namespace

bool is_painted(const SceneText& scene, const SceneTable& table) {
  if (!scene.has(table) || !scene.value(table, "near").empty()) return false;
  const std::string type = scene.value(table, "type");
  return table.kind == "weight" ||
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
          .table = {load ? "load" : "weight", ""},
          .text = "{ name = " + SceneText::word(name) + ", " + (load ? "type" : "kind") + " = " +
                  SceneText::word(kind) + ", value = 0" + (load ? "" : ", min = 0") +
                  ", paint = " + SceneText::list(words) + " }"};
}

}  // namespace batten
