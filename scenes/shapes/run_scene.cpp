// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/commands.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/mesh_pictures.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/scenes/lines/mesh_lines.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/runs/run_support.h"
#include "batten/scenes/shapes/load_effects.h"
#include "batten/scenes/shapes/shape_files.h"
#include "batten/scenes/shapes/stress_analysis.h"
#include "batten/scenes/shapes/stress_results.h"

namespace batten {
namespace {

constexpr size_t kMost = 3;  // number of items listed per kind

std::string some(const std::vector<std::string>& names, size_t most = 8) {
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > most) text += ", … (" + std::to_string(names.size()) + " in all)";
  return text;
}

// The first few texts, one per line; the label precedes the first one.
std::string listed_lines(const std::string& label, const std::vector<std::string>& texts) {
  std::string text;
  for (size_t i = 0; i < std::min(texts.size(), kMost); ++i)
    text += summary_line(i ? "" : label, texts[i]);
  if (texts.size() > kMost)
    text +=
        summary_line("", "and " + std::to_string(texts.size() - kMost) + " more (see report.json)");
  return text;
}

std::string repairs(const NetworkReport& n) {
  std::map<std::string, int> counts;
  double farthest = 0;
  for (const NetworkDiagnostic& f : n.diagnostics) {
    if (!f.repaired) continue;
    ++counts[to_text(f.kind)];
    farthest = std::max(farthest, f.distance);
  }
  std::string text;
  for (const auto& [kind, count] : counts)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind;
  return text.empty() ? "" : text + "; largest gap " + format_number(farthest);
}

std::string joins(const NetworkReport& n) {
  std::map<std::string, long> counts;
  double angle = 0;
  size_t open = 0;
  for (const auto& j : n.joins) {
    ++counts[j.kind];
    if (j.kind != "smooth") continue;
    open += j.open[0] || j.open[1];
    angle = std::max(angle, j.max_inside_deg);
  }
  std::string text = format_count(counts["G0"], "crease") + " (G0), " +
                     std::to_string(counts["smooth"]) + " smooth";
  if (counts["smooth"]) text += " within " + format_number(angle) + " degrees";
  if (open) text += " (" + std::to_string(open) + " of them with an end that is G0)";
  text += ", " + format_count(counts["free edge"], "free edge");
  if (counts["non-manifold"])
    text += ", " + std::to_string(counts["non-manifold"]) + " non-manifold";
  return text;
}

/// Summary of curves, edges and repairs.
std::string line_summary(const NetworkReport& n, const std::string& unit) {
  std::string text = summary_line("curves", std::to_string(n.lines) + ", split into " +
                                                format_count(n.edges, "edge") + " at " +
                                                format_count(n.nodes, "node") + ", gap tolerance " +
                                                format_number(n.tolerance) + unit);
  if (constexpr double prepared = 0.5; n.joined_fraction < prepared) {
    const bool found = n.tolerance > 1.1e-3 * n.size;
    text += summary_line(
        "gaps", "only " + format_number(100 * n.joined_fraction) + " % of the curve ends " +
                    (found ? "would meet" : "meet") +
                    " another curve within 1e-3 of the size; set gap_tolerance (--gap-tolerance) "
                    "for another tolerance");
  }
  if (const std::string repaired = repairs(n); !repaired.empty())
    text += summary_line("repaired", repaired + unit);
  std::vector<std::string> listed_only;
  for (const NetworkDiagnostic& f : n.diagnostics)
    if (!f.repaired) listed_only.push_back(f.text);
  text += listed_lines("not joined", listed_only);
  return text;
}

/// Summary of the regions found and skinned, with numbers of triangles.
std::string region_summary(const NetworkReport& n, const Report::Surface& s) {
  size_t skinned = 0;
  std::vector<std::string> not_skinned;
  for (const auto& r : n.regions) {
    skinned += r.skinned;
    if (!r.skinned) not_skinned.push_back("'" + r.name + "': " + r.rejection_reason);
  }
  std::string text = summary_line(
      "faces", std::to_string(n.regions.size()) + " found, " + std::to_string(skinned) +
                   " skinned: " + std::to_string(s.triangles) + " triangles, " +
                   std::to_string(s.dofs) + " unknowns per coordinate");
  return text + listed_lines("not skinned", not_skinned);
}

/// Summary of recognised primitives: planes, cylinders, …
std::string shape_summary(const NetworkReport& n) {
  std::map<std::string, std::pair<int, std::set<std::string>>> shapes;  // count, radii
  for (const auto& r : n.regions)
    if (!r.shape.empty()) {
      auto& [count, radii] = shapes[r.shape];
      ++count;
      char radius[32];
      std::snprintf(radius, sizeof radius, "%.4g", r.radius);
      if (r.radius > 0) radii.insert(radius);
    }
  std::string text;
  for (const auto& [shape, of] : shapes) {
    text += (text.empty() ? "" : ", ") +
            format_count(of.first, shape, shape == "torus" ? "tori" : shape + "s");
    std::string radii;
    for (const std::string& radius : of.second) radii += (radii.empty() ? "" : ", ") + radius;
    constexpr size_t few = 4;
    if (!radii.empty() && of.second.size() <= few) text += " (radius " + radii + ")";
  }
  return text.empty() ? "" : summary_line("shapes", text);
}

/// Summary of the shells.
std::string shell_summary(const NetworkReport& n, const std::string& unit) {
  std::string text;
  for (const auto& shell : n.shells) {
    if (n.shells.size() > kMost && &shell >= &n.shells[kMost]) continue;
    text += summary_line(
        &shell == &n.shells.front() ? "shells" : "",
        format_count(shell.regions.size(), "face") + ", " + (shell.closed ? "closed" : "open") +
            (shell.orientable ? "" : ", non-orientable or non-manifold") + ", area " +
            format_number(shell.area) + unit + "²" +
            (shell.volume != 0 ? ", volume " + format_number(shell.volume) + unit + "³" : ""));
  }
  if (n.shells.size() > kMost)
    text += summary_line("", "and " + std::to_string(n.shells.size() - kMost) + " more shells");
  return text;
}

/// Summary of surface defects.
std::string defect_summary(const Report& report) {
  std::vector<std::string> texts;
  for (const auto& f : report.defects) texts.push_back(f.text);
  return listed_lines("defects", texts);
}

/// Summary of surface quality.
std::string quality_summary(const Report::Surface& s, const std::string& unit) {
  return summary_line("quality", "Jacobian " + format_number(s.quality.min_jacobian_ratio) +
                                     " of its median, normal jump " +
                                     format_number(s.quality.max_normal_jump_deg) +
                                     " degrees, surface to input curves " +
                                     format_number(s.quality.max_line_deviation) + unit);
}

/// Summary of minimum-variation fairing or of a loft.
std::string fairing_summary(const Report& report, const std::string& unit) {
  const Report::Surface& s = report.surface;
  if (s.fair == "loft") return summary_line("lofted", "along splines across the sections");
  if (!s.fairing) return "";
  const bool continues =
      report.network && std::any_of(report.network->joins.begin(), report.network->joins.end(),
                                    [](const auto& join) { return !join.neighbours.empty(); });
  const std::string what = s.fairing->requested ? ""
                                                : format_count(s.fairing->regions, "face") +
                                                      (continues ? " beside given faces: "
                                                                 : " with five or more sides: ");
  return summary_line("faired", what + "curvature variation " +
                                    format_number(s.fairing->start_functional) + " -> " +
                                    format_number(s.fairing->functional) + ", displacement up to " +
                                    format_number(s.fairing->max_move) + unit);
}

/// Summary of the distance to [[target]].
std::string target_summary(const Report& report, const std::string& unit) {
  if (!report.target) return "";
  const auto& t = *report.target;
  return summary_line("target",
                      "RMS " + format_number(t.before_rms) + " -> " + format_number(t.rms) + unit +
                          ", max " + format_number(t.max) + unit + " to the target and " +
                          format_number(t.back_max) + unit + " from it (" +
                          format_number(std::max(t.max, t.back_max) / t.size) +
                          " of the size), tolerance " + format_number(t.tolerance) + unit);
}

/// Summary of the continuity between the faces of a STEP file.
std::string edges_of(const Report::Step& step) {
  const int smooth = step.tangent + step.curvature;
  if (smooth + step.creases == 0) return "";
  const auto missed = std::count_if(step.joins.begin(), step.joins.end(),
                                    [](const auto& join) { return join.exceeds_tolerance; });
  return "; " + format_count(step.creases, "crease") + ", " +
         format_count(smooth, "smooth edge", "smooth edges") +
         (smooth ? " within " + format_number(step.max_smooth_deg) + " degrees" : "") +
         (missed ? ", " + std::to_string(missed) + " above the tolerance" : "");
}

/// Counts of planar, cylindrical, … faces; empty if there are none.
std::string kinds_of(const Report::Step& step) {
  std::string text;
  for (const auto& [kind, count] : step.faces_by_kind)
    if (kind != "B-spline")
      text += (text.empty() ? "" : ", ") +
              format_count(count, kind, kind == "torus" ? "tori" : kind + "s");
  return text.empty() ? "" : " (" + text + ")";
}

/// Summary of the STEP file.
std::string step_summary(const Report::Step& step, const std::string& unit) {
  return summary_line(
      "STEP",
      format_count(step.faces, "face") + kinds_of(step) +
          (step.neighbours ? ", " + std::to_string(step.neighbours->faces) + " of them given,"
                           : "") +
          (step.source.empty() ? "" : ", those of " + step.source + ",") + " in " +
          (step.solids ? format_count(step.solids, "solid") : format_count(step.shells, "shell")) +
          ", " + (step.valid ? "valid" : "NOT valid") + ", within " +
          format_number(step.max_deviation) + unit + ", edges within " +
          format_number(step.max_gap) + unit + edges_of(step));
}

/// Summary of the mesh file.
std::string mesh_summary(const Report::Mesh& mesh) {
  return summary_line(
      "mesh", format_count(mesh.faces, "face") +
                  (mesh.given_faces ? ", " + std::to_string(mesh.given_faces) + " of them given, " +
                                          format_count(mesh.joined_loops, "opening") + " joined"
                                    : "") +
                  ", " + format_count(mesh.free_edges, "free edge"));
}

/// Summary of alternatives, with the TOML that selects them.
std::string alternative_summary(const NetworkReport& n) {
  std::vector<std::string> ambiguous_regions;
  for (const auto& c : n.ambiguous_regions) ambiguous_regions.push_back(c.text);
  std::string text = listed_lines("ambiguous", ambiguous_regions);
  text += summary_line("to change",
                       "[[face]] loops = [[\"…\", \"…\"]], with surface = false for "
                       "no surface there;");
  text += summary_line("",
                       "[[join]] curves = [\"…\"], continuity = \"G0\" or \"smooth\" "
                       "(batten info lists the names)");
  return text;
}

void draw_sweep(const BuiltModel& made, const ModelLayout& layout, const Scene& scene,
                const SceneSweep& sweep, const std::filesystem::path& file,
                const Progress& progress) {
  std::vector<SolvedShape> shapes;
  for (size_t i = 0; i < sweep.values.size(); ++i) {
    progress.update("sweep of " + sweep.parameter,
                    static_cast<double>(i) / static_cast<double>(sweep.values.size()));
    Scene panel = scene;
    panel.set(sweep.parameter, sweep.values[i], "");
    try {
      shapes.push_back(solve_shape(layout, panel, made, {{}, progress.cancelled}));
    } catch (const NoSolutionError& e) {
      throw NoSolutionError("sweep at " + sweep.parameter + " = " + format_number(sweep.values[i]) +
                            ": " + e.what());
    }
  }
  const int count = isize(shapes);
  const int columns = sweep.columns > 0
                          ? std::min(sweep.columns, count)
                          : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<PictureScene> panels;
  for (int i = 0; i < count; ++i) {
    PictureScene panel = shape_picture(sweep.picture.look, made, shapes[i]);
    panel.title += (panel.title.empty() ? "" : ", ") + sweep.parameter + " = " +
                   format_number(sweep.values[i]);
    panels.push_back(panel);
  }
  draw_contact_sheet(file, panels, columns, sweep.picture.size);
}

}  // namespace

