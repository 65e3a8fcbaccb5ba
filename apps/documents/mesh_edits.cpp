// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/mesh_edits.h"

#include <algorithm>
#include <sstream>

#include "batten/apps/documents/line_edits.h"
#include "batten/core/geometry.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;
using Part = MeshView::Part;

std::optional<SceneTable> last_edit(const SceneText& scene) {
  std::optional<SceneTable> last;
  for (const SceneTable& table : scene.tables())
    if (table.kind == "edit") last = table;
  return last;
}

/// The selections that a key of the last edit names.
std::vector<std::string> listed(const SceneText& scene, const char* key) {
  const auto edit = last_edit(scene);
  return edit ? scene.strings(*edit, key) : std::vector<std::string>{};
}

bool lists_part(const SceneText& scene, const char* key, const std::string& part) {
  const std::vector<std::string> words = listed(scene, key);
  return std::find(words.begin(), words.end(), part) != words.end();
}

/// The handle with this name in the last edit.
SceneTable handle_of(const SceneText& scene, const std::string& part) {
  const auto edit = last_edit(scene);
  return {"edit.handle", (edit ? edit->name : "") + "." + part};
}

/// The names matched by a list of features, without `part`.
std::vector<std::string> without(const std::vector<std::string>& words, const MeshView& mesh,
                                 const std::string& part) {
  std::vector<std::string> left;
  for (const std::string& word : words) {
    if (!matches_wildcard(word, part)) {
      left.push_back(word);
      continue;
    }
    for (const Part& one : mesh.parts)
      if (matches_wildcard(word, one.name) && one.name != part) left.push_back(one.name);
  }
  return left;
}

void release_part(const SceneText& scene, const MeshView& mesh, const std::string& part,
                  std::vector<DocumentCommand>& edits) {
  for (const SceneTable& table : scene.tables()) {
    if (table == SceneTable{"feature", part})
      edits.push_back({.kind = CommandKind::Remove, .table = table});
    if (table.kind != "features") continue;
    const std::vector<std::string> words = scene.strings(table, "of");
    const std::vector<std::string> left = without(words, mesh, part);
    if (left.empty())
      edits.push_back({.kind = CommandKind::Remove, .table = table});
    else if (left != words)
      edits.push_back({.kind = CommandKind::Set,
                       .table = table,
                       .key = "of",
                       .text = SceneText::toml_string_list(left)});
  }
  if (const SceneTable handle = handle_of(scene, part); scene.has(handle))
    edits.push_back({.kind = CommandKind::Remove, .table = handle});
  const auto edit = last_edit(scene);
  for (const char* key : {"fixed", "region_of_interest"}) {
    std::vector<std::string> words = listed(scene, key);
    if (std::erase(words, part) == 0) continue;
    if (words.empty())
      edits.push_back({.kind = CommandKind::Erase, .table = *edit, .key = key});
    else
      edits.push_back({.kind = CommandKind::Set,
                       .table = *edit,
                       .key = key,
                       .text = SceneText::toml_string_list(words)});
  }
}

}  // namespace

PartUse use_of(const SceneText& scene, const std::string& part) {
  if (scene.has(handle_of(scene, part))) return PartUse::Handle;
  if (lists_part(scene, "fixed", part)) return PartUse::Fixed;
  if (lists_part(scene, "region_of_interest", part)) return PartUse::Interest;
  for (const SceneTable& table : scene.tables()) {
    const std::vector<std::string> of =
        table.kind == "features" ? scene.strings(table, "of") : std::vector<std::string>{};
    const bool named = std::any_of(of.begin(), of.end(),
                                   [&](const auto& word) { return matches_wildcard(word, part); });
    if (named || table == SceneTable{"feature", part})
      return scene.value(table, "keep") == "\"orientation\"" ? PartUse::TranslationOnly
                                                             : PartUse::Rigid;
  }
  return PartUse::Free;
}

std::vector<DocumentCommand> use_edits(const SceneText& scene, const MeshView& mesh,
                                       const std::string& part, PartUse use) {
  std::vector<DocumentCommand> edits;
  if (use_of(scene, part) == use) return edits;
  release_part(scene, mesh, part, edits);
  if (use == PartUse::Free) return edits;
  const std::string name = SceneText::toml_value(part);
  for (const Part& one : mesh.parts)
    if (one.name == part && one.kind == Part::Kind::Set && !scene.has({"select", part}))
      edits.push_back({.kind = CommandKind::Add,
                       .table = {"select", ""},
                       .text = "{ name = " + name + ", " + one.key + " = " + name + " }"});
  const auto edit = last_edit(scene);
  const bool lists_it = use == PartUse::Fixed || use == PartUse::Interest;
  const bool moves = lists_it || use == PartUse::Handle;
  if (!edit && moves)
    edits.push_back(
        {.kind = CommandKind::Add, .table = {"edit", ""}, .text = "{ name = \"edit 1\" }"});
  if (lists_it) {
    const char* key = use == PartUse::Fixed ? "fixed" : "region_of_interest";
    std::vector<std::string> words = listed(scene, key);
    words.push_back(part);
    edits.push_back({.kind = CommandKind::Set,
                     .table = edit ? *edit : SceneTable{"edit", "edit 1"},
                     .key = key,
                     .text = SceneText::toml_string_list(words)});
  } else if (use == PartUse::Handle) {
    edits.push_back({.kind = CommandKind::Add,
                     .table = {"edit.handle", ""},
                     .text = "{ name = " + name + " }"});
  } else {
    const std::string keep = use == PartUse::TranslationOnly ? ", keep = \"orientation\"" : "";
    edits.push_back({.kind = CommandKind::Add,
                     .table = {"feature", ""},
                     .text = "{ name = " + name + keep + " }"});
  }
  return edits;
}

