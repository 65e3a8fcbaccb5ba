// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/fair_scene.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

CombPictureSpec comb_picture(const TomlTable& t, UniqueNames& files) {
  using Show = CombPictureSpec::Show;
  CombPictureSpec rule;
  rule.file = output_file(t, "file", files, {".png"});
  rule.title = t.text("title", "");
  rule.show = t.choice("show", Show::Combs, {{"combs", Show::Combs}, {"stages", Show::Stages}});
  rule.points = t.boolean("points", true);
  double azimuth = 0, elevation = 0;
  PictureSize size;
  read_view(t, azimuth, elevation, size);
  if (t.has("size")) rule.size = size;
  if (t.has("view")) rule.view = {azimuth, elevation};
  return rule;
}

FairScene fair_scene(const toml::table& root_table, const std::filesystem::path& file) {
  refuse_renamed_keys(root_table, SceneKind::Surface, file.string());
  const TomlTable root(
      file.string(), root_table, "the scene",
      {"name", "unit", "segments", "curve", "curves", "fair", "output", "picture"});
  FairScene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.unit = read_unit(root, "unit");
  scene.segments = root.positive("segments", 0);
  scene.lines = read_scene_lines(root, file.parent_path(), false);
  scene.stages = read_fair_stages(root);
  UniqueNames files("file name");
  const std::vector<std::pair<std::string, std::vector<std::string>>> kinds = {
      {"curves", {".curves"}},     {"csv", {".csv"}},          {"obj", {".obj"}},
      {"vtp", {".vtp"}},           {"dxf", {".dxf"}},          {"svg", {".svg"}},
      {"step", {".step", ".stp"}}, {"iges", {".iges", ".igs"}}};
  std::vector<std::string> keys;
  for (const auto& kind : kinds) keys.push_back(kind.first);
  for (const TomlTable& t : root.table("output", keys))
    for (const auto& [key, endings] : kinds)
      if (t.has(key)) scene.outputs.push_back(output_file(t, key, files, endings));
  for (const TomlTable& t :
       root.tables("picture", {"file", "title", "show", "points", "view", "size"}))
    scene.pictures.push_back(comb_picture(t, files));
  return scene;
}

}  // namespace

std::vector<Parameter> FairScene::parameters() const {
  std::vector<Parameter> list;
  for_each_fair_parameter(stages, [&](const std::string& n, double value) {
    list.push_back({n, value, 0, std::numeric_limits<double>::infinity()});
  });
  return list;
}

void FairScene::set(const std::string& parameter, double value, const std::string& where) {
  std::vector<std::string> names;
  bool known = false;
  for_each_fair_parameter(stages, [&](const std::string& n, double& slot) {
    names.push_back(n);
    if (n != parameter) return;
    known = true;
    if (!(value > 0) || !std::isfinite(value))
      throw InputError(where + "found " + format_number(value) + " for '" + n +
                       "', expected a number above 0");
    slot = value;
  });
  if (!known)
    throw InputError(where + "found parameter '" + parameter + "', expected " +
                     (names.empty()
                          ? std::string("none: no stage has a noise, a deviation or a wavelength")
                          : "one of: " + comma_separated(names)) +
                     did_you_mean(parameter, names));
}

bool is_fair_scene(const std::filesystem::path& file) {
  const toml::table root = parse_toml(read_input_file(file, "a scene (.toml)"), file, "a scene");
  for (const char* key : {"skin", "mesh", "face", "join"})
    if (root.contains(key)) return false;
  return root.contains("fair");
}

FairScene parse_fair_scene(const std::string& text, const std::filesystem::path& file) {
  return fair_scene(parse_toml(text, file, "a fairing scene (unit, [[curve]], [[fair]] …)"), file);
}

FairScene read_fair_scene(const std::filesystem::path& file) {
  return parse_fair_scene(read_input_file(file, "a fairing scene (.toml)"), file);
}

}  // namespace batten