std::string network_summary(const Report& report, const std::filesystem::path& folder) {
  const NetworkReport& n = *report.network;
  const auto& s = report.surface;
  const std::string unit = " " + report.unit;
  std::string text = printable(report.name) + "\n";
  text += listed_lines("read", report.reading_notes);
  text += line_summary(n, unit);
  if (!n.added_curves.empty())
    text += summary_line("lofted", format_count(n.added_curves.size(), "curve") +
                                       " added between the sections: " + some(n.added_curves));
  text += region_summary(n, s);
  text += shape_summary(n);
  const bool skinned =
      std::any_of(n.regions.begin(), n.regions.end(), [](const auto& r) { return r.skinned; });
  if (skinned) text += summary_line("edges", joins(n));
  text += shell_summary(n, unit);
  if (skinned) text += summary_line("normals", "point " + s.normals);
  if (report.is_sculpted && s.moved > 0)
    text += summary_line("displaced", "by up to " + format_number(s.moved) + unit +
                                          " from the shape of the curves alone");
  text += defect_summary(report);
  if (!n.unused_edges.empty())
    text += summary_line("unused", format_count(n.unused_edges.size(), "edge") +
                                       " without a face: " + some(n.unused_edges));
  if (skinned)
    text += fairing_summary(report, unit) + target_summary(report, unit) + quality_summary(s, unit);
  if (report.mesh) text += mesh_summary(*report.mesh);
  if (report.step) text += step_summary(*report.step, unit);
  if (report.stress) text += stress_summary(*report.stress, report.unit);
  if (report.comparison)
    text += summary_line("compared", "max " + format_number(report.comparison->max) + unit +
                                         ", RMS " + format_number(report.comparison->rms) + unit +
                                         " from " + report.comparison->file);
  text += alternative_summary(n);
  return text + summary_footer(report, folder);
}

