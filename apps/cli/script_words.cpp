// The words of `batten run-script`.
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/documents/run_script.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/io/files/text.h"

namespace batten {

Command add_run_script(ProgramWords& program, CommonWords& common) {
  const auto file = std::make_shared<std::string>();
  const Words sub = program.command(
      "run-script", "Do again what was done to a scene in batten-studio, command by command");
  sub.option("script", *file, "Script: open, add, set, slide, settle, undo, save, export, …")
      .required();
  add_common(sub, common);
  return {sub, [file, &common] {
            const ScriptReport report = run_script(*file, terminal_progress(common.quiet));
            std::string text = report.name + "\n";
            text += result_line("script", counted(report.commands, "command")) + report.shape;
            for (const std::string& written : report.files) text += result_line("file", written);
            return finish(report, text, common);
          }};
}

}  // namespace batten
