// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/line_edits.h"

#include <algorithm>
#include <cmath>

#include "batten/io/files/text.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;

std::string list_of(const std::vector<Vec3>& points) {
  std::vector<std::string> words;
  for (const Vec3& p : points) words.push_back(SceneText::toml_value(p));
  return SceneText::list(words);
}

}  // namespace

std::vector<Vec3> parse_points(const std::string& value) {
  if (value.empty()) return {};
  const toml::table root = parse_toml("points = " + value, {}, "points");
  const toml::array* list = root["points"].as_array();
  std::vector<Vec3> points;
  for (size_t i = 0; list && i < list->size(); ++i) {
    const toml::array* one = list->get(i)->as_array();
    if (!one || one->size() != 3) return {};
    Vec3 p;
    for (size_t k = 0; k < 3; ++k) p[static_cast<long>(k)] = one->get(k)->value_or(0.0);
    points.push_back(p);
  }
  return points;
}

namespace {

constexpr std::pair<LineKey, const char*> kLineKeys[] = {
    {LineKey::Points, "points"}, {LineKey::Bezier, "bezier"}, {LineKey::Arc, "arc"}};

const char* key_name(LineKey key) {
  for (const auto& [one, word] : kLineKeys)
    if (one == key) return word;
  return "points";
}

}  // namespace

LineKey line_key(const SceneText& scene, const std::string& line) {
  const SceneTable table{"curve", line};
  if (!scene.has(table)) return LineKey::None;
  for (const auto& [key, word] : kLineKeys)
    if (!parse_points(scene.value(table, word)).empty()) return key;
  return LineKey::None;
}

SceneText with_single_shape_key(SceneText scene, const SceneTable& table, const std::string& key,
                                const std::string& value) {
  const auto& shapes = shape_keys();
  const bool shape = std::find(shapes.begin(), shapes.end(), key) != shapes.end();
  if (table.kind == "curve" && shape && scene.has(table))
    for (const auto& [other, words] : scene.values(table))
      if (other != key && std::find(shapes.begin(), shapes.end(), other) != shapes.end())
        scene.erase(table, other);
  scene.set(table, key, value);
  return scene;
}

std::vector<DocumentCommand> tangent_edits(const SceneText& scene, const std::string& line) {
  const std::vector<Vec3> points = defining_points(scene, line);
  if (line_key(scene, line) != LineKey::Points || points.size() != 2) return {};
  const Vec3 third = (points[1] - points[0]) / 3;
  const double size = 3 * third.norm();
  return {points_edit(line,
                      {points[0], rounded_point(points[0] + third, size),
                       rounded_point(points[1] - third, size), points[1]},
                      LineKey::Bezier)};
}

std::string defining_line(const SceneText& scene, const std::string& name) {
  if (scene.has({"curve", name})) return name;
  const std::string whole = name.substr(0, std::min(name.size(), name.rfind('.')));
  return scene.has({"curve", whole}) ? whole : "";
}

DocumentCommand move_point_command(const Vec3& from, const Vec3& to) {
  return {.kind = CommandKind::Move, .text = list_of({from, to})};
}

SceneText with_moved_point(SceneText scene, const std::string& from_to) {
  const std::vector<Vec3> positions = parse_points(from_to);
  if (positions.size() != 2)
    throw InputError("found '" + from_to +
                     "', expected the old and the new position, [[x, y, z], [x, y, z]]");
  bool any = false;
  const std::vector<SceneTable> tables = scene.tables();
  for (const SceneTable& table : tables) {
    if (table.kind != "curve") continue;
    std::vector<Vec3> points = defining_points(scene, table.name);
    bool has = false;
    for (Vec3& p : points)
      if (p == positions[0]) {
        p = positions[1];
        has = true;
      }
    if (has) scene.set(table, key_name(line_key(scene, table.name)), list_of(points));
    any |= has;
  }
  if (!any)
    throw InputError("found no curve with the point " + SceneText::toml_value(positions[0]) +
                     ", expected one");
  return scene;
}

std::vector<Vec3> defining_points(const SceneText& scene, const std::string& line) {
  const LineKey key = line_key(scene, line);
  return key == LineKey::None ? std::vector<Vec3>{}
                              : parse_points(scene.value({"curve", line}, key_name(key)));
}

Vec3 rounded_point(const Vec3& p, double size) {
  const double step = std::pow(10, std::floor(std::log10(std::max(size, 1e-12))) - 5);
  Vec3 r;
  for (int i = 0; i < 3; ++i) r[i] = std::stod(format_number(std::round(p[i] / step) * step));
  return r;
}

DocumentCommand line_command(const std::string& name, const std::vector<Vec3>& points,
                             LineKey key) {
  return {.kind = CommandKind::Add,
          .table = {"curve", ""},
          .text = "{ name = " + SceneText::toml_value(name) + ", " + key_name(key) + " = " +
                  list_of(points) + " }"};
}

