// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/line_files.h"

#include <algorithm>
#include <map>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/cad/cad_format.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/scenes/lines/crossing_corners.h"
#include "batten/scenes/lines/line_corners.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {
namespace {

const std::vector<std::string> kPointEndings = {".csv", ".txt", ".xyz", ".dat", ".obj", ".curves"};
const std::vector<std::string> kDrawingEndings = {".dxf", ".svg"};
const std::vector<std::string> kSketchEndings = {".json"};

std::string all_endings() {
  return comma_separated(kPointEndings) + ", " + comma_separated(cad_extensions()) + ", " +
         comma_separated(kDrawingEndings) + ", " + comma_separated(kSketchEndings);
}

/// Formats locations of [[curve]] and [[curves]] for messages.
struct SceneFile {
  std::string file, unit;
  std::string at(const SourceLocation& location) const { return format_location(file, location); }
};

/// What to do with a file that contains no curves.
std::string advice_for(const std::filesystem::path& file) {
  if (lower_extension(file) == ".toml") return "; `batten run` runs a scene";
  if (MeshFile::can_read(file)) return "; `batten fit` fits surfaces to a mesh";
  return "";
}

std::vector<SourceLine> read_file(const SceneFile& scene, const SceneLine& source) {
  const std::string at = scene.at(source.location);
  require_input_file(source.file, "a curve file (" + all_endings() + ")", at);
  if (line_file_kind(source.file) == LineFileKind::None)
    throw InputError(at + "found the extension '" + source.file.extension().string() + "' of '" +
                     source.file.string() + "', expected one of: " + all_endings() +
                     advice_for(source.file));
  if (line_file_kind(source.file) == LineFileKind::Sketch && !source.unit.empty() &&
      source.unit != scene.unit)
    throw InputError(at + "found the unit '" + source.unit + "' for '" + source.file.string() +
                     "', expected none: a sketch is in the scene's unit, " + scene.unit);
  if (line_file_kind(source.file) == LineFileKind::Cad && !source.unit.empty())
    throw InputError(at + "found a unit for '" + source.file.string() +
                     "', expected none: files of this type state their unit");
  return read_source_file(source.file, source.unit, scene.unit, source.creases);
}

void check_names(const SceneFile& scene, const SceneLine& source,
                 const std::vector<LocatedString>& words, const std::vector<SourceLine>& lines) {
  std::vector<std::string> names;
  for (const auto& line : lines) names.push_back(line.name);
  for (const auto& word : words)
    if (std::find(names.begin(), names.end(), word.text) == names.end())
      throw InputError(scene.at(word.location) + "found the curve name '" + word.text +
                       "', expected one of those in '" + source.file.string() +
                       "': " + comma_separated(names) + did_you_mean(word.text, names));
}

bool contains(const std::vector<LocatedString>& words, const std::string& name) {
  return std::any_of(words.begin(), words.end(),
                     [&](const LocatedString& w) { return w.text == name; });
}

/// Gives a line the corners that the scene states.
void apply_corners(const SceneFile& scene, const SceneLine& source, SourceLine& line) {
  if (source.measured && !line.points.empty()) line.vertices = SourceLine::Vertices::Measured;
  if (!source.corners) return;
  if (line.curve) try {
      line.curve = with_corners(line.curve, source.all_corners, *source.corners);
    } catch (const InputError& e) {
      throw InputError(scene.at(source.location) + "curve '" + line.name + "': " + e.what());
    }
  else if (!line.points.empty())
    line.corners = source.all_corners ? all_corners(line.points) : source.corners;
}

std::vector<SourceLine> lines_of(const SceneFile& scene, const SceneLine& source) {
  if (source.file.empty()) {
    SourceLine line;
    line.name = source.name;
    line.at = scene.at(source.location);
    line.points = source.points;
    line.curve = source.curve;
    apply_corners(scene, source, line);
    line.role = source.role;
    line.mesh_alignment = source.mesh_alignment;
    line.constrains_surface = source.constrains_surface;
    return {line};
  }
  std::vector<SourceLine> lines = read_file(scene, source);
  if (!source.name.empty()) {
    if (lines.size() != 1)
      throw InputError(scene.at(source.location) + "found " + std::to_string(lines.size()) +
                       " curves in '" + source.file.string() + "', expected one for the curve '" +
                       source.name + "'; use [[curves]] for several");
    lines.front().name = source.name;
  }
  for (const auto* words : {&source.only, &source.skip, &source.inner, &source.holes})
    check_names(scene, source, *words, lines);
  const SourceLine first = lines.front();
  std::erase_if(lines, [&](const SourceLine& line) {
    return contains(source.skip, line.name) ||
           (!source.only.empty() && !contains(source.only, line.name));
  });
  if (!lines.empty()) {
    lines.front().notes = first.notes;
    lines.front().warnings = first.warnings;
  }
  if (source.corners && !source.corners->empty() && lines.size() > 1)
    throw InputError(scene.at(source.location) + "found numbers of corners for " +
                     std::to_string(lines.size()) + " curves of '" + source.file.string() +
                     "', expected corners = \"all\" or \"none\", or one curve in 'only'");
  for (auto& line : lines) {
    apply_corners(scene, source, line);
    line.role = contains(source.inner, line.name)   ? CharacterLine::Role::Inner
                : contains(source.holes, line.name) ? CharacterLine::Role::Hole
                                                    : source.role;
    line.mesh_alignment = source.mesh_alignment;
    line.constrains_surface = source.constrains_surface || line.role != CharacterLine::Role::Hole;
  }
  return lines;
}

}  // namespace

