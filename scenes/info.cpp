// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/commands.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/io/cad/cad_format.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/pictures/comb_pictures.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/io/scene/fair_scene.h"
#include "batten/io/scene/scene.h"
#include "batten/io/scene/scene_text.h"
#include "batten/io/scene/sequence_scene.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/selection.h"
#include "batten/scenes/lines/line_files.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/shapes/load_effects.h"
#include "batten/scenes/shapes/solved_shape.h"
#include "batten/skinning/surfaces/loft_plan.h"
#include "batten/skinning/surfaces/section_region.h"

namespace batten {

// Descriptions of CAD files, and pictures of the continuity of their faces.

/// Describes the contents of a CAD file and the continuity of its faces. `lines` returns the text
/// about its curves; it is added if there are few curves, or nothing else. Throws InputError.
std::string cad_info(const std::filesystem::path& file, const std::string& unit,
                     const std::function<std::string()>& lines);

/// Draws the edges of a CAD file with combs of the curvature across them, on both sides. Returns
/// false if the file has no faces. Throws InputError.
bool draw_face_edges(const std::filesystem::path& picture, const std::filesystem::path& file,
                     const std::string& unit);

// Descriptions of meshes and mesh sequences.

/// Describes a mesh file: counts, defects, bounding box, sets and properties, components with
/// attached elements, boundary loops and proposed features. `unit`: unit of its lengths. Throws
/// InputError.
std::string mesh_info(const std::filesystem::path& file, const std::string& unit,
                      const FeatureDetectionOptions& proposals = {});

/// True for extensions of mesh sequences: .glb .gltf .pc2 .mdd .pvd .frd.
bool is_sequence_file(const std::filesystem::path& file);

/// Describes a sequence: frames, times, nodes, bounding box of all frames, components, node motion
/// between frames, jerks, and whether the last frame equals the first. Throws InputError.
std::string sequence_info(const SequenceSource& source, const std::string& unit);

/// Describes the sequence of a scene, with its handles, features and operations.
std::string sequence_info(const SequenceScene& scene);

namespace {

constexpr double kCorner = 20;  // degrees, as in a scene

// "straight", or the normal of the plane that contains the curve; empty if the curve is not planar.
std::string flatness(const InputCurve& curve) {
  std::vector<Vec3> points;
  const std::vector<double> breaks = curve.breaks();
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    for (int k = 0; k < 8; ++k)
      points.push_back(curve.evaluate(breaks[i] + (breaks[i + 1] - breaks[i]) * k / 8));
  points.push_back(curve.evaluate(curve.end()));
  const PrincipalAxes spread = principal_axes(points);
  constexpr double flat = 1e-12;  // relative to the squared spread
  if (spread.values[1] <= flat * spread.values[2]) return "  straight";
  if (spread.values[0] > flat * spread.values[2]) return "";
  Vec3 normal = spread.axes.col(0);
  for (int i = 2; i >= 0; --i)
    if (std::abs(normal[i]) > 1e-6) {
      normal *= normal[i] < 0 ? -1 : 1;
      break;
    }
  normal = (normal * 1e6).array().round() / 1e6 + 0.0;
  return "  in a plane with normal " + format_point(normal);
}

// False for points that coincide, which sketches may contain. Throws InputError for a parametric
// curve without length.
bool has_length(const SourceLine& line, double corner_angle) {
  if (!line.curve)
    return std::any_of(line.points.begin(), line.points.end(),
                       [&](const Vec3& p) { return p != line.points.front(); });
  split_at_corners({line.name, line.curve}, std::min(corner_angle, 179.9));
  return true;
}

std::string lines_text(const std::vector<SourceLine>& lines, const std::string& unit,
                       double corner_angle) {
  std::string text = std::to_string(lines.size()) + (lines.size() == 1 ? " curve" : " curves") +
                     ", lengths in " + unit + "\n";
  size_t width = 0;
  for (const auto& line : lines) width = std::max(width, printable(line.name).size());
  for (const auto& line : lines) {
    const std::string name = printable(line.name);
    text += "  " + name + std::string(width - name.size() + 2, ' ');
    if (!has_length(line, corner_angle)) {
      text += "zero length  at " + format_point(line.points.front()) + "\n";
      continue;
    }
    std::shared_ptr<const InputCurve> curve;
    std::string remark;
    try {
      curve = line.as_curve(corner_angle);
      if (!line.points.empty()) remark = "  " + describe(interpret_points(line, *curve));
    } catch (const InputError& e) {
      // Strokes may have repeated points, which fairing accepts.
      curve = curve_from_hermite(interpolating_spline(line.name, line.points));
      remark = "  not usable for surfaces: " + printable(e.what());
    }
    text += "length " + format_number(ArcLength(curve).total()) + "  from " +
            format_point(curve->evaluate(curve->start())) + " to " +
            format_point(curve->evaluate(curve->end())) + flatness(*curve) +
            (line.role == CharacterLine::Role::Inner  ? "  inner"
             : line.role == CharacterLine::Role::Hole ? "  hole"
                                                      : "") +
            remark + "\n";
    if (!line.format_note.empty()) text += "    read: " + line.format_note + "\n";
    for (const auto* notes : {&line.notes, &line.warnings})
      for (const std::string& note : *notes) text += "  " + printable(note) + "\n";
  }
  return text;
}

void draw_lines(const std::filesystem::path& picture, const std::vector<SourceLine>& lines,
                const std::string& unit, double corner_angle) {
  CombPicture sheet;
  sheet.unit = unit;
  sheet.panels.resize(1);
  CombPanel& panel = sheet.panels[0];
  panel.title = std::to_string(lines.size()) + (lines.size() == 1 ? " curve" : " curves");
  for (const SourceLine& line : lines) {
    if (!has_length(line, corner_angle)) continue;
    try {
      const auto curve = line.as_curve(corner_angle);
      FitOptions options;
      options.tolerance = 1e-4 * ArcLength(curve).total();
      options.corner_angle = 0.5;  // corners are already breaks of the curve
      panel.curves.push_back(fit_curve(line.name, curve, options));
    } catch (const InputError&) {  // reported in the text
      continue;
    }
    panel.points.insert(panel.points.end(), line.points.begin(), line.points.end());
  }
  draw_combs(picture, sheet);
}

std::string parameters_text(const std::vector<Parameter>& parameters) {
  std::string text = "parameters (--set name=value)\n";
  for (const Parameter& p : parameters) {
    text += "  " + printable(p.name) + " = " + format_number(p.value);
    if (std::isfinite(p.min) || std::isfinite(p.max))
      text += "  (" + (std::isfinite(p.min) ? "from " + format_number(p.min) : std::string("any")) +
              (std::isfinite(p.max) ? " to " + format_number(p.max) : " up") + ")";
    text += "\n";
  }
  return text;
}

// Edges and faces by the names that [[face]] and [[join]] use.
std::string network_text(const Scene& scene) {
  std::vector<CharacterLine> lines = read_lines(scene);
  add_mirrored(scene, lines);
  const ModelBuildOptions options = model_build_options(scene, lines);
  const CurveNetwork network = build_network(lines, options);
  const auto place = [&](const NetworkEdge& edge, int end) {
    return format_point(network.nodes()[edge.nodes[end]].position);
  };
  std::string text = "network: " + std::to_string(network.edges().size()) +
                     (network.edges().size() == 1 ? " edge" : " edges") + " between " +
                     std::to_string(network.nodes().size()) +
                     (network.nodes().size() == 1 ? " node" : " nodes") + " (gap tolerance " +
                     format_number(network.tolerance()) + " " + scene.unit + ")\n";
  for (const NetworkEdge& edge : network.edges())
    text += "  " + printable(edge.name) + "  length " + format_number(edge.length) + "  from " +
            place(edge, 0) + " to " + place(edge, 1) + "\n";
  for (const NetworkDiagnostic& diagnostic : network.diagnostics())
    text += std::string(diagnostic.repaired ? "  repaired: " : "  not joined: ") +
            printable(diagnostic.text) + "\n";
  std::optional<LoftNetwork> loft;
  if (options.search.specs.empty() && options.model.joins.empty()) {
    if (const auto plan = find_loft(network)) loft = loft_network(network, *plan, options);
    if (const auto row = ordered_sections(network); !loft && !row.empty()) {
      text += "1 face through the sections";
      for (const CharacterLine& section : row) text += " " + printable(section.name);
      return text + "\n";
    }
  }
  const CurveNetwork& of_faces = loft ? loft->network : network;
  const FoundRegions found = loft ? loft->found : require_regions(network, options);
  text += std::to_string(found.regions.size()) + (found.regions.size() == 1 ? " face" : " faces") +
          (!loft ? "\n"
           : loft->rails.empty()
               ? " between sections\n"
               : " between sections, " + format_count(loft->rails.size(), "added curve") + "\n");
  for (const NetworkRegion& region : found.regions) {
    text += "  " + printable(region.name) + (region.annulus ? "  annulus  " : "  ");
    for (size_t l = 0; l < region.loops.size(); ++l) {
      text += l ? ", [" : "[";
      for (size_t i = 0; i < region.loops[l].size(); ++i)
        text += (i ? ", " : "") + printable(of_faces.edges()[region.loops[l][i].edge].name);
      text += "]";
    }
    for (size_t i = 0; i < region.inner.size(); ++i)
      text += (i ? ", " : "  inner ") + printable(of_faces.edges()[region.inner[i]].name);
    text += "\n";
  }
  for (const AmbiguousRegion& ambiguous : found.ambiguous_regions)
    text += "  ambiguous: " + printable(ambiguous.text) + "\n";
  return text;
}

/// The effects of the loads of a scene, or why they are unknown.
std::string loads_text(const Scene& scene) {
  if (scene.loads.empty() && scene.moves.empty() && scene.sliders.empty()) return "";
  try {
    const BuiltModel made = build_model(scene, faired_lines(scene, {}).lines);
    return effects_text(load_effects(scene, made, solve_refined_shape(made, scene)), scene.unit);
  } catch (const CancelledError&) {
    throw;
  } catch (const Error& e) {
    return "effects of the parameters: unknown, because " + printable(e.what()) + "\n";
  }
}

std::string scene_text(const Scene& scene) {
  return "scene '" + printable(scene.name) + "', unit " + scene.unit + "\n" +
         lines_text(read_sources(scene), scene.unit, scene.skin.options.corner_angle) +
         (specifies_single_region(scene) ? "" : network_text(scene)) +
         parameters_text(scene.parameters()) + loads_text(scene);
}

std::string fairing_text(const FairScene& scene) {
  return "fair scene '" + printable(scene.name) + "', unit " + scene.unit + "\n" +
         lines_text(read_sources(scene.lines, scene.file, scene.unit), scene.unit, kCorner) +
         parameters_text(scene.parameters());
}

std::string edits_text(const DeformScene& scene) {
  return "deform scene '" + printable(scene.name) + "', unit " + scene.unit + "\n" +
         mesh_info(scene.mesh, scene.unit, scene.proposals) + parameters_text(scene.parameters());
}

// The curves of a file, in `unit`: drawings state their own unit, other files are in `unit`.
std::vector<SourceLine> curves_of_file(const std::filesystem::path& file, const std::string& unit) {
  return read_source_file(file, line_file_kind(file) == LineFileKind::Drawing ? "" : unit, unit);
}

}  // namespace

std::string file_info(const std::filesystem::path& file, const std::string& unit) {
  require_input_file(file, "a scene, a mesh or a curve file");
  switch (file_kind(file)) {
    case FileKind::Scene:
      return is_sequence_scene(file) ? sequence_info(read_sequence_scene(file))
             : is_deform_scene(file) ? edits_text(read_deform_scene(file))
             : is_fair_scene(file)   ? fairing_text(read_fair_scene(file))
                                     : scene_text(read_scene(file));
    case FileKind::Mesh:
      return mesh_info(file, unit);
    case FileKind::Sequence:
      return sequence_info(SequenceSource{file, {}, {}}, unit);
    case FileKind::Cad:
      return cad_info(file, unit, [&] {
        return lines_text(read_source_file(file, unit, unit), unit, kCorner);
      });
    case FileKind::Lines:
      return lines_text(curves_of_file(file, unit), unit, kCorner);
    case FileKind::None:
      break;
  }
  throw InputError(file.string() + ": found the extension '" + file.extension().string() +
                   "', expected a scene (.toml), curves (.csv, .txt, .xyz, .dat, .obj, .curves, "
                   ".iges, .step, .brep, .dxf, .svg, .json), a mesh (" +
                   comma_separated(MeshFile::readable_extensions()) +
                   ") or a mesh sequence (.glb, .gltf, .pc2, .mdd, .pvd, .frd)");
}

void draw_lines(const std::filesystem::path& picture, const std::filesystem::path& file,
                const std::string& unit) {
  if (file.extension() == ".toml") {
    if (is_deform_scene(file) || is_sequence_scene(file))
      throw InputError(file.string() +
                       ": found a scene without curves to draw, expected a surface or fair scene");
    if (is_fair_scene(file)) {
      const FairScene scene = read_fair_scene(file);
      return draw_lines(picture, read_sources(scene.lines, scene.file, scene.unit), scene.unit,
                        kCorner);
    }
    const Scene scene = read_scene(file);
    return draw_lines(picture, read_sources(scene), scene.unit, scene.skin.options.corner_angle);
  }
  if (line_file_kind(file) == LineFileKind::None)
    throw InputError(file.string() +
                     ": found a file without curves to draw, expected a scene or a curve file");
  if (draw_face_edges(picture, file, unit)) return;
  draw_lines(picture, curves_of_file(file, unit), unit, kCorner);
}

namespace {

// Formats loops as in [[face]]: [["a", "b"], ["c"]].
std::string format_loops(const CurveNetwork& network, const std::vector<EdgeLoop>& loops) {
  std::vector<std::string> lists;
  for (const EdgeLoop& loop : loops) {
    std::vector<std::string> names;
    for (const auto& part : loop) names.push_back(network.edges()[part.edge].name);
    lists.push_back(SceneText::toml_string_list(names));
  }
  return SceneText::list(lists);
}

// The TOML that creates these surfaces; if `with` is empty, the TOML that suppresses the chosen
// ones.
std::string format_alternative(const CurveNetwork& network, const AmbiguousRegion& ambiguous,
                               const std::vector<EdgeLoop>& with) {
  const std::vector<EdgeLoop>& loops = with.empty() ? ambiguous.chosen : with;
  std::vector<std::vector<EdgeLoop>> surfaces;
  for (const EdgeLoop& loop : loops) surfaces.push_back({loop});
  if (ambiguous.one_surface) surfaces = {loops};
  std::string text;
  for (const auto& surface : surfaces)
    text += "    [[face]]\n    loops = " + format_loops(network, surface) + "\n" +
            (with.empty() ? "    surface = false\n" : "");
  return text;
}

LoopAlternative panel_of(const CurveNetwork& network, const std::string& title,
                         const std::vector<EdgeLoop>& loops, bool one_surface) {
  LoopAlternative panel{title, {}, one_surface};
  for (const EdgeLoop& loop : loops) {
    panel.loops.emplace_back();
    for (const OrientedEdge& use : loop)
      panel.loops.back().push_back(network.edges()[use.edge].curve);
  }
  return panel;
}

}  // namespace

std::string draw_alternatives(const std::filesystem::path& folder, const Scene& scene) {
  require_display();
  std::vector<CharacterLine> lines = read_lines(scene);
  add_mirrored(scene, lines);
  const ModelBuildOptions options = model_build_options(scene, lines);
  const CurveNetwork network = build_network(lines, options);
  const FoundRegions found = require_regions(network, options);
  if (found.ambiguous_regions.empty()) return "no ambiguous faces\n";
  make_output_folder(folder);
  LoopPicture picture;
  for (const NetworkEdge& edge : network.edges()) picture.lines.push_back(edge.curve);
  std::string text;
  for (size_t k = 0; k < found.ambiguous_regions.size(); ++k) {
    const AmbiguousRegion& ambiguous = found.ambiguous_regions[k];
    const std::string file = "alternatives_" + std::to_string(k + 1) + ".png";
    text += file + ": " + ambiguous.text + "\n";
    picture.alternatives = {panel_of(network,
                                     ambiguous.chosen.empty() ? "current: no surface" : "current",
                                     ambiguous.chosen, ambiguous.one_surface)};
    for (size_t a = 0; a < ambiguous.alternatives.size(); ++a) {
      const auto& other = ambiguous.alternatives[a];
      const long percent = std::lround(100 * ambiguous.margins[a]);
      const std::string title =
          std::string(other.empty() ? "alternative: no surface" : "alternative") +
          (percent > 0 ? ", score " + std::to_string(percent) + " % higher" : "");
      picture.alternatives.push_back(panel_of(network, title, other, ambiguous.one_surface));
      text += "  " + title + ":\n" + format_alternative(network, ambiguous, other);
    }
    draw_loops(folder / file, picture);
  }
  return text;
}

namespace {

/// Curves and meshes share extensions: a mesh has faces, a Nastran deck has grid points.
bool is_mesh_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  if (ending != ".obj" && ending != ".dat") return MeshFile::can_read(file);
  std::ifstream in(file);
  for (std::string row; std::getline(in, row);) {
    const auto has = [&](const std::string& begin) {  // lines may end with a carriage return only
      return row.starts_with(begin) || row.find("\r" + begin) != row.npos;
    };
    if (ending == ".obj" ? has("f ") || has("f\t") : has("GRID") || has("BEGIN BULK")) return true;
  }
  return false;
}

}  // namespace