DocumentCommand points_edit(const std::string& line, const std::vector<Vec3>& points, LineKey key) {
  return {.kind = CommandKind::Set,
          .table = {"curve", line},
          .key = key_name(key),
          .text = list_of(points)};
}

std::vector<DocumentCommand> split_edits(const DocumentView& view, const std::string& line,
                                         int point) {
  const SceneText scene(view.text);
  const std::vector<Vec3> points = defining_points(scene, line);
  if (line_key(scene, line) != LineKey::Points) return {};
  if (point < 1 || point + 1 >= static_cast<int>(points.size())) return {};
  const auto at = points.begin() + point;
  return {points_edit(line, {points.begin(), at + 1}),
          line_command(view.free_name("curve"), {at, points.end()})};
}

std::vector<DocumentCommand> join_line_edits(const DocumentView& view, const std::string& line) {
  const SceneText scene(view.text);
  std::vector<Vec3> points = defining_points(scene, line);
  if (points.size() < 2 || line_key(scene, line) != LineKey::Points) return {};
  std::string partner;
  std::vector<Vec3> joined;
  for (const SceneTable& table : scene.tables()) {
    if (table.kind != "curve" || table.name == line) continue;
    if (line_key(scene, table.name) != LineKey::Points) continue;
    std::vector<Vec3> other = defining_points(scene, table.name);
    if (other.size() < 2) continue;
    for (int way = 0; way < 4; ++way) {
      if (way == 2) std::reverse(points.begin(), points.end());
      if (points.back() == other.front()) {
        if (!partner.empty() && partner != table.name) return {};
        partner = table.name;
        joined = points;
        joined.insert(joined.end(), other.begin() + 1, other.end());
      }
      std::reverse(other.begin(), other.end());
    }
    std::reverse(points.begin(), points.end());
  }
  if (partner.empty()) return {};
  return {{.kind = CommandKind::Remove, .table = {"curve", partner}}, points_edit(line, joined)};
}

std::vector<DocumentCommand> mirror_edits(const DocumentView& view, const std::string& line,
                                          int axis) {
  const SceneText scene(view.text);
  std::vector<Vec3> points = defining_points(scene, line);
  const std::vector<Vec3> before = points;
  for (Vec3& p : points) p[axis] = p[axis] == 0 ? 0 : -p[axis];
  if (points == before) return {};  // the line lies in the plane
  return {line_command(view.free_name("curve"), points, line_key(scene, line))};
}

namespace {}  // namespace

std::vector<DocumentCommand> join_edits(const SceneText& scene, const std::string& line,
                                        const std::optional<std::string>& continuity) {
  std::vector<DocumentCommand> edits;
  bool said = false;
  // In reverse order, so that removing a table does not renumber those still to be visited.
  std::vector<SceneTable> tables = scene.tables();
  std::reverse(tables.begin(), tables.end());
  for (const SceneTable& table : tables) {
    if (table.kind != "join") continue;
    std::vector<std::string> lines = scene.strings(table, "curves");
    const auto found = std::find(lines.begin(), lines.end(), line);
    if (found == lines.end()) continue;
    const std::vector<std::string> stated = scene.strings(table, "continuity");
    if (continuity && !stated.empty() && stated.front() == *continuity && !said) {
      said = true;
    } else if (lines.size() == 1 && continuity && !said) {
      edits.push_back({.kind = CommandKind::Set,
                       .table = table,
                       .key = "continuity",
                       .text = SceneText::toml_value(*continuity)});
      said = true;
    } else if (lines.size() == 1) {
      edits.push_back({.kind = CommandKind::Remove, .table = table});
    } else {
      lines.erase(found);
      edits.push_back({.kind = CommandKind::Set,
                       .table = table,
                       .key = "curves",
                       .text = SceneText::toml_string_list(lines)});
    }
  }
  if (continuity && !said)
    edits.push_back({.kind = CommandKind::Add,
                     .table = {"join", ""},
                     .text = "{ curves = " + SceneText::toml_string_list({line}) +
                             ", continuity = " + SceneText::toml_value(*continuity) + " }"});
  return edits;
}

std::vector<DocumentCommand> alternative_edits(const NetworkReport::Choice& choice,
                                               int alternative) {
  std::vector<DocumentCommand> edits;
  const auto add_face = [&](const std::vector<NetworkReport::LoopNames>& loops, const char* more) {
    std::vector<std::string> lists;
    for (const auto& loop : loops) lists.push_back(SceneText::toml_string_list(loop));
    edits.push_back({.kind = CommandKind::Add,
                     .table = {"face", ""},
                     .text = "{ loops = " + SceneText::list(lists) + more + " }"});
  };
  const auto& wanted = choice.alternatives.at(static_cast<size_t>(alternative));
  for (const auto& loop : choice.chosen)
    if (std::find(wanted.begin(), wanted.end(), loop) == wanted.end())
      add_face({loop}, ", surface = false");
  for (const auto& loop : wanted)
    if (std::find(choice.chosen.begin(), choice.chosen.end(), loop) == choice.chosen.end())
      add_face({loop}, "");
  return edits;
}

}  // namespace batten
