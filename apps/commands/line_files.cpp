#include "batten/apps/commands/line_files.h"

#include <algorithm>
#include <map>

#include "batten/io/cad_lines.h"
#include "batten/io/point_lines.h"

namespace batten {
namespace {

const std::vector<std::string> kPointEndings = {".csv", ".txt", ".xyz", ".dat", ".obj"};
const std::vector<std::string> kCadEndings = {".iges", ".igs", ".step", ".stp"};

std::vector<CharacterLine> read_file(const Scene& scene, const SceneLine& source) {
  const std::string at = scene.at(source.place);
  if (!std::filesystem::is_regular_file(source.file))
    throw InputError(at + "found no file '" + source.file.string() +
                     "', expected a file of lines (" + listed(kPointEndings) + ", " +
                     listed(kCadEndings) + ")");
  if (line_file_kind(source.file) == LineFileKind::None)
    throw InputError(at + "found the ending '" + source.file.extension().string() + "' of '" +
                     source.file.string() + "', expected one of: " + listed(kPointEndings) + ", " +
                     listed(kCadEndings));
  if (line_file_kind(source.file) == LineFileKind::Cad && !source.unit.empty())
    throw InputError(at + "found a unit for '" + source.file.string() +
                     "', expected none: files of this kind say their unit themselves");
  return read_line_file(source.file, source.unit, scene.unit, scene.skin.options.corner_angle);
}

void check_names(const Scene& scene, const SceneLine& source, const std::vector<PlacedWord>& words,
                 const std::vector<CharacterLine>& lines) {
  std::vector<std::string> names;
  for (const auto& line : lines) names.push_back(line.name);
  for (const auto& word : words)
    if (std::find(names.begin(), names.end(), word.text) == names.end())
      throw InputError(scene.at(word.place) + "found the line name '" + word.text +
                       "', expected one of those in '" + source.file.string() +
                       "': " + listed(names) + did_you_mean(word.text, names));
}

bool contains(const std::vector<PlacedWord>& words, const std::string& name) {
  return std::any_of(words.begin(), words.end(),
                     [&](const PlacedWord& w) { return w.text == name; });
}

std::shared_ptr<const InputCurve> curve_of(const SceneLine& source, double corner_angle) {
  const auto& p = source.points;
  return source.bezier ? bezier_curve(p[0], p[1], p[2], p[3])
                       : curve_through_points(source.name, p, corner_angle);
}

std::vector<CharacterLine> lines_of(const Scene& scene, const SceneLine& source) {
  if (source.file.empty()) {
    try {
      return {{source.name, curve_of(source, scene.skin.options.corner_angle), source.role}};
    } catch (const InputError& e) {
      throw InputError(scene.at(source.place) + e.what());
    }
  }
  std::vector<CharacterLine> lines = read_file(scene, source);
  if (!source.name.empty()) {
    if (lines.size() != 1)
      throw InputError(scene.at(source.place) + "found " + std::to_string(lines.size()) +
                       " lines in '" + source.file.string() + "', expected one for the line '" +
                       source.name + "'; [[lines]] takes several");
    lines.front().name = source.name;
  }
  for (const auto* words : {&source.only, &source.skip, &source.inner})
    check_names(scene, source, *words, lines);
  std::erase_if(lines, [&](const CharacterLine& line) {
    return contains(source.skip, line.name) ||
           (!source.only.empty() && !contains(source.only, line.name));
  });
  for (auto& line : lines)
    line.role = contains(source.inner, line.name) ? CharacterLine::Role::Inner : source.role;
  return lines;
}

}  // namespace

LineFileKind line_file_kind(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto has = [&](const std::vector<std::string>& endings) {
    return std::find(endings.begin(), endings.end(), ending) != endings.end();
  };
  return has(kPointEndings) ? LineFileKind::Points
         : has(kCadEndings) ? LineFileKind::Cad
                            : LineFileKind::None;
}

std::vector<CharacterLine> read_line_file(const std::filesystem::path& file,
                                          const std::string& unit, const std::string& model_unit,
                                          double corner_angle) {
  const double model = unit_in_metres(model_unit);
  if (line_file_kind(file) == LineFileKind::Cad) return read_cad_lines(file, model);
  std::vector<CharacterLine> lines;
  for (const NamedPoints& line :
       read_point_lines(file, unit.empty() ? 1 : unit_in_metres(unit) / model)) {
    try {
      lines.push_back({line.name, curve_through_points(line.name, line.points, corner_angle)});
    } catch (const InputError& e) {
      throw InputError(place_prefix(file.string(), {line.first_line, 1}) + e.what());
    }
  }
  return lines;
}

std::vector<CharacterLine> read_lines(const Scene& scene) {
  std::vector<CharacterLine> all;
  std::map<std::string, Place> places;
  for (const SceneLine& source : scene.lines)
    for (CharacterLine& line : lines_of(scene, source)) {
      const auto [it, added] = places.emplace(line.name, source.place);
      if (!added)
        throw InputError(scene.at(source.place) + "found the line name '" + line.name +
                         "' again (first in line " + std::to_string(it->second.line) +
                         "), expected each name once");
      all.push_back(std::move(line));
    }
  return all;
}

}  // namespace batten