FileKind file_kind(const std::filesystem::path& file) {
  if (file.extension() == ".toml") return FileKind::Scene;
  if (is_mesh_file(file)) return FileKind::Mesh;
  if (is_sequence_file(file)) return FileKind::Sequence;
  switch (line_file_kind(file)) {
    case LineFileKind::None:
      return FileKind::None;
    case LineFileKind::Cad:
      return FileKind::Cad;
    default:
      return FileKind::Lines;
  }
}

namespace {

std::string format_position(const Vec3& p) {
  return "(" + format_number(p.x()) + ", " + format_number(p.y()) + ", " + format_number(p.z()) +
         ")";
}

std::string describe_box(const Box3& box) {
  return "from " + format_position(box.min()) + " to " + format_position(box.max());
}

std::string sets_text(const std::string& what, const std::vector<MeshFile::Set>& sets) {
  std::string text;
  for (const auto& s : sets)
    text += "  " + what + " '" + printable(s.name) + "'" +
            (s.title.empty() ? "" : " (" + printable(s.title) + ")") + ": " +
            (s.faces.empty() ? std::to_string(s.nodes.size()) + " nodes"
                             : std::to_string(s.faces.size()) + " faces") +
            "\n";
  return text;
}

/// Describes mesh components with their boxes, and the non-shell elements that connect them.
std::string parts_text(const MeshFile& file, const TriangleMesh& mesh) {
  const std::vector<int> part = node_components(mesh.topology());
  const int count = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  if (count < 2 && file.other_elements().empty()) return "";
  std::vector<Box3> boxes(count);
  std::vector<int> nodes(count, 0), lowest(count, -1);
  for (int v = 0; v < isize(part); ++v) {
    if (part[v] < 0) continue;
    boxes[part[v]].extend(mesh.point(v));
    ++nodes[part[v]];
    if (lowest[part[v]] < 0) lowest[part[v]] = v;
  }
  std::string text;
  for (int p = 0; p < count && count > 1; ++p)
    text += "  part " + std::to_string(p + 1) + ": " + std::to_string(nodes[p]) + " nodes, node " +
            std::to_string(file.node_label(lowest[p])) + " …, " + describe_box(boxes[p]) + "\n";
  // Non-shell nodes are grouped by their elements; each group reaches the components it is attached
  // to.
  DisjointSets hanging(part.size());
  for (const NonShellElement& e : file.other_elements()) {
    int first = -1;
    for (const int v : e.nodes)
      if (part[v] < 0) {
        if (first >= 0) hanging.unite(first, v);
        first = v;
      }
  }
  std::map<int, std::set<int>> reached;  // components, by the lowest node of a group
  for (const NonShellElement& e : file.other_elements())
    for (const int v : e.nodes)
      for (const int u : e.nodes)
        if (part[v] < 0 && part[u] >= 0) reached[hanging.find(v)].insert(part[u]);
  std::map<std::set<int>, std::map<std::string, int>> between;  // components, elements
  for (const NonShellElement& e : file.other_elements()) {
    std::set<int> parts;
    for (const int v : e.nodes)
      if (part[v] >= 0)
        parts.insert(part[v]);
      else
        parts.insert(reached[hanging.find(v)].begin(), reached[hanging.find(v)].end());
    ++between[parts][e.name];
  }
  for (const auto& [parts, elements] : between) {
    std::string where = parts.size() > 1 ? "between parts"
                        : parts.empty()  ? "not attached to a part"
                                         : "on part";
    for (const int p : parts) where += " " + std::to_string(p + 1);
    text += "  " + where + ":";
    for (const auto& [name, n] : elements)
      text += (name == elements.begin()->first ? " " : ", ") + std::to_string(n) + " " +
              printable(name);
    text += "\n";
  }
  return text;
}

std::string describe_hole(const HoleMeasure& m) {
  if (!m.circular) return "not circular, perimeter " + format_number(m.perimeter);
  return "centre " + format_position(m.centre) + ", radius " + format_number(m.radius);
}

}  // namespace

