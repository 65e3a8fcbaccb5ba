// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/window/slider_panels.h"

#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QKeyEvent>
#include <QLabel>
#include <QLineEdit>
#include <QProxyStyle>
#include <QPushButton>
#include <QSlider>
#include <QSpinBox>
#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/apps/studio/view/strings.h"

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

// Parameters.

namespace {

using CommandKind = DocumentCommand::CommandKind;
constexpr int kSteps = 2000, kNumberWidth = 124;

bool same_rows(const DocumentView::Slider& a, const DocumentView::Slider& b) {
  return a.name == b.name && a.unit == b.unit && a.min == b.min && a.max == b.max &&
         a.driven == b.driven;
}

/// True if the scene has a single [[edit]], so that labels need not name it.
bool has_one_edit(const DocumentView& view) {
  return std::count_if(view.tables.begin(), view.tables.end(),
                       [](const auto& table) { return table.name.kind == "edit"; }) == 1;
}

/// Label of a parameter: "edit 1.flange.angle" is "flange: rotation", "alpha_uu" is "Membrane
/// stiffness α_uu". `one_edit`: the name of the edit is left out.
QString label_of(const std::string& parameter, bool one_edit) {
  const QString name = shown(parameter);
  for (const auto& [key, label] : {std::pair("alpha", kMembrane), std::pair("beta", kBending)})
    if (name == key || name.startsWith(QString(key) + "_"))
      return text(label) + name.mid(QString(key).size());
  const int dot = name.lastIndexOf('.');
  if (dot < 0) return name;
  const QString of = name.left(dot), what = name.mid(dot + 1);
  return text(kParameterOf)
      .arg(one_edit ? of.mid(of.indexOf('.') + 1) : of,
           what == "angle" ? text(kRotationAngle) : what);
}

/// The value at a slider position, rounded to the decimals by which positions differ.
double value_at(int step, double low, double high) {
  const double width = (high - low) / kSteps;
  const int decimals =
      width > 0 ? std::max(0, -static_cast<int>(std::floor(std::log10(width)))) : 0;
  return QString::number(low + width * step, 'f', decimals).toDouble();
}

}  // namespace

SliderPanel::SliderPanel(QWidget* parent, std::function<void(DocumentCommand)> post)
    : QScrollArea(parent), post_(std::move(post)) {
  setWidgetResizable(true);
  setFrameShape(QFrame::NoFrame);
  setMinimumWidth(260);
  rebuild();
}

void SliderPanel::refresh(const DocumentView& view) {
  const bool same = view.sliders.size() == rows_.size() &&
                    std::equal(rows_.begin(), rows_.end(), view.sliders.begin(),
                               [](const Row& row, const auto& s) { return same_rows(row.of, s); });
  const char* const none = view.timeline ? kNoSlidersOfSequence
                           : view.mesh   ? kNoSlidersOfMesh
                                         : kNoSliders;
  if (const bool one_edit = has_one_edit(view); !same || none_ != none || one_edit_ != one_edit) {
    none_ = none;
    one_edit_ = one_edit;
    rows_.clear();
    size_ = view.size;
    for (const auto& slider : view.sliders) rows_.push_back({slider});
    rebuild();
  }
  for (size_t i = 0; i < rows_.size(); ++i)
    if (!rows_[i].slider->isSliderDown()) show_value(rows_[i], view.sliders[i].value);
}

void SliderPanel::show_live_value(const std::string& parameter, double value) {
  for (Row& row : rows_)
    if (row.of.name == parameter && !row.slider->isSliderDown()) show_value(row, value);
}

void SliderPanel::rebuild() {
  auto* content = new QWidget;
  auto* column = new QVBoxLayout(content);
  column->setSpacing(4);
  if (rows_.empty()) {
    auto* none = new QLabel(text(none_ ? none_ : kNoSliders));
    none->setWordWrap(true);
    column->addWidget(none);
  }
  setWidget(content);
  for (size_t i = 0; i < rows_.size(); ++i) add_row(i);
  column->addStretch();
}

