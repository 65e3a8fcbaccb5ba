#include "batten/apps/commands/shapes/run_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "batten/apps/commands/lines/scene_lines.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/apps/commands/shapes/stress_accuracy.h"
#include "batten/apps/commands/shapes/stress_sensitivity.h"
#include "batten/apps/commands/shapes/stress_shape.h"
#include "batten/apps/commands/shapes/stress_witness.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/io/files/text.h"
#include "batten/io/pictures/display.h"

namespace batten {
namespace {

constexpr size_t kMost = 3;  // of a kind that are spelled out

std::string some(const std::vector<std::string>& names, size_t most = 8) {
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > most) text += ", … (" + std::to_string(names.size()) + " in all)";
  return text;
}

// The first few, one under the other; the label stands before the first.
std::string listed_lines(const std::string& label, const std::vector<std::string>& texts) {
  std::string text;
  for (size_t i = 0; i < std::min(texts.size(), kMost); ++i)
    text += result_line(i ? "" : label, texts[i]);
  if (texts.size() > kMost)
    text += result_line(
        "", "and " + std::to_string(texts.size() - kMost) + " more (report.json has all)");
  return text;
}

std::string repairs(const NetworkReport& n) {
  std::map<std::string, int> counts;
  double farthest = 0;
  for (const NetworkFinding& f : n.findings) {
    if (!f.repaired) continue;
    ++counts[word(f.kind)];
    farthest = std::max(farthest, f.distance);
  }
  std::string text;
  for (const auto& [kind, count] : counts)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind;
  return text.empty() ? "" : text + "; farthest apart " + number(farthest);
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
  std::string text =
      counted(counts["crease"], "crease") + ", " + std::to_string(counts["smooth"]) + " smooth";
  if (counts["smooth"]) text += " within " + number(angle) + " degrees";
  if (open) text += " (" + std::to_string(open) + " of them with an end that is a crease)";
  text += ", " + counted(counts["rim"], "rim");
  if (counts["branching"]) text += ", " + std::to_string(counts["branching"]) + " branching";
  return text;
}

/// Says how many lines meet where, what was repaired and what was not.
std::string line_results(const NetworkReport& n, const std::string& unit) {
  std::string text =
      result_line("lines", std::to_string(n.lines) + ", in " + counted(n.arcs, "piece") +
                               " between " + counted(n.nodes, "place") +
                               " where they meet within " + number(n.tolerance) + unit);
  if (constexpr double prepared = 0.5; n.usual_share < prepared) {
    const bool found = n.tolerance > 1.1e-3 * n.size;
    text += result_line("by hand",
                        "within 1e-3 of their size only " + number(100 * n.usual_share) +
                            " % of their ends " + (found ? "would meet" : "meet") +
                            " another line: state gap_tolerance (--gap-tolerance) to have another");
  }
  if (const std::string repaired = repairs(n); !repaired.empty())
    text += result_line("repaired", repaired + unit);
  std::vector<std::string> listed_only;
  for (const NetworkFinding& f : n.findings)
    if (!f.repaired) listed_only.push_back(f.text);
  text += listed_lines("not joined", listed_only);
  return text;
}

/// Says which regions were found and skinned, with how many triangles.
std::string region_results(const NetworkReport& n, const Report::Surface& s) {
  size_t skinned = 0;
  std::vector<std::string> not_skinned;
  for (const auto& r : n.regions) {
    skinned += r.skinned;
    if (!r.skinned) not_skinned.push_back("'" + r.name + "': " + r.why_not);
  }
  std::string text = result_line(
      "regions", std::to_string(n.regions.size()) + " found, " + std::to_string(skinned) +
                     " skinned: " + std::to_string(s.triangles) + " triangles, " +
                     std::to_string(s.dofs) + " unknowns a coordinate");
  return text + listed_lines("not skinned", not_skinned);
}

/// Says which regions are planes, cylinders, …
std::string shape_results(const NetworkReport& n) {
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
            counted(of.first, shape, shape == "torus" ? "tori" : shape + "s");
    std::string radii;
    for (const std::string& radius : of.second) radii += (radii.empty() ? "" : ", ") + radius;
    constexpr size_t few = 4;
    if (!radii.empty() && of.second.size() <= few) text += " (radius " + radii + ")";
  }
  return text.empty() ? "" : result_line("shapes", text);
}

