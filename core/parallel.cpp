// SPDX-License-Identifier: MPL-2.0
#include "batten/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"

#if defined(__linux__)
#include <pthread.h>
#include <sched.h>
#include <unistd.h>
#endif

namespace batten {
namespace {

std::atomic<int> requested_threads{0};

// Pool of threads that sleep between calls, because starting new threads would cost more than many
// a solve, and memory. A call never waits for a sleeping thread, only for those that took a part.
// The pool is never destroyed: its threads end with the process, even if destructors of other
// objects still use it.
class Pool {
 public:
  // Runs `work` on the caller and on up to `helpers` threads. Returns false if another call is
  // active (perhaps the caller's own) or if this is a forked process, which has none of the
  // threads. The caller must then do all the work itself.
  bool run(int helpers, const std::function<void()>& work) {
    if (process_ != this_process() || busy_.exchange(true)) return false;
    {
      const std::lock_guard lock(mutex_);
      start_threads(helpers);
      work_ = &work;
      wanted_ = std::min(helpers, isize(threads_));
      helpers = wanted_;
      avoid_core_of_caller();
    }
    for (int i = 0; i < helpers; ++i) work_available_.notify_one();
    work();
    {
      std::unique_lock lock(mutex_);
      wanted_ = 0;
      // The caller polls while it waits, so that the threads learn of a cancellation.
      constexpr auto poll_interval = std::chrono::milliseconds(2);
      while (!finished_.wait_for(lock, poll_interval, [this] { return active_ == 0; })) {
        lock.unlock();
        is_cancelled();
        lock.lock();
      }
    }
    busy_ = false;
    return true;
  }

 private:
  void start_threads(int count) {
    try {
      while (isize(threads_) < count) threads_.emplace_back([this] { serve(); });
    } catch (const std::exception&) {
      // The system provides no more threads or memory: continue with those that exist.
    }
  }

  // After an idle period, the system tends to wake a thread on the core of its waker, where it
  // waits until the caller pauses. A drag at 60 events per second would then use one core only.
  void avoid_core_of_caller() {
#if defined(__linux__)
    cpu_set_t others;
    const int core = sched_getcpu();
    if (core < 0 || core >= CPU_SETSIZE) return;
    if (core == avoided_core_ && pinned_threads_ == threads_.size()) return;
    if (sched_getaffinity(0, sizeof others, &others) != 0) return;
    CPU_CLR(core, &others);
    if (CPU_COUNT(&others) == 0) return;
    for (auto& t : threads_) pthread_setaffinity_np(t.native_handle(), sizeof others, &others);
    avoided_core_ = core;
    pinned_threads_ = threads_.size();
#endif
  }

  static long this_process() {
#if defined(__linux__)
    return getpid();
#else
    return 0;
#endif
  }

  void serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
      work_available_.wait(lock, [this] { return wanted_ > 0; });
      --wanted_;
      ++active_;
      lock.unlock();
      (*work_)();
      lock.lock();
      if (--active_ == 0) finished_.notify_one();
    }
  }

  const long process_ = this_process();
  std::atomic<bool> busy_{false};
  std::mutex mutex_;
  std::condition_variable work_available_, finished_;
  std::vector<std::thread> threads_;
  const std::function<void()>* work_ = nullptr;
  int wanted_ = 0, active_ = 0;
  int avoided_core_ = -1;
  std::size_t pinned_threads_ = 0;
};

}  // namespace

int core_count() {
  // The query takes microseconds, so it is done once.
  static const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return cores;
}

int thread_count() {
  const int chosen = requested_threads.load();
  return chosen > 0 ? chosen : core_count();
}

void set_thread_count(int count) { requested_threads = std::max(0, count); }

void parallel_for(int parts, const std::function<void(int)>& work) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const detail::CurrentProgress progress = detail::current_progress();
  const std::thread::id caller = std::this_thread::get_id();
  const auto run = [&] {
    const bool calls_back = progress.calls_back && std::this_thread::get_id() == caller;
    const detail::ProgressLink link({progress.state, calls_back});
    for (int part = next++; part < parts; part = next++) {
      try {
        throw_if_cancelled();
        work(part);
      } catch (...) {
        if (progress.state && progress.state->cancelled) next = parts;
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  static Pool& pool = *new Pool;
  const int helpers = std::min(parts, thread_count()) - 1;
  if (helpers < 1 || !pool.run(helpers, std::ref(run))) run();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace batten
