#include "batten/apps/studio/window/timeline_panel.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QSlider>
#include <QSpinBox>
#include <QTimer>

#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

constexpr int kFrameTime = 42;  // ms

}  // namespace

TimelinePanel::TimelinePanel(QWidget* parent, std::function<void(int)> show)
    : QWidget(parent),
      show_(std::move(show)),
      play_(new QPushButton(text(kPlay))),
      slider_(new QSlider(Qt::Horizontal)),
      number_(new QSpinBox),
      description_(new QLabel),
      clock_(new QTimer(this)) {
  auto* row = new QHBoxLayout(this);
  auto* before = new QPushButton(text(kPreviousKey));
  auto* behind = new QPushButton(text(kNextKey));
  number_->setPrefix(text(kFrameNumber));
  play_->setCheckable(true);
  play_->setShortcut(QKeySequence(Qt::Key_Space));
  for (QWidget* part :
       std::initializer_list<QWidget*>{play_, before, behind, slider_, number_, description_})
    row->addWidget(part, part == slider_ ? 1 : 0);
  clock_->setInterval(kFrameTime);
  QObject::connect(clock_, &QTimer::timeout, this, [this] {
    if (!frame_pending_)
      request_frame(slider_->value() < slider_->maximum() ? slider_->value() + 1 : 1);
  });
  QObject::connect(play_, &QPushButton::toggled, this, [this](bool on) { play(on); });
  QObject::connect(before, &QPushButton::clicked, this, [this] { to_keyframe(-1); });
  QObject::connect(behind, &QPushButton::clicked, this, [this] { to_keyframe(1); });
  QObject::connect(slider_, &QSlider::valueChanged, this, [this](int frame) {
    if (!showing_) request_frame(frame);
  });
  QObject::connect(number_, QOverload<int>::of(&QSpinBox::valueChanged), this, [this](int frame) {
    if (!showing_) request_frame(frame);
  });
}

void TimelinePanel::refresh(const DocumentView& view) {
  setVisible(view.timeline.has_value());
  if (!view.timeline) return play(false);
  showing_ = true;
  slider_->setRange(1, view.timeline->frames);
  number_->setRange(1, view.timeline->frames);
  number_->setSuffix(QString(" / %1").arg(view.timeline->frames));
  if (!frame_pending_ && !slider_->isSliderDown()) {
    slider_->setValue(view.timeline->frame + 1);
    number_->setValue(view.timeline->frame + 1);
  }
  keyframes_ = view.timeline->keyframes;
  QStringList keys;
  for (const int key : keyframes_) keys << QString::number(key + 1);
  description_->setText(keys.isEmpty() ? QString() : text(kKeyframes).arg(keys.join(", ")));
  showing_ = false;
}

void TimelinePanel::play(bool on) {
  play_->setChecked(on);
  on ? clock_->start() : clock_->stop();
}

bool TimelinePanel::is_playing() const { return clock_->isActive(); }

void TimelinePanel::frame_drawn() { frame_pending_ = false; }

void TimelinePanel::request_frame(int frame) {
  showing_ = true;
  slider_->setValue(frame);
  number_->setValue(frame);
  showing_ = false;
  frame_pending_ = true;
  show_(frame - 1);
}

// Goes to the nearest keyframe before (-1) or after (+1) the displayed frame.
void TimelinePanel::to_keyframe(int direction) {
  const int now = slider_->value() - 1;
  int best = -1;
  for (const int key : keyframes_)
    if ((key - now) * direction > 0 && (best < 0 || (key - best) * direction < 0)) best = key;
  if (best >= 0) request_frame(best + 1);
}

}  // namespace batten::studio
