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

Command add_sculpt(CLI::App& app, CommonWords& common) {
  const auto words = std::make_shared<SculptWords>();
  SculptWords& a = *words;
  auto* sub = app.add_subcommand(
      "sculpt", "Settle, sweep, move and refine a scene's surface under live loads");
  sub->add_option("scene", a.file, "Scene (.toml)")->required();
  sub->add_option("--out", a.out, "Folder for all files, report.json too")->required();
  repeated(sub->add_option("--set", a.task.settings, "Set a parameter: name=value"));
  auto* sweep = repeated(
      sub->add_option("--sweep", a.task.sweeps,
                      "Settle at so many values, each from the one before: name=from:to:count"));
  auto* time = sub->add_option("--time", a.task.time,
                               "Motion from the settled shape, until this time; needs --dt");
  auto* dt = sub->add_option("--dt", a.task.dt, "Step of the motion; needs --time");
  time->check(kPositive)->needs(dt);
  dt->check(kPositive)->needs(time);
  sub->add_option("--frames", a.task.frames, "Most frames of a motion")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  auto* refinement =
      sub->add_option("--refine", a.task.refinement,
                      "Halve triangles where curvature jumps, so many rounds: jumps:ROUNDS");
  sub->add_flag(
         "--stress", a.task.stress,
         "Largest displacement and stress of the shell of [stress], at each value of a sweep")
      ->needs(sweep);
  auto* record =
      sub->add_option("--record", a.task.record, "Write everything that was done to this file");
  sub->add_option("--replay", a.task.replay, "Do what such a file says")
      ->excludes(sweep)
      ->excludes(time)
      ->excludes(refinement)
      ->excludes(record);
  add_common(sub, common);
  return {sub, [words, &common] {
            const Report report = run_sculpt(read_scene(words->file), words->task, words->out,
                                             terminal_progress(common.quiet));
            return finish(report, sculpt_summary(report, words->out), common);
          }};
}

}  // namespace batten
