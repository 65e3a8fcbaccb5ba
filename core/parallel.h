// SPDX-License-Identifier: MPL-2.0
// Multithreading on one machine, with results that are bit-identical for any number of threads.
#pragma once

#include <algorithm>
#include <functional>
#include <thread>

#include "batten/core/cancellation.h"

namespace batten {

/// Number of CPU cores that the process may use.
int core_count();

/// Number of threads that Batten uses (default: the number of cores). Results do not depend on this
/// number: work is split such that every sum is always accumulated in the same order.
int thread_count();
/// Sets the number of threads, 1 or more; 0 restores the default, the number of cores.
void set_thread_count(int count);

/// Calls `work(part)` once for each part = 0 … parts-1 on up to thread_count() threads, and returns
/// when all calls have finished.
///
/// The first exception thrown by a part is rethrown here, after the other parts have finished. The
/// threads are kept for the next call and sleep in between. Nested calls, concurrent calls and calls
/// in a forked process run all parts in the calling thread.
///
/// Polls the current ProgressScope (cancellation.h) before each part, and while the calling thread
/// waits for the others. After a cancellation, the remaining parts are not called, and
/// CancelledError is thrown. Parts that wait for each other must use is_cancelled() and must not
/// throw.
void parallel_for(int parts, const std::function<void(int part)>& work);

// Parallel loops over many small items.

/// Calls work(first, last) in parallel for consecutive ranges [first, last) of 0 … count - 1, with
/// at most `chunk` items each. Ranges do not depend on the number of threads. Allocates nothing.
template <int chunk = 4096, class Work>
void parallel_chunks(long count, const Work& work) {
  const int parts = static_cast<int>((count + chunk - 1) / chunk);
  if (parts <= 1) {
    work(0L, count);
    return;
  }
  parallel_for(parts, [&](int p) {
    work(static_cast<long>(p) * chunk, std::min<long>(count, static_cast<long>(p + 1) * chunk));
  });
}

/// Calls work(i) in parallel for i = 0 … count - 1, in chunks of `chunk` items.
template <int chunk, class Work>
void parallel_for_each(int count, const Work& work) {
  parallel_chunks<chunk>(count, [&](long first, long last) {
    for (int i = static_cast<int>(first); i < last; ++i) work(i);
  });
}

// Waiting for another thread that is about to finish.

/// Spin-wait with back-off: the first 2,000 waits only pause the processor, later ones yield the
/// core to other threads.
class SpinWait {
 public:
  void wait() {
    if (--spins_left_ > 0) {
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    } else {
      std::this_thread::yield();
    }
  }
  /// Waits as wait() does, and polls the current ProgressScope in every 256th call, so that the
  /// other thread learns of a cancellation.
  void wait_and_poll() {
    wait();
    if (spins_left_ % 256 == 0) is_cancelled();
  }

 private:
  int spins_left_ = 2000;
};

}  // namespace batten
