// Progress reports and cancellation of long computations.
#pragma once

#include <functional>
#include <string_view>

#include "batten/core/errors.h"

namespace batten {

/// Progress and cancellation callbacks for long computations. Both are optional: without them
/// nothing is reported and the computation cannot be cancelled.
struct Progress {
  /// Called with the name of the current stage and its completed fraction, 0 to 1.
  std::function<void(std::string_view stage, double fraction)> report;
  /// Polled regularly, possibly by several threads at once. If it returns true, the computation
  /// stops with CancelledError.
  std::function<bool()> cancelled;

  /// Reports progress. Throws CancelledError if the computation was cancelled.
  void update(std::string_view stage, double fraction) const {
    throw_if_cancelled();
    if (report) report(stage, fraction);
  }
  /// Throws CancelledError if the computation was cancelled.
  void throw_if_cancelled() const {
    if (cancelled && cancelled()) throw CancelledError();
  }
};

}  // namespace batten
