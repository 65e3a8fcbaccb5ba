#include "batten/apps/commands/documents/document_view.h"

#include <algorithm>
#include <optional>

#include "batten/core/geometry.h"

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

}  // namespace batten
