// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/cli/process.h"

#include <cxxabi.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

// Standard streams and limits.

// As in the GNU core utilities: each stream is opened in the wrong direction.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0 && errno == EBADF)
      ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

// Recursions of libraries, and arrays of Eigen on the stack. All examples run with 384 kB.
constexpr rlim_t kLeastStack = 1 << 20, kWantedStack = 8 << 20;
// A display, the pipes of a reader in another process, and a CAD file that a library reads.
constexpr rlim_t kLeastOpenFiles = 32, kOpenFiles = 256;

// Raises a limit to `wanted` if the system permits. Throws NoSolutionError if it stays below
// `least`.
void raise_limit(__rlimit_resource resource, rlim_t least, rlim_t wanted, const char* found,
                 const char* expected) {
  rlimit limit{};
  if (::getrlimit(resource, &limit) != 0 || limit.rlim_cur >= wanted) return;
  limit.rlim_cur = std::min(wanted, limit.rlim_max);
  if (limit.rlim_cur < least || ::setrlimit(resource, &limit) != 0)
    throw NoSolutionError(std::string("found a limit of ") + found + ", expected " + expected);
}

// The stack of threads, which otherwise is as small as the initial limit of the first one.
void set_stack_of_threads() {
  pthread_attr_t attributes;
  size_t size = 0;
  if (::pthread_getattr_default_np(&attributes) != 0) return;
  if (::pthread_attr_getstacksize(&attributes, &size) == 0 && size < kWantedStack &&
      ::pthread_attr_setstacksize(&attributes, kWantedStack) == 0)
    ::pthread_setattr_default_np(&attributes);
  ::pthread_attr_destroy(&attributes);
}

}  // namespace

void prepare_process() {
  open_standard_streams();
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  raise_limit(RLIMIT_STACK, kLeastStack, kWantedStack, "the stack below 1 MB (ulimit -s)",
              "1 MB or more (ulimit -s 1024)");
  raise_limit(RLIMIT_NOFILE, kLeastOpenFiles, kOpenFiles, "open files below 32 (ulimit -n)",
              "32 or more (ulimit -n 32)");
  set_stack_of_threads();
}

// Interrupts.

namespace {

std::atomic<bool> signal_came = false, time_is_up = false, bar_is_drawn = false;
sem_t signals;  // incremented per signal; sem_post() is async-signal-safe
pid_t process = 0;

void count_signal(int number) {
  (number == SIGXCPU ? time_is_up : signal_came) = true;
  sem_post(&signals);
}

// Waits for a signal, then up to 0.3 s for another one; then ends the program.
void watch() {
  while (sem_wait(&signals) != 0) {
  }
  timespec until{};
  clock_gettime(CLOCK_REALTIME, &until);
  until.tv_nsec += 300'000'000;
  until.tv_sec += until.tv_nsec / 1'000'000'000;
  until.tv_nsec %= 1'000'000'000;
  if (!time_is_up) sem_timedwait(&signals, &until);
  remove_temporary_files();
  end_progress();
  std::fputs(time_is_up ? "batten: the limit of the processor time is reached (ulimit -t)\n"
                        : "batten: cancelled\n",
             stderr);
  std::_Exit(time_is_up ? kNoSolution : kCancelled);
}

// Sends SIGXCPU early enough to remove files before the system kills the process.
void start_timer() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_CPU, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  sigevent event{};
  event.sigev_notify = SIGEV_SIGNAL;
  event.sigev_signo = SIGXCPU;
  timer_t timer{};
  itimerspec at{};
  at.it_value.tv_sec = static_cast<time_t>(std::max<rlim_t>(limit.rlim_cur, 1)) - 1;
  at.it_value.tv_nsec = 700'000'000;
  std::signal(SIGXCPU, count_signal);
  if (::timer_create(CLOCK_PROCESS_CPUTIME_ID, &event, &timer) == 0)
    ::timer_settime(timer, TIMER_ABSTIME, &at, nullptr);
}

// Memory for destructors and messages after the other memory is used up.
void* reserve = nullptr;
constexpr size_t kReserve = 1 << 20;

void use_reserve() {
  std::free(reserve);
  reserve = nullptr;
}

// Replaces std::abort() after exceptions that nobody can handle.
[[noreturn]] void end_at_once() {
  if (::getpid() != process) std::abort();  // a child, whose parent reports the signal
  ::alarm(5);  // seconds; in case that this thread has locked the list of temporary files
  remove_temporary_files();
  std::_Exit(std::current_exception() ? print_failure() : kNoSolution);
}

}  // namespace

