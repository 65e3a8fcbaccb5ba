#include "batten/io/files/sandboxed_read.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace {

std::atomic<bool> sandbox_enabled = false;

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kMemoryIsLimited = false;  // the sanitizer reserves terabytes of address space
#else
constexpr bool kMemoryIsLimited = true;
#endif

// First byte that the child sends: the outcome.
enum class Outcome : char { Bytes = 'b', Refused = 'r', NoMemory = 'm', Failed = 'f' };

struct Limits {
  rlim_t seconds, bytes;  // processor time, memory
  rlim_t by_the_clock() const { return 4 * seconds; }
};

Limits limits_for(const std::filesystem::path& file, int times) {
  const double megabytes = static_cast<double>(input_file_size(file)) / 1048576;
  return {static_cast<rlim_t>(times * (6 + std::ceil(4 * megabytes))),
          (rlim_t{1} << 30) + static_cast<rlim_t>(200 * 1048576 * megabytes)};
}

// Size of the address space of this process in bytes.
rlim_t addresses_in_use() {
  long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%ld", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return static_cast<rlim_t>(pages) * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int resource, rlim_t most) {
  rlimit now{};
  if (::getrlimit(static_cast<__rlimit_resource_t>(resource), &now) != 0) return;
  now.rlim_cur = now.rlim_max == RLIM_INFINITY ? most : std::min(most, now.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource_t>(resource), &now);
}

bool write_all(int to, const char* bytes, size_t count) {
  while (count > 0) {
    const ssize_t done = ::write(to, bytes, count);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    bytes += done;
    count -= static_cast<size_t>(done);
  }
  return true;
}

// Runs in the child: reads, sends the outcome and the bytes, and exits without destructors.
[[noreturn]] void run_child(int to, pid_t parent, const Limits& limits,
                            const std::function<std::string()>& read) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL,
                           SIGABRT, SIGXCPU, SIGPIPE, SIGALRM})
    ::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.seconds);
  // A lock that another thread held during the fork is never released, and waiting for it uses no
  // processor time. So elapsed time must be limited, too.
  ::alarm(static_cast<unsigned>(limits.by_the_clock()));
  if (kMemoryIsLimited) limit(RLIMIT_AS, addresses_in_use() + limits.bytes);
  if (const int nothing = ::open("/dev/null", O_RDWR); nothing >= 0) {
    ::dup2(nothing, STDOUT_FILENO);
    ::dup2(nothing, STDERR_FILENO);
  }
  Outcome outcome = Outcome::Bytes;
  std::string bytes;
  sandbox_enabled = false;  // nested reads run in this process
  try {
    bytes = read();
  } catch (const InputError& error) {
    outcome = Outcome::Refused;
    bytes = error.what();
  } catch (const std::bad_alloc&) {
    outcome = Outcome::NoMemory;
  } catch (const std::exception& error) {
    outcome = Outcome::Failed;
    bytes = error.what();
  } catch (...) {
    outcome = Outcome::Failed;
  }
  const char first = static_cast<char>(outcome);
  ::_exit(write_all(to, &first, 1) && write_all(to, bytes.data(), bytes.size()) ? 0 : 1);
}

std::string read_all(int from) {
  std::string all;
  std::string part(1 << 16, '\0');
  for (;;) {
    const ssize_t got = ::read(from, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return all;
    all.append(part.data(), static_cast<size_t>(got));
  }
}

int ending_of(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

void enable_sandboxed_read(bool yes) { sandbox_enabled = yes; }
bool is_sandboxed_read_enabled() { return sandbox_enabled; }

std::string sandboxed_read(const std::filesystem::path& file, const std::string& library,
                           const std::function<std::string()>& read, int times) {
  if (!is_sandboxed_read_enabled()) return read();
  const auto fail = [&](const std::string& what) -> void {
    throw InputError(file.string() + ": " + library + " " + what);
  };
  const Limits limits = limits_for(file, times);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw Error(std::string("cannot create a pipe for a child process: ") + std::strerror(errno));
  const pid_t parent = ::getpid(), child = ::fork();
  if (child == 0) run_child(ends[1], parent, limits, read);
  const int fork_error = errno;
  ::close(ends[1]);
  std::string all = child > 0 ? read_all(ends[0]) : std::string();
  ::close(ends[0]);
  if (child < 0)
    throw Error(std::string("cannot create a child process: ") + std::strerror(fork_error));
  const int status = ending_of(child);
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    if (number == SIGINT || number == SIGTERM || number == SIGHUP) throw CancelledError();
    if (number == SIGXCPU || number == SIGALRM || number == SIGKILL)
      fail("did not finish reading this file within " +
           std::to_string(number == SIGALRM ? limits.by_the_clock() : limits.seconds) +
           " s: it is damaged, or too large");
    fail(std::string("crashes while reading this file (") + ::strsignal(number) +
         "): it is damaged");
  }
  if (all.empty()) fail("terminates while reading this file: it is damaged");
  const auto outcome = static_cast<Outcome>(all[0]);
  all.erase(0, 1);
  switch (outcome) {
    case Outcome::Bytes:
      if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        fail("could not return the contents of this file");
      return all;
    case Outcome::Refused:
      throw InputError(all);
    case Outcome::NoMemory:
      fail("requires more than " + std::to_string(limits.bytes >> 20) +
           " MB for this file: it is damaged, or too large");
      break;
    case Outcome::Failed:
      fail("cannot read this file: " + all);
  }
  return {};
}

}  // namespace batten
