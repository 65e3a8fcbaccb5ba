// What is chosen: its keys in the scene, and what can be done with it.
#pragma once

#include <QWidget>
#include <functional>
#include <memory>

#include "batten/apps/commands/documents/document_content.h"
#include "batten/apps/commands/documents/document_view.h"
#include "batten/apps/commands/documents/load_edits.h"
#include "batten/apps/studio/window/input_event_filter.h"
#include "batten/apps/studio/window/model_tree.h"

class QLabel;
class QPushButton;
class QTableWidget;
class QVBoxLayout;

namespace batten::studio {

/// The table of a chosen item, key by key as the scene has it, to be changed in place; buttons that
/// make a line a crease or smooth, take the other way of a close choice, or say what a part of a mesh
/// is for.
class PropertyPanel : public QWidget {
 public:
  /// What the hand has chosen in the view.
  struct ViewSelection {
    std::function<int()> point;  ///< of the chosen line, -1 for none
    std::function<std::optional<SurfacePoint>()> surface_point;  ///< of the surface
  };
  PropertyPanel(QWidget* parent, std::function<void(DocumentCommand)> post,
                ViewSelection selection);

  void refresh(std::shared_ptr<const DocumentView> view, const ModelTree::Item& item);
  QPushButton* button(const char* text) const;  ///< by its English text; null: not shown
  QTableWidget& keys() { return *keys_; }
  /// The support or load of [stress] that is chosen.
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
  void add_button(const char* what, std::function<std::vector<DocumentCommand>()> edits);
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
