#include "batten/apps/commands/documents/mesh_edits.h"

#include <algorithm>
#include <sstream>

#include "batten/apps/commands/runs/run_parts.h"
#include "batten/core/words.h"

namespace batten {
namespace {

using Verb = DocumentCommand::Verb;
using Part = MeshView::Part;

std::optional<SceneTable> last_edit(const SceneText& scene) {
  std::optional<SceneTable> last;
  for (const SceneTable& table : scene.tables())
    if (table.kind == "edit") last = table;
  return last;
}

/// The handle of the last edit that has this name.
SceneTable handle_of(const SceneText& scene, const std::string& part) {
  const auto edit = last_edit(scene);
  return {"edit.handle", (edit ? edit->name : "") + "." + part};
}

/// Names that a list of features means, but for one.
std::vector<std::string> without(const std::vector<std::string>& words, const MeshView& mesh,
                                 const std::string& part) {
  std::vector<std::string> left;
  for (const std::string& word : words) {
    if (!matches(word, part)) {
      left.push_back(word);
      continue;
    }
    for (const Part& one : mesh.parts)
      if (matches(word, one.name) && one.name != part) left.push_back(one.name);
  }
  return left;
}

void let_go(const SceneText& scene, const MeshView& mesh, const std::string& part,
            std::vector<DocumentCommand>& edits) {
  for (const SceneTable& table : scene.tables()) {
    if (table == SceneTable{"feature", part})
      edits.push_back({.verb = Verb::Remove, .table = table});
    if (table.kind != "features") continue;
    const std::vector<std::string> words = scene.words(table, "of");
    const std::vector<std::string> left = without(words, mesh, part);
    if (left.empty())
      edits.push_back({.verb = Verb::Remove, .table = table});
    else if (left != words)
      edits.push_back(
          {.verb = Verb::Set, .table = table, .key = "of", .text = SceneText::word_list(left)});
  }
  if (const SceneTable handle = handle_of(scene, part); scene.has(handle))
    edits.push_back({.verb = Verb::Remove, .table = handle});
  if (const auto edit = last_edit(scene)) {
    std::vector<std::string> fixed = scene.words(*edit, "fixed");
    if (std::erase(fixed, part) == 0) return;
    if (fixed.empty())
      edits.push_back({.verb = Verb::Erase, .table = *edit, .key = "fixed"});
    else
      edits.push_back(
          {.verb = Verb::Set, .table = *edit, .key = "fixed", .text = SceneText::word_list(fixed)});
  }
}

}  // namespace

PartUse use_of(const SceneText& scene, const std::string& part) {
  if (scene.has(handle_of(scene, part))) return PartUse::Handle;
  const auto fixed =
      last_edit(scene) ? scene.words(*last_edit(scene), "fixed") : std::vector<std::string>{};
  if (std::find(fixed.begin(), fixed.end(), part) != fixed.end()) return PartUse::Fixed;
  for (const SceneTable& table : scene.tables()) {
    const std::vector<std::string> of =
        table.kind == "features" ? scene.words(table, "of") : std::vector<std::string>{};
    const bool listed =
        std::any_of(of.begin(), of.end(), [&](const auto& word) { return matches(word, part); });
    if (listed || table == SceneTable{"feature", part})
      return scene.value(table, "keep") == "\"direction\"" ? PartUse::KeepsDirection
                                                           : PartUse::Rigid;
  }
  return PartUse::Free;
}

std::vector<DocumentCommand> use_edits(const SceneText& scene, const MeshView& mesh,
                                       const std::string& part, PartUse use) {
  std::vector<DocumentCommand> edits;
  if (use_of(scene, part) == use) return edits;
  let_go(scene, mesh, part, edits);
  if (use == PartUse::Free) return edits;
  const std::string name = SceneText::word(part);
  for (const Part& one : mesh.parts)
    if (one.name == part && one.kind == Part::Kind::Set && !scene.has({"select", part}))
      edits.push_back({.verb = Verb::Add,
                       .table = {"select", ""},
                       .text = "{ name = " + name + ", " + one.key + " = " + name + " }"});
  const auto edit = last_edit(scene);
  const bool moves = use == PartUse::Fixed || use == PartUse::Handle;
  if (!edit && moves)
    edits.push_back({.verb = Verb::Add, .table = {"edit", ""}, .text = "{ name = \"edit 1\" }"});
  if (use == PartUse::Fixed) {
    std::vector<std::string> fixed =
        edit ? scene.words(*edit, "fixed") : std::vector<std::string>{};
    fixed.push_back(part);
    edits.push_back({.verb = Verb::Set,
                     .table = edit ? *edit : SceneTable{"edit", "edit 1"},
                     .key = "fixed",
                     .text = SceneText::word_list(fixed)});
  } else if (use == PartUse::Handle) {
    edits.push_back(
        {.verb = Verb::Add, .table = {"edit.handle", ""}, .text = "{ name = " + name + " }"});
  } else {
    const std::string keep = use == PartUse::KeepsDirection ? ", keep = \"direction\"" : "";
    edits.push_back(
        {.verb = Verb::Add, .table = {"feature", ""}, .text = "{ name = " + name + keep + " }"});
  }
  return edits;
}

DocumentCommand nodes_edit(const SceneText& scene, const std::string& name,
                           const std::vector<long>& labels) {
  std::vector<std::string> numbers;
  for (const long label : labels) numbers.push_back(std::to_string(label));
  const std::string list = SceneText::list(numbers);
  const SceneTable table{"select", name};
  if (scene.has(table)) return {.verb = Verb::Set, .table = table, .key = "nodes", .text = list};
  return {.verb = Verb::Add,
          .table = {"select", ""},
          .text = "{ name = " + SceneText::word(name) + ", nodes = " + list + " }"};
}

std::vector<long> nodes_of(const SceneText& scene, const std::string& name) {
  const SceneTable table{"select", name};
  std::vector<long> labels;
  if (!scene.has(table)) return labels;
  std::string list = scene.value(table, "nodes");
  for (char& c : list)
    if (c == '[' || c == ']' || c == ',') c = ' ';
  std::istringstream in(list);
  for (long label = 0; in >> label;) labels.push_back(label);
  return labels;
}

}  // namespace batten
