// How a long computation tells where it is, and how it is stopped.
#pragma once

#include <functional>
#include <string_view>

#include "batten/core/errors.h"

namespace batten {

/// What the caller of a long computation hands down; an empty one reports nothing, never cancels.
struct Progress {
  /// Called with the name of the stage and the fraction of it that is done, 0 to 1.
  std::function<void(std::string_view stage, double fraction)> report;
  /// Asked now and then; true stops the computation with CancelledError.
  std::function<bool()> cancelled;

  void at(std::string_view stage, double fraction) const {
    if (cancelled && cancelled()) throw CancelledError();
    if (report) report(stage, fraction);
  }
};

}  // namespace batten