std::string mesh_info(const std::filesystem::path& path, const std::string& unit,
                      const FeatureDetectionOptions& proposals) {
  const MeshFile file = MeshFile::read(path);
  const ShellMesh& shells = file.shells();
  const MeshDiagnosis d = diagnose(shells);
  std::string text = file.format() + ": " + std::to_string(shells.node_count()) + " nodes, " +
                     std::to_string(shells.face_count()) + " faces in " +
                     std::to_string(d.components) + (d.components == 1 ? " part" : " parts") +
                     ", lengths in " + unit + "\n";
  for (const auto& w : file.warnings()) text += "  " + printable(w) + "\n";
  text += sets_text("set", file.sets()) + sets_text("property", file.properties());
  const auto name = [&](int v) { return std::to_string(file.node_label(v)); };
  const PreparedMesh prepared = [&] {
    try {
      return prepare(shells, name);
    } catch (const InputError& e) {
      throw InputError(path.string() + ": " + e.what() + "\n  " + text);
    }
  }();
  const TriangleMesh& mesh = prepared.mesh;
  for (const auto& note : prepared.notes) text += "  " + printable(note) + "\n";
  text += "  " + describe_box(mesh.box()) + "\n" + parts_text(file, mesh);
  const QualitySummary q = summarize(shells, shells.points);
  text += "  worst aspect " + format_number(q.aspect.worst) + ", warpage " +
          format_number(q.warpage_degrees.worst) + " degrees, Jacobian " +
          format_number(q.jacobian.worst) + "\n";
  const auto& loops = mesh.topology().boundary_loops();
  for (size_t l = 0; l < loops.size(); ++l)
    text += "  loop " + std::to_string(l + 1) + ": " + std::to_string(loops[l].size()) +
            " nodes, " + describe_hole(measure_hole(mesh.points(), loops[l])) + "\n";
  for (const auto& p : detect_features(mesh, proposals))
    text += "  feature '" + p.name +
            "': " + std::to_string(mesh.topology().nodes_of(p.vertices).size()) + " nodes, " +
            describe_hole(p.measure) + "\n";
  return text;
}

