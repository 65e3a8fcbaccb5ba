// Input helpers for scrolling panels: combo boxes, spin boxes and sliders.
#pragma once

#include <QObject>

class QSlider;
class QWidget;

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

}  // namespace batten::studio
