#include "batten/apps/studio/window/input_event_filter.h"

#include <QKeyEvent>
#include <QLineEdit>
#include <QProxyStyle>
#include <QSlider>

namespace batten::studio {
namespace {

class JumpingStyle : public QProxyStyle {
 public:
  int styleHint(StyleHint hint, const QStyleOption* option, const QWidget* widget,
                QStyleHintReturn* more) const override {
    return hint == SH_Slider_AbsoluteSetButtons
               ? static_cast<int>(Qt::LeftButton)
               : QProxyStyle::styleHint(hint, option, widget, more);
  }
};

}  // namespace

void InputEventFilter::watch(QWidget* input) {
  input->installEventFilter(this);
  for (QLineEdit* line : input->findChildren<QLineEdit*>()) line->installEventFilter(this);
}

bool InputEventFilter::eventFilter(QObject* input, QEvent* event) {
  const bool wheel = event->type() == QEvent::Wheel;
  bool undo = false;
  if (event->type() == QEvent::ShortcutOverride) {
    auto* key = static_cast<QKeyEvent*>(event);
    undo = key->matches(QKeySequence::Undo) || key->matches(QKeySequence::Redo);
  }
  if (!wheel && !undo) return QObject::eventFilter(input, event);
  event->ignore();
  return true;
}

void jump_to_press(QSlider* slider) {
  auto* style = new JumpingStyle;
  style->setParent(slider);
  slider->setStyle(style);
}

}  // namespace batten::studio
