// The words of `batten run` and `batten stress`.
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/runs/mpi_processes.h"
#include "batten/apps/commands/runs/run_file.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/io/scene/read_scene.h"

namespace batten {
namespace {

struct SceneArguments {
  std::string file, out;
  std::vector<std::string> settings;
  StressTask stress;
};

Subcommand add_scene(CommandLine& program, const char* name, const char* what, SceneArguments& a,
                     CommonOptions& common) {
  const Subcommand subcommand = program.command(name, what);
  subcommand.option("scene", a.file, "Scene (.toml)").required();
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.option("--set", a.settings, "Set a parameter of the scene: name=value")
      .allow_repeated();
  add_common(subcommand, common);
  return subcommand;
}

int run(const SceneArguments& a, const CommonOptions& common) {
  const auto done = [&](const auto& report) {
    return print_result(report, summary(report, a.out), common);
  };
  const Progress progress = terminal_progress(common.quiet);
  return visit_scene(a.file, [&](auto& scene) {
    if constexpr (requires { scene.set("", 0.0, ""); }) apply_settings(scene, a.settings);
    return done(run_any_scene(scene, a.out, progress));
  });
}

int stress(const SceneArguments& a, const CommonOptions& common) {
  const auto processes = MpiProcesses::detect();
  if (processes && processes->is_worker()) {
    processes->serve();
    return kDone;
  }
  StressTask task = a.stress;
  if (processes) task.factors = processes->factors();
  Scene scene = read_scene(a.file);
  apply_settings(scene, a.settings);
  const auto report = run_stress(scene, a.out, task, terminal_progress(common.quiet));
  return print_result(report, summary(report, a.out), common);
}

}  // namespace

Command add_run(CommandLine& program, CommonOptions& common) {
  const auto a = std::make_shared<SceneArguments>();
  const Subcommand subcommand =
      add_scene(program, "run", "Do everything a scene asks for", *a, common);
  return {subcommand, [a, &common] { return run(*a, common); }};
}

Command add_stress(CommandLine& program, CommonOptions& common) {
  const auto a = std::make_shared<SceneArguments>();
  const Subcommand subcommand =
      add_scene(program, "stress",
                "The same, and the stresses of the shape as the shell of [stress]", *a, common);
  const CommandOption with_ccx =
      subcommand.flag("--with-ccx", a->stress.with_calculix,
                      "Run CalculiX on the same shell, and print what it finds");
  using Element = ShellDeck::Element;
  subcommand
      .indexed_enum_option(
          "--ccx-elements",
          {{"S6", int(Element::S6)}, {"S3", int(Element::S3)}, {"S8R", int(Element::S8R)}},
          [a](int element) { a->stress.element = Element(element); }, "Its elements: S6, S3 or S8R")
      .needs(with_ccx);
  subcommand
      .option("--accuracy", a->stress.accuracy,
              "Make elements smaller until displacements are this exact: 0.01 is a percent")
      .positive();
  return {subcommand, [a, &common] { return stress(*a, common); }};
}

}  // namespace batten
