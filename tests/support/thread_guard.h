// Tests on one thread and on several.
#pragma once

#include "batten/core/parallel.h"

namespace batten_test {

/// Leaves the number of threads as it was found: as many as cores.
struct ThreadGuard {
  ThreadGuard() = default;
  /// Sets the number meanwhile.
  explicit ThreadGuard(int count) { batten::set_thread_count(count); }
  ThreadGuard(const ThreadGuard&) = delete;
  ~ThreadGuard() { batten::set_thread_count(0); }
};

}  // namespace batten_test
