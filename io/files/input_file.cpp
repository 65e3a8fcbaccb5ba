// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/input_file.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <new>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/errors.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// Why a file cannot be read, judged by its type; nullptr if it can.
const char* obstacle(const struct stat& found) {
  if (S_ISDIR(found.st_mode)) return "a folder";
  if (S_ISFIFO(found.st_mode)) return "a pipe";
  if (S_ISSOCK(found.st_mode)) return "a socket";
  if (!S_ISREG(found.st_mode)) return "a device";
  return nullptr;
}

const char* reason_of(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return "found no such file";
    case ELOOP:
      return "found a cycle of symbolic links";
    case EACCES:
    case EPERM:
      return "found no permission to read this file";
    default:
      return std::strerror(error);
  }
}

// Proposes the file with the most similar name in the same folder, if a file does not exist.
std::string similar_file(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end;
       entry.increment(none))
    names.push_back(entry->path().filename().string());
  std::sort(names.begin(), names.end());  // the order of entries depends on the file system
  return did_you_mean(file.filename().string(), names);
}

// A file opened for reading.
class OpenFile {
 public:
  OpenFile(const std::filesystem::path& file, const std::string& expected, const std::string& where)
      : name_(where + file.string()), expected_(expected) {
    // Check the type before opening, because opening a pipe waits for its other end.
    struct stat found {};
    if (::stat(file.c_str(), &found) != 0) {
      const int error = errno;
      if (error == ENOENT) expected_ += similar_file(file);
      fail(reason_of(error));
    }
    if (const char* what = obstacle(found)) fail(std::string("found ") + what);
    record_input(file);
    file_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file_ < 0) fail(reason_of(errno));
    if (::fstat(file_, &found) != 0 || obstacle(found) != nullptr) close_and_fail();
    size_ = static_cast<std::uintmax_t>(found.st_size);
    if (size_ > kMaxInputFileSize) {
      ::close(file_);
      fail("found " + std::to_string(size_ >> 20) + " MB, more than the limit of " +
           std::to_string(kMaxInputFileSize >> 20) + " MB");
    }
  }
  ~OpenFile() { ::close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  // The contents. If the file grows meanwhile, only the original size is read.
  std::string bytes() const {
    std::string all(size_, '\0');
    size_t done = 0;
    while (done < all.size()) {
      const ssize_t got = ::read(file_, all.data() + done, all.size() - done);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(reason_of(errno));
      if (got == 0) break;
      done += static_cast<size_t>(got);
    }
    all.resize(done);
    return all;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(name_ + ": " + reason + ", expected " + expected_);
  }
  [[noreturn]] void close_and_fail() {
    ::close(file_);
    fail("this file cannot be read");
  }

  std::string name_, expected_;
  int file_ = -1;
  std::uintmax_t size_ = 0;
};

}  // namespace

void require_input_file(const std::filesystem::path& file, const std::string& expected,
                        const std::string& where) {
  const OpenFile open(file, expected, where);
}

std::string read_input_file(const std::filesystem::path& file, const std::string& expected,
                            const std::string& where) {
  return OpenFile(file, expected, where).bytes();
}

std::uintmax_t input_file_size(const std::filesystem::path& file) noexcept {
  struct stat found {};
  return ::stat(file.c_str(), &found) == 0 ? static_cast<std::uintmax_t>(found.st_size) : 0;
}

namespace {

// The position after a quoted string that begins at `at`, or the end of the text.
size_t behind_quotes(std::string_view text, size_t at) {
  const char quote = text[at];
  const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
  const std::string_view closing = text.substr(at).starts_with(three) ? three : three.substr(0, 1);
  for (size_t i = at + closing.size(); i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\')
      ++i;
    else if (text.substr(i).starts_with(closing))
      return i + closing.size();
    else if (closing.size() == 1 && text[i] == '\n')
      return i;  // unterminated: the parser will report it
  }
  return text.size();
}

[[noreturn]] void fail(std::string_view text, size_t at, const std::string& file,
                       const std::string& what) {
  const auto line = std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
  const size_t before = at == 0 ? text.npos : text.rfind('\n', at - 1);
  const size_t column = before == text.npos ? at + 1 : at - before;
  throw InputError(format_location(file, {static_cast<int>(line) + 1, static_cast<int>(column)}) +
                   "found " + what + " in each other, expected " +
                   std::to_string(kMaxNestingDepth) + " levels at most");
}

}  // namespace

