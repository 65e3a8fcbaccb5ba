// The few cores of one machine, used without changing a single bit of the result.
#pragma once

#include <functional>

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

}  // namespace batten
