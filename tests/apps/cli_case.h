// SPDX-License-Identifier: MPL-2.0
// Runs the program in a separate folder, without an X server.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

namespace batten_test {

namespace fs = std::filesystem;

struct CliResult {
  int code = -1;
  std::string out, err;
};

inline std::string contents(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

inline void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

/// A folder with the files of one case, in which the program runs. There is no X server, and none is
/// started unless the test names one in BATTEN_XVFB.
class CliCase {
 public:
  explicit CliCase(const std::string& name) : folder_(scratch("cli_" + name)) {}
  ~CliCase() { fs::remove_all(folder_); }

  const fs::path& folder() const { return folder_; }
  fs::path operator/(const std::string& name) const { return folder_ / name; }
  void file(const std::string& name, const std::string& text) const { write(folder_ / name, text); }

  /// Starts batten in the folder.
  pid_t start(const std::vector<std::string>& arguments) const {
    std::vector<std::string> words = {BATTEN_CLI};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (auto& w : words) argv.push_back(w.data());
    argv.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      if (chdir(folder_.c_str()) != 0) _exit(127);
      for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, SIG_DFL);
      unsetenv("DISPLAY");
      setenv("BATTEN_XVFB", "", 0);
      dup2(open(".out", O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
      dup2(open(".err", O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
    return child;
  }
  CliResult wait(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
    return {code, contents(folder_ / ".out"), contents(folder_ / ".err")};
  }
  CliResult run(const std::vector<std::string>& arguments) const { return wait(start(arguments)); }

  /// `batten run s.toml --out out` on this scene must fail with this message and leave no files.
  void fails(const std::string& scene, int code, const std::vector<std::string>& parts,
             const std::vector<std::string>& more = {}, const std::string& command = "run") const {
    file("s.toml", scene);
    std::vector<std::string> arguments = {command, "s.toml", "--out", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CliResult r = run(arguments);
    INFO("scene:\n" << scene << "\nmessage:\n" << r.err);
    CHECK(r.code == code);
    for (const auto& part : parts) {
      INFO("expected in the message: " << part);
      CHECK(r.err.find(part) != std::string::npos);
    }
    CHECK_FALSE(fs::exists(folder_ / "out"));
  }

 private:
  fs::path folder_;
};

inline nlohmann::json report(const CliCase& c, const std::string& folder,
                             const std::string& name = "report.json") {
  return nlohmann::json::parse(contents(c / (folder + "/" + name)));
}

}  // namespace batten_test