LineFileKind line_file_kind(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  const auto has = [&](const std::vector<std::string>& endings) {
    return std::find(endings.begin(), endings.end(), ending) != endings.end();
  };
  return has(kPointEndings)      ? LineFileKind::Points
         : has(cad_extensions()) ? LineFileKind::Cad
         : has(kDrawingEndings)  ? LineFileKind::Drawing
         : has(kSketchEndings)   ? LineFileKind::Sketch
                                 : LineFileKind::None;
}

namespace {

/// Decides what the vertices of a polyline are.
void interpret_polyline(SourceLine& line) {
  if (line.curve) line.points = polyline_vertices(*line.curve);
  if (line.points.empty()) return;
  line.curve = nullptr;
  line.vertices = SourceLine::Vertices::Polyline;
  try {
    if (const auto deviation = sampled_curve_deviation(line.points)) {
      line.vertices = SourceLine::Vertices::SampledCurve;
      line.polyline_deviation = *deviation;
    }
  } catch (const InputError&) {
    // Coincident vertices and the like are reported by as_curve().
  }
}

std::vector<SourceLine> read_drawn(const std::filesystem::path& file, const std::string& unit,
                                   double model) {
  Drawing drawing = read_drawing(file);
  const double stated = unit.empty() ? drawing.unit_in_metres : unit_in_metres(unit);
  const AffineTransform to_model = scaling_about(Vec3::Zero(), stated > 0 ? stated / model : 1);
  std::vector<SourceLine> lines;
  for (DrawnLine& line : drawing.lines) {
    for (Vec3& p : line.points) p = to_model(p);
    lines.push_back({line.name, file.string() + ": ", std::move(line.points),
                     line.curve ? transformed(line.curve, to_model) : nullptr});
    interpret_polyline(lines.back());
  }
  const std::string name = file.filename().string() + ": ";
  for (const std::string& note : drawing.notes) lines[0].notes.push_back(name + note);
  for (const std::string& warning : drawing.warnings) lines[0].warnings.push_back(name + warning);
  if (stated == 0) lines[0].notes.push_back(name + "the file states no length unit");
  if (unit.empty() && stated > 0 && std::abs(stated / model - 1) > 1e-12)
    lines[0].notes.push_back(name + "the unit of the file is " + format_unit(stated));
  return lines;
}

}  // namespace

std::string cad_faces_note(const std::filesystem::path& file, int faces) {
  return file.filename().string() + ": curves only, namely the edges of its " +
         format_count(faces, "face") +
         "; new surfaces are made through them (batten fit takes the faces themselves)";
}

std::vector<SourceLine> read_source_file(const std::filesystem::path& file, const std::string& unit,
                                         const std::string& model_unit, bool creases) {
  const double model = unit_in_metres(model_unit);
  std::vector<SourceLine> lines;
  if (line_file_kind(file) == LineFileKind::Sketch) {
    for (const CharacterLine& line : read_sketch_graph(file))
      lines.push_back({line.name, file.string() + ": ", {}, line.curve});
    return lines;
  }
  if (line_file_kind(file) == LineFileKind::Cad) {
    int faces = 0;
    for (const CharacterLine& line : cad_plugin().read_cad_lines(file, model, creases, &faces)) {
      lines.push_back({line.name, file.string() + ": ", {}, line.curve});
      interpret_polyline(lines.back());
    }
    if (faces > 0 && !creases) lines.front().notes.push_back(cad_faces_note(file, faces));
    return lines;
  }
  if (line_file_kind(file) == LineFileKind::Drawing) return read_drawn(file, unit, model);
  for (NamedPoints& line :
       read_point_lines(file, unit.empty() ? 1 : unit_in_metres(unit) / model)) {
    lines.push_back({line.name, format_location(file.string(), {line.first_line, 1}),
                     std::move(line.points), nullptr});
    lines.back().format_note = line.format_note;
  }
  return lines;
}

namespace {

// Resolves lines that are copies, including copies of copies.
class Copies {
 public:
  Copies(const SceneFile& scene, std::vector<SourceLine>& lines,
         const std::map<std::string, const SceneLine*>& copies)
      : scene_(scene), lines_(lines), copies_(copies) {}

