#include "batten/apps/commands/shapes/run_scene.h"

#include <algorithm>
#include <cmath>

#include "batten/apps/commands/lines/fair_lines.h"
#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/io/pictures/display.h"

namespace batten {
namespace {

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
  ShapeRun run(scene, folder);
  run.report.parameters = scene.parameters();
  MadeModel made = model_of(run, scene, progress);
  const MadeShape shape = make_refined_shape(made, scene, progress);
  run.watch.lap("sculpt");
  measure_into(run, made, shape, scene, progress);
  write_files(run, scene, made, shape, progress);
  draw_pictures(run, scene, made, shape, progress);
  for (const auto& sweep : scene.sweeps) {
    if (!shape.layout || !can_draw(run.report, sweep.picture.file)) continue;
    draw_sweep(made, *shape.layout, scene, sweep, run.out.file(sweep.picture.file), progress);
    run.report.files.push_back(sweep.picture.file);
  }
  if (!scene.pictures.empty() || !scene.sweeps.empty()) run.watch.lap("pictures");
  run.finish(progress);
  run.out.commit();
  return std::move(run.report);
}

void view_scene(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                const Progress& progress) {
  require_display();
  MadeModel made = make_model(scene, faired_lines(scene, progress).lines, progress);
  const MadeShape shape = make_refined_shape(made, scene, progress);
  draw_picture(file, picture_of(look, made, shape));
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
  for (const auto& scan : report.scans)
    text += result_line("scan", std::to_string(scan.points - scan.left_out) + " of " +
                                    std::to_string(scan.points) + " points of '" + scan.name +
                                    "', rms " + number(scan.before_rms) + " -> " +
                                    number(scan.rms) + unit);
  if (report.comparison)
    text += result_line("compared", "max " + number(report.comparison->max) + unit + ", rms " +
                                        number(report.comparison->rms) + unit + " from " +
                                        report.comparison->file);
  return text + result_ending(report, folder);
}

}  // namespace batten
