// SPDX-License-Identifier: MPL-2.0
#include "batten/core/parallel.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "batten/tests/support/catch.h"
#include "batten/tests/support/thread_guard.h"

#if defined(__linux__)
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#endif

using namespace batten;
using namespace batten_test;

TEST_CASE("thread_count is what was set, and the number of cores after 0", "[core][parallel]") {
  const ThreadGuard guard;
  const int cores = thread_count();
  CHECK(cores >= 1);
  set_thread_count(3);
  CHECK(thread_count() == 3);
  set_thread_count(0);
  CHECK(thread_count() == cores);
}

TEST_CASE("parallel_parts calls every part exactly once, on any number of threads",
          "[core][parallel]") {
  const ThreadGuard guard;
  for (const int threads : {1, 2, 3, 8})
    for (const int parts : {0, 1, 2, 7, 1000}) {
      set_thread_count(threads);
      std::vector<std::atomic<int>> calls(parts);
      parallel_for(parts, [&](int part) { ++calls.at(part); });
      int wrong = 0;
      for (const auto& c : calls) wrong += c != 1;
      CHECK(wrong == 0);
    }
}

TEST_CASE("one thread is the caller's own, in order", "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(1);
  std::vector<int> order;
  std::set<std::thread::id> who;
  parallel_for(5, [&](int part) {
    order.push_back(part);
    who.insert(std::this_thread::get_id());
  });
  CHECK(order == std::vector<int>{0, 1, 2, 3, 4});
  CHECK(who == std::set<std::thread::id>{std::this_thread::get_id()});
}

TEST_CASE("no more threads work than thread_count", "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(2);
  std::mutex mutex;
  std::set<std::thread::id> who;
  parallel_for(200, [&](int) {
    const std::lock_guard lock(mutex);
    who.insert(std::this_thread::get_id());
  });
  CHECK(who.size() <= 2);
}

TEST_CASE("an exception of a part reaches the caller, after the other parts are done",
          "[core][parallel]") {
  const ThreadGuard guard;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    std::atomic<int> done{0};
    std::string message;
    try {
      parallel_for(50, [&](int part) {
        if (part == 20) throw std::runtime_error("part 20");
        ++done;
      });
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    CHECK(message == "part 20");
    CHECK(done == 49);
  }
}

TEST_CASE("threads are used again and again, for calls too short to wake them",
          "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(4);
  long sum = 0;
  for (int call = 0; call < 20000; ++call) {
    std::atomic<int> parts{0};
    parallel_for(3, [&](int part) { parts += part + 1; });
    sum += parts;
  }
  CHECK(sum == 20000 * 6);
}

namespace {

// Two tasks that wait for each other: true if two threads executed them.
bool two_threads_work() {
  std::atomic<int> started{0};
  std::atomic<bool> together{true};
  parallel_for(2, [&](int) {
    ++started;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (started < 2 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    if (started < 2) together = false;
  });
  return together;
}

}  // namespace

TEST_CASE("the second thread comes, also after an exception, a nested call, two callers",
          "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(2);
  REQUIRE(two_threads_work());
  CHECK_THROWS_AS(parallel_for(4, [](int) { throw std::runtime_error("each"); }),
                  std::runtime_error);
  REQUIRE(two_threads_work());
  parallel_for(2, [](int) { parallel_for(2, [](int) {}); });
  REQUIRE(two_threads_work());
  std::thread other([] { parallel_for(100, [](int) {}); });
  parallel_for(100, [](int) {});
  other.join();
  REQUIRE(two_threads_work());
}

TEST_CASE("two callers at once keep their parts apart", "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(3);
  const auto rounds = [](std::atomic<int>& wrong) {
    for (int round = 0; round < 200; ++round) {
      std::vector<std::atomic<int>> calls(6);
      parallel_for(6, [&](int part) {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
        ++calls[part];
      });
      for (const auto& c : calls) wrong += c != 1;
    }
  };
  std::atomic<int> wrong{0};
  std::thread other([&] { rounds(wrong); });
  rounds(wrong);
  other.join();
  CHECK(wrong == 0);
}

TEST_CASE("threads that are there already do not join when fewer are asked for",
          "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(8);
  parallel_for(8, [](int) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
  set_thread_count(2);
  for (int round = 0; round < 20; ++round) {
    std::mutex mutex;
    std::set<std::thread::id> who;
    parallel_for(8, [&](int) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const std::lock_guard lock(mutex);
      who.insert(std::this_thread::get_id());
    });
    CHECK(who.size() <= 2);
  }
}

TEST_CASE("the first exception is the one that is thrown again", "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(1);
  const auto throws = [](int part) {
    if (part == 3 || part == 7) throw std::runtime_error("part " + std::to_string(part));
  };
  CHECK_THROWS_WITH(parallel_for(9, throws), "part 3");
}

TEST_CASE("a part may call parallel_parts, and so may two threads at once", "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(3);
  std::atomic<int> inner{0};
  parallel_for(6, [&](int) { parallel_for(5, [&](int) { ++inner; }); });
  CHECK(inner == 30);

  const auto many = [](std::atomic<long>& sum) {
    for (int call = 0; call < 2000; ++call) parallel_for(4, [&](int part) { sum += part; });
  };
  std::atomic<long> mine{0}, other{0};
  std::thread thread([&] { many(other); });
  many(mine);
  thread.join();
  CHECK(mine == 2000 * 6);
  CHECK(other == 2000 * 6);
}

#if defined(__linux__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("a forked process works alone and ends", "[core][parallel]") {
  const ThreadGuard guard;
  set_thread_count(3);
  std::atomic<int> parts{0};
  parallel_for(8, [&](int) { ++parts; });
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    parallel_for(8, [&](int) { ++parts; });
    // exit() runs the destructors of static objects.
    std::exit(parts == 16 ? 0 : 1);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}
#endif
