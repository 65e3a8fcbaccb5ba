// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/window/tour.h"

#include <QCoreApplication>
#include <QEvent>
#include <QFile>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>
#include <iterator>

#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

constexpr int kCardWidth = 330, kMargin = 14;

}  // namespace

/// A step: its text, and whether it is done, compared with the state at its start.
struct Tour::Step {
  const char* description;
  bool (*done)(const Observation& now, const Observation& start);
};

const Tour::Step Tour::steps[] = {
    {kTourStart, nullptr},
    {kTourSlider,
     [](const Observation& now, const Observation& start) { return now.swell != start.swell; }},
    {kTourPush,
     [](const Observation& now, const Observation& start) { return now.pushes > start.pushes; }},
    {kTourZebra,
     [](const Observation& now, const Observation&) { return now.shading == Shading::Zebra; }},
    {kTourStress,
     [](const Observation& now, const Observation&) { return now.shading == Shading::Stress; }},
    {kTourUndo, [](const Observation& now, const Observation&) { return now.can_redo; }},
    {kTourChoose, [](const Observation& now, const Observation&) { return now.line_selected; }},
    {kTourEnd, nullptr},
};

Tour::Tour(QWidget* view)
    : QFrame(view),
      description_(new QLabel),
      count_(new QLabel),
      next_(new QPushButton(text(kTourNext))) {
  setObjectName("tour");
  setAutoFillBackground(true);
  setFrameShape(QFrame::StyledPanel);
  setFixedWidth(kCardWidth);
  description_->setWordWrap(true);
  auto* column = new QVBoxLayout(this);
  auto* row = new QHBoxLayout;
  auto* end = new QPushButton(text(kTourClose));
  row->addWidget(count_, 1);
  row->addWidget(end);
  row->addWidget(next_);
  column->addWidget(description_);
  column->addLayout(row);
  QObject::connect(next_, &QPushButton::clicked, this, [this] { show_step(step_ + 1); });
  QObject::connect(end, &QPushButton::clicked, this, [this] { deleteLater(); });
  view->installEventFilter(this);
  show_step(0);
  show();
}

// Moves the card to the lower right corner: texts and scales of the view are on the left, the axes
// above.
void Tour::reposition() {
  adjustSize();
  move(parentWidget()->width() - width() - kMargin, parentWidget()->height() - height() - kMargin);
}

bool Tour::eventFilter(QObject* view, QEvent* event) {
  if (event->type() == QEvent::Resize) reposition();
  return QFrame::eventFilter(view, event);
}

void Tour::show_step(int step) {
  const int count = static_cast<int>(std::size(steps));
  if (step >= count) return deleteLater();
  step_ = step;
  start_ = now_;
  description_->setText(text(steps[step].description));
  count_->setText(QString("%1 / %2").arg(step + 1).arg(count));
  next_->setText(text(step + 1 < count ? kTourNext : kTourDone));
  reposition();
}

void Tour::observe(const Observation& observation) {
  now_ = observation;
  const Step& step = steps[step_];
  if (step.done && step.done(now_, start_)) show_step(step_ + 1);
}

QString tour_scene() {
  const QString installed =
      QCoreApplication::applicationDirPath() + "/../share/batten/door/scene.toml";
  return QFile::exists(installed) ? installed : QString(BATTEN_DOOR);
}

}  // namespace batten::studio
