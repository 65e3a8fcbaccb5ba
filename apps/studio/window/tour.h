// SPDX-License-Identifier: MPL-2.0
// Guided tour of the window, on the door-panel example.
#pragma once

#include <QFrame>

#include "batten/apps/studio/view/shape_actors.h"

class QLabel;
class QPushButton;

namespace batten::studio {

/// A card over the view that suggests the next step and continues when it is done. It detects this
/// from the state of the document and the window; a button skips a step.
class Tour : public QFrame {
 public:
  explicit Tour(QWidget* view);

  /// State from which the tour detects what the user has done.
  struct Observation {
    double swell = 0;  ///< the door's parameter
    int pushes = 0;    ///< number of point loads
    bool can_redo = false, line_selected = false;
    Shading shading = Shading::Shaded;
  };
  /// Continues with the next step if the current one is done.
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
  Observation now_, start_;  // current state, and state at the start of the step
};

/// Scene file of the example: next to an installed program, or in the source tree.
QString tour_scene();

}  // namespace batten::studio
