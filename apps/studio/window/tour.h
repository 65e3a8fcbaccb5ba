// A tour of the window on the door.
#pragma once

#include <QFrame>

#include "batten/apps/studio/view/shape_actors.h"

class QLabel;
class QPushButton;

namespace batten::studio {

/// A card over the view that says what to try next, and goes on when it was done. What was tried is seen
/// in the document and the window; a button passes a step over.
class Tour : public QFrame {
 public:
  explicit Tour(QWidget* view);

  /// What there is to be seen of what was tried.
  struct Observation {
    double swell = 0;  ///< the door's parameter
    int pushes = 0;    ///< point loads
    bool can_redo = false, line_selected = false;
    Shading shading = Shading::Shaded;
  };
  /// Looks whether the step was done.
  void observe(const Observation& observation);
  int step() const { return step_; }
  QPushButton& next() { return *next_; }

 protected:
  bool eventFilter(QObject* view, QEvent* event) override;

 private:
  struct Step;
  static const Step steps[];
  void show_step(int step);
  void reposition();
  QLabel* description_;
  QLabel* count_;
  QPushButton* next_;
  int step_ = -1;
  Observation now_, start_;  // and as the step began
};

/// The file of the door: beside an installed program, or in the source.
QString tour_scene();

}  // namespace batten::studio
