// SPDX-License-Identifier: MPL-2.0
// Tests on one thread and on several.
#pragma once

#include "batten/core/parallel.h"

namespace batten_test {

/// Restores the default number of threads: one per core.
struct ThreadGuard {
  ThreadGuard() = default;
  /// Sets the number for its lifetime.
  explicit ThreadGuard(int count) { batten::set_thread_count(count); }
  ThreadGuard(const ThreadGuard&) = delete;
  ~ThreadGuard() { batten::set_thread_count(0); }
};

}  // namespace batten_test
