// The words of `batten run-script`.
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/documents/run_script.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/io/files/text.h"

namespace batten {

Command add_run_script(CommandLine& program, CommonOptions& common) {
  const auto file = std::make_shared<std::string>();
  const Subcommand subcommand = program.command(
      "run-script", "Do again what was done to a scene in batten-studio, command by command");
  subcommand.option("script", *file, "Script: open, add, set, slide, settle, undo, save, export, …")
      .required();
  add_common(subcommand, common);
  return {subcommand, [file, &common] {
            const ScriptReport report = run_script(*file, terminal_progress(common.quiet));
            std::string text = report.name + "\n";
            text += summary_line("script", format_count(report.commands, "command")) + report.shape;
            for (const std::string& written : report.files) text += summary_line("file", written);
            return print_result(report, text, common);
          }};
}

}  // namespace batten
