// SPDX-License-Identifier: MPL-2.0
// Progress reports and cancellation of long computations.
#pragma once

#include <functional>
#include <string_view>

#include "batten/core/errors.h"

namespace batten {

/// Progress and cancellation callbacks for long computations. An empty `report` reports nothing;
/// with an empty `cancelled` the computation cannot be cancelled.
struct Progress {
  /// Called with the name of the current stage and the completed fraction of this stage, 0 to 1.
  std::function<void(std::string_view stage, double fraction)> report;
  /// True if the user has cancelled the computation, which then throws CancelledError. Called
  /// regularly, possibly by several threads at once.
  std::function<bool()> cancelled;

  /// Reports the completed fraction (0 to 1) of a stage of the computation. Throws CancelledError
  /// if the computation was cancelled.
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