DocumentCommand nodes_edit(const SceneText& scene, const std::string& name,
                           const std::vector<long>& labels) {
  std::vector<std::string> numbers;
  for (const long label : labels) numbers.push_back(std::to_string(label));
  const std::string list = SceneText::list(numbers);
  const SceneTable table{"select", name};
  if (scene.has(table))
    return {.kind = CommandKind::Set, .table = table, .key = "nodes", .text = list};
  return {.kind = CommandKind::Add,
          .table = {"select", ""},
          .text = "{ name = " + SceneText::toml_value(name) + ", nodes = " + list + " }"};
}

std::vector<long> nodes_of(const SceneText& scene, const std::string& name) {
  const SceneTable table{"select", name};
  std::vector<long> labels;
  if (!scene.has(table)) return labels;
  std::string list = scene.value(table, "nodes");
  for (char& c : list)
    if (c == '[' || c == ']' || c == ',') c = ' ';
  std::istringstream in(list);
  for (long label = 0; in >> label;) labels.push_back(label);
  return labels;
}

namespace {

std::string handle_move_to_toml(const std::string& handle, const Vec3& shift,
                                const Vec3& rotation_vector) {
  std::string text =
      "{ name = " + SceneText::toml_value(handle) + ", translate = " + SceneText::toml_value(shift);
  if (rotation_vector.norm() > 0)
    text += ", rotate = { axis = " + SceneText::toml_value(rotation_vector.normalized()) +
            ", angle = " + SceneText::toml_value(rotation_vector.norm()) + " }";
  return text + " }";
}

/// The list of moves of a keyframe, with the handle's move replaced or added.
std::string with_move(const std::string& list, const std::string& handle, const std::string& move) {
  const toml::table root = parse_toml("list = " + list, {}, "moves of handles");
  std::string text;
  if (const toml::array* moves = root["list"].as_array())
    for (const toml::node& one : *moves) {
      const toml::table& table = *one.as_table();
      if (table["name"].value_or(std::string()) == handle) continue;
      text += to_toml(table) + ", ";
    }
  return "[" + text + move + "]";
}

/// The last operation, or the last one of a type ("\"path\"").
SceneTable last_operation(const SceneText& scene, const std::string& type = "") {
  SceneTable operation;
  for (const SceneTable& table : scene.tables())
    if (table.kind == "operation" && (type.empty() || scene.value(table, "type") == type))
      operation = table;
  return operation;
}

/// An unused operation name, as TOML text.
std::string free_operation(const SceneText& scene, const std::string& beginning) {
  int number = 1;
  while (scene.has({"operation", beginning + std::to_string(number)})) ++number;
  return SceneText::toml_value(beginning + std::to_string(number));
}

}  // namespace

std::vector<DocumentCommand> keyframe_edits(const SceneText& scene, int frame,
                                            const std::string& handle, const Vec3& shift,
                                            const Vec3& rotation_vector) {
  const std::string move = handle_move_to_toml(handle, shift, rotation_vector);
  const std::string key = "{ frame = " + std::to_string(frame) + ", handle = [" + move + "] }";
  const SceneTable operation = last_operation(scene);
  if (operation.kind.empty() || scene.value(operation, "type") != "\"keyframes\"") {
    return {{.kind = CommandKind::Add,
             .table = {"operation", ""},
             .text = "{ name = " + free_operation(scene, "keys ") +
                     ", type = \"keyframes\", keyframe = [" + key + "] }"}};
  }
  for (const SceneTable& table : scene.tables())
    if (table.kind == "operation.keyframe" && table.name.starts_with(operation.name + ".") &&
        scene.value(table, "frame") == std::to_string(frame))
      return {{.kind = CommandKind::Set,
               .table = table,
               .key = "handle",
               .text = with_move(scene.value(table, "handle"), handle, move)}};
  for (const auto& [name, value] : scene.values(operation))
    if (name == "keyframe")  // an inline list
      return {{.kind = CommandKind::Set,
               .table = operation,
               .key = name,
               .text = value.substr(0, value.rfind(']')) + ", " + key + "]"}};
  return {{.kind = CommandKind::Add, .table = {"operation.keyframe", ""}, .text = key}};
}

DocumentCommand path_edit(const SceneText& scene, const std::vector<Vec3>& through) {
  std::vector<std::string> points;
  for (const Vec3& p : through) points.push_back(SceneText::toml_value(p));
  const SceneTable operation = last_operation(scene, "\"path\"");
  if (!operation.kind.empty())
    return {.kind = CommandKind::Set,
            .table = operation,
            .key = "through",
            .text = SceneText::list(points)};
  return {.kind = CommandKind::Add,
          .table = {"operation", ""},
          .text = "{ name = " + free_operation(scene, "path ") +
                  ", type = \"path\", through = " + SceneText::list(points) + " }"};
}

std::vector<Vec3> path_of(const SceneText& scene) {
  const SceneTable operation = last_operation(scene, "\"path\"");
  return operation.kind.empty() ? std::vector<Vec3>{}
                                : parse_points(scene.value(operation, "through"));
}

std::vector<DocumentCommand> sequence_handle_edits(const SceneText& scene,
                                                   const std::string& selection) {
  if (scene.has({"handle", selection})) return {};
  return {{.kind = CommandKind::Add,
           .table = {"handle", ""},
           .text = "{ name = " + SceneText::toml_value(selection) + " }"}};
}

}  // namespace batten
