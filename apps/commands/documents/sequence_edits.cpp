#include "batten/apps/commands/documents/sequence_edits.h"

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;

std::string handle_move_to_toml(const std::string& handle, const Vec3& shift,
                                const Vec3& rotation_vector) {
  std::string text =
      "{ name = " + SceneText::word(handle) + ", translate = " + point_to_toml(shift);
  if (rotation_vector.norm() > 0)
    text += ", rotate = { axis = " + point_to_toml(rotation_vector.normalized()) +
            ", degrees = " + SceneText::word(rotation_vector.norm()) + " }";
  return text + " }";
}

/// The list of moves of a keyframe with one in the place of the handle's.
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

/// The last step, or the last of a kind ("\"path\"").
SceneTable last_step(const SceneText& scene, const std::string& kind = "") {
  SceneTable step;
  for (const SceneTable& table : scene.tables())
    if (table.kind == "step" && (kind.empty() || scene.value(table, "kind") == kind)) step = table;
  return step;
}

/// A name that no step has yet, as a word.
std::string free_step(const SceneText& scene, const std::string& beginning) {
  int number = 1;
  while (scene.has({"step", beginning + std::to_string(number)})) ++number;
  return SceneText::word(beginning + std::to_string(number));
}

}  // namespace

std::vector<DocumentCommand> keyframe_edits(const SceneText& scene, int frame,
                                            const std::string& handle, const Vec3& shift,
                                            const Vec3& rotation_vector) {
  const std::string move = handle_move_to_toml(handle, shift, rotation_vector);
  const std::string key = "{ frame = " + std::to_string(frame) + ", handle = [" + move + "] }";
  const SceneTable step = last_step(scene);
  if (step.kind.empty() || scene.value(step, "kind") != "\"keyframes\"") {
    return {{.kind = CommandKind::Add,
             .table = {"step", ""},
             .text = "{ name = " + free_step(scene, "keys ") +
                     ", kind = \"keyframes\", keyframe = [" + key + "] }"}};
  }
  for (const SceneTable& table : scene.tables())
    if (table.kind == "step.keyframe" && table.name.starts_with(step.name + ".") &&
        scene.value(table, "frame") == std::to_string(frame))
      return {{.kind = CommandKind::Set,
               .table = table,
               .key = "handle",
               .text = with_move(scene.value(table, "handle"), handle, move)}};
  for (const auto& [name, value] : scene.values(step))
    if (name == "keyframe")  // a list in braces
      return {{.kind = CommandKind::Set,
               .table = step,
               .key = name,
               .text = value.substr(0, value.rfind(']')) + ", " + key + "]"}};
  return {{.kind = CommandKind::Add, .table = {"step.keyframe", ""}, .text = key}};
}

DocumentCommand path_edit(const SceneText& scene, const std::vector<Vec3>& through) {
  std::vector<std::string> points;
  for (const Vec3& p : through) points.push_back(point_to_toml(p));
  const SceneTable step = last_step(scene, "\"path\"");
  if (!step.kind.empty())
    return {
        .kind = CommandKind::Set, .table = step, .key = "through", .text = SceneText::list(points)};
  return {.kind = CommandKind::Add,
          .table = {"step", ""},
          .text = "{ name = " + free_step(scene, "path ") +
                  ", kind = \"path\", through = " + SceneText::list(points) + " }"};
}

std::vector<Vec3> path_of(const SceneText& scene) {
  const SceneTable step = last_step(scene, "\"path\"");
  return step.kind.empty() ? std::vector<Vec3>{} : parse_points(scene.value(step, "through"));
}

std::vector<DocumentCommand> sequence_handle_edits(const SceneText& scene,
                                                   const std::string& selection) {
  if (scene.has({"handle", selection})) return {};
  return {{.kind = CommandKind::Add,
           .table = {"handle", ""},
           .text = "{ name = " + SceneText::word(selection) + " }"}};
}

}  // namespace batten
