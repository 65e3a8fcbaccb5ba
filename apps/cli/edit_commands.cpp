// The words of `batten deform` and `batten sequence`.
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/meshes/run_deform.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/sequences/run_sequence.h"

namespace batten {
namespace {

struct EditArguments {
  std::string file, out;
  std::vector<std::string> settings;
  SequenceTask sequence;
};

}  // namespace

Command add_deform(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<EditArguments>();
  EditArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("deform", "Edit a mesh; its form features keep their shape exactly");
  subcommand.option("edits", a.file, "Edits of a mesh (.toml)").required();
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.option("--set", a.settings, "Set a parameter of the edits: name=value")
      .allow_repeated();
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            DeformScene scene = read_deform_scene(arguments->file);
            apply_settings(scene, arguments->settings);
            const auto report = run_deform(scene, arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

Command add_sequence(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<EditArguments>();
  EditArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "sequence", "Edit a deforming mesh: keyframes, footprints, paths; mix, filter, morph");
  subcommand.option("edits", a.file, "Edits of a sequence (.toml)").required();
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.parsed_option(
      "--frames",
      [arguments](const std::string& text) {
        const size_t colon = text.find(':');
        const auto first = parse_number(text.substr(0, colon)),
                   last = colon == std::string::npos ? first : parse_number(text.substr(colon + 1));
        if (!first || !last || !(*first >= 1) || !(*last >= *first) || *last > 1e9)
          return "found " + text + ", expected FIRST:LAST";
        arguments->sequence.frames = {static_cast<int>(*first), static_cast<int>(*last)};
        return std::string();
      },
      "Make these frames only, FIRST:LAST from 1: runs of a job array share the work");
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const auto report = run_sequence(read_sequence_scene(arguments->file), arguments->out,
                                             arguments->sequence, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

}  // namespace batten
