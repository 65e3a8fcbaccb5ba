// One slider for each parameter of the document.
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

/// A slider with its number for each parameter that a hand may move. While one is dragged it posts
/// `set_slider`, when it is let go `settle`. Where a range is open, the slider's own grows when its end is
/// reached.
class SliderPanel : public QScrollArea {
 public:
  SliderPanel(QWidget* parent, std::function<void(DocumentCommand)> post);

  void refresh(const DocumentView& view);
  /// Shows a value that something else moves in this moment; the next view has it, too.
  void show_live_value(const std::string& parameter, double value);
  QSlider* slider(const std::string& parameter) const;  ///< null: none of this name
  QDoubleSpinBox* number(const std::string& parameter) const;

 private:
  struct Row {
    DocumentView::Slider of;
    double low = 0, high = 0;  // of the slider
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
  double size_ = 0;             // of the surface
  const char* none_ = nullptr;  // what is said where there are no sliders
  bool showing_ = false;
};

}  // namespace batten::studio
