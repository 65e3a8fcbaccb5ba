#include "batten/apps/commands/documents/network_edits.h"

#include <algorithm>

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;

}  // namespace

std::vector<DocumentCommand> join_edits(const SceneText& scene, const std::string& line,
                                        const std::optional<std::string>& kind) {
  std::vector<DocumentCommand> edits;
  bool said = false;
  // From the last one, so that numbers of those before stay when one is removed.
  std::vector<SceneTable> tables = scene.tables();
  std::reverse(tables.begin(), tables.end());
  for (const SceneTable& table : tables) {
    if (table.kind != "join") continue;
    std::vector<std::string> lines = scene.words(table, "lines");
    const auto found = std::find(lines.begin(), lines.end(), line);
    if (found == lines.end()) continue;
    const std::vector<std::string> kinds = scene.words(table, "kind");
    if (kind && !kinds.empty() && kinds.front() == *kind && !said) {
      said = true;
    } else if (lines.size() == 1 && kind && !said) {
      edits.push_back({.kind = CommandKind::Set,
                       .table = table,
                       .key = "kind",
                       .text = SceneText::word(*kind)});
      said = true;
    } else if (lines.size() == 1) {
      edits.push_back({.kind = CommandKind::Remove, .table = table});
    } else {
      lines.erase(found);
      edits.push_back({.kind = CommandKind::Set,
                       .table = table,
                       .key = "lines",
                       .text = SceneText::toml_string_list(lines)});
    }
  }
  if (kind && !said)
    edits.push_back({.kind = CommandKind::Add,
                     .table = {"join", ""},
                     .text = "{ lines = " + SceneText::toml_string_list({line}) +
                             ", kind = " + SceneText::word(*kind) + " }"});
  return edits;
}

std::vector<DocumentCommand> alternative_edits(const NetworkReport::Choice& choice,
                                               int alternative) {
  std::vector<DocumentCommand> edits;
  const auto region = [&](const std::vector<NetworkReport::LoopNames>& loops, const char* more) {
    std::vector<std::string> lists;
    for (const auto& loop : loops) lists.push_back(SceneText::toml_string_list(loop));
    edits.push_back({.kind = CommandKind::Add,
                     .table = {"region", ""},
                     .text = "{ loops = " + SceneText::list(lists) + more + " }"});
  };
  const auto& wanted = choice.alternatives.at(static_cast<size_t>(alternative));
  for (const auto& loop : choice.chosen)
    if (std::find(wanted.begin(), wanted.end(), loop) == wanted.end())
      region({loop}, ", surface = false");
  for (const auto& loop : wanted)
    if (std::find(choice.chosen.begin(), choice.chosen.end(), loop) == choice.chosen.end())
      region({loop}, "");
  return edits;
}

}  // namespace batten
