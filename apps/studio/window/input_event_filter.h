// Lists, numbers and sliders as a hand expects them in a panel that scrolls.
#pragma once

#include <QObject>

class QSlider;
class QWidget;

namespace batten::studio {

/// Events that a list or a number leaves to others: the wheel scrolls on over it and does not change
/// it, and undo and redo are the document's.
class InputEventFilter : public QObject {
 public:
  using QObject::QObject;
  /// Makes a list or a number quiet, for as long as this object lives.
  void watch(QWidget* input);

 protected:
  bool eventFilter(QObject* input, QEvent* event) override;
};

/// A press beside the handle of a slider moves it there, and a drag goes on from there.
void jump_to_press(QSlider* slider);

}  // namespace batten::studio