void check_nesting_depth(std::string_view text, const std::string& file) {
  int depth = 0, dots = 0;
  for (size_t i = 0; i < text.size();) {
    switch (text[i]) {
      case '"':
      case '\'':
        i = behind_quotes(text, i);
        continue;
      case '#':
        i = std::min(text.find('\n', i), text.size());
        continue;
      case '[':
      case '{':
        ++depth;
        dots = 0;
        break;
      case ']':
      case '}':
        depth = std::max(0, depth - 1);
        break;
      case '.':
        ++dots;
        break;
      case '=':
      case ',':
      case '\n':
        dots = 0;
        break;
      default:
        break;
    }
    if (depth + dots > kMaxNestingDepth) fail(text, i, file, "lists, tables or parts of a key");
    ++i;
  }
}

void check_xml_nesting_depth(std::string_view text, const std::string& file) {
  int depth = 0;
  const auto behind = [&](std::string_view ending, size_t from) {
    const size_t found = text.find(ending, from);
    return found == text.npos ? text.size() : found + ending.size();
  };
  for (size_t i = text.find('<'); i < text.size(); i = text.find('<', i)) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("<!--")) {
      i = behind("-->", i);
    } else if (rest.starts_with("<![CDATA[")) {
      i = behind("]]>", i);
    } else if (rest.starts_with("<?")) {
      i = behind("?>", i);
    } else if (rest.starts_with("<!")) {
      i = behind(">", i);
    } else {
      const size_t start = i;
      for (++i; i < text.size() && text[i] != '>'; ++i)
        if (text[i] == '"' || text[i] == '\'') i = std::min(text.find(text[i], i + 1), text.size());
      if (rest.starts_with("</"))
        --depth;
      else if (i < text.size() && text[i - 1] != '/' && ++depth > kMaxNestingDepth)
        fail(text, start, file, "elements");
    }
  }
}

// Readers of third-party libraries in a child process.

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
  rlim_t seconds, bytes;    // processor time, memory
  bool are_of_file = true;  // false: this process has a lower limit of its memory
  rlim_t by_the_clock() const { return 4 * seconds; }
};

// Address space of this process in bytes: "VmSize:" now, "VmPeak:" the maximum.
rlim_t addresses(const char* field) {
  char line[256];
  unsigned long kilobytes = 0;
  std::FILE* file = std::fopen("/proc/self/status", "re");
  if (!file) return 0;
  while (std::fgets(line, sizeof line, file))
    if (std::strncmp(line, field, std::strlen(field)) == 0)
      kilobytes = std::strtoul(line + std::strlen(field), nullptr, 10);
  std::fclose(file);
  return rlim_t{1024} * kilobytes;
}

Limits limits_for(const std::filesystem::path& file, int times) {
  const double megabytes = static_cast<double>(input_file_size(file)) / 1048576;
  Limits limits{static_cast<rlim_t>(times * (6 + std::ceil(4 * megabytes))),
                (rlim_t{1} << 30) + static_cast<rlim_t>(200 * 1048576 * megabytes)};
  rlimit own{};
  if (::getrlimit(RLIMIT_CPU, &own) == 0) limits.seconds = std::min(limits.seconds, own.rlim_max);
  const rlim_t used = addresses("VmSize:");
  if (::getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY &&
      own.rlim_cur < used + limits.bytes) {
    limits.bytes = own.rlim_cur > used ? own.rlim_cur - used : 0;
    limits.are_of_file = false;
  }
  return limits;
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
  // The pipe must not be one of the standard streams, which may have been closed.
  to = ::fcntl(to, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL,
                           SIGABRT, SIGXCPU, SIGPIPE, SIGALRM})
    ::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.seconds);
  // Waiting uses no processor time. So elapsed time must be limited, too.
  ::alarm(static_cast<unsigned>(limits.by_the_clock()));
  const rlim_t most_addresses = addresses("VmSize:") + limits.bytes;
  if (kMemoryIsLimited) limit(RLIMIT_AS, most_addresses);
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
  // Libraries call a file damaged if they get no memory for it.
  constexpr rlim_t kLastBytes = 16 << 20;
  if (kMemoryIsLimited && outcome != Outcome::Bytes &&
      addresses("VmPeak:") + kLastBytes > most_addresses)
    outcome = Outcome::NoMemory;
  const char first = static_cast<char>(outcome);
  ::_exit(write_all(to, &first, 1) && write_all(to, bytes.data(), bytes.size()) ? 0 : 1);
}

