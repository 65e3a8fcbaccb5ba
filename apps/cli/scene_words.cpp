// The words of `batten run` and `batten stress`.
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/runs/distributed.h"
#include "batten/apps/commands/runs/run_file.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/io/scene/read_scene.h"

namespace batten {
namespace {

struct SceneWords {
  std::string file, out;
  std::vector<std::string> settings;
  StressTask stress;
};

Words add_scene(ProgramWords& program, const char* name, const char* what, SceneWords& a,
                CommonWords& common) {
  const Words sub = program.command(name, what);
  sub.option("scene", a.file, "Scene (.toml)").required();
  sub.option("--out", a.out, "Folder for all files, report.json too").required();
  sub.option("--set", a.settings, "Set a parameter of the scene: name=value").repeated();
  add_common(sub, common);
  return sub;
}

int run(const SceneWords& a, const CommonWords& common) {
  const auto done = [&](const auto& report) {
    return finish(report, summary(report, a.out), common);
  };
  const Progress progress = terminal_progress(common.quiet);
  return with_scene_of(a.file, [&](auto& scene) {
    if constexpr (requires { scene.set("", 0.0, ""); }) apply_settings(scene, a.settings);
    return done(run_any(scene, a.out, progress));
  });
}

int stress(const SceneWords& a, const CommonWords& common) {
  const auto processes = Distributed::of_this_run();
  if (processes && processes->helps()) {
    processes->serve();
    return kDone;
  }
  StressTask task = a.stress;
  if (processes) task.factors = processes->factors();
  Scene scene = read_scene(a.file);
  apply_settings(scene, a.settings);
  const auto report = run_stress(scene, a.out, task, terminal_progress(common.quiet));
  return finish(report, summary(report, a.out), common);
}

}  // namespace

Command add_run(ProgramWords& program, CommonWords& common) {
  const auto a = std::make_shared<SceneWords>();
  const Words sub = add_scene(program, "run", "Do everything a scene asks for", *a, common);
  return {sub, [a, &common] { return run(*a, common); }};
}

Command add_stress(ProgramWords& program, CommonWords& common) {
  const auto a = std::make_shared<SceneWords>();
  const Words sub =
      add_scene(program, "stress",
                "The same, and the stresses of the shape as the shell of [stress]", *a, common);
  const Word with_ccx = sub.flag("--with-ccx", a->stress.with_calculix,
                                 "Run CalculiX on the same shell, and print what it finds");
  using Element = ShellDeck::Element;
  sub.numbered_choice(
         "--ccx-elements",
         {{"S6", int(Element::S6)}, {"S3", int(Element::S3)}, {"S8R", int(Element::S8R)}},
         [a](int element) { a->stress.element = Element(element); }, "Its elements: S6, S3 or S8R")
      .needs(with_ccx);
  sub.option("--accuracy", a->stress.accuracy,
             "Make elements smaller until displacements are this exact: 0.01 is a percent")
      .positive();
  return {sub, [a, &common] { return stress(*a, common); }};
}

}  // namespace batten
