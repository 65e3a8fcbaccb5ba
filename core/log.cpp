// SPDX-License-Identifier: MPL-2.0
#include "batten/core/log.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

namespace batten {
namespace {

std::atomic<bool> on{false};
thread_local bool logging = false;  // this thread is in a call of the function

struct Log {
  std::recursive_mutex mutex;  // the function may call set_log()
  std::shared_ptr<const LogFunction> function;
};

// Never destroyed: threads may log while the program ends.
Log& the_log() {
  static Log& log = *new Log;
  return log;
}

}  // namespace

void set_log(LogFunction function) {
  Log& log = the_log();
  auto next = function ? std::make_shared<const LogFunction>(std::move(function)) : nullptr;
  const std::lock_guard lock(log.mutex);
  on = next != nullptr;
  log.function.swap(next);
}

bool detail::log_is_on() { return on.load(std::memory_order_relaxed) && !logging; }

void detail::write_log(LogLevel level, const std::string& message) {
  Log& log = the_log();
  const std::lock_guard lock(log.mutex);
  const auto function = log.function;  // it may be replaced during the call
  if (!function) return;
  logging = true;
  try {
    (*function)(level, message);
  } catch (...) {  // a message must not end the computation
  }
  logging = false;
}

}  // namespace batten
