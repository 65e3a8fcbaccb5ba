// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/external_program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/prctl.h>
#endif

#include <csignal>
#include <cstdlib>

#include "batten/core/errors.h"

namespace batten {

int run_external_program(const ExternalProgram& program, const std::vector<std::string>& arguments,
                         const std::filesystem::path& folder, const std::filesystem::path& log) {
  constexpr int not_found = 127;
  const char* const named = std::getenv(program.variable.c_str());
  std::string name = named ? named : program.name;
  const std::string output = log.empty() ? "/dev/null" : std::filesystem::absolute(log).string();
  // Nothing is allocated between fork() and exec(): other threads may hold the allocator's lock.
  std::vector<std::string> words = arguments;
  std::vector<char*> command{name.data()};
  for (std::string& word : words) command.push_back(word.data());
  command.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
#if defined(__linux__)
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    constexpr int readable = 0644;
    const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, readable);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    if (chdir(folder.c_str()) == 0) execvp(command[0], command.data());
    _exit(not_found);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0) throw InputError("cannot start '" + name + "'");
  if (WIFSIGNALED(status)) return 128 + WTERMSIG(status);
  if (WEXITSTATUS(status) == not_found)
    throw InputError("found no program '" + name + "', expected " + program.description +
                     " or its path in the environment variable " + program.variable);
  return WEXITSTATUS(status);
}

}  // namespace batten