// Processor time of a process in clock ticks; -1 if it is running or waits for a device.
long ticks_if_asleep(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text);
  const size_t name_end = text.rfind(')');  // the name of the program may contain spaces
  if (name_end == text.npos) return -1;
  std::istringstream fields(text.substr(name_end + 1));
  std::string state, skipped;
  fields >> state;
  constexpr int before_times = 10;  // parent, group, … page faults
  for (int i = 0; i < before_times; ++i) fields >> skipped;
  long user = 0, system = 0;
  fields >> user >> system;
  return fields && state == "S" ? user + system : -1;
}

// The bytes that a child sends. If it has slept for two seconds, it is killed, and the result is
// nullopt: it waits for a lock that another thread held during the fork, which is never released.
std::optional<std::string> read_all(int from, pid_t child) {
  constexpr int interval_ms = 200, most_idle = 10;
  std::string all;
  std::string part(1 << 16, '\0');
  long ticks = -1;
  for (int idle = 0; idle < most_idle;) {
    pollfd ready{from, POLLIN, 0};
    const int count = ::poll(&ready, 1, interval_ms);
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) {
      const long now = ticks_if_asleep(child);
      idle = now >= 0 && now == ticks ? idle + 1 : 0;
      ticks = now;
      continue;
    }
    const ssize_t got = ::read(from, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return all;
    all.append(part.data(), static_cast<size_t>(got));
    idle = 0;
  }
  ::kill(child, SIGKILL);
  return std::nullopt;
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
  record_input(file);
  if (!is_sandboxed_read_enabled()) return read();
  const auto fail = [&](const std::string& what) -> void {
    throw InputError(file.string() + ": " + library + " " + what);
  };
  const Limits limits = limits_for(file, times);
  std::optional<std::string> received;
  int status = 0;
  constexpr int attempts = 4;
  for (int attempt = 0; attempt < attempts && !received; ++attempt) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
      throw NoSolutionError(file.string() + ": cannot create a pipe to the reader of this file: " +
                            std::strerror(errno) + "; expected a higher limit (ulimit -n)");
    const pid_t parent = ::getpid(), child = ::fork();
    if (child == 0) run_child(ends[1], parent, limits, read);
    const int fork_error = errno;
    ::close(ends[1]);
    if (child > 0) received = read_all(ends[0], child);
    ::close(ends[0]);
    if (child < 0)
      throw NoSolutionError(file.string() + ": cannot create a process to read this file: " +
                            std::strerror(fork_error) +
                            "; expected a higher limit (ulimit -u, ulimit -v)");
    status = ending_of(child);
  }
  if (!received) fail("waits without end while reading this file");
  std::string& all = *received;
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    if (number == SIGINT || number == SIGTERM || number == SIGHUP) throw CancelledError();
    if (number == SIGXCPU || number == SIGALRM || number == SIGKILL)
      fail("did not finish reading this file within " +
           std::to_string(number == SIGALRM ? limits.by_the_clock() : limits.seconds) +
           " s: it is damaged, or too large");
    if (!limits.are_of_file)
      throw NoSolutionError(file.string() + ": " + library + " crashes while reading this file (" +
                            ::strsignal(number) + "): it is damaged, or the " +
                            std::to_string(limits.bytes >> 20) +
                            " MB of memory that are available do not suffice");
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
      return std::move(all);
    case Outcome::Refused:
      throw InputError(all);
    case Outcome::NoMemory:
      if (!limits.are_of_file)
        throw NoSolutionError(file.string() + ": not enough memory: " + library +
                              " requires more than the " + std::to_string(limits.bytes >> 20) +
                              " MB that are available");
      fail("requires more than " + std::to_string(limits.bytes >> 20) +
           " MB for this file: it is damaged, or too large");
      break;
    case Outcome::Failed:
      fail("cannot read this file: " + all);
  }
  return {};
}

}  // namespace batten
