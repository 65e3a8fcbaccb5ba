// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/commands.h"

#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/io/cad/cad_format.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/scenes/lines/line_corners.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// Names that occur more often in `before` than in `after`: "'hull' (3 of 4)", the first few; empty
/// if none. `edges`: true: include edges of faces.
std::string missing_names(const std::vector<CadAttribute>& before,
                          const std::vector<CadAttribute>& after, bool edges) {
  std::string text;
  size_t lost = 0;
  for (const CadAttribute& use : before) {
    const auto at = std::find_if(after.begin(), after.end(),
                                 [&](const CadAttribute& other) { return other.name == use.name; });
    const auto count = [&](const CadAttribute& one) {
      return one.solids + one.faces + one.curves + (edges ? one.edges : 0);
    };
    const int all = count(use), kept = at == after.end() ? 0 : count(*at);
    if (kept >= all) continue;
    if (++lost <= 5)
      text += (text.empty() ? "'" : ", '") + use.name + "' (" + std::to_string(kept) + " of " +
              std::to_string(all) + ")";
  }
  return lost > 5 ? text + " and " + std::to_string(lost - 5) + " more" : text;
}

bool has(const std::vector<std::string>& endings, const fs::path& file) {
  return std::find(endings.begin(), endings.end(), lower_extension(file)) != endings.end();
}

std::string name_of(const fs::path& file) { return file.filename().string(); }

/// Length of a unit in metres; 0 for "".
double metres(const std::string& unit) { return unit.empty() ? 0 : unit_in_metres(unit); }

void row(ConvertReport& report, const std::string& label, const std::string& text) {
  report.text += summary_line(label, text);
}

void report_failed_check(ConvertReport& report, const std::string& what,
                         const std::string& detail) {
  report.failed_checks.push_back({what, detail});
}

/// Adds files that were written beside the requested one; the result is a text that lists them.
std::string add_files(ConvertReport& report, const std::vector<fs::path>& beside) {
  std::string words;
  for (const fs::path& file : beside) {
    report.files.push_back(file.string());
    words += ", colours in " + name_of(file);
  }
  return words;
}

/// The unit that a format prescribes; empty if it prescribes none.
std::string fixed_unit(const fs::path& file) {
  const std::string ending = lower_extension(file);
  return ending == ".glb" ? "m" : ending == ".3mf" ? "mm" : "";
}

std::string unit_in_file(const fs::path& file, const std::string& unit) {
  const std::string fixed = fixed_unit(file);
  return fixed.empty() ? unit : fixed;
}

// ---- CAD ------------------------------------------------------------------------------------

void check_facets(ConvertReport& report, double chord, double deviation, int cracks, int unmeshed) {
  if (!(deviation <= chord))
    report_failed_check(
        report, "convert.chord",
        "is " + format_number(deviation) + ", expected at most " + format_number(chord));
  if (cracks)
    report_failed_check(
        report, "convert.cracks",
        "are " + format_count(cracks, "edge") + " between triangles, expected none");
  if (unmeshed)
    report_failed_check(report, "convert.faces",
                        "include " + format_count(unmeshed, "face") + " without a triangle");
}

std::string describe_chord(double deviation, double chord, double size, const std::string& unit) {
  return "triangles within " + format_number(deviation) + " " + unit + " of the faces, chord " +
         format_number(chord) + " " + unit + " (" + format_number(chord / size) + " of the size)";
}

/// Compares the written file with the input; `ending`: extension of the written file.
void compare(ConvertReport& report, const CadConversion& c, const std::string& ending) {
  const CadContents &a = c.before, &b = c.after;
  const double scale = a.unit_in_metres / b.unit_in_metres;
  const auto same = [&](const std::string& what, int before, int after) {
    if (before != after)
      report_failed_check(report, "convert." + what,
                          "are " + std::to_string(after) + ", expected " + std::to_string(before));
  };
  same("faces", a.faces, b.faces);
  same("solids", a.solids, b.solids);
  same("closed_shells", a.closed_shells, b.closed_shells);
  same("curves", a.curves, b.curves);
  const auto near = [&](const std::string& what, double before, double after, double loose) {
    const double most = 1e-6 * std::abs(before) + loose;
    if (!(std::abs(before - after) <= most))
      report_failed_check(report, "convert." + what,
                          "is " + format_number(after) + ", expected " + format_number(before) +
                              " within " + format_number(most));
  };
  // Readers move trimming curves within their tolerances.
  const double loose = std::max(a.trim_uncertainty_area * scale * scale, b.trim_uncertainty_area);
  near("area", a.area * scale * scale, b.area, loose);
  near("volume", a.volume * std::pow(scale, 3), b.volume, loose * b.size);
  if (ending.starts_with(".br")) return;
  const bool step = ending.starts_with(".st");
  if (step) same("products", isize(a.products), isize(b.products));
  for (const auto& [what, before, after] :
       {std::tuple("names", &a.names, &b.names), std::tuple("colours", &a.colours, &b.colours)})
    if (const std::string lost = missing_names(*before, *after, step); !lost.empty())
      report_failed_check(report, std::string("convert.") + what, "are lost: " + lost);
}