bool is_sequence_file(const std::filesystem::path& file) {
  static const std::vector<std::string> endings{".glb", ".gltf", ".pc2", ".mdd", ".pvd", ".frd"};
  return std::find(endings.begin(), endings.end(), lower_extension(file)) != endings.end();
}

std::string sequence_info(const SequenceSource& source, const std::string& unit) {
  const MeshSequence s = read_frames(source.path, source.options);
  const MeshDiagnosis mesh = diagnose(s.shells);
  Vec3 low = s.frames.front().colwise().minCoeff(), high = s.frames.front().colwise().maxCoeff();
  double step = 0;
  for (size_t k = 0; k < s.frames.size(); ++k) {
    low = low.cwiseMin(s.frames[k].colwise().minCoeff().transpose());
    high = high.cwiseMax(s.frames[k].colwise().maxCoeff().transpose());
    if (k > 0) step = std::max(step, (s.frames[k] - s.frames[k - 1]).rowwise().norm().maxCoeff());
  }
  const auto jerks = second_differences(s.frames);
  const double size = size_of(s),
               apart = (s.frames.back() - s.frames.front()).rowwise().norm().maxCoeff();
  std::string text =
      std::to_string(s.frame_count()) + " frames from " + format_number(s.times.front()) + " to " +
      format_number(s.times.back()) + ", " + std::to_string(s.node_count()) + " nodes, " +
      std::to_string(s.shells.face_count()) + " faces in " + std::to_string(mesh.components) +
      (mesh.components == 1 ? " part" : " parts") + ", lengths in " + unit + "\n";
  text += "  bounding box of all frames: from " + format_point(low) + " to " + format_point(high) +
          "\n";
  if (s.frame_count() > 1)
    text += "  largest node displacement " + format_number(step) +
            " between frames, largest second difference " +
            format_number(*std::max_element(jerks.begin(), jerks.end())) +
            (apart < 1e-6 * size ? "; the last frame equals the first one" : "") + "\n";
  return text;
}

