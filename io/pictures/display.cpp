// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/display.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <future>
#include <random>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/core/parallel.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// A descriptor that is closed at the end of its scope, and in programs that this process starts.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// The functions of libX11 that are needed. It is loaded only to draw.
struct X11 {
  void* (*open)(const char* name);
  int (*close)(void* display);
  int (*query_extension)(void* display, const char* name, int* opcode, int* event, int* error);
  void (*set_authorization)(const char* name, int name_length, const char* data, int data_length);

  /// Throws InputError if the library is missing.
  static const X11& library() {
    static const X11 functions = [] {
      void* library = dlopen("libX11.so.6", RTLD_NOW | RTLD_LOCAL);
      if (!library) throw InputError("no display: the library libX11.so.6 is missing");
      return X11{
          reinterpret_cast<decltype(open)>(dlsym(library, "XOpenDisplay")),
          reinterpret_cast<decltype(close)>(dlsym(library, "XCloseDisplay")),
          reinterpret_cast<decltype(query_extension)>(dlsym(library, "XQueryExtension")),
          reinterpret_cast<decltype(set_authorization)>(dlsym(library, "XSetAuthorization"))};
    }();
    return functions;
  }
};

/// Connects to a server with OpenGL. Returns nullptr, and the reason, if that is not possible.
void* connect(const std::string& server, std::string& reason) {
  const X11& x = X11::library();
  void* display = x.open(server.c_str());
  if (!display) {
    reason = "the X server '" + server + "' does not answer";
    return nullptr;
  }
  int opcode, event, error;
  if (x.query_extension(display, "GLX", &opcode, &event, &error)) return display;
  reason = "the X server '" + server + "' has no OpenGL (GLX)";
  x.close(display);
  return nullptr;
}

// A virtual server.

using Cookie = std::array<char, 16>;
constexpr char kProtocol[] = "MIT-MAGIC-COOKIE-1";

/// The contents of a file of xauth(1) with one entry, valid for all displays: family, address,
/// display number, protocol and cookie, each after its length in two bytes.
std::string authority_file(const Cookie& cookie) {
  const auto field = [](const std::string& text) {
    return std::string{static_cast<char>(text.size() >> 8), static_cast<char>(text.size() & 255)} +
           text;
  };
  const std::string any_family = "\xff\xff";
  return any_family + field("") + field("") + field(kProtocol) +
         field(std::string(cookie.data(), cookie.size()));
}

/// Descriptors 3 and 4 of the server: it writes its number to 3, and reads the cookie from 4.
struct ServerFiles {
  int number, cookie, messages;
};

/// Replaces this process, a fork with one thread, by the server. Calls only functions that are safe
/// after a fork.
[[noreturn]] void become_server(const char* program, const ServerFiles& files, pid_t parent) {
  setsid();  // Ctrl-C in the terminal is for the parent, which still needs the server
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  constexpr int above = 5;  // so that no descriptor is overwritten before it is copied
  const int number = fcntl(files.number, F_DUPFD, above),
            cookie = fcntl(files.cookie, F_DUPFD, above),
            messages = fcntl(files.messages, F_DUPFD, above), nothing = open("/dev/null", O_RDWR);
  dup2(nothing, 0);
  dup2(messages, 1);
  dup2(messages, 2);
  dup2(number, 3);
  dup2(cookie, 4);
  close_range(above, ~0U, 0);
  execl(program, "Xvfb", "-displayfd", "3", "-auth", "/proc/self/fd/4", "-nolisten", "tcp",
        "-screen", "0", "1280x1024x24", static_cast<char*>(nullptr));
  _exit(127);
}

/// Starts the server in a thread that lives until the process ends: PR_SET_PDEATHSIG ends the server
/// when the thread that forked ends. Returns the process id, or -1.
pid_t start_server(const std::string& program, const ServerFiles& files) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return -1;
  const Descriptor from(ends[0]);
  const pid_t parent = getpid();
  const auto serve = [program, files, parent, to = ends[1]] {
    const pid_t child = fork();
    if (child == 0) become_server(program.c_str(), files, parent);
    const bool told = write(to, &child, sizeof child) == sizeof child;
    close(to);
    if (told && child > 0)
      while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
      }
  };
  try {
    std::thread(serve).detach();
  } catch (const std::system_error&) {  // the system provides no more threads
    close(ends[1]);
    return -1;
  }
  pid_t child = -1;
  while (read(from, &child, sizeof child) < 0 && errno == EINTR) {
  }
  return child;
}

