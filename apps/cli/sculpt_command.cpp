// The words of `batten sculpt`.
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/shapes/run_sculpt.h"
#include "batten/io/scene/read_scene.h"

namespace batten {
namespace {

struct SculptArguments {
  std::string file, out;
  SculptTask task;
};

}  // namespace

Command add_sculpt(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<SculptArguments>();
  SculptArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "sculpt", "Settle, sweep, move and refine a scene's surface under live loads");
  subcommand.option("scene", a.file, "Scene (.toml)").required();
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.option("--set", a.task.settings, "Set a parameter: name=value").allow_repeated();
  const CommandOption sweep =
      subcommand
          .option("--sweep", a.task.sweeps,
                  "Settle at so many values, each from the one before: name=from:to:count")
          .allow_repeated();
  const CommandOption time = subcommand.option(
      "--time", a.task.time, "Motion from the settled shape, until this time; needs --dt");
  const CommandOption dt = subcommand.option("--dt", a.task.dt, "Step of the motion; needs --time");
  time.positive().needs(dt);
  dt.positive().needs(time);
  subcommand.option("--frames", a.task.frames, "Most frames of a motion")
      .in_range(1, 1000)
      .show_default();
  const CommandOption refinement =
      subcommand.option("--refine", a.task.refinement,
                        "Halve triangles where curvature jumps, so many rounds: jumps:ROUNDS");
  subcommand
      .flag("--stress", a.task.stress,
            "Largest displacement and stress of the shell of [stress], at each value of a sweep")
      .needs(sweep);
  const CommandOption record =
      subcommand.option("--record", a.task.record, "Write everything that was done to this file");
  subcommand.option("--replay", a.task.replay, "Do what such a file says")
      .excludes(sweep)
      .excludes(time)
      .excludes(refinement)
      .excludes(record);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const Report report = run_sculpt(read_scene(arguments->file), arguments->task,
                                             arguments->out, terminal_progress(common.quiet));
            return print_result(report, sculpt_summary(report, arguments->out), common);
          }};
}

}  // namespace batten