std::string sequence_info(const SequenceScene& scene) {
  std::string text = "sequence scene '" + printable(scene.name) + "', unit " + scene.unit + "\n" +
                     sequence_info(scene.source, scene.unit);
  const auto list = [&](const std::string& what, const auto& things) {
    if (things.empty()) return;
    text += what + ":";
    for (size_t i = 0; i < things.size(); ++i) text += (i ? ", " : " ") + printable(things[i].name);
    text += "\n";
  };
  list("handles", scene.handles);
  list("operations", scene.steps);
  return text;
}

namespace {

constexpr size_t kMaxListed = 20;  // products, names, colours and layers

std::string describe_closedness(const CadContents& c) {
  if (c.shells == 0) return "";
  return c.closed_shells == c.shells ? ", closed"
                                     : ", " + std::to_string(c.closed_shells) + " of " +
                                           format_count(c.shells, "shell") + " closed";
}

std::string product_row(const CadProduct& product) {
  std::string text(2 + 2 * static_cast<size_t>(product.level), ' ');
  text += product.assembly ? "assembly" : "part";
  text += product.name.empty() ? " without a name" : " '" + printable(product.name) + "'";
  if (!product.instance_name.empty()) text += " as '" + printable(product.instance_name) + "'";
  if (!product.assembly) {
    if (product.solids) text += ", " + format_count(product.solids, "solid");
    if (product.faces || !product.curves) text += ", " + format_count(product.faces, "face");
    if (product.curves) text += ", " + format_count(product.curves, "curve");
  }
  if (!product.translation.isZero()) text += ", at " + format_point(product.translation);
  if (product.rotation_deg > 1e-9)
    text += ", rotated by " + format_number(product.rotation_deg) + " degrees";
  if (!product.colour.empty()) text += ", " + product.colour;
  return text + "\n";
}

/// "3 faces, 1 curve".
std::string describe_use(const CadAttribute& use) {
  std::string text;
  for (const auto& [count, noun] :
       {std::pair(use.products, "product"), std::pair(use.solids, "solid"),
        std::pair(use.faces, "face"), std::pair(use.edges, "edge"), std::pair(use.curves, "curve")})
    if (count > 0) text += (text.empty() ? "" : ", ") + format_count(count, noun);
  return text;
}

std::string uses_text(const std::string& what, const std::vector<CadAttribute>& uses) {
  std::string text;
  for (size_t i = 0; i < std::min(uses.size(), kMaxListed); ++i)
    text += "  " + what + " '" + printable(uses[i].name) + "': " + describe_use(uses[i]) + "\n";
  if (uses.size() > kMaxListed)
    text += "  and " + std::to_string(uses.size() - kMaxListed) + " more\n";
  return text;
}

/// The contents of a CAD file: products with their positions, names, colours and layers, the first
/// twenty of each. Lengths are in the file's unit.
std::string contents_text(const CadContents& c) {
  std::string text = contents_line(c) + "\n";
  for (const std::string& note : c.notes) text += "  " + printable(note) + "\n";
  const std::string unit = format_unit(c.unit_in_metres);
  text += "  size " + format_number(c.size) + " " + unit;
  if (c.faces) text += ", area " + format_number(c.area) + " " + unit + "²";
  if (c.solids) text += ", volume " + format_number(c.volume) + " " + unit + "³";
  text += "\n";
  for (size_t i = 0; i < std::min(c.products.size(), kMaxListed); ++i)
    text += product_row(c.products[i]);
  if (c.products.size() > kMaxListed)
    text += "  and " + std::to_string(c.products.size() - kMaxListed) + " more\n";
  return text + uses_text("name", c.names) + uses_text("colour", c.colours) +
         uses_text("layer", c.layers);
}

// Describes a STEP file; empty if it has no faces.
std::string step_text(const std::filesystem::path& file, const std::string& unit) {
  const StepReport step = cad_plugin().check_step(file, unit_in_metres(unit), {});
  if (step.faces == 0) return "";
  return std::to_string(step.faces) + " faces in " + std::to_string(step.shells) +
         " shells, lengths in " + unit + "\n  " + (step.valid ? "valid" : "NOT valid") + ", area " +
         format_number(step.area) + "\n";
}

EdgeComb comb_of(const EdgeContinuity& edge) {
  using Kind = EdgeContinuity::Kind;
  EdgeComb comb;
  comb.kind = edge.kind == Kind::Crease    ? EdgeComb::Kind::Crease
              : edge.kind == Kind::Tangent ? EdgeComb::Kind::Tangent
                                           : EdgeComb::Kind::Curvature;
  for (const EdgeCombSample& sample : edge.comb_samples) {
    comb.line.push_back(sample.at);
    for (size_t side = 0; side < 2; ++side)
      comb.curvature_vectors[side].push_back(sample.curvature_vectors[side]);
  }
  return comb;
}

}  // namespace