/// Says what the shells are.
std::string shell_results(const NetworkReport& n, const std::string& unit) {
  std::string text;
  for (const auto& shell : n.shells) {
    if (n.shells.size() > kMost && &shell >= &n.shells[kMost]) continue;
    text += result_line(
        &shell == &n.shells.front() ? "shells" : "",
        counted(shell.regions.size(), "region") + ", " + (shell.closed ? "closed" : "open") +
            (shell.orientable ? "" : ", one-sided or branching") + ", area " + number(shell.area) +
            unit + "²" +
            (shell.volume != 0 ? ", volume " + number(shell.volume) + unit + "³" : ""));
  }
  if (n.shells.size() > kMost)
    text += result_line("", "and " + std::to_string(n.shells.size() - kMost) + " more shells");
  return text;
}

/// Says what is wrong with the surface.
std::string flaw_results(const Report& report) {
  std::vector<std::string> texts;
  for (const auto& f : report.flaws) texts.push_back(f.text);
  return listed_lines("wrong", texts);
}

/// Says how good the surface is.
std::string quality_result(const Report::Surface& s, const std::string& unit) {
  return result_line("quality", "Jacobian " + number(s.quality.min_jacobian_ratio) +
                                    " of its median, normal jump " +
                                    number(s.quality.max_normal_jump_deg) +
                                    " degrees, surface to your lines " +
                                    number(s.quality.max_line_deviation) + unit);
}

/// Says what least variation or a loft did.
std::string fairing_result(const Report::Surface& s, const std::string& unit) {
  if (s.fair == "loft") return result_line("lofted", "along splines across the sections");
  if (!s.fairing) return "";
  const std::string what =
      s.fairing->asked ? "" : counted(s.fairing->regions, "region") + " with five sides or more: ";
  return result_line("faired", what + "change of curvature " + number(s.fairing->start_functional) +
                                   " -> " + number(s.fairing->functional) + ", moved by up to " +
                                   number(s.fairing->max_move) + unit);
}

/// Says how near the shape came to [[target]].
std::string target_result(const Report& report, const std::string& unit) {
  if (!report.target) return "";
  const auto& t = *report.target;
  return result_line("target", "rms " + number(t.before_rms) + " -> " + number(t.rms) + unit +
                                   ", largest " + number(t.max) + " there and " +
                                   number(t.back_max) + unit + " back (" +
                                   number(std::max(t.max, t.back_max) / t.size) +
                                   " of the size), tolerance " + number(t.tolerance) + unit);
}

/// Says how the faces of a STEP file meet.
std::string edges_of(const Report::Step& step) {
  const int smooth = step.tangent + step.curvature;
  if (smooth + step.creases == 0) return "";
  const auto missed = std::count_if(step.joins.begin(), step.joins.end(),
                                    [](const auto& join) { return join.missed; });
  return "; " + counted(step.creases, "crease") + ", " +
         counted(smooth, "smooth edge", "smooth edges") +
         (smooth ? " within " + number(step.max_smooth_deg) + " degrees" : "") +
         (missed ? ", " + std::to_string(missed) + " missed" : "");
}

/// Says how many faces are planes, cylinders, …; "" where none is.
std::string kinds_of(const Report::Step& step) {
  std::string text;
  for (const auto& [kind, count] : step.faces_by_kind)
    if (kind != "B-spline")
      text +=
          (text.empty() ? "" : ", ") + counted(count, kind, kind == "torus" ? "tori" : kind + "s");
  return text.empty() ? "" : " (" + text + ")";
}

/// Says what the STEP file holds.
std::string step_result(const Report::Step& step, const std::string& unit) {
  return result_line(
      "STEP", counted(step.faces, "face") + kinds_of(step) + " in " +
                  (step.solids ? counted(step.solids, "solid") : counted(step.shells, "shell")) +
                  ", " + (step.valid ? "valid" : "NOT valid") + ", within " +
                  number(step.max_deviation) + unit + ", edges within " + number(step.max_gap) +
                  unit + edges_of(step));
}

