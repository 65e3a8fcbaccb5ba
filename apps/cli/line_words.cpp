// The words of `batten skin`, `batten info` and `batten view`, which take files of lines.
#include <iostream>
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"

#include "batten/apps/commands/info.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/io/scene/read_scene.h"

namespace batten {
namespace {

struct LineWords {
  std::string file, out, unit = "mm", screenshot, compare, show = "shaded", picture, choices;
  std::vector<std::string> files, inner, settings;
  std::vector<double> angles;
  double edge_length = 0, tolerance = 0, gap_tolerance = 0, pressure = 0;
  int contours = 0;
  bool network = false, exact_step = false;
  StepWords step;
};

Scene lines_scene(const LineWords& a) {
  Scene scene =
      scene_of_lines({a.files.begin(), a.files.end()}, {a.inner.begin(), a.inner.end()}, a.unit);
  if (a.network)
    scene.notes.push_back(
        "--network is not needed any more, since what curves bound is always found: leave it out");
  scene.skin.options.edge_length = a.edge_length;
  scene.skin.options.tolerance = a.tolerance;
  scene.network.tolerance = a.gap_tolerance;
  scene.compare = a.compare;
  scene.step_lines = a.step.lines;
  scene.step_ap242 = a.step.ap242;
  if (a.exact_step) scene.step_form = Scene::StepForm::Exact;
  if (a.pressure != 0) {
    SceneLoad load;
    load.name = "pressure";
    load.value = a.pressure;
    scene.loads.push_back(load);
  }
  return scene;
}

int info(LineWords a) {
  if (!a.choices.empty()) {
    a.files = {a.file};
    std::cout << draw_choices(a.choices,
                              a.file.ends_with(".toml") ? read_scene(a.file) : lines_scene(a));
    return kDone;
  }
  std::cout << file_info(a.file, a.unit);
  if (!a.picture.empty()) draw_lines(a.picture, a.file, a.unit);
  return kDone;
}

int view(LineWords a, const CommonWords& common) {
  Scene scene;
  if (a.file.ends_with(".toml")) {
    scene = read_scene(a.file);
    apply_settings(scene, a.settings);
  } else {
    a.files = {a.file};
    scene = lines_scene(a);
  }
  PictureScene look;
  using Field = PictureScene::Field;
  look.title = scene.name;
  look.field = a.show == "shaded"           ? Field::None
               : a.show == "mean_curvature" ? Field::Mean
               : a.show == "regions"        ? Field::Regions
                                            : Field::Gauss;
  look.contours = a.contours;
  if (!a.angles.empty()) {
    look.azimuth = a.angles[0];
    look.elevation = a.angles[1];
  }
  view_scene(scene, look, a.screenshot, terminal_progress(common.quiet));
  end_progress();
  if (!common.quiet) std::cout << a.screenshot << "\n";
  return kDone;
}

}  // namespace

Command add_skin(ProgramWords& program, CommonWords& common) {
  const auto words = std::make_shared<LineWords>();
  LineWords& a = *words;
  const Words sub =
      program.command("skin", "From files of curves straight to surfaces: STEP, VTK, report");
  sub.option("lines", a.files,
             "Curves: .csv .txt .xyz .dat .obj .curves .iges .step .dxf .svg .json")
      .required();
  sub.option("--inner", a.inner, "A file of curves that lie on a surface and bound none")
      .repeated();
  sub.flag("--network", a.network, "").hidden();
  sub.option("--out", a.out, "Folder for all files").required();
  add_unit(sub, a.unit);
  sub.option("--edge-length", a.edge_length, "Target length of element edges").positive();
  sub.option("--tolerance", a.tolerance, "Largest distance of fitted lines").positive();
  sub.option("--gap-tolerance", a.gap_tolerance,
             "Distance within which curves meet; found unless given")
      .positive();
  sub.option("--compare", a.compare, "CAD file: measure the distance from its faces");
  sub.flag("--exact-step", a.exact_step,
           "STEP to rounding, three faces a triangle, instead of one face a region");
  add_step_words(sub, a.step);
  sub.option("--pressure", a.pressure, "Pressure along the normal, relative units");
  add_common(sub, common);
  return {sub, [words, &common] {
            const auto report =
                run_scene(lines_scene(*words), words->out, terminal_progress(common.quiet));
            return finish(report, summary(report, words->out), common);
          }};
}

Command add_info(ProgramWords& program) {
  const auto words = std::make_shared<LineWords>();
  LineWords& a = *words;
  const Words sub = program.command(
      "info", "What is in a scene, a file of lines, a mesh, a deforming mesh, a STEP file");
  sub.option("file", a.file, "The file").required();
  sub.option("--picture", a.picture, "Draw its lines with their curvature, to a .png");
  sub.option("--choices", a.choices,
             "Draw surfaces that could as well be others, into this folder, and say what to write");
  add_unit(sub, a.unit);
  return {sub, [words] { return info(*words); }};
}

Command add_view(ProgramWords& program, CommonWords& common) {
  const auto words = std::make_shared<LineWords>();
  LineWords& a = *words;
  const Words sub = program.command("view", "A picture of a scene's or a line file's surface");
  sub.option("file", a.file, "Scene (.toml) or file of lines").required();
  sub.option("--screenshot", a.screenshot, "The picture to write (.png)").required();
  sub.option("--set", a.settings, "Set a parameter of the scene: name=value").repeated();
  sub.option("--show", a.show, "What to show")
      .one_of({"shaded", "mean_curvature", "gauss_curvature", "regions"})
      .with_default();
  sub.flag("--network", a.network, "").hidden();
  sub.option("--contours", a.contours, "Number of contour lines").within(0, 1000);
  sub.option("--view", a.angles, "Azimuth and elevation, degrees").count(2);
  add_unit(sub, a.unit);
  add_common(sub, common);
  return {sub, [words, &common] { return view(*words, common); }};
}

}  // namespace batten