Scene scene_of_lines(const std::vector<std::filesystem::path>& outline,
                     const std::vector<std::filesystem::path>& inner, const std::string& unit) {
  Scene scene;
  scene.unit = unit;
  scene.name = outline.front().stem().string();
  for (const auto* files : {&outline, &inner})
    for (const auto& file : *files) {
      SceneLine line;
      line.file = file;
      line.role = files == &inner ? CharacterLine::Role::Inner : CharacterLine::Role::Outline;
      scene.lines.push_back(line);
    }
  scene.step = scene.name + ".step";
  scene.vtp = scene.name + ".vtp";
  return scene;
}

namespace {

// Analyses the shell of a shape, on a refined mesh.
void stress_into(RunContext& run, const Scene& scene, const BuiltModel& made,
                 const SolvedShape& shape, const StressTask& task, const Progress& progress) {
  const StressAccuracy accuracy = stress_accuracy(task.accuracy);
  const RefinedShape refined = refine_adaptively(scene, shape, accuracy, task.factors, progress);
  analyse(run, scene, refined, accuracy, task.factors, task.animations, progress);
  if (!run.report.stress) return;
  if (scene.stress->sensitivities) {
    run.report.stress->sensitivities =
        compute_sensitivities(*run.report.stress, scene, made, shape, progress);
    run.watch.lap("sensitivities");
  }
  if (task.with_calculix) check_with_calculix(run, scene, refined.shape, task.element, progress);
}

Report run_all(const Scene& scene, const std::filesystem::path& folder, const StressTask* stress,
               const Progress& progress) {
  RunContext run(scene, folder);
  run.report.parameters = scene.parameters();
  BuiltModel made = model_of(run, scene, progress);
  const SolvedShape shape = solve_refined_shape(made, scene, progress);
  run.watch.lap("sculpt");
  measure_into(run, made, shape, scene, progress);
  check_load_sizes(run.report, scene);
  if (stress) stress_into(run, scene, made, shape, *stress, progress);
  write_files(run, scene, made, shape, progress);
  draw_pictures(run, scene, made, shape, progress);
  for (const auto& sweep : scene.sweeps) {
    if (!shape.layout || !can_draw(run.report, sweep.picture.file)) continue;
    draw_sweep(made, *shape.layout, scene, sweep, run.out.file(sweep.picture.file), progress);
    run.report.files.push_back(sweep.picture.file);
  }
  if (!scene.pictures.empty() || !scene.sweeps.empty()) run.watch.lap("pictures");
  write_step_file(run, scene, made, progress);
  run.finish(progress);
  run.out.commit();
  return std::move(run.report);
}

}  // namespace

