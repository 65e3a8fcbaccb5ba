#include "batten/apps/cli/terminal.h"

#include <semaphore.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <thread>

#include "batten/io/files/temporary_file_guard.h"

namespace batten {
namespace {

std::atomic<bool> signal_came = false;
std::atomic<bool> bar_is_drawn = false;
sem_t signals;  // one up for each signal: all that a handler may do

void count_signal(int) {
  signal_came = true;
  sem_post(&signals);
}

// Waits for a signal and for the work to stop; ends the program where it does not.
void watch(int exit_code) {
  while (sem_wait(&signals) != 0) {
  }
  timespec until{};
  clock_gettime(CLOCK_REALTIME, &until);
  until.tv_nsec += 300'000'000;
  until.tv_sec += until.tv_nsec / 1'000'000'000;
  until.tv_nsec %= 1'000'000'000;
  sem_timedwait(&signals, &until);
  remove_temporary_files();
  end_progress();
  std::fputs("batten: cancelled\n", stderr);
  std::_Exit(exit_code);
}

void draw(std::string_view stage, double fraction) {
  constexpr int kWidth = 30;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const int done = static_cast<int>(fraction * kWidth);
  const std::string bar = std::string(done, '#') + std::string(kWidth - done, '.');
  // "\033[K" wipes what a longer line before left.
  std::fprintf(stderr, "\r[%s] %3.0f %%  %.*s\033[K", bar.c_str(), 100 * fraction,
               static_cast<int>(std::min<size_t>(stage.size(), 40)), stage.data());
  std::fflush(stderr);
  bar_is_drawn = true;
}

}  // namespace

void catch_interrupts(int exit_code) {
  sem_init(&signals, 0, 0);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, count_signal);
  std::thread(watch, exit_code).detach();
}

bool interrupted() { return signal_came; }

Progress terminal_progress(bool quiet) {
  Progress progress;
  progress.cancelled = interrupted;
  if (quiet || !isatty(STDERR_FILENO)) return progress;
  using Clock = std::chrono::steady_clock;
  progress.report = [next = Clock::now() + std::chrono::seconds(1), last = std::string()](
                        std::string_view stage, double fraction) mutable {
    const auto now = Clock::now();
    // A new stage shows at once when there is a bar already: it may be a long one without steps.
    if (now < next && !(bar_is_drawn && stage != last)) return;
    draw(stage, fraction);
    last = stage;
    next = now + std::chrono::milliseconds(100);
  };
  return progress;
}

void end_progress() {
  if (bar_is_drawn) std::fprintf(stderr, "\r\033[K");
  bar_is_drawn = false;
}

}  // namespace batten
