// The words of `batten sculpt`.
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/shapes/run_sculpt.h"
#include "batten/io/scene/read_scene.h"

namespace batten {
namespace {

struct SculptWords {
  std::string file, out;
  SculptTask task;
};

}  // namespace

Command add_sculpt(ProgramWords& program, CommonWords& common) {
  const auto words = std::make_shared<SculptWords>();
  SculptWords& a = *words;
  const Words sub = program.command(
      "sculpt", "Settle, sweep, move and refine a scene's surface under live loads");
  sub.option("scene", a.file, "Scene (.toml)").required();
  sub.option("--out", a.out, "Folder for all files, report.json too").required();
  sub.option("--set", a.task.settings, "Set a parameter: name=value").repeated();
  const Word sweep =
      sub.option("--sweep", a.task.sweeps,
                 "Settle at so many values, each from the one before: name=from:to:count")
          .repeated();
  const Word time = sub.option("--time", a.task.time,
                               "Motion from the settled shape, until this time; needs --dt");
  const Word dt = sub.option("--dt", a.task.dt, "Step of the motion; needs --time");
  time.positive().needs(dt);
  dt.positive().needs(time);
  sub.option("--frames", a.task.frames, "Most frames of a motion").within(1, 1000).with_default();
  const Word refinement =
      sub.option("--refine", a.task.refinement,
                 "Halve triangles where curvature jumps, so many rounds: jumps:ROUNDS");
  sub.flag("--stress", a.task.stress,
           "Largest displacement and stress of the shell of [stress], at each value of a sweep")
      .needs(sweep);
  const Word record =
      sub.option("--record", a.task.record, "Write everything that was done to this file");
  sub.option("--replay", a.task.replay, "Do what such a file says")
      .excludes(sweep)
      .excludes(time)
      .excludes(refinement)
      .excludes(record);
  add_common(sub, common);
  return {sub, [words, &common] {
            const Report report = run_sculpt(read_scene(words->file), words->task, words->out,
                                             terminal_progress(common.quiet));
            return finish(report, sculpt_summary(report, words->out), common);
          }};
}

}  // namespace batten