Report run_scene(const Scene& scene, const std::filesystem::path& folder,
                 const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles files;
  record_input(scene.file);
  return run_all(scene, folder, nullptr, progress);
}

Report run_stress(const Scene& scene, const std::filesystem::path& folder, const StressTask& task,
                  const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles files;
  record_input(scene.file);
  if (!scene.stress)
    throw InputError(scene.at({}) +
                     "found no [stress], expected one with thickness, material and supports");
  return run_all(scene, folder, &task, progress);
}

RunReport view_scene(const Scene& scene, const PictureScene& look,
                     const std::filesystem::path& file, const Progress& progress) {
  const CommandFiles files;
  record_input(scene.file);
  require_display();
  FairedLines lines = faired_lines(scene, progress);
  BuiltModel made = build_model(scene, lines.lines, progress);
  const SolvedShape shape = solve_refined_shape(made, scene, progress);
  draw_picture(file, shape_picture(look, made, shape));
  RunReport report;
  report.name = scene.name;
  report.files = {file.string()};
  report.warnings = std::move(lines.warnings);
  return report;
}

namespace {

/// The edges of CAD faces in their triangle mesh, as pairs of nodes: mesh edges between the
/// triangles of different faces, and free ones.
std::vector<std::vector<int>> edges_of_facets(const CadFacets& facets) {
  std::map<std::pair<int, int>, std::vector<int>> faces;  // of each mesh edge
  for (int t = 0; t < facets.mesh.face_count(); ++t) {
    const auto corners = facets.mesh.face(t);
    for (size_t c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(corners[c], corners[(c + 1) % 3]);
      faces[{low, high}].push_back(facets.faces[static_cast<size_t>(t)]);
    }
  }
  std::vector<std::vector<int>> edges;
  for (const auto& [nodes, beside] : faces)
    if (beside.size() != 2 || beside[0] != beside[1]) edges.push_back({nodes.first, nodes.second});
  return edges;
}

}  // namespace

