#include "batten/apps/studio/window/tour.h"

#include <QCoreApplication>
#include <QEvent>
#include <QFile>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>
#include <iterator>

#include "batten/apps/studio/view/texts.h"

namespace batten::studio {
namespace {

constexpr int kCardWidth = 330, kMargin = 14;

}  // namespace

/// Words, and whether the step is done since it began.
struct Tour::Step {
  const char* words;
  bool (*done)(const Sight& now, const Sight& start);
};

const Tour::Step Tour::steps[] = {
    {kTourStart, nullptr},
    {kTourSlider, [](const Sight& now, const Sight& start) { return now.swell != start.swell; }},
    {kTourPush, [](const Sight& now, const Sight& start) { return now.pushes > start.pushes; }},
    {kTourZebra, [](const Sight& now, const Sight&) { return now.shading == Shading::Zebra; }},
    {kTourStress, [](const Sight& now, const Sight&) { return now.shading == Shading::Stress; }},
    {kTourUndo, [](const Sight& now, const Sight&) { return now.can_redo; }},
    {kTourChoose, [](const Sight& now, const Sight&) { return now.line_chosen; }},
    {kTourEnd, nullptr},
};

Tour::Tour(QWidget* view)
    : QFrame(view),
      words_(new QLabel),
      count_(new QLabel),
      next_(new QPushButton(text(kTourNext))) {
  setObjectName("tour");
  setAutoFillBackground(true);
  setFrameShape(QFrame::StyledPanel);
  setFixedWidth(kCardWidth);
  words_->setWordWrap(true);
  auto* column = new QVBoxLayout(this);
  auto* row = new QHBoxLayout;
  auto* end = new QPushButton(text(kTourClose));
  row->addWidget(count_, 1);
  row->addWidget(end);
  row->addWidget(next_);
  column->addWidget(words_);
  column->addLayout(row);
  QObject::connect(next_, &QPushButton::clicked, this, [this] { show_step(step_ + 1); });
  QObject::connect(end, &QPushButton::clicked, this, [this] { deleteLater(); });
  view->installEventFilter(this);
  show_step(0);
  show();
}

// In the lower right corner: words and scales of the view are on the left, its axes above.
void Tour::place() {
  adjustSize();
  move(parentWidget()->width() - width() - kMargin,
       parentWidget()->height() - height() - kMargin);
}

bool Tour::eventFilter(QObject* view, QEvent* event) {
  if (event->type() == QEvent::Resize) place();
  return QFrame::eventFilter(view, event);
}

void Tour::show_step(int step) {
  const int count = static_cast<int>(std::size(steps));
  if (step >= count) return deleteLater();
  step_ = step;
  start_ = now_;
  words_->setText(text(steps[step].words));
  count_->setText(QString("%1 / %2").arg(step + 1).arg(count));
  next_->setText(text(step + 1 < count ? kTourNext : kTourDone));
  place();
}

void Tour::look(const Sight& sight) {
  now_ = sight;
  const Step& step = steps[step_];
  if (step.done && step.done(now_, start_)) show_step(step_ + 1);
}

QString tour_scene() {
  const QString installed =
      QCoreApplication::applicationDirPath() + "/../share/batten/door/scene.toml";
  return QFile::exists(installed) ? installed : QString(BATTEN_DOOR);
}

}  // namespace batten::studio
