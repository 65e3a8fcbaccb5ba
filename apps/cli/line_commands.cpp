// The words of `batten skin`, `batten info` and `batten view`, which take files of lines.
#include <iostream>
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"

#include "batten/apps/commands/info.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/io/scene/read_scene.h"

namespace batten {
namespace {

struct LineArguments {
  std::string file, out, unit = "mm", screenshot, compare, show = "shaded", picture, alternatives;
  std::vector<std::string> files, inner, settings;
  std::vector<double> angles;
  double edge_length = 0, tolerance = 0, gap_tolerance = 0, pressure = 0;
  int contours = 0;
  bool network = false, exact_step = false;
  StepFileArguments step;
};

Scene lines_scene(const LineArguments& a) {
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

int info(LineArguments a) {
  if (!a.alternatives.empty()) {
    a.files = {a.file};
    std::cout << draw_alternatives(a.alternatives,
                                   a.file.ends_with(".toml") ? read_scene(a.file) : lines_scene(a));
    return kDone;
  }
  std::cout << file_info(a.file, a.unit);
  if (!a.picture.empty()) draw_lines(a.picture, a.file, a.unit);
  return kDone;
}

int view(LineArguments a, const CommonOptions& common) {
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

Command add_skin(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("skin", "From files of curves straight to surfaces: STEP, VTK, report");
  subcommand
      .option("lines", a.files,
              "Curves: .csv .txt .xyz .dat .obj .curves .iges .step .dxf .svg .json")
      .required();
  subcommand.option("--inner", a.inner, "A file of curves that lie on a surface and bound none")
      .allow_repeated();
  subcommand.flag("--network", a.network, "").hidden();
  subcommand.option("--out", a.out, "Folder for all files").required();
  add_unit(subcommand, a.unit);
  subcommand.option("--edge-length", a.edge_length, "Target length of element edges").positive();
  subcommand.option("--tolerance", a.tolerance, "Largest distance of fitted lines").positive();
  subcommand
      .option("--gap-tolerance", a.gap_tolerance,
              "Distance within which curves meet; found unless given")
      .positive();
  subcommand.option("--compare", a.compare, "CAD file: measure the distance from its faces");
  subcommand.flag("--exact-step", a.exact_step,
                  "STEP to rounding, three faces a triangle, instead of one face a region");
  add_step_options(subcommand, a.step);
  subcommand.option("--pressure", a.pressure, "Pressure along the normal, relative units");
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const auto report =
                run_scene(lines_scene(*arguments), arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

Command add_info(CommandLine& program) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "info", "What is in a scene, a file of lines, a mesh, a deforming mesh, a STEP file");
  subcommand.option("file", a.file, "The file").required();
  subcommand.option("--picture", a.picture, "Draw its lines with their curvature, to a .png");
  subcommand.option(
      "--choices", a.alternatives,
      "Draw surfaces that could as well be others, into this folder, and say what to write");
  add_unit(subcommand, a.unit);
  return {subcommand, [arguments] { return info(*arguments); }};
}

Command add_view(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("view", "A picture of a scene's or a line file's surface");
  subcommand.option("file", a.file, "Scene (.toml) or file of lines").required();
  subcommand.option("--screenshot", a.screenshot, "The picture to write (.png)").required();
  subcommand.option("--set", a.settings, "Set a parameter of the scene: name=value")
      .allow_repeated();
  subcommand.option("--show", a.show, "What to show")
      .one_of({"shaded", "mean_curvature", "gauss_curvature", "regions"})
      .show_default();
  subcommand.flag("--network", a.network, "").hidden();
  subcommand.option("--contours", a.contours, "Number of contour lines").in_range(0, 1000);
  subcommand.option("--view", a.angles, "Azimuth and elevation, degrees").count(2);
  add_unit(subcommand, a.unit);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] { return view(*arguments, common); }};
}

}  // namespace batten