  void make() {
    for (const auto& [name, copy] : copies_) shape(name, *copy, 0);
  }

 private:
  SourceLine& named(const std::string& name, const SourceLocation& location) {
    std::vector<std::string> names;
    for (SourceLine& line : lines_) {
      if (line.name == name) return line;
      names.push_back(line.name);
    }
    throw InputError(scene_.at(location) + "found a copy of '" + name +
                     "', expected one of: " + comma_separated(names) + did_you_mean(name, names));
  }

  void shape(const std::string& name, const SceneLine& copy, size_t depth) {
    SourceLine& line = named(name, copy.location);
    if (line.curve || !line.points.empty()) return;
    if (depth > copies_.size())
      throw InputError(scene_.at(copy.location) + "found the curve '" + name +
                       "' as a copy of itself, expected a copy of another curve");
    const auto of = copies_.find(copy.copy);
    if (of != copies_.end()) shape(copy.copy, *of->second, depth + 1);
    const SourceLine& given = named(copy.copy, copy.location);
    for (const Vec3& p : given.points) line.points.push_back(copy.transform(p));
    if (given.curve) line.curve = transformed(given.curve, copy.transform);
    line.corners = given.corners;
    line.vertices = given.vertices;
    line.polyline_deviation = given.polyline_deviation;
  }

  const SceneFile& scene_;
  std::vector<SourceLine>& lines_;
  const std::map<std::string, const SceneLine*>& copies_;
};

}  // namespace

namespace {

// Puts the name of the file before the names of curves that occur in several files: "wing: edge 1".
void make_names_unique_by_file(const std::vector<SceneLine>& scene,
                               std::vector<std::vector<SourceLine>>& sources) {
  std::map<std::string, int> uses;
  for (const auto& lines : sources)
    for (const SourceLine& line : lines) ++uses[line.name];
  for (size_t s = 0; s < sources.size(); ++s) {
    if (scene[s].file.empty() || !scene[s].name.empty()) continue;
    const std::string stem = scene[s].file.stem().string();
    std::string example;
    for (SourceLine& line : sources[s]) {
      if (uses[line.name] == 1) continue;
      line.name = stem + ": " + line.name;
      if (example.empty()) example = line.name;
    }
    if (!example.empty())
      sources[s].front().notes.push_back(scene[s].file.filename().string() +
                                         ": names of curves that occur in several files are "
                                         "preceded by the name of the file, as in '" +
                                         example + "'");
  }
}

}  // namespace

std::vector<SourceLine> read_sources(const std::vector<SceneLine>& lines,
                                     const std::filesystem::path& file, const std::string& unit) {
  const SceneFile scene{file.string(), unit};
  std::vector<std::vector<SourceLine>> sources;
  for (const SceneLine& source : lines) sources.push_back(lines_of(scene, source));
  make_names_unique_by_file(lines, sources);
  std::vector<SourceLine> all;
  std::map<std::string, SourceLocation> places;
  std::map<std::string, const SceneLine*> copies;
  for (size_t s = 0; s < lines.size(); ++s)
    for (SourceLine& line : sources[s]) {
      const SceneLine& source = lines[s];
      const auto [it, added] = places.emplace(line.name, source.location);
      if (!added)
        throw InputError(scene.at(source.location) + "found the curve name '" + line.name +
                         "' again (first in line " + std::to_string(it->second.line) +
                         "), expected unique names");
      if (!source.copy.empty()) copies.emplace(line.name, &source);
      all.push_back(std::move(line));
    }
  Copies(scene, all, copies).make();
  return all;
}

std::vector<SourceLine> read_sources(const Scene& scene) {
  std::vector<SourceLine> lines = read_sources(scene.lines, scene.file, scene.unit);
  for (SourceLine& line : lines) line.corner_angle_is_stated = scene.skin.corner_angle_is_stated;
  find_crossing_corners(lines, scene.skin.options.corner_angle);
  return lines;
}

std::vector<Vec3> scan_points(const Scene& scene, const SceneLoad& load) {
  if (load.type != SceneLoad::Type::PointCloudSprings) return {};
  const std::string expected = "a file of points (" + comma_separated(kPointEndings) + ")";
  if (line_file_kind(load.file) != LineFileKind::Points)
    throw InputError(scene.at(load.location) + "found '" + load.file.string() + "', expected " +
                     expected);
  require_input_file(load.file, expected, scene.at(load.location));
  std::vector<Vec3> points;
  for (const SourceLine& line : read_source_file(load.file, load.unit, scene.unit))
    points.insert(points.end(), line.points.begin(), line.points.end());
  return points;
}

std::vector<CharacterLine> read_lines(const Scene& scene) {
  std::vector<CharacterLine> lines;
  for (const SourceLine& line : read_sources(scene))
    lines.push_back(character_line(line, scene.skin.options.corner_angle));
  return lines;
}

}  // namespace batten