std::string contents_line(const CadContents& c) {
  std::string text = c.format + ", " + (c.unit_stated ? "in " : "no unit, assumed ") +
                     format_unit(c.unit_in_metres) + ": " +
                     format_count(isize(c.products), "product");
  if (c.solids) text += ", " + format_count(c.solids, "solid");
  if (c.faces) text += ", " + format_count(c.faces, "face") + describe_closedness(c);
  if (c.curves) text += ", " + format_count(c.curves, "curve");
  if (!c.names.empty()) text += "; " + format_count(isize(c.names), "name");
  if (!c.colours.empty()) text += "; " + format_count(isize(c.colours), "colour");
  if (!c.layers.empty()) text += "; " + format_count(isize(c.layers), "layer");
  return text;
}

std::string cad_info(const std::filesystem::path& file, const std::string& unit,
                     const std::function<std::string()>& lines) {
  const CadContents contents = cad_plugin().read_cad_contents(file);
  std::string text = contents_text(contents);
  if (contents.faces == 0) return text + lines();
  const CadFormat format = cad_format(file);
  const ContinuityReport report =
      cad_plugin().measure_continuity(file, unit_in_metres(unit), ContinuityOptions{});
  text += format == CadFormat::Step
              ? sandboxed_read(file, "OpenCASCADE", [&] { return step_text(file, unit); })
              : std::to_string(report.faces) + " faces, lengths in " + unit + "\n";
  text += continuity_text(report, ContinuityOptions{}, unit);
  return format == CadFormat::Iges ? text + lines() : text;
}

bool draw_face_edges(const std::filesystem::path& picture, const std::filesystem::path& file,
                     const std::string& unit) {
  if (file_kind(file) != FileKind::Cad ||
      cad_plugin().read_cad_surfaces(file, unit_in_metres(unit)).empty())
    return false;
  require_display();
  ContinuityOptions options;
  options.comb_samples = 40;
  const ContinuityReport report =
      cad_plugin().measure_continuity(file, unit_in_metres(unit), options);
  EdgePicture drawing;
  drawing.title = file.filename().string() + ": curvature across edges";
  drawing.unit = unit;
  for (const EdgeContinuity& edge : report.inner) drawing.edges.push_back(comb_of(edge));
  drawing.free_edges = report.free_edge_lines;
  draw_edge_combs(picture, drawing);
  return true;
}

}  // namespace batten
