// The few cores of one machine, used without changing a single bit of the result.
#pragma once

#include <functional>
#include <algorithm>
#include <thread>

namespace batten {

/// Number of cores of this machine that the process may use.
int core_count();

/// How many threads Batten uses; the number of cores unless set. Results never depend on it: work
/// is split so that every sum is taken in the same order whoever takes it.
int thread_count();
/// Sets the number of threads, 1 or more; 0 returns to the number of cores.
void set_thread_count(int count);

/// Calls `work(part)` for part = 0 … parts-1, each once, on up to thread_count() threads, and
/// returns when all are done. The first exception thrown by a part is thrown again here. The
/// threads are kept for the next call and sleep meanwhile. A call from a part, beside another call,
/// or in a forked process does all parts itself.
void parallel_for(int parts, const std::function<void(int part)>& work);


// Loops over many small things, on several threads.

/// Calls work(first, last) for pieces of 0 … count - 1, each a thread's at a time; allocates
/// nothing.
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

/// The same one by one: calls work(i).
template <int chunk, class Work>
void parallel_for_each(int count, const Work& work) {
  parallel_chunks<chunk>(count, [&](long first, long last) {
    for (int i = static_cast<int>(first); i < last; ++i) work(i);
  });
}


// Waiting for another thread that will be done soon. Internal.

/// A short while without sleep, then the core is offered to others at every turn.
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

 private:
  int spins_left_ = 2000;
};

}  // namespace batten
