// SPDX-License-Identifier: MPL-2.0
#include "batten/core/cancellation.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

namespace batten {

namespace detail {

namespace {

thread_local CurrentProgress current;

}  // namespace

CurrentProgress current_progress() { return current; }

ProgressLink::ProgressLink(CurrentProgress progress) : outer_(current) { current = progress; }

ProgressLink::~ProgressLink() { current = outer_; }

}  // namespace detail

using detail::CurrentProgress;
using detail::ProgressState;

ProgressScope::ProgressScope(const Progress& progress)
    : state_{progress},
      link_(progress.cancelled || progress.report ? CurrentProgress{&state_, true}
                                                  : detail::current_progress()) {}

namespace {

void cancel_by_exception(ProgressState& state) {
  state.failure = std::current_exception();
  state.cancelled.store(true, std::memory_order_release);
}

}  // namespace

bool is_cancelled() {
  const auto [state, calls_back] = detail::current_progress();
  if (!state) return false;
  if (state->cancelled.load(std::memory_order_acquire)) return true;
  if (!calls_back || !state->progress.cancelled) return false;
  try {
    if (!state->progress.cancelled()) return false;
    state->cancelled.store(true, std::memory_order_release);
  } catch (...) {
    cancel_by_exception(*state);
  }
  return true;
}

void throw_if_cancelled() {
  if (!is_cancelled()) return;
  if (const auto& failure = detail::current_progress().state->failure)
    std::rethrow_exception(failure);
  throw CancelledError();
}

void report_progress(std::string_view stage, double fraction) {
  const auto [state, calls_back] = detail::current_progress();
  if (!state || !calls_back || !state->progress.report || state->cancelled) return;
  try {
    state->progress.report(stage, fraction);
  } catch (...) {
    cancel_by_exception(*state);
  }
}

void update_progress(std::string_view stage, double fraction) {
  throw_if_cancelled();
  report_progress(stage, fraction);
}

namespace {

constexpr auto kPollInterval = std::chrono::milliseconds(2);
// Each of them may use as much memory as a symbolic analysis.
constexpr int kMaxUnattended = 2;

// Number of calls of call_without_polls() that nobody waits for any more.
std::atomic<int> unattended{0};

struct UnpolledCall {
  std::function<void()> work;
  std::mutex mutex;
  std::condition_variable ended;
  bool has_ended = false, is_attended = true;
  std::exception_ptr failure;

  void run() {
    std::exception_ptr thrown;
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
    work = nullptr;  // releases its data on this thread: freeing gigabytes takes long
    const std::lock_guard lock(mutex);
    failure = thrown;
    has_ended = true;
    if (!is_attended) --unattended;
    ended.notify_one();
  }
  // Returns true if the call has ended within the time.
  bool wait() {
    std::unique_lock lock(mutex);
    return ended.wait_for(lock, kPollInterval, [this] { return has_ended; });
  }
  void abandon() {
    const std::lock_guard lock(mutex);
    is_attended = false;
    if (!has_ended) ++unattended;
  }
};

}  // namespace

void call_without_polls(const std::function<void()>& work) {
  const auto [state, calls_back] = detail::current_progress();
  if (!state || !state->progress.cancelled) {
    work();
    return;
  }
  while (unattended >= kMaxUnattended) {
    throw_if_cancelled();
    std::this_thread::sleep_for(kPollInterval);
  }
  throw_if_cancelled();
  const auto call = std::make_shared<UnpolledCall>();
  call->work = work;
  try {
    std::thread([call] { call->run(); }).detach();
  } catch (const std::system_error&) {  // the system provides no more threads
    work();
    return;
  }
  while (!call->wait())
    if (is_cancelled()) {
      call->abandon();
      throw_if_cancelled();
    }
  if (call->failure) std::rethrow_exception(call->failure);
}

}  // namespace batten
