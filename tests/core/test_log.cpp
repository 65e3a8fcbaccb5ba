// SPDX-License-Identifier: MPL-2.0
// Messages of the kernel to a function.
#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "batten/core/log.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

/// Turns the messages off at the end of a test.
struct LogOff {
  LogOff() = default;
  LogOff(const LogOff&) = delete;
  ~LogOff() { set_log({}); }
};

}  // namespace

TEST_CASE("messages are evaluated only if a function receives them", "[core][log]") {
  const LogOff off;
  int evaluated = 0;
  const auto message = [&] { return std::to_string(++evaluated); };
  log(LogLevel::Warning, message);
  CHECK(evaluated == 0);
  std::vector<std::pair<LogLevel, std::string>> seen;
  set_log([&](LogLevel level, std::string_view text) { seen.emplace_back(level, text); });
  log(LogLevel::Warning, message);
  set_log({});
  log(LogLevel::Info, message);
  CHECK(seen == std::vector<std::pair<LogLevel, std::string>>{{LogLevel::Warning, "1"}});
}

TEST_CASE("the function may throw, log, and replace itself", "[core][log]") {
  const LogOff off;
  std::vector<std::string> seen;
  set_log([&](LogLevel, std::string_view text) {
    seen.emplace_back(text);
    log(LogLevel::Info, [] { return std::string("inside"); });
    set_log([&](LogLevel, std::string_view next) { seen.push_back("next " + std::string(next)); });
    throw std::runtime_error("from the function");
  });
  log(LogLevel::Info, [] { return std::string("a"); });
  log(LogLevel::Info, [] { return std::string("b"); });
  CHECK(seen == std::vector<std::string>{"a", "next b"});
}

TEST_CASE("several threads call the function one at a time", "[core][log]") {
  const LogOff off;
  std::atomic<int> inside{0}, calls{0};
  std::atomic<bool> together{false};
  set_log([&](LogLevel, std::string_view) {
    if (++inside > 1) together = true;
    ++calls;
    --inside;
  });
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([] {
      for (int i = 0; i < 500; ++i) log(LogLevel::Debug, [] { return std::string("x"); });
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(calls == 2000);
  CHECK_FALSE(together);
}

TEST_CASE("a factorization is logged with its number of unknowns", "[core][log]") {
  const LogOff off;
  std::string seen;
  set_log([&](LogLevel, std::string_view text) { seen = text; });
  SparseMatrix identity(3, 3);
  identity.setIdentity();
  SparseCholesky cholesky;
  cholesky.factorize(identity);
  CHECK(seen.find("factorization of 3 unknowns") == 0);
}
