// Panel for the frames of a sequence: scrubbing, playback and keyframes.
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
