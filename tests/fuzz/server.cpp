// SPDX-License-Identifier: MPL-2.0
// The batten program as a server for fuzz.py: each run is a fork of this process, which has already
// loaded its libraries. This takes 5 ms instead of 130 ms for a start of the program.
// Input lines: folder TAB faults TAB argument TAB argument …; response: exit code (negative: the
// number of a signal), seconds, megabytes. The output of a run goes to FOLDER/printed. A run longer
// than BATTEN_FUZZ_SECONDS gets SIGTERM, and is killed if it does not stop.
//
// Faults of the system, separated by commas, or "-" for none:
//     closed=DIGITS   these of the descriptors 0, 1 and 2 are closed
//     full=DIGIT      the descriptor 1 or 2 is /dev/full
//     memory=MB       limit of the address space, beyond what the libraries use
//     files=COUNT     limit of open files
//     size=BYTES      limit of the size of a file
//     stack=KB        limit of the stack
//     threads=COUNT   limit of threads and processes, as the user nobody (needs root)
//     disk=KB         FOLDER/disk is a disk of this size (needs root)
// A fault that cannot be made ends the run with code 99.
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

int batten_main(int argc, char** argv);  // apps/cli/main.cpp

namespace {

using Clock = std::chrono::steady_clock;

double most_seconds() {
  const char* stated = std::getenv("BATTEN_FUZZ_SECONDS");
  return stated ? std::atof(stated) : 10;
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Waits for the end of a run, and stops it if necessary.
int end_of(pid_t child, Clock::time_point start, rusage& used) {
  constexpr double to_answer = 2;
  constexpr useconds_t nap = 500;
  bool asked = false;
  int status = 0;
  while (wait4(child, &status, WNOHANG, &used) == 0) {
    const double seconds = seconds_since(start);
    if (seconds > most_seconds() + to_answer) {
      kill(child, SIGKILL);
    } else if (seconds > most_seconds() && !asked) {
      kill(child, SIGTERM);
      asked = true;
    }
    usleep(nap);
  }
  return status;
}

void require(bool made) {
  if (!made) _exit(99);
}

bool limit(__rlimit_resource_t resource, rlim_t most) {
  const rlimit both{most, most};
  return setrlimit(resource, &both) == 0;
}

rlim_t addresses_in_use() {
  long pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

// A disk that only this process sees, and that disappears with it.
bool mount_disk(const std::string& folder, const std::string& kilobytes) {
  if (unshare(CLONE_NEWNS) != 0 || mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0)
    return false;
  const std::string place = folder + "/disk", options = "size=" + kilobytes + "k,mode=777";
  return mkdir(place.c_str(), 0777) == 0 &&
         mount("none", place.c_str(), "tmpfs", 0, options.c_str()) == 0;
}

bool become_nobody(const std::string& folder) {
  constexpr uid_t nobody = 65534;
  return chmod(folder.c_str(), 0777) == 0 && setresgid(nobody, nobody, nobody) == 0 &&
         setresuid(nobody, nobody, nobody) == 0;
}

bool make_fault(const std::string& fault, const std::string& folder) {
  const size_t equals = fault.find('=');
  const std::string kind = fault.substr(0, equals), value = fault.substr(equals + 1);
  const auto number = static_cast<rlim_t>(std::atoll(value.c_str()));
  if (kind == "closed") {
    for (const char digit : value) close(digit - '0');
    return true;
  }
  if (kind == "full") return dup2(open("/dev/full", O_WRONLY), static_cast<int>(number)) >= 0;
  if (kind == "memory") return limit(RLIMIT_AS, addresses_in_use() + (number << 20));
  if (kind == "files") return limit(RLIMIT_NOFILE, number);
  if (kind == "size") return limit(RLIMIT_FSIZE, number);
  if (kind == "stack") return limit(RLIMIT_STACK, number << 10);
  if (kind == "threads") return become_nobody(folder) && limit(RLIMIT_NPROC, number);
  if (kind == "disk") return mount_disk(folder, value);
  return false;
}

[[noreturn]] void run_program(const std::string& folder, const std::string& faults,
                              std::vector<std::string> words) {
  const int printed = open((folder + "/printed").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  const int nothing = open("/dev/null", O_RDONLY);
  require(printed >= 0 && nothing >= 0 && chdir(folder.c_str()) == 0);
  dup2(nothing, STDIN_FILENO);
  dup2(printed, STDOUT_FILENO);
  dup2(printed, STDERR_FILENO);
  close(printed);
  close(nothing);
  std::istringstream all(faults);
  for (std::string fault; faults != "-" && std::getline(all, fault, ',');)
    require(make_fault(fault, folder));
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::exit(batten_main(static_cast<int>(words.size()), arguments.data()));
}

}  // namespace

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream in(line);
    std::string folder, faults, word;
    std::vector<std::string> words = {"batten"};
    std::getline(in, folder, '\t');
    std::getline(in, faults, '\t');
    while (std::getline(in, word, '\t')) words.push_back(word);
    const auto start = Clock::now();
    const pid_t child = fork();
    if (child == 0) run_program(folder, faults, words);
    if (child < 0) return 1;
    rusage used{};
    const int status = end_of(child, start, used);
    std::printf("%d %.3f %.0f\n", WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status),
                seconds_since(start), static_cast<double>(used.ru_maxrss) / 1024);
    std::fflush(stdout);
  }
  return 0;
}
