// The frames of a sequence: shown, played, with their keyframes.
#pragma once

#include <QWidget>
#include <functional>

#include "batten/apps/commands/documents/document_view.h"

class QLabel;
class QPushButton;
class QSlider;
class QSpinBox;
class QTimer;

namespace batten::studio {

/// A slider over frames, a button that plays them, and buttons from keyframe to keyframe.
class TimelinePanel : public QWidget {
 public:
  /// `show`: another frame is asked for, from 0.
  TimelinePanel(QWidget* parent, std::function<void(int)> show);

  void refresh(const DocumentView& view);
  /// Plays until it is called again; a frame waits until the one before is drawn.
  void play(bool on);
  bool is_playing() const;
  /// What was asked for is drawn.
  void frame_drawn();

  // For tests and tours.
  QSlider& slider() { return *slider_; }
  QPushButton& play_button() { return *play_; }

 private:
  void request_frame(int frame);
  void to_keyframe(int way);
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
