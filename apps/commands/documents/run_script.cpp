#include "batten/apps/commands/documents/run_script.h"

#include <sstream>

#include "batten/apps/commands/documents/document.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

std::string rows_of(const Document& document) {
  const SculptingSession* session = document.session();
  if (!session) {
    const std::string why = document.problem().empty() ? "no lines" : document.problem();
    return result_line("surface", "none: " + why);
  }
  const ModelLayout& layout = session->layout();
  std::string text =
      result_line("surface", counted(layout.region_count(), "region") + ", " +
                                 counted(layout.mesh()->triangle_count(), "element") + ", energy " +
                                 number(session->energy().stretching + session->energy().bending));
  for (const NamedValue& p : session->parameters().all())
    text += result_line("", p.name + " = " + number(session->parameters().value(p.name)));
  return text;
}

}  // namespace

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
  report.shape = rows_of(document);
  return report;
}

}  // namespace batten
