#include "batten/apps/commands/documents/run_script.h"

#include <sstream>

#include "batten/apps/commands/documents/document.h"
#include "batten/apps/commands/runs/run_parts.h"

namespace batten {
ScriptReport run_script(const std::filesystem::path& script, const Progress& progress) {
  ScriptReport report;
  report.name = script.filename().string();
  Document document;
  for (const PlacedCommand& one : read_script(script)) {
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
    std::istringstream told(document.told());
    for (std::string line; std::getline(told, line);)
      report.missed.push_back({script_line(one.command), line});
    for (const auto verb : {DocumentCommand::Verb::Save, DocumentCommand::Verb::Export})
      if (one.command.verb == verb) report.files.push_back(one.command.file.string());
  }
  report.shape = document.content().rows();
  return report;
}

}  // namespace batten