/// Says what else could be, and with which words.
std::string choice_results(const NetworkReport& n) {
  std::vector<std::string> choices;
  for (const auto& c : n.choices) choices.push_back(c.text);
  std::string text = listed_lines("could be", choices);
  text += result_line("to change",
                      "[[region]] loops = [[\"…\", \"…\"]], with surface = false for "
                      "none there;");
  text += result_line("",
                      "[[join]] lines = [\"…\"], kind = \"crease\" or \"smooth\" "
                      "(batten info: the names)");
  return text;
}

void draw_sweep(const MadeModel& made, const ModelLayout& layout, const Scene& scene,
                const SceneSweep& sweep, const std::filesystem::path& file,
                const Progress& progress) {
  std::vector<MadeShape> shapes;
  for (size_t i = 0; i < sweep.values.size(); ++i) {
    progress.at("sweep of " + sweep.parameter,
                static_cast<double>(i) / static_cast<double>(sweep.values.size()));
    Scene panel = scene;
    panel.set(sweep.parameter, sweep.values[i], "");
    try {
      shapes.push_back(make_shape(layout, panel, made, {{}, progress.cancelled}));
    } catch (const NoSolutionError& e) {
      throw NoSolutionError("sweep at " + sweep.parameter + " = " + number(sweep.values[i]) + ": " +
                            e.what());
    }
  }
  const int count = count_of(shapes);
  const int columns = sweep.columns > 0
                          ? std::min(sweep.columns, count)
                          : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<PictureScene> panels;
  for (int i = 0; i < count; ++i) {
    PictureScene panel = picture_of(sweep.picture.look, made, shapes[i]);
    panel.title +=
        (panel.title.empty() ? "" : ", ") + sweep.parameter + " = " + number(sweep.values[i]);
    panels.push_back(panel);
  }
  draw_contact_sheet(file, panels, columns, sweep.picture.size);
}

}  // namespace

