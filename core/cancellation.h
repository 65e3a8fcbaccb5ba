// SPDX-License-Identifier: MPL-2.0
// Cancellation of long computations: polls in inner loops, and calls of libraries that cannot poll.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <string_view>

#include "batten/core/progress.h"

namespace batten {

namespace detail {

// The Progress of a scope, and what its polls have found. `failure`: exception that one of its
// functions has thrown; set before `cancelled`.
struct ProgressState {
  const Progress& progress;
  std::atomic<bool> cancelled = false;
  std::exception_ptr failure = nullptr;
};

// State of the current scope of a thread. Only the thread of the scope calls the functions of its
// Progress; other threads that work for it read the state.
struct CurrentProgress {
  ProgressState* state = nullptr;
  bool calls_back = false;
};

// Extends the current scope of one thread to another one, or (without state) suspends the scope of
// this thread. Ends with the object.
class ProgressLink {
 public:
  explicit ProgressLink(CurrentProgress progress);
  ~ProgressLink();
  ProgressLink(const ProgressLink&) = delete;
  ProgressLink& operator=(const ProgressLink&) = delete;

 private:
  CurrentProgress outer_;
};
CurrentProgress current_progress();

}  // namespace detail

/// Makes a Progress the current one of the calling thread while the object exists.
///
/// Long functions of the public interface have a parameter of type Progress. Most of their time is
/// spent in loops many layers below, in part behind callbacks. These loops have no such parameter:
/// they poll the current Progress of their thread.
///
///     MaxValues ShellEvaluator::at(…, const Progress& progress) {
///       const ProgressScope scope(progress);
///       …
///     }
///     void ElementPattern::assemble(…) {
///       for (int e = 0; e < count; ++e) {
///         poll_every<64>(e);  // throws CancelledError
///         …
///
/// parallel_for() extends the scope to its threads and polls before each part. Only the thread of
/// the scope calls the functions of its Progress. The other threads learn from it that the
/// computation was cancelled; from then on, all polls in the scope throw. Of nested scopes, the
/// innermost one counts. A Progress without functions leaves the outer scope in place. Allocates
/// nothing.
class ProgressScope {
 public:
  /// Keeps a reference to `progress`.
  explicit ProgressScope(const Progress& progress);
  ProgressScope(const ProgressScope&) = delete;
  ProgressScope& operator=(const ProgressScope&) = delete;

 private:
  detail::ProgressState state_;
  detail::ProgressLink link_;
};

/// Suspends the current scope of the calling thread while the object exists: computations that must
/// not be cancelled, for example those that restore a state.
class UncancellableScope {
 public:
  UncancellableScope() : link_({}) {}

 private:
  detail::ProgressLink link_;
};

/// Whether the computation of the current scope was cancelled; polls it. For loops that must not
/// throw, because other threads wait for their results: throw_if_cancelled() follows after them. A
/// function of the Progress that throws also cancels the computation.
bool is_cancelled();
/// Throws CancelledError if is_cancelled(), or the exception that a function of the Progress threw.
void throw_if_cancelled();
/// Calls throw_if_cancelled() if `i` is divisible by `interval`, that is in every `interval`-th pass
/// of a loop. An interval of about a millisecond of work makes the cost of the polls negligible.
template <int interval>
void poll_every(long i) {
  if (i % interval == 0) throw_if_cancelled();
}

/// Reports the completed fraction (0 to 1) of a stage to the Progress of the current scope. Never
/// throws. Has no effect on threads that work for the thread of the scope.
void report_progress(std::string_view stage, double fraction);
/// Reports the completed fraction (0 to 1) of a stage as report_progress() does. Then throws as
/// throw_if_cancelled() does.
void update_progress(std::string_view stage, double fraction);

/// Calls `work` once, for example a function of a library that cannot poll, and rethrows its
/// exceptions. Within a scope that can be cancelled, `work` runs on a thread of its own, while the
/// calling thread polls every 2 ms.
///
/// After a cancellation, CancelledError is thrown at once, and `work` continues unattended. It must
/// therefore own, or share, all data that it reads or writes. At most two calls continue unattended
/// at a time: further calls wait for one of these to end.
void call_without_polls(const std::function<void()>& work);

}  // namespace batten
