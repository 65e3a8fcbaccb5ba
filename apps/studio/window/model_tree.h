// SPDX-License-Identifier: MPL-2.0
// Tree of the objects in a document.
#pragma once

#include <QHash>
#include <QTreeWidget>
#include <functional>
#include <string>

#include "batten/apps/documents/document_view.h"

namespace batten::studio {

/// Tree of the objects in a document. For a shape: curves, faces, edges, alternative faces,
/// loads and constraints. For a mesh: holes, selections, features and boundary conditions, edits.
/// In addition, the other tables of the scene.
class ModelTree : public QTreeWidget {
 public:
  /// An entry of the tree.
  struct Item {
    enum class Kind { None, Line, Region, Join, Table, Alternative, StressPart, Part, Parts };
    Kind kind = Kind::None;
    std::string name;  ///< name of a curve, face, edge or part of a mesh
    SceneTable table;  ///< scene table that defines it; may be empty for curves and faces
    /// Index of an alternative face, or of a part among stress_parts(); -1: none.
    int number = -1;
  };
  ModelTree(QWidget* parent, std::function<void(const Item&)> on_selected);

  /// Rebuilds the tree from a document; keeps the selection.
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
  QHash<QString, bool> open_;  // expanded state of groups, by title
  int document_number_ = 0;
  bool filling_ = false;
};

}  // namespace batten::studio
