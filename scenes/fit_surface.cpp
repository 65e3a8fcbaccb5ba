// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/fit_surface.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/lines/mesh_lines.h"
#include "batten/scenes/mesh_data.h"
#include "batten/scenes/model_data.h"

namespace batten {
namespace {

/// Writes the curves, faces, joins and targets of a scene of `batten fit` as text. Names of files are
/// relative to `folder`; empty: absolute.
class FitSceneText {
 public:
  FitSceneText(const Scene& scene, const FitSettings& settings, std::filesystem::path folder = {})
      : scene_(scene), settings_(settings), folder_(std::move(folder)) {}

  std::string text() {
    add("name", SceneText::toml_value(scene_.name));
    add("unit", SceneText::toml_value(scene_.unit));
    text_ += "\n[skin]\nnoisy_curves = \"keep\"\n";
    add_length("gap_tolerance", scene_.network.tolerance);
    if (settings_.edge_length > 0) text_ += "\n[mesh]\n";
    add_length("edge_length", settings_.edge_length);
    for (const InputLine& curve : settings_.curves) text_ += detail::curve_table(curve);
    for (const SceneLine& line : scene_.lines) add_line(line);
    for (const RegionSpec& face : scene_.network.regions) add_face(face);
    for (const JoinSpec& join : scene_.network.joins)
      text_ +=
          "\n[[join]]\ncurves = [" + SceneText::toml_value(join.line) + "]\ncontinuity = \"G0\"\n";
    for (const SceneTarget& target : scene_.targets) add_target(target);
    text_ += "\n[output]\n";
    add("step", SceneText::toml_value(scene_.name + ".step"));
    add_length("step_tolerance", settings_.fit_tolerance);
    if (scene_.step_lines) add("step_curves", "true");
    if (scene_.step_ap242) add("step_schema", "\"ap242\"");
    add("vtp", SceneText::toml_value(scene_.name + ".vtp"));
    return std::move(text_);
  }

 private:
  void add(const std::string& key, const std::string& value) {
    text_ += key + " = " + value + "\n";
  }
  void add_length(const std::string& key, double length) {
    if (length > 0) add(key, SceneText::toml_value(length));
  }
  void add_file(const std::filesystem::path& file) {
    const std::filesystem::path path = folder_.empty() ? std::filesystem::absolute(file)
                                                       : std::filesystem::proximate(file, folder_);
    add("file", SceneText::toml_value(path.string()));
  }

  void add_line(const SceneLine& line) {
    if (!line.file.empty()) {
      text_ += "\n[[curves]]\n";
      add_file(line.file);
      if (line.creases) add("creases", "true");
      return;
    }
    text_ += detail::curve_table({line.name, line.points});
    add("corners", "\"none\"");
  }

  void add_face(const RegionSpec& face) {
    std::vector<std::string> loops;
    for (const auto& loop : face.loops) loops.push_back(SceneText::toml_string_list(loop));
    text_ += "\n[[face]]\n";
    add("name", SceneText::toml_value(face.name));
    add("loops", SceneText::list(loops));
    if (!face.inner.empty()) add("inner", SceneText::toml_string_list(face.inner));
    if (face.annulus) add("annulus", "true");
    if (face.skin.convex) add("convex", "true");
  }

  void add_target(const SceneTarget& target) {
    text_ += "\n[[target]]\n";
    if (target.mesh)
      add_mesh(*target.mesh);
    else
      add_file(target.file);
    if (settings_.cage) add("cage", "\"catmull-clark\"");
    add_length("fit_tolerance", settings_.fit_tolerance);
  }

  void add_mesh(const ShellMesh& mesh) {
    std::vector<std::string> points, faces;
    for (long i = 0; i < mesh.points.rows(); ++i)
      points.push_back(SceneText::toml_value(Vec3(mesh.points.row(i))));
    for (int f = 0; f < mesh.face_count(); ++f) {
      if (mesh.second_order(f))
        throw InputError(
            "target: found a mesh with second-order faces, expected triangles, quads and "
            "polygons; or pass the name of its file");
      std::vector<std::string> vertices;
      for (const int v : mesh.face(f)) vertices.push_back(std::to_string(v));
      faces.push_back(SceneText::list(vertices));
    }
    add("points", SceneText::list(points));
    add("faces", SceneText::list(faces));
  }

  const Scene& scene_;
  const FitSettings& settings_;
  const std::filesystem::path folder_;
  std::string text_;
};

void require_length(double value, const std::string& what) {
  if (!(value >= 0) || !std::isfinite(value))
    throw InputError(what + ": found " + format_number(value) + ", expected a number above 0");
}

void check_settings(const FitSettings& settings) {
  unit_in_metres(settings.unit);  // throws for an unknown unit
  require_length(settings.fit_tolerance, "fit_tolerance");
  require_length(settings.edge_length, "edge_length");
  require_length(settings.gap_tolerance, "gap_tolerance");
}

Model fitted(Scene scene, const FitSettings& settings, const Progress& progress) {
  if (!settings.name.empty()) scene.name = settings.name;
  if (settings.gap_tolerance > 0) scene.network.tolerance = settings.gap_tolerance;
  return parse(FitSceneText(scene, settings).text(), ".", {}, progress);
}

/// The scene of given curves, without a target.
Scene scene_of_curves(const FitSettings& settings) {
  Scene scene;
  if (!settings.curve_files.empty())
    scene = scene_of_lines(settings.curve_files, {}, settings.unit);
  scene.unit = settings.unit;
  return scene;
}

}  // namespace

Report run_fit(const std::filesystem::path& target, const FitTask& task,
               const std::filesystem::path& folder, const Progress& progress) {
  const FitSettings& settings = task.settings;
  Scene scene = scene_of_target(target, settings.curve_files, settings.unit);
  scene.targets.front().tolerance = scene.step_tolerance = settings.fit_tolerance;
  scene.targets.front().cage = settings.cage;
  scene.skin.options.edge_length = settings.edge_length;
  scene.step_lines = task.step_curves;
  scene.step_ap242 = task.step_ap242;
  if (settings.gap_tolerance > 0) scene.network.tolerance = settings.gap_tolerance;
  scene.text = "# The model that batten fit made of " + target.filename().string() +
               ". Add loads, parameters or [stress], and run it with batten run.\n" +
               FitSceneText(scene, settings, folder).text();
  return run_scene(scene, folder, progress);
}

Model fit_surface(const std::filesystem::path& target, const FitSettings& settings,
                  const Progress& progress) {
  check_settings(settings);
  if (settings.curves.empty())
    return fitted(scene_of_target(target, settings.curve_files, settings.unit), settings, progress);
  Scene scene = scene_of_curves(settings);
  scene.name = target.stem().string();
  scene.targets.emplace_back().file = target;
  return fitted(std::move(scene), settings, progress);
}

Model fit_surface(const Mesh& target, const FitSettings& settings, const Progress& progress) {
  check_settings(settings);
  Scene scene = scene_of_curves(settings);
  scene.name = "surface";
  if (settings.curves.empty() && settings.curve_files.empty())
    add_mesh_lines(scene, target.data().source.prepared, target.sets());
  scene.targets.emplace_back().mesh = {target.shared_data(), &target.data().shells()};
  return fitted(std::move(scene), settings, progress);
}

}  // namespace batten
