// SPDX-License-Identifier: MPL-2.0
// Pictures without an X server: the program starts a virtual one, which ends with it.
#include "batten/tests/apps/cli_case.h"

#include <signal.h>

#include <chrono>
#include <cstring>
#include <functional>
#include <thread>

using namespace batten_test;

namespace {

const std::string kScenePicture =
    "unit = \"mm\"\n[[curve]]\nname = \"rim\"\n"
    "points = [[0,0,0], [100,0,0], [100,100,20], [0,100,0], [0,0,0]]\n"
    "[mesh]\nedge_length = 40\n[[picture]]\nfile = \"s.png\"\nsize = [200, 100]\n";

bool becomes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 1000 && !condition(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

/// Names the program Xvfb for the runs of a case: a script that tells its process id, does `more`,
/// and becomes the server.
class Server {
 public:
  Server(const CliCase& c, const std::string& more) : number_(c / "pid") {
    const fs::path script = c / "server";
    write(script, "#!/bin/sh\necho $$ > '" + number_.string() + "'\n" + more + "\n");
    fs::permissions(script, fs::perms::owner_all);
    setenv("BATTEN_XVFB", script.c_str(), 1);
  }
  ~Server() { unsetenv("BATTEN_XVFB"); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  bool started() const { return fs::exists(number_) && fs::file_size(number_) > 0; }
  /// False also for a zombie: containers may not reap it. The state is read, not the command line,
  /// which is empty for a moment while the script becomes another program.
  bool running() const {
    std::string number;
    std::ifstream(number_) >> number;
    const std::string stat = contents("/proc/" + number + "/stat");
    const std::size_t name_end = stat.rfind(") ");
    return name_end != std::string::npos && !std::strchr("ZX", stat.at(name_end + 2));
  }

 private:
  fs::path number_;
};

bool have_xvfb() {
  const bool there = std::system("command -v Xvfb > /dev/null") == 0;
  if (!there) WARN("skipped: Xvfb is not installed");
  return there;
}

}  // namespace

TEST_CASE("a virtual X server draws the pictures and ends with the program", "[apps][pictures]") {
  if (!have_xvfb()) return;
  const CliCase c("virtual_display");
  c.file("s.toml", kScenePicture);
  const Server server(c, "exec Xvfb \"$@\"");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  CHECK(r.code == 0);
  CHECK(contents(c / "out/s.png").starts_with("\x89PNG"));
  REQUIRE(server.started());
  CHECK(becomes_true([&] { return !server.running(); }));
}

TEST_CASE("no virtual X server is started if nothing is drawn", "[apps][pictures]") {
  const CliCase c("no_picture");
  c.file("s.toml", kScenePicture.substr(0, kScenePicture.find("[[picture]]")));
  const Server server(c, "exit 1");
  CHECK(c.run({"run", "s.toml", "--out", "out"}).code == 0);
  CHECK_FALSE(server.started());
}

TEST_CASE("a virtual X server ends when the program is killed", "[apps][pictures]") {
  if (!have_xvfb()) return;
  const CliCase c("killed_display");
  c.file("s.toml", kScenePicture);
  // The server is ready only after the program is gone: nothing but the signal can end it.
  const Server server(c, "exec sleep 100");
  const pid_t program = c.start({"view", "s.toml", "--screenshot", "v.png"});
  REQUIRE(becomes_true([&] { return server.started(); }));
  CHECK(server.running());
  kill(program, SIGKILL);
  CHECK(c.wait(program).code == 1000 + SIGKILL);
  CHECK(becomes_true([&] { return !server.running(); }));
}

TEST_CASE("a server that does not start is named, and all other files are written",
          "[apps][pictures]") {
  const CliCase c("broken_display");
  c.file("s.toml", kScenePicture + "[output]\nvtp = \"s.vtp\"\n");
  const Server server(c, "echo '(EE) no keyboard' >&2; exit 1");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  CHECK(r.code == 4);
  CHECK_THAT(r.err, Catch::Matchers::Contains("check failed: s.png is not drawn: no display: ") &&
                        Catch::Matchers::Contains("did not start: no keyboard") &&
                        Catch::Matchers::Contains("apt install xvfb"));
  CHECK(fs::exists(c / "out/s.vtp"));
}
