// The words of `batten fit`.
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/shapes/fit_scene.h"
#include "batten/apps/commands/shapes/run_scene.h"

namespace batten {
namespace {

struct FitWords {
  std::string target, out, unit = "mm";
  std::vector<std::string> lines;
  double tolerance = 0, edge_length = 0, meet = 0;
  bool cage = false;
  StepWords step;
};

Scene scene_of(const FitWords& a) {
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

Command add_fit(ProgramWords& program, CommonWords& common) {
  const auto words = std::make_shared<FitWords>();
  FitWords& a = *words;
  const Words sub = program.command(
      "fit",
      "Skin the lines of a given surface again, so that it can be sculpted: STEP, VTK, report");
  sub.option("target", a.target, "The surface: .step .iges .brep, or a mesh (.stl .obj .ply …)")
      .required();
  sub.option("--lines", a.lines,
             "Lines to keep; unless given, the edges of the CAD file, or the creases "
             "and rims of the mesh")
      .repeated();
  sub.option("--out", a.out, "Folder for all files").required();
  add_unit(sub, a.unit);
  sub.option("--tolerance", a.tolerance, "Largest distance from the surface; 1e-4 of the size")
      .positive();
  sub.flag("--cage", a.cage,
           "The mesh is a cage of polygons: fit to its Catmull-Clark limit surface");
  sub.option("--edge-length", a.edge_length, "Target length of element edges at the start")
      .positive();
  sub.option("--gap-tolerance", a.meet, "Distance within which curves meet; found unless given")
      .positive();
  add_step_words(sub, a.step);
  add_common(sub, common);
  return {sub, [words, &common] {
            const auto report =
                run_scene(scene_of(*words), words->out, terminal_progress(common.quiet));
            return finish(report, summary(report, words->out), common);
          }};
}

}  // namespace batten