void catch_interrupts() {
  process = ::getpid();
  std::set_terminate(end_at_once);
  reserve = std::malloc(kReserve);
  std::set_new_handler([] {
    use_reserve();
    throw std::bad_alloc();
  });
  sem_init(&signals, 0, 0);
  std::thread(watch).detach();
  for (const int number : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(number, count_signal) == SIG_IGN) std::signal(number, SIG_IGN);
  start_timer();
}

bool interrupted() { return signal_came; }

// Output.

namespace {

int output_error = 0;  // errno of the first failure

void flush_output() {
  errno = 0;
  if (output_error == 0 && (!std::cout.flush() || std::fflush(stdout) != 0 || std::ferror(stdout)))
    output_error = errno != 0 ? errno : EIO;
}

}  // namespace

void print(const std::string& text) {
  std::cout << printable(text, LineFeeds::Keep);
  flush_output();  // before other messages, which would flush it, too
}

// Failures.

namespace {

struct Failure {
  ExitCode code;
  std::string message;
};

std::string name_of(const std::exception& error) {
  int status = 0;
  char* name = abi::__cxa_demangle(typeid(error).name(), nullptr, nullptr, &status);
  std::string text = name ? name : typeid(error).name();
  std::free(name);
  return text;
}

Failure failure_of(const std::system_error& error) {
  if (error.code() == std::errc::resource_unavailable_try_again)
    return {kNoSolution,
            "cannot create a thread: " + error.code().message() +
                "; expected higher limits of threads and memory (ulimit -u, ulimit -v, or "
                "those of the container)"};
  return {kNoSolution, std::string("the system refuses an operation: ") + error.what()};
}

Failure current_failure() {
  try {
    throw;
  } catch (const ConflictError& e) {
    return {kConflict, e.what()};
  } catch (const CancelledError& e) {
    return {kCancelled, e.what()};
  } catch (const InputError& e) {
    return {kBadInput, e.what()};
  } catch (const Error& e) {
    return {kNoSolution, e.what()};
  } catch (const std::bad_alloc&) {
    return {kNoSolution, "not enough memory"};
  } catch (const std::length_error& e) {
    return {kNoSolution,
            std::string("not enough memory: a list would be too long (") + e.what() + ")"};
  } catch (const std::filesystem::filesystem_error& e) {
    return {kBadInput, e.path1().string() + ": " + e.code().message()};
  } catch (const std::system_error& e) {
    return failure_of(e);
  } catch (const std::exception& e) {
    return {kNoSolution, "a defect of this program, please report it with the input: " +
                             name_of(e) + ": " + e.what()};
  } catch (...) {
    return {kNoSolution,
            "a defect of this program, please report it with the input: an error of a "
            "library without a message"};
  }
}

}  // namespace

ExitCode print_failure() noexcept {
  end_progress();
  try {
    Failure failure = current_failure();
    // The error may only be due to a file removed after the interrupt.
    if (interrupted()) failure = {kCancelled, CancelledError().what()};
    std::cerr << "batten: " << printable(failure.message, LineFeeds::KeepBeforeIndent) << "\n";
    return failure.code;
  } catch (...) {  // no memory for the message
    std::fputs("batten: not enough memory\n", stderr);
    return kNoSolution;
  }
}

// The end.

void end_process(int code) {
  try {
    remove_temporary_files();
  } catch (const std::exception&) {  // no memory
  }
  flush_output();
  if (output_error != 0) {
    std::fprintf(stderr, "batten: cannot write to the standard output: %s\n",
                 std::strerror(output_error));
    code = kBadInput;
  } else if (code == kDone && (!std::cerr || std::ferror(stderr))) {
    code = kBadInput;  // warnings are lost
  }
#if defined(__SANITIZE_ADDRESS__)
  std::exit(code);  // the search for leaks is an exit handler
#else
  std::_Exit(code);
#endif
}

// The progress bar.

namespace {

void draw(std::string_view stage, double fraction) {
  constexpr int kWidth = 30;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const int done = static_cast<int>(fraction * kWidth);
  const std::string bar = std::string(done, '#') + std::string(kWidth - done, '.');
  // "\033[K" erases the rest of a longer previous line.
  std::fprintf(stderr, "\r[%s] %3.0f %%  %s\033[K", bar.c_str(), 100 * fraction,
               printable(stage.substr(0, 40)).c_str());
  std::fflush(stderr);
  bar_is_drawn = true;
}

}  // namespace

Progress terminal_progress(bool quiet) {
  Progress progress;
  progress.cancelled = interrupted;
  if (quiet || !isatty(STDERR_FILENO)) return progress;
  using Clock = std::chrono::steady_clock;
  progress.report = [next = Clock::now() + std::chrono::seconds(1), last = std::string()](
                        std::string_view stage, double fraction) mutable {
    const auto now = Clock::now();
    // If a bar is drawn already, a new stage shows at once: it may be a long one without progress
    // steps.
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
