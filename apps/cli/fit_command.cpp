// The words of `batten fit`.
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/shapes/fit_scene.h"
#include "batten/apps/commands/shapes/run_scene.h"

namespace batten {
namespace {

struct FitArguments {
  std::string target, out, unit = "mm";
  std::vector<std::string> lines;
  double tolerance = 0, edge_length = 0, meet = 0;
  bool cage = false;
  StepFileArguments step;
};

Scene scene_of(const FitArguments& a) {
  Scene scene = scene_of_target(a.target, {a.lines.begin(), a.lines.end()}, a.unit);
  scene.targets.front().tolerance = scene.step_tolerance = a.tolerance;
  scene.targets.front().cage = a.cage;
  scene.skin.options.edge_length = a.edge_length;
  scene.step_lines = a.step.lines;
  scene.step_ap242 = a.step.ap242;
  if (a.meet > 0) scene.network.tolerance = a.meet;
  return scene;
}

}  // namespace

Command add_fit(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<FitArguments>();
  FitArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "fit",
      "Skin the lines of a given surface again, so that it can be sculpted: STEP, VTK, report");
  subcommand
      .option("target", a.target, "The surface: .step .iges .brep, or a mesh (.stl .obj .ply …)")
      .required();
  subcommand
      .option("--lines", a.lines,
              "Lines to keep; unless given, the edges of the CAD file, or the creases "
              "and rims of the mesh")
      .allow_repeated();
  subcommand.option("--out", a.out, "Folder for all files").required();
  add_unit(subcommand, a.unit);
  subcommand
      .option("--tolerance", a.tolerance, "Largest distance from the surface; 1e-4 of the size")
      .positive();
  subcommand.flag("--cage", a.cage,
                  "The mesh is a cage of polygons: fit to its Catmull-Clark limit surface");
  subcommand.option("--edge-length", a.edge_length, "Target length of element edges at the start")
      .positive();
  subcommand
      .option("--gap-tolerance", a.meet, "Distance within which curves meet; found unless given")
      .positive();
  add_step_options(subcommand, a.step);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const auto report =
                run_scene(scene_of(*arguments), arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

}  // namespace batten