std::optional<ViewReport> view_cad_faces(const std::filesystem::path& cad, const PictureScene& look,
                                         const std::filesystem::path& picture) {
  const CommandFiles files;
  record_input(cad);
  if (cad_plugin().read_cad_contents(cad).faces == 0) return std::nullopt;
  if (look.field != PictureScene::Field::None || look.contours > 0)
    throw InputError(cad.string() +
                     ": found a CAD file with faces, which are drawn shaded; expected a scene or "
                     "curves for colours and contour lines. Fit a model to the faces (batten fit) "
                     "and draw its scene, or draw the curvature across their edges (batten info "
                     "--picture)");
  require_display();
  const CadFacets facets = cad_plugin().tessellate_cad(cad, {});
  MeshPicture drawing;
  drawing.shells = &facets.mesh;
  drawing.points = facets.mesh.points;
  drawing.lines = edges_of_facets(facets);
  drawing.azimuth = look.azimuth;
  drawing.elevation = look.elevation;
  draw_meshes(picture, {drawing}, 1);
  ViewReport report;
  report.name = cad.stem().string();
  report.files = {picture.string()};
  report.text = cad.filename().string() + ": its own " +
                format_count(isize(std::set(facets.faces.begin(), facets.faces.end())), "face");
  if (facets.unmeshed > 0)
    report.warnings.push_back(format_count(facets.unmeshed, "face") + " of " + cad.string() +
                              " could not be drawn");
  return report;
}

namespace {

// Summary of lines that only trim, with their distance from the surface.
std::string trimming_summary(const Report& report, const std::string& unit) {
  std::string text;
  for (const auto& line : report.lines)
    if (!line.constrains_surface)
      text +=
          summary_line("trimmed", "by '" + line.name + "', at most " +
                                      format_number(line.deviation) + unit + " from the surface");
  return text;
}

}  // namespace