/// The number that a server writes when it is ready; empty if it ends before, or hangs.
std::string server_number(int from) {
  using Clock = std::chrono::steady_clock;
  constexpr auto patience = std::chrono::seconds(60);
  const auto end = Clock::now() + patience;
  std::string text;
  while (Clock::now() < end && (text.empty() || text.back() != '\n')) {
    pollfd ready{from, POLLIN, 0};
    constexpr int step = 1000;  // milliseconds
    if (poll(&ready, 1, step) <= 0) continue;
    char c = 0;
    const ssize_t got = read(from, &c, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return "";
    text += c;
  }
  if (text.empty() || text.back() != '\n') return "";
  text.pop_back();
  return text;
}

/// The messages of a server that failed, as one short line.
std::string messages_in(int file) {
  std::string text(400, '\0');
  const ssize_t got = pread(file, text.data(), text.size(), 0);
  text.resize(static_cast<size_t>(std::max<ssize_t>(got, 0)));
  std::istringstream words(text);
  std::string line;
  for (std::string word; words >> word;)
    if (word != "(EE)") line += (line.empty() ? "" : " ") + word;
  return line;
}

Cookie random_cookie() {
  std::random_device random;
  Cookie cookie;
  for (char& c : cookie) c = static_cast<char>(random() & 255);
  return cookie;
}

/// Starts a virtual server and connects to it. Only this process knows its cookie. Returns nullptr,
/// and the reason, if that is not possible.
void* connect_to_virtual(const std::string& program, std::string& reason) {
  const X11& x = X11::library();
  const Cookie cookie = random_cookie();
  const std::string authority = authority_file(cookie);
  int ends[2];
  const Descriptor file(memfd_create("batten-xauth", MFD_CLOEXEC)),
      messages(memfd_create("batten-xvfb", MFD_CLOEXEC));
  if (file < 0 || messages < 0 || pipe2(ends, O_CLOEXEC) != 0 ||
      write(file, authority.data(), authority.size()) != static_cast<ssize_t>(authority.size())) {
    reason = std::string(program) + ": " + std::strerror(errno);
    return nullptr;
  }
  const Descriptor from(ends[0]);
  Descriptor to(ends[1]);
  const pid_t server = start_server(program, {to, file, messages});
  to.close();
  const std::string number = server > 0 ? server_number(from) : "";
  if (number.empty()) {
    if (server > 0) kill(server, SIGTERM);
    reason = program + " did not start" +
             (messages_in(messages).empty() ? "" : ": " + messages_in(messages));
    return nullptr;
  }
  x.set_authorization(kProtocol, sizeof kProtocol - 1, cookie.data(), isize(cookie));
  void* display = connect(":" + number, reason);
  x.set_authorization(nullptr, 0, nullptr, 0);
  if (!display) kill(server, SIGTERM);
  return display;
}

fs::path folder_beside_program() {
  std::error_code none;
  return fs::read_symlink("/proc/self/exe", none).parent_path() / ".." / BATTEN_LIBDIR / "batten" /
         "xvfb";
}

/// The programs Xvfb to try, in this order.
std::vector<std::string> virtual_servers() {
  if (std::getenv("BATTEN_XVFB"))
    return variable("BATTEN_XVFB").empty() ? std::vector<std::string>()
                                           : std::vector{variable("BATTEN_XVFB")};
  std::vector<fs::path> folders = {folder_beside_program() / "bin"};
  std::istringstream path(variable("PATH"));
  for (std::string folder; std::getline(path, folder, ':');) folders.emplace_back(folder);
  std::vector<std::string> found;
  for (const fs::path& folder : folders)
    if (const fs::path file = folder / "Xvfb"; access(file.c_str(), X_OK) == 0)
      found.push_back(file.string());
  return found;
}

/// Connects to the server of the variable DISPLAY.
void* connect_to_given(std::string& reason) {
  const std::string server = variable("DISPLAY");
  if (!server.empty()) return connect(server, reason);
  reason = "there is no X server";
  return nullptr;
}

// Mesa crashes or waits without end if it gets less.
constexpr double kAddressesToDraw = 9e8;  // bytes; 8e8 suffice with two cores
constexpr double kAddressesPerCore = 1e7;
constexpr int kThreadsToDraw = 8;  // with the server and its helpers; and one per core

bool can_start_threads(int count) {
  std::promise<void> end;
  const std::shared_future<void> ended = end.get_future();
  std::vector<std::thread> threads;
  bool started = true;
  try {
    for (int i = 0; i < count; ++i) threads.emplace_back([ended] { ended.wait(); });
  } catch (const std::system_error&) {
    started = false;
  }
  end.set_value();
  for (std::thread& thread : threads) thread.join();
  return started;
}

/// Throws InputError unless the limits of the system permit to draw.
void require_resources() {
  const int cores = std::min(core_count(), 32);
  const double expected = kAddressesToDraw + cores * kAddressesPerCore,
               found = std::max(available_addresses(), 0.0);
  if (found < expected)
    throw InputError("no display: to draw, " + format_bytes(expected) +
                     " of address space are needed, but only " + format_bytes(found) +
                     " are available (ulimit -v)");
  if (!can_start_threads(cores + kThreadsToDraw))
    throw InputError("no display: to draw, " + std::to_string(cores + kThreadsToDraw) +
                     " threads are needed, but the system does not provide them (ulimit -u)");
}

void* connect_to_any() {
  require_resources();
  std::string reason;
  if (void* display = connect_to_given(reason)) return display;
  std::error_code none;
  const fs::path drivers = folder_beside_program() / "lib" / "dri";
  if (fs::exists(drivers, none)) setenv("LIBGL_DRIVERS_PATH", drivers.c_str(), 0);
  const std::vector<std::string> servers = virtual_servers();
  if (servers.empty()) reason += ", and no virtual one (Xvfb)";
  for (const std::string& program : servers) {
    std::string problem;
    if (void* display = connect_to_virtual(program, problem)) return display;
    reason += "; " + problem;
  }
  throw InputError("no display: " + reason +
                   "; to draw pictures, install Xvfb (on Debian: apt install xvfb "
                   "libgl1-mesa-dri)");
}

}  // namespace

void* detail::x_display() {
  static void* const display = connect_to_any();
  return display;
}

void require_display() { detail::x_display(); }

void require_visible_display() {
  static void* const display = [] {  // stays open: a server may restart after its last client
    std::string reason;
    if (void* given = connect_to_given(reason)) return given;
    throw InputError("no display: " + reason + "; a window requires an X server");
  }();
  static_cast<void>(display);
}

}  // namespace batten
