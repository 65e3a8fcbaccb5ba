#include "batten/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace batten {
namespace {
std::atomic<int> chosen_threads{0};
}

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
  std::vector<std::thread> others;
  for (int i = 1; i < std::min(parts, thread_count()); ++i) others.emplace_back(run);
  run();
  for (auto& t : others) t.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace batten
