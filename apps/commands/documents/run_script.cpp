#include "batten/apps/commands/documents/run_script.h"

#include <sstream>

#include "batten/apps/commands/documents/document.h"
#include "batten/apps/commands/runs/run_support.h"

namespace batten {
ScriptReport run_script(const std::filesystem::path& script, const Progress& progress) {
  ScriptReport report;
  report.name = script.filename().string();
  Document document;
  for (const LocatedCommand& one : read_script(script)) {
    ++report.commands;
    try {
      document.apply(one.command, progress);
    } catch (const NoSolutionError& e) {
      report.warnings.push_back(one.where + e.what());
    } catch (const ConflictError& e) {
      throw ConflictError(e.conflicts(), one.where);
    } catch (const InputError& e) {
      throw InputError(one.where + e.what());
    }
    std::istringstream run_messages(document.run_messages());
    for (std::string line; std::getline(run_messages, line);)
      report.failed_checks.push_back({script_line(one.command), line});
    for (const auto kind :
         {DocumentCommand::CommandKind::Save, DocumentCommand::CommandKind::Export})
      if (one.command.kind == kind) report.files.push_back(one.command.file.string());
  }
  report.shape = document.content().rows();
  return report;
}

}  // namespace batten
