// Panel with one slider per parameter of the document.
#pragma once

#include <QScrollArea>
#include <functional>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/apps/commands/documents/document_view.h"
#include "batten/apps/studio/window/input_event_filter.h"

class QDoubleSpinBox;
class QFormLayout;
class QLabel;
class QSlider;

namespace batten::studio {

/// A slider with a number field for each parameter that the user can change. Dragging posts
/// SetSlider commands; releasing posts SolveToEquilibrium. If a parameter has no bound, the
/// slider's range grows when its end is reached.
class SliderPanel : public QScrollArea {
 public:
  SliderPanel(QWidget* parent, std::function<void(DocumentCommand)> post);

  /// Shows the parameters of a document.
  void refresh(const DocumentView& view);
  /// Shows a value that is being changed elsewhere; the next document view contains it, too.
  void show_live_value(const std::string& parameter, double value);
  QSlider* slider(const std::string& parameter) const;  ///< null: no such parameter
  QDoubleSpinBox* number(const std::string& parameter) const;

 private:
  struct Row {
    DocumentView::Slider of;
    double low = 0, high = 0;  // range of the slider
    QSlider* slider = nullptr;
    QDoubleSpinBox* number = nullptr;
  };
  void rebuild();
  void add_row(size_t i);
  void show_value(Row& row, double value);
  void extend_range(Row& row, double value);
  std::function<void(DocumentCommand)> post_;
  std::vector<Row> rows_;
  InputEventFilter input_filter_;
  double size_ = 0;             // size of the surface
  const char* none_ = nullptr;  // text shown if there are no sliders
  bool one_edit_ = false;       // the scene has a single [[edit]]
  bool showing_ = false;
};

}  // namespace batten::studio