void cad_to_cad(const ConvertTask& task, ConvertReport& report) {
  CadConvertOptions options;
  options.unit_in_metres = metres(task.unit);
  options.ap242 = task.ap242;
  options.chord = task.chord;
  const CadConversion c = cad_plugin().convert_cad(task.from, task.to, options);
  const std::string unit = format_unit(c.unit_in_metres);
  const std::string ending = lower_extension(task.to);
  row(report, "read", name_of(task.from) + ": " + contents_line(c.before));
  if (ending == ".glb") {
    row(report, "written",
        name_of(task.to) + ": " + std::to_string(c.triangles) +
            " triangles, in metres (the unit of glTF)");
    row(report, "", describe_chord(c.deviation, c.chord, c.size, unit));
    check_facets(report, c.chord, c.deviation, c.cracks, c.unmeshed);
    return;
  }
  row(report, "written", name_of(task.to) + ": " + contents_line(c.after));
  const bool brep = ending.starts_with(".br");
  if (brep && unit != "mm")
    report.warnings.push_back("BREP files state no unit: coordinates are in " + unit +
                              ", but other programs assume mm");
  compare(report, c, ending);
  for (const auto* notes : {&c.before.notes, &c.notes})
    report.warnings.insert(report.warnings.end(), notes->begin(), notes->end());
}

bool is_deck(const fs::path& file) {
  return has({".inp", ".bdf", ".nas", ".dat", ".fem", ".k", ".key", ".dyn", ".rad"}, file);
}

/// Warns of faces that the elements of a deck cannot represent.
void warn_of_degenerate_faces(const ConvertTask& task, const ShellMesh& mesh,
                              ConvertReport& report) {
  if (!is_deck(task.to)) return;
  int count = 0, first = 0;
  for (int f = mesh.face_count() - 1; f >= 0; --f)
    if (is_degenerate(mesh, f)) ++count, first = f;
  if (count > 0)
    report.warnings.push_back(format_count(count, "face") +
                              " with fewer than three different corners not written, the first " +
                              "is number " + std::to_string(first + 1));
}

void cad_to_mesh(const ConvertTask& task, ConvertReport& report) {
  CadFacetOptions options;
  options.unit_in_metres = metres(task.unit);
  options.chord = task.chord;
  const CadFacets f = cad_plugin().tessellate_cad(task.from, options);
  std::vector<MeshSet> sets;
  for (const FacetGroup& group : f.groups)
    sets.push_back({group.name, "", {}, group.triangles, group.colour});
  const std::string beside = add_files(report, write_mesh(task.to, f.mesh, sets, f.unit_in_metres));
  const std::string unit = format_unit(f.unit_in_metres);
  row(report, "read", name_of(task.from) + ": " + contents_line(f.contents));
  row(report, "written",
      name_of(task.to) + ": " + format_count(f.mesh.face_count(), "triangle") + ", " +
          format_count(f.mesh.node_count(), "node") + ", in " + unit_in_file(task.to, unit) + ", " +
          (f.free_edges ? format_count(f.free_edges, "free edge") : "closed") + beside);
  row(report, "", describe_chord(f.deviation, f.chord, f.size, unit));
  check_facets(report, f.chord, f.deviation, f.cracks, f.unmeshed);
  report.warnings = f.contents.notes;
  warn_of_degenerate_faces(task, f.mesh, report);
}

// ---- meshes and curves ----------------------------------------------------------------------

