#include "batten/apps/cli/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>

namespace batten {
namespace {

volatile std::sig_atomic_t interrupted = 0;
bool bar_is_drawn = false;

void interrupt(int signal) {
  if (interrupted) std::signal(signal, SIG_DFL);
  if (interrupted) std::raise(signal);
  interrupted = 1;
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

void catch_interrupts() {
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  std::signal(SIGHUP, interrupt);
}

Progress terminal_progress(bool quiet) {
  Progress progress;
  progress.cancelled = [] { return interrupted != 0; };
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
