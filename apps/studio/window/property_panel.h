// SPDX-License-Identifier: MPL-2.0
// Panel with the properties of the selected object.
#pragma once

#include <QWidget>
#include <functional>
#include <memory>

#include "batten/apps/documents/document_content.h"
#include "batten/apps/documents/document_view.h"
#include "batten/apps/documents/load_edits.h"
#include "batten/apps/studio/window/model_tree.h"
#include "batten/apps/studio/window/slider_panels.h"

class QLabel;
class QPushButton;
class QTableWidget;
class QVBoxLayout;

namespace batten::studio {

/// Shows the scene table of the selected object, whose values can be edited in place. Buttons make
/// an edge a crease or smooth, select an alternative region, or define the role of a part of a
/// mesh.
class PropertyPanel : public QWidget {
 public:
  /// Selection in the 3-D view.
  struct ViewSelection {
    std::function<int()> point;  ///< selected point of the selected curve; -1: none
    std::function<std::optional<PickedPoint>()> surface_point;  ///< clicked point of the surface
  };
  PropertyPanel(QWidget* parent, std::function<void(DocumentCommand)> post,
                ViewSelection selection);

  /// Shows the properties of an entry of the tree.
  void refresh(std::shared_ptr<const DocumentView> view, const ModelTree::Item& item);
  QPushButton* button(const char* text) const;  ///< by its English text; null: not shown
  QTableWidget& keys() { return *keys_; }
  /// The selected support or load of [stress]; none if something else is selected.
  std::optional<StressPart> selected_stress_part() const;

 private:
  void post_value(int row);
  void fill_table();
  void add_key(const std::string& key, const std::string& value);
  void fill_description();
  void fill_mesh();
  void fill_line();
  void fill_stress();
  void add_keep_all_button();
  QPushButton* add_button(const char* what, std::function<std::vector<DocumentCommand>()> edits);
  std::function<void(DocumentCommand)> post_;
  ViewSelection selection_;
  std::shared_ptr<const DocumentView> view_;
  ModelTree::Item item_;
  QLabel* title_;
  QLabel* description_;
  QWidget* buttons_;
  QTableWidget* keys_;
  InputEventFilter input_filter_;
  bool filling_ = false;
};

}  // namespace batten::studio
