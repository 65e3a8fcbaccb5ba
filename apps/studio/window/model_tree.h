// What the document is made of, as a tree.
#pragma once

#include <QHash>
#include <QTreeWidget>
#include <functional>
#include <string>

#include "batten/apps/commands/documents/document_view.h"

namespace batten::studio {

/// Of a shape its lines, surfaces, joins, close choices and what acts; of a mesh its openings,
/// selections, what is kept and the edits; and the other tables of the scene.
class ModelTree : public QTreeWidget {
 public:
  /// Something in the tree.
  struct Item {
    enum class Kind { None, Line, Region, Join, Table, Alternative, StressPart, Part, Parts };
    Kind kind = Kind::None;
    std::string name;  ///< of a line, region, join's line or part of a mesh
    SceneTable table;  ///< where the scene says it; of a line or region it may have none
    int number = -1;   ///< of a close choice, or of a part of [stress] among stress_parts()
  };
  ModelTree(QWidget* parent, std::function<void(const Item&)> on_selected);

  void refresh(const DocumentView& view);
  void select_line(const std::string& line);
  void select_region(const std::string& region);  ///< or a part of a mesh, or a table
  void clear_selection();
  Item current() const;

 private:
  QTreeWidgetItem* group(const char* title, int count);
  void add(QTreeWidgetItem* group, const QString& name, const QString& detail, Item item,
           const QString& wrong = {});
  void select(Item::Kind kind, const std::string& name);
  void restore_selection(const Item& before);
  void fill_shape(const DocumentView& view);
  void fill_mesh(const DocumentView& view);
  void fill_tables(const DocumentView& view);
  std::function<void(const Item&)> on_selected_;
  std::vector<Item> items_;
  QHash<QString, bool> open_;  // groups by their titles
  int document_number_ = 0;
  bool filling_ = false;
};

}  // namespace batten::studio
