#include "batten/io/scene/scene_lines.h"

#include <cmath>

#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/io/scene/scene_curves.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

CharacterLine::Role read_role(const TomlTable& table) {
  using Role = CharacterLine::Role;
  return table.choice("role", Role::Outline,
                      {{"outline", Role::Outline}, {"hole", Role::Hole}, {"inner", Role::Inner}});
}

CharacterLine::MeshAlignment read_mesh_alignment(const TomlTable& table) {
  using MeshAlignment = CharacterLine::MeshAlignment;
  return table.choice("treatment", MeshAlignment::Auto,
                      {{"auto", MeshAlignment::Auto},
                       {"fitted", MeshAlignment::EdgeAligned},
                       {"embedded", MeshAlignment::Embedded}});
}

// corners = [3, 7], "none" or "all".
std::optional<std::vector<int>> read_corners(const TomlTable& table, const SceneLine& line) {
  if (!table.has("corners")) return std::nullopt;
  if (line.points.empty() && line.file.empty())
    table.fail("corners", "corners of a curve", "them only of points");
  std::vector<int> corners;
  if (!table.is_array("corners")) {
    const bool all = table.choice("corners", true, {{"all", true}, {"none", false}});
    if (all && !line.file.empty())
      table.fail("corners", "\"all\" for the points of a file", "\"none\" or numbers of points");
    for (int i = 1; all && i + 1 < isize(line.points); ++i) corners.push_back(i);
    if (all) corners.push_back(0);
    return corners;
  }
  for (const double number : table.list("corners")) {
    const bool whole = number == std::floor(number) && number >= 1 && number < 1e9;
    if (!whole || (line.file.empty() && number > isize(line.points)))
      table.fail("corners", batten::format_number(number),
                 line.file.empty() ? "numbers of points, 1 to " + std::to_string(line.points.size())
                                   : "numbers of points, from 1 on");
    corners.push_back(static_cast<int>(number) - 1);
  }
  return corners;
}

// Reads what shape the line has; returns the key that says it.
std::string read_shape(const TomlTable& table, const std::filesystem::path& folder,
                       SceneLine& line) {
  std::vector<std::string> found;
  for (const std::string& word : shape_keys())
    if (table.has(word)) found.push_back(word);
  if (found.size() != 1)
    table.fail("name",
               found.empty() ? "the line '" + line.name + "' without its shape"
                             : "more than one shape for the line '" + line.name + "'",
               "one of: " + comma_separated(shape_keys()));
  const std::string key = found.front();
  if (table.has("unit") && key != "file")
    table.fail("unit", "a unit beside '" + key + "'",
               "it only beside 'file': the scene is in the scene's unit");
  if (key == "file") {
    line.file = folder / table.text("file");
    if (table.has("unit")) line.unit = read_unit(table, "unit");
  } else if (key == "points") {
    line.points = table.points(key);
    if (line.points.size() < 2)
      table.fail(key, std::to_string(line.points.size()) + " points", "2 points or more");
  } else if (key == "copy") {
    line.copy = table.text("copy");
    line.transform = read_placement(table);
  } else {
    line.curve = read_curve(table, key);
  }
  return key;
}

SceneLine read_line(const TomlTable& table, const std::filesystem::path& folder, bool roles) {
  SceneLine line;
  line.location = table.location();
  line.name = table.text("name");
  if (roles) {
    line.role = read_role(table);
    line.mesh_alignment = read_mesh_alignment(table);
    line.constrains_surface = table.boolean("hold", true);
    if (!line.constrains_surface && line.role != CharacterLine::Role::Hole)
      table.fail("hold", "hold = false of a line that is no hole", "role = \"hole\" beside it");
  }
  line.location = table.location(read_shape(table, folder, line));
  for (const std::string& key : placement_keys())
    if (table.has(key) && line.copy.empty())
      table.fail(key, "'" + key + "' without 'copy'", "both: copy = \"the line's name\"");
  line.corners = read_corners(table, line);
  return line;
}

SceneLine read_lines(const TomlTable& table, const std::filesystem::path& folder, bool roles) {
  SceneLine line;
  line.file = folder / table.text("file");
  line.location = table.location("file");
  if (table.has("unit")) line.unit = read_unit(table, "unit");
  if (roles) {
    line.role = read_role(table);
    line.mesh_alignment = read_mesh_alignment(table);
  }
  line.only = table.words("only");
  line.skip = table.words("skip");
  if (roles) {
    line.inner = table.words("inner");
    line.holes = table.words("holes");
    line.constrains_surface = table.boolean("hold", true);
    if (!line.constrains_surface && line.holes.empty() && line.role != CharacterLine::Role::Hole)
      table.fail("hold", "hold = false without holes", "'holes', or role = \"hole\", beside it");
  }
  if (!line.only.empty() && !line.skip.empty())
    table.fail("skip", "both 'only' and 'skip'", "one of them");
  return line;
}

}  // namespace

std::vector<std::string> line_keys(bool roles) {
  std::vector<std::string> keys = {"name", "unit", "corners"};
  keys.insert(keys.end(), shape_keys().begin(), shape_keys().end());
  keys.insert(keys.end(), placement_keys().begin(), placement_keys().end());
  if (roles) keys.insert(keys.end(), {"role", "treatment", "hold"});
  return keys;
}

std::vector<std::string> lines_keys(bool roles) {
  std::vector<std::string> keys = {"file", "unit", "only", "skip"};
  if (roles) keys.insert(keys.end(), {"role", "treatment", "inner", "holes", "hold"});
  return keys;
}

std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles, bool required) {
  std::vector<SceneLine> lines;
  UniqueNames names("line name");
  names.read(root, "line", line_keys(roles), lines,
             [&](const TomlTable& t) { return read_line(t, folder, roles); });
  for (const TomlTable& t : root.tables("lines", lines_keys(roles)))
    lines.push_back(read_lines(t, folder, roles));
  if (required && lines.empty()) root.fail("", "no lines", "[[line]] or [[lines]]");
  return lines;
}

}  // namespace batten