std::string summary(const Report& report, const std::filesystem::path& folder) {
  if (report.network) return network_summary(report, folder);
  const auto& s = report.surface;
  const auto& q = s.quality;
  const std::string unit = " " + report.unit;
  double deviation = 0;
  for (const auto& line : report.lines)
    if (line.constrains_surface) deviation = std::max(deviation, line.deviation);

  std::string text = printable(report.name) + "\n" + listed_lines("read", report.reading_notes);
  text += summary_line("curves", std::to_string(report.lines.size()) + ", fitted within " +
                                     format_number(deviation) + unit);
  text += summary_line("surface", std::to_string(s.triangles) + " triangles, " +
                                      std::to_string(s.dofs) + " unknowns per coordinate, area " +
                                      format_number(q.area) + unit + "²");
  text += s.boundary == "curves"
              ? summary_line(
                    "constraints",
                    "residual " + format_number(q.max_line_residual) +
                        (q.max_line_gap > 0
                             ? ", gap at embedded curves " + format_number(q.max_line_gap) + unit
                             : "") +
                        ", surface to input curves " + format_number(q.max_line_deviation) + unit)
              : summary_line("constraints",
                             "corners only, residual " + format_number(s.max_constraint_residual));
  text += trimming_summary(report, unit);
  if (report.is_sculpted && s.moved > 0)
    text += summary_line("displaced", "by up to " + format_number(s.moved) + unit +
                                          " from the shape of the curves alone");
  text += fairing_summary(report, unit) + target_summary(report, unit) + defect_summary(report);
  text += summary_line("normals", "point " + s.normals);
  text += summary_line("quality", "Jacobian " + format_number(q.min_jacobian_ratio) +
                                      " of its median, normal jump " +
                                      format_number(q.max_normal_jump_deg) + " degrees");
  if (report.step) {
    const auto& step = *report.step;
    const std::string valid = step.valid ? "valid" : "NOT valid";
    text += summary_line(
        "STEP",
        step.form == "exact"
            ? std::to_string(step.faces) + " faces, " + valid + ", gap " +
                  format_number(step.max_gap) + unit
            : (kinds_of(step).empty() ? "one face of " + std::to_string(step.poles_u) + " × " +
                                            std::to_string(step.poles_v) + " poles, "
                                      : format_count(step.faces, "face") + kinds_of(step) + ", ") +
                  valid + ", within " + format_number(step.max_deviation) + unit +
                  ", edges within " + format_number(step.max_gap) + unit + edges_of(step));
  }
  for (const auto& scan : report.scans)
    text += summary_line("point cloud", std::to_string(scan.points - scan.left_out) + " of " +
                                            std::to_string(scan.points) + " points of '" +
                                            scan.name + "', RMS " + format_number(scan.before_rms) +
                                            " -> " + format_number(scan.rms) + unit);
  if (report.stress) text += stress_summary(*report.stress, report.unit);
  if (report.comparison)
    text += summary_line("compared", "max " + format_number(report.comparison->max) + unit +
                                         ", RMS " + format_number(report.comparison->rms) + unit +
                                         " from " + report.comparison->file);
  return text + summary_footer(report, folder);
}

namespace {

/// Adds a region for each face of a CAD file, except faces with a line that occurs twice. The
/// region search handles these.
void add_cad_regions(Scene& scene, const std::filesystem::path& file) {
  const CadFaceTopology found = cad_plugin().read_cad_loops(file, unit_in_metres(scene.unit));
  scene.network.tolerance = std::max(kExactLineTolerance * found.size, 1.1 * found.gap);
  constexpr double smooth = 0.5;  // degrees; faces with a larger angle belong to separate surfaces
  for (const CadSharedEdge& join : found.joins)
    if (join.angle_deg > smooth)
      scene.network.joins.push_back({join.line, JoinSpec::Kind::Crease, ""});
  for (const CadFaceBoundary& face : found.faces) {
    RegionSpec spec;
    std::set<std::string> used;
    bool once = !face.loops.empty();
    for (const auto& loop : face.loops)
      for (const std::string& line : loop) once = once && used.insert(line).second;
    if (!once) continue;
    spec.name = face.name;
    spec.loops = face.loops;
    spec.annulus = face.tube;
    spec.skin.convex = face.convex;
    scene.network.regions.push_back(std::move(spec));
  }
}

}  // namespace

Scene scene_of_target(const std::filesystem::path& target,
                      const std::vector<std::filesystem::path>& lines, const std::string& unit) {
  const bool mesh = MeshFile::can_read(target);
  Scene scene;
  if (lines.empty() && mesh) {
    scene.unit = unit;
    const MeshFile file = MeshFile::read(target);
    add_mesh_lines(scene, prepare(file.shells()), file.sets());
  } else {
    scene = scene_of_lines(lines.empty() ? std::vector{target} : lines, {}, unit);
    if (lines.empty()) {
      scene.lines.front().creases = true;
      add_cad_regions(scene, target);
    }
  }
  scene.network.fair_noisy_lines = false;  // the lines belong to the target
  scene.name = target.stem().string();
  scene.step = scene.name + ".step";
  scene.vtp = scene.name + ".vtp";
  scene.targets.emplace_back().file = target;
  return scene;
}

}  // namespace batten