/// Conversion factor from the unit of an input that states none to the requested unit.
double factor_of(const ConvertTask& task) {
  if (task.unit.empty() || task.unit == task.from_unit) return 1;
  if (task.from_unit.empty())
    throw InputError(task.from.string() + ": found --unit " + task.unit +
                     " for a file that states no length unit, expected --from-unit, too");
  return unit_in_metres(task.from_unit) / unit_in_metres(task.unit);
}

/// Unit in metres of a mesh that is written to a format with a prescribed unit; 0 for other
/// formats.
double declared_unit(const ConvertTask& task) {
  const std::string fixed = fixed_unit(task.to);
  if (fixed.empty()) return 0;
  const std::string kind = lower_extension(task.to) + " is in " + fixed;
  if (!task.unit.empty() && task.unit != fixed)
    throw InputError(task.to.string() + ": found --unit " + task.unit + ", expected none: " + kind);
  if (task.from_unit.empty())
    throw InputError(task.from.string() + ": found a file that states no length unit, and " + kind +
                     ", expected --from-unit, the unit of the coordinates");
  return unit_in_metres(task.from_unit);
}

/// The face sets of a file, or its properties if there are none; split by colour.
std::vector<MeshSet> groups_of(const MeshFile& file) {
  std::vector<std::string> colours(static_cast<size_t>(file.shells().face_count()));
  for (const MeshSet& property : file.properties())
    for (const int f : property.faces) colours[f] = property.colour;
  const bool sets = std::any_of(file.sets().begin(), file.sets().end(),
                                [](const MeshSet& set) { return !set.faces.empty(); });
  std::vector<MeshSet> groups;
  for (const MeshSet& set : sets ? file.sets() : file.properties()) {
    const size_t first = groups.size();
    for (const int f : set.faces) {
      auto at = std::find_if(groups.begin() + static_cast<long>(first), groups.end(),
                             [&](const MeshSet& group) { return group.colour == colours[f]; });
      if (at == groups.end())
        at = groups.insert(at, MeshSet{set.name, set.title, {}, {}, colours[f]});
      at->faces.push_back(f);
    }
  }
  return groups;
}

void mesh_to_mesh(const ConvertTask& task, ConvertReport& report) {
  const double stated = declared_unit(task);
  const double factor = stated > 0 ? 1 : factor_of(task);
  const MeshFile file = MeshFile::read(task.from);
  ShellMesh mesh = file.shells();
  mesh.points *= factor;
  const std::string beside = add_files(report, write_mesh(task.to, mesh, groups_of(file), stated));
  const auto counts =
      format_count(mesh.node_count(), "node") + ", " + format_count(mesh.face_count(), "face");
  row(report, "read", name_of(task.from) + ": " + file.format() + ", " + counts);
  const std::string to = stated > 0 ? fixed_unit(task.to) : task.unit;
  row(report, "written",
      name_of(task.to) + ": " + counts +
          (to.empty() || to == task.from_unit ? ", coordinates unchanged"
                                              : ", " + task.from_unit + " to " + to) +
          beside);
  if (is_deck(task.from))
    row(report, "", "nodes, shells and sets only: no materials, sections, supports or loads");
  report.warnings = file.warnings();
  if (!file.other_elements().empty())
    report.warnings.push_back(format_count(isize(file.other_elements()), "element") +
                              " other than shells not written");
  warn_of_degenerate_faces(task, mesh, report);
}

/// The curve of a line; a polyline of a drawing or CAD file has a corner at every vertex, also if it
/// samples a smooth curve. Null for a curve that is given by points.
std::shared_ptr<const InputCurve> curve_as_given(SourceLine line) {
  if (line.curve || line.vertices == SourceLine::Vertices::Points) return line.curve;
  line.corners = all_corners(line.points);
  return line.as_curve(SkinOptions{}.corner_angle);
}

/// Replaces the curves through samples of input curves by exact ones, if the input consists of
/// cubic pieces. Every kink becomes a corner.
void keep_exact(const std::vector<SourceLine>& lines, std::vector<NamedCurve>& curves) {
  constexpr double kink = 1e-5;  // degrees; exact_curve() treats smaller angles as smooth
  for (size_t i = 0; i < lines.size(); ++i)
    if (const auto given = curves[i].has_curve() ? curve_as_given(lines[i]) : nullptr)
      if (auto exact = exact_curve(*given, kink)) curves[i].curve = *std::move(exact);
}

