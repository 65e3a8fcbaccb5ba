#include "batten/io/scene/scene_lines.h"

#include "batten/io/scene/scene_words.h"

namespace batten {
namespace {

CharacterLine::Role read_role(const TomlTable& table) {
  using Role = CharacterLine::Role;
  return table.choice("role", Role::Outline,
                      {{"outline", Role::Outline}, {"hole", Role::Hole}, {"inner", Role::Inner}});
}

CharacterLine::Treatment read_treatment(const TomlTable& table) {
  using Treatment = CharacterLine::Treatment;
  return table.choice("treatment", Treatment::Auto,
                      {{"auto", Treatment::Auto},
                       {"fitted", Treatment::Fitted},
                       {"embedded", Treatment::Embedded}});
}

SceneLine read_line(const TomlTable& table, const std::filesystem::path& folder, bool roles) {
  SceneLine line;
  line.place = table.place();
  line.name = table.text("name");
  if (roles) {
    line.role = read_role(table);
    line.treatment = read_treatment(table);
  }
  const int sources = table.has("file") + table.has("points") + table.has("bezier");
  if (sources != 1)
    table.fail("name",
               sources == 0 ? "the line '" + line.name + "' without its shape"
                            : "more than one shape for the line '" + line.name + "'",
               "one of: file, points, bezier");
  if (table.has("file")) {
    line.file = folder / table.text("file");
    if (table.has("unit")) line.unit = unit_word(table, "unit");
    line.place = table.place("file");
  } else {
    line.bezier = table.has("bezier");
    const std::string key = line.bezier ? "bezier" : "points";
    line.points = table.points(key);
    line.place = table.place(key);
    if (table.has("unit"))
      table.fail("unit", "a unit beside '" + key + "'",
                 "it only beside 'file': points in the scene are in the scene's unit");
    if (line.bezier && line.points.size() != 4)
      table.fail(key, std::to_string(line.points.size()) + " points", "4 control points");
    if (line.points.size() < 2)
      table.fail(key, std::to_string(line.points.size()) + " points", "2 points or more");
  }
  return line;
}

SceneLine read_lines(const TomlTable& table, const std::filesystem::path& folder, bool roles) {
  SceneLine line;
  line.file = folder / table.text("file");
  line.place = table.place("file");
  if (table.has("unit")) line.unit = unit_word(table, "unit");
  if (roles) {
    line.role = read_role(table);
    line.treatment = read_treatment(table);
  }
  line.only = table.words("only");
  line.skip = table.words("skip");
  if (roles) {
    line.inner = table.words("inner");
    line.holes = table.words("holes");
  }
  if (!line.only.empty() && !line.skip.empty())
    table.fail("skip", "both 'only' and 'skip'", "one of them");
  return line;
}

}  // namespace

std::vector<std::string> line_keys(bool roles) {
  std::vector<std::string> keys = {"name", "file", "points", "bezier", "unit"};
  if (roles) keys.insert(keys.end(), {"role", "treatment"});
  return keys;
}

std::vector<std::string> lines_keys(bool roles) {
  std::vector<std::string> keys = {"file", "unit", "only", "skip"};
  if (roles) keys.insert(keys.end(), {"role", "treatment", "inner", "holes"});
  return keys;
}

std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles) {
  std::vector<SceneLine> lines;
  Names names("line name");
  names.read(root, "line", line_keys(roles), lines,
             [&](const TomlTable& t) { return read_line(t, folder, roles); });
  for (const TomlTable& t : root.tables("lines", lines_keys(roles)))
    lines.push_back(read_lines(t, folder, roles));
  if (lines.empty()) root.fail("", "no lines", "[[line]] or [[lines]]");
  return lines;
}

}  // namespace batten