void SliderPanel::add_row(size_t i) {
  auto* column = static_cast<QVBoxLayout*>(widget()->layout());
  auto* controls = new QHBoxLayout;
  auto* label = new QLabel(label_of(rows_[i].of.name, one_edit_));
  auto* number = new QDoubleSpinBox;
  number->setDecimals(4);
  const QString unit = shown(rows_[i].of.unit);
  number->setSuffix(unit.isEmpty() || unit == "°" ? unit : " " + unit);
  number->setRange(std::max(rows_[i].of.min, -1e12), std::min(rows_[i].of.max, 1e12));
  number->setKeyboardTracking(false);
  number->setEnabled(!rows_[i].of.driven);
  number->setFixedWidth(kNumberWidth);
  input_filter_.watch(number);
  auto* slider = new QSlider(Qt::Horizontal);
  jump_to_press(slider);
  slider->setRange(0, kSteps);
  slider->setEnabled(!rows_[i].of.driven);
  slider->setObjectName("slider " + shown(rows_[i].of.name));
  controls->addWidget(slider, 1);
  controls->addWidget(number);
  column->addWidget(label);
  column->addLayout(controls);
  rows_[i].slider = slider;
  rows_[i].number = number;
  extend_range(rows_[i], rows_[i].of.value);
  const std::string name = rows_[i].of.name;
  QObject::connect(slider, &QSlider::valueChanged, this, [this, i, name](int step) {
    if (showing_) return;
    Row& row = rows_[i];
    const double value = value_at(step, row.low, row.high);
    post_({.kind = CommandKind::SetSlider, .key = name, .value = value});
    showing_ = true;
    row.number->setValue(value);
    showing_ = false;
    if (!row.slider->isSliderDown()) post_({.kind = CommandKind::SolveToEquilibrium});
  });
  QObject::connect(slider, &QSlider::sliderReleased, this, [this, i] {
    extend_range(rows_[i], rows_[i].number->value());
    post_({.kind = CommandKind::SolveToEquilibrium});
  });
  QObject::connect(number, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this,
                   [this, name](double value) {
                     if (showing_) return;
                     post_({.kind = CommandKind::SetSlider, .key = name, .value = value});
                     post_({.kind = CommandKind::SolveToEquilibrium});
                   });
}

// Sets the range of the slider to that of the parameter. If a bound is open, the range is ± max(10,
// 2 |value|) or, for coordinates, a quarter of the surface size on both sides of the value.
void SliderPanel::extend_range(Row& row, double value) {
  constexpr double usual = 10;
  const std::string& name = row.of.name;
  const bool coordinate = name.size() > 2 && name[name.size() - 2] == '.' && name.back() >= 'x';
  const double reach = coordinate && size_ > 0 ? size_ / 4 : std::max(usual, 2 * std::abs(value));
  const double middle = coordinate ? value : 0;
  row.low = std::isfinite(row.of.min) ? row.of.min : middle - reach;
  row.high = std::isfinite(row.of.max) ? row.of.max : middle + reach;
}

void SliderPanel::show_value(Row& row, double value) {
  showing_ = true;
  if (value < row.low || value > row.high) extend_range(row, value);
  row.slider->setValue(static_cast<int>(
      std::lround(kSteps * (value - row.low) / std::max(row.high - row.low, 1e-300))));
  row.number->setSingleStep((row.high - row.low) / 100);
  row.number->setValue(value);
  showing_ = false;
}

QSlider* SliderPanel::slider(const std::string& parameter) const {
  for (const Row& row : rows_)
    if (row.of.name == parameter) return row.slider;
  return nullptr;
}

QDoubleSpinBox* SliderPanel::number(const std::string& parameter) const {
  for (const Row& row : rows_)
    if (row.of.name == parameter) return row.number;
  return nullptr;
}

// Frames.

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
