#include "batten/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#if defined(__linux__)
#include <pthread.h>
#include <sched.h>
#endif

namespace batten {
namespace {

std::atomic<int> chosen_threads{0};

// Threads that sleep between calls: starting new ones would cost more than many a solve, and
// memory. A call never waits for a sleeper, only for those that took a part.
class Pool {
 public:
  ~Pool() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (auto& t : threads_) t.join();
  }

  // False: another call is under way (perhaps the caller's own), take all parts yourself.
  bool run(int helpers, const std::function<void()>& work) {
    if (busy_.exchange(true)) return false;
    {
      const std::lock_guard lock(mutex_);
      while (static_cast<int>(threads_.size()) < helpers)
        threads_.emplace_back([this] { serve(); });
      work_ = &work;
      wanted_ = helpers;
      leave_this_core_to_the_caller();
    }
    for (int i = 0; i < helpers; ++i) wake_.notify_one();
    work();
    {
      std::unique_lock lock(mutex_);
      wanted_ = 0;
      finished_.wait(lock, [this] { return active_ == 0; });
    }
    busy_ = false;
    return true;
  }

 private:
  // A system that has slept tends to wake a thread on the core of its waker, where it waits for
  // the caller to pause: a drag at 60 events a second would run on one core.
  void leave_this_core_to_the_caller() {
#if defined(__linux__)
    const int core = sched_getcpu();
    if (core < 0 || (core == left_core_ && placed_ == threads_.size())) return;
    cpu_set_t others;
    if (sched_getaffinity(0, sizeof others, &others) != 0) return;
    if (core < CPU_SETSIZE) CPU_CLR(core, &others);
    if (CPU_COUNT(&others) == 0) return;
    for (auto& t : threads_) pthread_setaffinity_np(t.native_handle(), sizeof others, &others);
    left_core_ = core;
    placed_ = threads_.size();
#endif
  }

  void serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return stop_ || wanted_ > 0; });
      if (stop_) return;
      --wanted_;
      ++active_;
      lock.unlock();
      (*work_)();
      lock.lock();
      if (--active_ == 0) finished_.notify_one();
    }
  }

  std::atomic<bool> busy_{false};
  std::mutex mutex_;
  std::condition_variable wake_, finished_;
  std::vector<std::thread> threads_;
  const std::function<void()>* work_ = nullptr;
  int wanted_ = 0, active_ = 0;
  bool stop_ = false;
  int left_core_ = -1;
  std::size_t placed_ = 0;
};

}  // namespace

int thread_count() {
  const int chosen = chosen_threads.load();
  return chosen > 0 ? chosen : std::max(1u, std::thread::hardware_concurrency());
}

void set_thread_count(int count) { chosen_threads = std::max(0, count); }

void parallel_parts(int parts, const std::function<void(int)>& work) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto run = [&] {
    for (int part = next++; part < parts; part = next++) {
      try {
        work(part);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  static Pool pool;
  const int helpers = std::min(parts, thread_count()) - 1;
  if (helpers < 1 || !pool.run(helpers, std::ref(run))) run();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace batten
