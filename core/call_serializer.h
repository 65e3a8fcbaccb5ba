// SPDX-License-Identifier: MPL-2.0
// Mutual exclusion of calls on one object, which also detects calls from inside of a call.
#pragma once

#include <atomic>
#include <mutex>
#include <thread>

#include "batten/core/errors.h"

namespace batten {

/// Serialises the calls of several threads on one object.
class CallSerializer {
 public:
  /// Calls function() while no other thread is in a call. Throws Error if this thread is in a
  /// call already, as when a progress callback uses its own object.
  template <class Function>
  auto operator()(const Function& function) {
    if (owner_.load() == std::this_thread::get_id())
      throw Error(
          "found a call from inside of another call of the same object, expected it after that");
    const std::lock_guard lock(mutex_);
    const OwnerScope mine(owner_);
    return function();
  }

 private:
  struct OwnerScope {
    explicit OwnerScope(std::atomic<std::thread::id>& of) : owner(of) {
      owner = std::this_thread::get_id();
    }
    ~OwnerScope() { owner = std::thread::id(); }
    OwnerScope(const OwnerScope&) = delete;
    std::atomic<std::thread::id>& owner;
  };
  std::mutex mutex_;
  std::atomic<std::thread::id> owner_{};
};

}  // namespace batten
