// SPDX-License-Identifier: MPL-2.0
// Panels with sliders, for the parameters of a document and for the frames of a sequence, and the
// input helpers of all panels.
#pragma once

#include <QObject>
#include <QScrollArea>
#include <QWidget>
#include <functional>
#include <vector>

#include "batten/apps/documents/document_command.h"
#include "batten/apps/documents/document_view.h"

class QDoubleSpinBox;
class QFormLayout;
class QLabel;
class QPushButton;
class QSlider;
class QSpinBox;
class QTimer;

namespace batten::studio {

/// Event filter for combo boxes and spin boxes. The mouse wheel scrolls the panel instead of
/// changing the value, and undo and redo go to the document.
class InputEventFilter : public QObject {
 public:
  using QObject::QObject;
  /// Filters the events of a widget, as long as this object lives.
  void watch(QWidget* input);

 protected:
  bool eventFilter(QObject* input, QEvent* event) override;
};

/// Makes a slider jump to a press beside its handle, and continue with a drag from there.
void jump_to_press(QSlider* slider);

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

/// A slider over the frames, a play button, and buttons for the previous and next keyframe.
class TimelinePanel : public QWidget {
 public:
  /// `show`: called to request a frame, 0-based.
  TimelinePanel(QWidget* parent, std::function<void(int)> show);

  /// Shows the timeline of a document.
  void refresh(const DocumentView& view);
  /// Starts (on) or stops playback. A frame is requested only after the previous one is drawn.
  void play(bool on);
  bool is_playing() const;
  /// Must be called when the requested frame has been drawn.
  void frame_drawn();

  // Access for tests and tours.
  QSlider& slider() { return *slider_; }
  QPushButton& play_button() { return *play_; }

 private:
  void request_frame(int frame);
  void to_keyframe(int direction);
  std::function<void(int)> show_;
  QPushButton* play_;
  QSlider* slider_;
  QSpinBox* number_;
  QLabel* description_;
  QTimer* clock_;
  std::vector<int> keyframes_;
  bool showing_ = false, frame_pending_ = false;
};

}  // namespace batten::studio