std::string network_summary(const Report& report, const std::filesystem::path& folder) {
  const NetworkReport& n = *report.network;
  const auto& s = report.surface;
  const std::string unit = " " + report.unit;
  std::string text = report.name + "\n";
  text += listed_lines("read", report.surprises);
  text += line_results(n, unit);
  text += region_results(n, s);
  text += shape_results(n);
  const bool skinned =
      std::any_of(n.regions.begin(), n.regions.end(), [](const auto& r) { return r.skinned; });
  if (skinned) text += result_line("joins", joins(n));
  text += shell_results(n, unit);
  if (skinned) text += result_line("normals", "point " + s.normals);
  if (report.is_sculpted && s.moved > 0)
    text +=
        result_line("moved", "by up to " + number(s.moved) + unit + " from the lines' own shape");
  text += flaw_results(report);
  if (!n.bare.empty())
    text += result_line("left over",
                        counted(n.bare.size(), "line") + " without a surface: " + some(n.bare));
  if (skinned)
    text += fairing_result(s, unit) + target_result(report, unit) + quality_result(s, unit);
  if (report.step) text += step_result(*report.step, unit);
  if (report.stress) text += stress_results(*report.stress, report.unit);
  if (report.comparison)
    text += result_line("compared", "max " + number(report.comparison->max) + unit + ", rms " +
                                        number(report.comparison->rms) + unit + " from " +
                                        report.comparison->file);
  text += choice_results(n);
  return text + result_ending(report, folder);
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

// The shell of a shape, on smaller elements where an accuracy is asked for.
void stress_into(ShapeRun& run, const Scene& scene, const MadeModel& made, const MadeShape& shape,
                 const StressTask& task, const Progress& progress) {
  AccurateShape accurate{shape, {}, true};
  if (task.accuracy > 0)
    accurate = accurate_shape(scene, shape, task.accuracy, task.factors, progress);
  analyse(run, scene, accurate.shape, task.factors, progress);
  if (!run.report.stress) return;
  run.report.stress->meshes = accurate.meshes;
  if (!accurate.reached)
    run.report.missed.push_back({"stress.accuracy", "is " + number(accurate.meshes.back().error) +
                                                        ", asked for " + number(task.accuracy)});
  if (scene.stress->sensitivities) find_sensitivities(run, scene, made, shape, progress);
  if (task.with_calculix) ask_calculix(run, scene, accurate.shape, task.element, progress);
}

Report run_all(const Scene& scene, const std::filesystem::path& folder, const StressTask* stress,
               const Progress& progress) {
  ShapeRun run(scene, folder);
  run.report.parameters = scene.parameters();
  MadeModel made = model_of(run, scene, progress);
  const MadeShape shape = make_refined_shape(made, scene, progress);
  run.watch.lap("sculpt");
  measure_into(run, made, shape, scene, progress);
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
  return run_all(scene, folder, nullptr, progress);
}

Report run_stress(const Scene& scene, const std::filesystem::path& folder, const StressTask& task,
                  const Progress& progress) {
  if (!scene.stress)
    throw InputError(scene.at({}) + "found no [stress], expected thickness, material and supports");
  return run_all(scene, folder, &task, progress);
}

void view_scene(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                const Progress& progress) {
  require_display();
  MadeModel made = make_model(scene, faired_lines(scene, progress).lines, progress);
  const MadeShape shape = make_refined_shape(made, scene, progress);
  draw_picture(file, picture_of(look, made, shape));
}

namespace {

// Lines that only trim, and how far from the surface they were drawn.
std::string trimming_results(const Report& report, const std::string& unit) {
  std::string text;
  for (const auto& line : report.lines)
    if (!line.holds)
      text += result_line("trimmed", "by '" + line.name + "', drawn within " +
                                         number(line.deviation) + unit + " of the surface");
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
    if (line.holds) deviation = std::max(deviation, line.deviation);

  std::string text = report.name + "\n" + listed_lines("read", report.surprises);
  text += result_line(
      "lines", std::to_string(report.lines.size()) + ", fitted within " + number(deviation) + unit);
  text +=
      result_line("surface", std::to_string(s.triangles) + " triangles, " + std::to_string(s.dofs) +
                                 " unknowns a coordinate, area " + number(q.area) + unit + "²");
  text += s.hold == "lines"
              ? result_line("held lines",
                            "residual " + number(q.max_line_residual) +
                                (q.max_line_gap > 0
                                     ? ", gap of embedded ones " + number(q.max_line_gap) + unit
                                     : "") +
                                ", surface to your lines " + number(q.max_line_deviation) + unit)
              : result_line("held", "corners only, residual " + number(s.max_constraint_residual));
  text += trimming_results(report, unit);
  if (report.is_sculpted && s.moved > 0)
    text +=
        result_line("moved", "by up to " + number(s.moved) + unit + " from the lines' own shape");
  text += fairing_result(s, unit) + target_result(report, unit) + flaw_results(report);
  text += result_line("normals", "point " + s.normals);
  text += result_line("quality", "Jacobian " + number(q.min_jacobian_ratio) +
                                     " of its median, normal jump " +
                                     number(q.max_normal_jump_deg) + " degrees");
  if (report.step) {
    const auto& step = *report.step;
    const std::string valid = step.valid ? "valid" : "NOT valid";
    text += result_line(
        "STEP",
        step.form == "exact"
            ? std::to_string(step.faces) + " faces, " + valid + ", gap " + number(step.max_gap) +
                  unit
            : (kinds_of(step).empty() ? "one face of " + std::to_string(step.poles_u) + " × " +
                                            std::to_string(step.poles_v) + " poles, "
                                      : counted(step.faces, "face") + kinds_of(step) + ", ") +
                  valid + ", within " + number(step.max_deviation) + unit + ", edges within " +
                  number(step.max_gap) + unit + edges_of(step));
  }
  for (const auto& scan : report.scans)
    text += result_line("scan", std::to_string(scan.points - scan.left_out) + " of " +
                                    std::to_string(scan.points) + " points of '" + scan.name +
                                    "', rms " + number(scan.before_rms) + " -> " +
                                    number(scan.rms) + unit);
  if (report.stress) text += stress_results(*report.stress, report.unit);
  if (report.comparison)
    text += result_line("compared", "max " + number(report.comparison->max) + unit + ", rms " +
                                        number(report.comparison->rms) + unit + " from " +
                                        report.comparison->file);
  return text + result_ending(report, folder);
}

}  // namespace batten
