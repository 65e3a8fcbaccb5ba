// SPDX-License-Identifier: MPL-2.0
// `batten fill`, `batten blend`: faces in the openings of a CAD file or a mesh, or between two of its
// edges, tangent to the faces beside them.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/commands.h"

namespace batten {
namespace {

std::string list_of(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts)
    list += (list.empty() ? "" : ", ") + SceneText::toml_value(text);
  return "[" + list + "]";
}

std::string path_from(const std::filesystem::path& folder, const std::filesystem::path& file) {
  const auto from = std::filesystem::absolute(folder).lexically_normal(),
             to = std::filesystem::absolute(file).lexically_normal();
  const std::filesystem::path relative = to.lexically_relative(from);
  return SceneText::toml_value((relative.empty() ? to : relative).string());
}

// File extension of the joined mesh: that of the given mesh if it can be written.
std::string mesh_ending(const std::filesystem::path& part) {
  const std::string ending = lower_extension(part);
  const std::vector<std::string>& written = mesh_file_endings();
  const bool same = ending != ".vtp" && std::count(written.begin(), written.end(), ending);
  return same ? ending : ".stl";
}

std::string scene_text_of(const std::filesystem::path& part, const FillTask& task,
                          const std::string& name, const std::filesystem::path& folder) {
  std::string text = "# The faces that batten " + std::string(task.bridge ? "blend" : "fill") +
                     " made in " + part.filename().string() +
                     ". Add loads, inner curves or [[join]], and run it with batten run.\n" +
                     "name = " + SceneText::toml_value(name) +
                     "\nunit = " + SceneText::toml_value(task.unit) + "\n";
  for (const std::filesystem::path& file : task.inner)
    text += "\n[[curves]]\nfile = " + path_from(folder, file) + "\nrole = \"inner\"\n";
  text += "\n[[neighbour]]\nfile = " + path_from(folder, part) + "\n";
  if (!task.faces.empty()) text += "faces = " + list_of(task.faces) + "\n";
  if (!task.replaced.empty()) text += "without = " + list_of(task.replaced) + "\n";
  if (!task.openings.empty()) {
    text += "openings = [";
    for (size_t k = 0; k < task.openings.size(); ++k)
      text += (k ? ", " : "") + std::to_string(task.openings[k]);
    text += "]\n";
  }
  if (!task.edges.empty()) text += "edges = " + list_of(task.edges) + "\n";
  if (task.bridge) text += "bridge = true\n";
  if (task.tension > 0) text += "tension = " + SceneText::toml_value(task.tension) + "\n";
  if (!task.continuity.empty()) text += "continuity = \"" + task.continuity + "\"\n";
  if (task.edge_length > 0)
    text += "\n[mesh]\nedge_length = " + SceneText::toml_value(task.edge_length) + "\n";
  text += "\n[output]\nstep = " + SceneText::toml_value(name + ".step") +
          "\nvtp = " + SceneText::toml_value(name + ".vtp") + "\n";
  if (MeshFile::can_read(part))
    text += "mesh = " + SceneText::toml_value(name + mesh_ending(part)) + "\n";
  if (task.patches_only) text += "step_neighbours = false\n";
  if (task.step_curves) text += "step_curves = true\n";
  if (task.step_ap242) text += "step_schema = \"ap242\"\n";
  return text;
}

}  // namespace

Report run_fill(const std::filesystem::path& part, const FillTask& task,
                const std::filesystem::path& folder, const Progress& progress) {
  const std::string name = part.stem().string() + (task.bridge ? "-blended" : "-filled");
  const std::string text = scene_text_of(part, task, name, folder);
  // Paths are relative to the folder; the file is written only with the results.
  Scene scene = parse_scene(text, folder / name);
  scene.file.clear();
  scene.neighbours.front().location = {};
  scene.neighbours.front().file = part;
  scene.text = text;
  return run_scene(scene, folder, progress);
}

}  // namespace batten
