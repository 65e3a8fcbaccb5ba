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
  /// Asked now and then, by several threads at once; true stops the computation with CancelledError.
  std::function<bool()> cancelled;

  void update(std::string_view stage, double fraction) const {
    throw_if_cancelled();
    if (report) report(stage, fraction);
  }
  /// Throws CancelledError where the computation is to stop.
  void throw_if_cancelled() const {
    if (cancelled && cancelled()) throw CancelledError();
  }
};

}  // namespace batten