/// The length unit that a file of curves states; empty if it states none.
std::string stated_unit(const ConvertTask& task) {
  if (file_kind(task.from) == FileKind::Cad)
    return format_unit(cad_plugin().read_cad_contents(task.from).unit_in_metres);
  if (!task.from_unit.empty() || line_file_kind(task.from) != LineFileKind::Drawing)
    return task.from_unit;
  const double metres = read_drawing(task.from).unit_in_metres;
  return metres > 0 ? format_unit(metres) : "";
}

void lines_to_lines(const ConvertTask& task, ConvertReport& report, const Progress& progress) {
  const std::string stated = stated_unit(task);
  std::string unit = task.unit.empty() ? stated : task.unit;
  // Other units, such as the pixels of SVG files, are converted to millimetres.
  const auto& units = length_units();
  if (std::find(units.begin(), units.end(), unit) == units.end()) unit = "mm";
  const auto lines = read_source_file(task.from, task.from_unit, unit);
  std::vector<NamedCurve> curves;
  for (const FairedResult& line : fair_lines(lines, {}, progress)) curves.push_back(line.named());
  if (!has({".csv", ".curves", ".obj"}, task.to)) keep_exact(lines, curves);
  report.warnings = write_curves(task.to, curves, {unit_in_metres(unit), task.ap242});
  for (const SourceLine& line : lines)
    report.warnings.insert(report.warnings.end(), line.warnings.begin(), line.warnings.end());
  row(report, "read", name_of(task.from) + ": " + format_count(isize(lines), "curve"));
  row(report, "written",
      name_of(task.to) + ": " + format_count(isize(curves), "curve") + ", in " + unit +
          (stated.empty() ? ", assumed because the file states no unit" : ""));
}

[[noreturn]] void refuse(const ConvertTask& task, const std::string& what,
                         const std::vector<std::string>& endings, const std::string& more = "") {
  throw InputError(task.to.string() + ": found the extension '" + task.to.extension().string() +
                   "' for " + what + ", expected one of: " + comma_separated(endings) + more);
}

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
  for (const std::string& ending : b)
    if (std::find(a.begin(), a.end(), ending) == a.end()) a.push_back(ending);
  return a;
}

void convert_cad_file(const ConvertTask& task, ConvertReport& report, const Progress& progress) {
  const auto cad = joined(cad_extensions(), {".glb"});
  if (has(cad, task.to)) return cad_to_cad(task, report);
  const bool lines = has(curve_file_extensions(), task.to),
             mesh = has(mesh_file_endings(), task.to);
  if (!lines && !mesh)
    refuse(task, "a CAD file", joined(joined(cad, mesh_file_endings()), curve_file_extensions()));
  // Extensions that lines and meshes share: the contents decide.
  if (mesh && !(lines && cad_plugin().read_cad_contents(task.from).faces == 0))
    return cad_to_mesh(task, report);
  lines_to_lines(task, report, progress);
}

}  // namespace

ConvertReport run_convert(const ConvertTask& task, const Progress& progress) {
  const CommandFiles files;
  require_input_file(task.from, "a CAD file, a mesh or a curve file");
  replaceable_file(task.to);
  ConvertReport report;
  report.name = name_of(task.from);
  report.files = {task.to.string()};
  switch (file_kind(task.from)) {
    case FileKind::Cad:
      if (!task.from_unit.empty())
        throw InputError(task.from.string() + ": found --from-unit " + task.from_unit +
                         ", expected none: CAD files state their unit");
      convert_cad_file(task, report, progress);
      break;
    case FileKind::Mesh:
      if (has(cad_extensions(), task.to))
        throw InputError(
            task.to.string() +
            ": found a CAD format for a mesh, expected a mesh format; use `batten fit` to fit "
            "smooth CAD faces to a mesh");
      if (!has(mesh_file_endings(), task.to)) refuse(task, "a mesh", mesh_file_endings());
      mesh_to_mesh(task, report);
      break;
    case FileKind::Lines:
      if (!has(curve_file_extensions(), task.to)) refuse(task, "curves", curve_file_extensions());
      lines_to_lines(task, report, progress);
      break;
    default:
      throw InputError(task.from.string() + ": found the extension '" +
                       task.from.extension().string() + "', expected a CAD file (" +
                       comma_separated(cad_extensions()) + "), a mesh or a curve file");
  }
  return report;
}

}  // namespace batten
