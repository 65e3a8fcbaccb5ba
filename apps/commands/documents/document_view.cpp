#include "batten/apps/commands/documents/document_view.h"

#include <algorithm>
#include <optional>

#include "batten/apps/commands/documents/document.h"
#include "batten/core/box.h"

namespace batten {
std::array<Vec3, 2> DocumentView::box() const {
  std::optional<Box3> box;
  for (const Polyline& line : lines)
    for (const Vec3& p : line.points) {
      if (!box) box.emplace(p);
      box->extend(p);
    }
  if (!box) return {Vec3::Zero(), Vec3::Zero()};
  return {box->min(), box->max()};
}

const DocumentView::Table* DocumentView::table(const SceneTable& name) const {
  for (const Table& table : tables)
    if (table.name == name) return &table;
  return nullptr;
}

std::string DocumentView::free_name(const std::string& beginning) const {
  for (int number = 1;; ++number) {
    const std::string name = beginning + " " + std::to_string(number);
    if (std::none_of(tables.begin(), tables.end(),
                     [&](const Table& table) { return table.name.name == name; }))
      return name;
  }
}

DocumentView view_of(const Document& document) {
  DocumentView view;
  view.title = document.file().empty() ? "untitled" : document.file().filename().string();
  if (!document.file().empty())
    view.folder = std::filesystem::absolute(document.file()).parent_path().filename().string();
  view.text = document.text().text();
  view.changed = document.changed();
  view.can_undo = document.can_undo();
  view.can_redo = document.can_redo();
  view.problem = document.content().problem();
  for (auto& [table, values] : document.text().all_values())
    view.tables.push_back({table, std::move(values)});
  document.content().look_at(view);
  return view;
}

}  // namespace batten
