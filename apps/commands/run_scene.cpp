#include "batten/apps/commands/run_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/apps/commands/fair_lines.h"
#include "batten/apps/commands/make_shape.h"
#include "batten/apps/commands/output_folder.h"
#include "batten/apps/commands/promises.h"
#include "batten/apps/commands/run_network.h"
#include "batten/apps/commands/run_parts.h"
#include "batten/apps/commands/shape_files.h"
#include "batten/io/whole_file.h"

namespace batten {
namespace {

void draw_sweep(const RegionLayout& layout, const Scene& scene, const SceneSweep& sweep,
                const std::filesystem::path& file, const Progress& progress) {
  std::vector<MadeShape> shapes;
  for (size_t i = 0; i < sweep.values.size(); ++i) {
    progress.at("sweep of " + sweep.parameter,
                static_cast<double>(i) / static_cast<double>(sweep.values.size()));
    Scene panel = scene;
    panel.set(sweep.parameter, sweep.values[i], "");
    try {
      shapes.push_back(make_shape(layout, panel, {{}, progress.cancelled}));
    } catch (const NoSolutionError& e) {
      throw NoSolutionError("sweep at " + sweep.parameter + " = " + number(sweep.values[i]) + ": " +
                            e.what());
    }
  }
  const int count = static_cast<int>(shapes.size());
  const int columns = sweep.columns > 0
                          ? std::min(sweep.columns, count)
                          : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<PictureScene> panels;
  for (int i = 0; i < count; ++i) {
    PictureScene panel = picture_of(sweep.picture.look, shapes[i].region);
    panel.title +=
        (panel.title.empty() ? "" : ", ") + sweep.parameter + " = " + number(sweep.values[i]);
    panels.push_back(panel);
  }
  draw_contact_sheet(file, panels, columns, sweep.picture.size);
}

/// Pictures need a display; a result without them is still a result, but not what was asked for.
void draw_all(Report& report, const RegionLayout& layout, const Scene& scene, const MadeShape& made,
              const OutputFolder& out, const Progress& progress) {
  if (scene.pictures.empty() && scene.sweeps.empty()) return;
  try {
    require_display();
  } catch (const InputError& e) {
    for (const auto& picture : scene.pictures)
      report.missed.push_back({picture.file, std::string("is not drawn: ") + e.what()});
    for (const auto& sweep : scene.sweeps)
      report.missed.push_back({sweep.picture.file, std::string("is not drawn: ") + e.what()});
    return;
  }
  for (const auto& picture : scene.pictures) {
    progress.at("picture " + picture.file, 0);
    draw_picture(out.file(picture.file), picture_of(picture.look, made.region), picture.size);
    report.files.push_back(picture.file);
  }
  for (const auto& sweep : scene.sweeps) {
    draw_sweep(layout, scene, sweep, out.file(sweep.picture.file), progress);
    report.files.push_back(sweep.picture.file);
  }
}

}  // namespace

void apply_settings(Scene& scene, const std::vector<std::string>& settings) {
  for (const Setting& s : parsed_settings(settings)) scene.set(s.name, s.value, s.where);
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

Scene scene_of_network(const std::vector<std::filesystem::path>& files, const std::string& unit) {
  Scene scene = scene_of_lines(files, {}, unit);
  scene.network.emplace();
  return scene;
}

Report run_scene(const Scene& scene, const std::filesystem::path& folder,
                 const Progress& progress) {
  if (scene.network) return run_network(scene, folder, progress);
  OutputFolder out(folder);
  Report report;
  report.name = scene.name;
  report.unit = scene.unit;
  report.parameters = scene.parameters();
  report.surface.hold = scene.skin.hold == SceneSkin::Hold::Corners ? "corners" : "lines";
  Stopwatch watch(report.timings);

  progress.at("lines", 0);
  const FairedLines lines = faired_lines(scene, progress);
  report.curves = lines.reports;
  watch.lap("lines");
  RegionLayout layout = lay_out(scene, lines.lines, progress);
  watch.lap("layout");
  const MadeShape made = make_refined_shape(layout, scene, progress);
  report.warnings = layout.warnings();
  watch.lap("sculpt");
  progress.at("measuring", 0);
  measure_into(report, made);
  watch.lap("measure");

  VtkOptions vtk;
  if (!scene.loads.empty() || !scene.constraints.empty() || scene.needs_session())
    vtk.references = {&made.unloaded};
  write_files(report, scene, made.region, vtk, out, watch, progress);
  if (!scene.pictures.empty() || !scene.sweeps.empty()) {
    draw_all(report, layout, scene, made, out, progress);
    watch.lap("pictures");
  }
  watch.total();

  const auto broken = broken_promises(report, layout.tolerance());
  report.missed.insert(report.missed.end(), broken.begin(), broken.end());
  report.files.push_back("report.json");
  write_whole_file(out.file("report.json"), [&](std::ostream& file) { file << to_json(report); });
  progress.at("files", 1);
  out.commit();
  return report;
}

void view_scene(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                const Progress& progress) {
  if (scene.network) return view_network(scene, look, file, progress);
  require_display();
  RegionLayout layout = lay_out(scene, faired_lines(scene, progress).lines, progress);
  const MadeShape made = make_refined_shape(layout, scene, progress);
  draw_picture(file, picture_of(look, made.region));
}

std::string summary(const Report& report, const std::filesystem::path& folder) {
  if (report.network) return network_summary(report, folder);
  const auto& s = report.surface;
  const auto& q = s.quality;
  const std::string unit = " " + report.unit;
  double deviation = 0;
  for (const auto& line : report.lines) deviation = std::max(deviation, line.deviation);

  std::string text = report.name + "\n";
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
  text += result_line("quality", "Jacobian " + number(q.min_jacobian_ratio) +
                                     " of its median, normal jump " +
                                     number(q.max_normal_jump_deg) + " degrees");
  if (report.step) {
    const auto& step = *report.step;
    const std::string valid = step.valid ? "valid" : "NOT valid";
    text += result_line("STEP", step.form == "exact"
                                    ? std::to_string(step.faces) + " faces, " + valid + ", gap " +
                                          number(step.max_gap) + unit
                                    : "one face of " + std::to_string(step.poles_u) + " × " +
                                          std::to_string(step.poles_v) + " poles, " + valid +
                                          ", within " + number(step.max_deviation) + unit +
                                          ", edges within " + number(step.max_gap) + unit);
  }
  for (const auto& springs : report.springs)
    text += result_line("springs", std::to_string(springs.points - springs.left_out) + " of " +
                                       std::to_string(springs.points) + " points of '" +
                                       springs.name + "', rms " + number(springs.before_rms) +
                                       " -> " + number(springs.rms) + unit);
  if (report.comparison)
    text += result_line("compared", "max " + number(report.comparison->max) + unit + ", rms " +
                                        number(report.comparison->rms) + unit + " from " +
                                        report.comparison->file);
  return text + result_ending(report, folder);
}

}  // namespace batten
