// SPDX-License-Identifier: MPL-2.0
// A window that is killed at any moment loses no saved data, and little of the unsaved changes.
#include <csignal>
#include <cstdlib>
#include <random>
#include <thread>

#include "batten/apps/documents/document_worker.h"
#include "batten/io/scene/scene.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten;
using namespace batten_test;
using CommandKind = DocumentCommand::CommandKind;

namespace {

const std::string kDome = R"(# Whatever happens, this line is here.
unit = "mm"
[[curve]]
name = "rim"
points = [[0,0,0], [400,0,0], [400,300,0], [0,300,0], [0,0,0]]

[mesh]
edge_length = 60

[[load]]
name = "crown"
type = "pressure"
value = 0
)";

/// Runs the hidden test case below in a folder, in a process of this program.
pid_t start_victim_process(const fs::path& folder) {
  const pid_t child = fork();
  if (child != 0) return child;
  setenv("BATTEN_VICTIM", folder.c_str(), 1);
  dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
  execl("/proc/self/exe", "test_apps", "[.victim]", nullptr);
  _exit(127);
}

double crown_of(const std::string& text) {
  const Scene scene = parse_scene(text, "killed.toml");
  return scene.loads.front().value;
}

}  // namespace

TEST_CASE("drags and saves without an end", "[apps][documents][.victim]") {
  const char* const folder = std::getenv("BATTEN_VICTIM");
  if (!folder) return;
  DocumentWorker worker([] {}, fs::path(folder) / "changes.toml");
  worker.post({.kind = CommandKind::Open, .file = fs::path(folder) / "s.toml"});
  for (int i = 1;; ++i) {
    for (int j = 0; j < 5; ++j)
      worker.post({.kind = CommandKind::SetSlider, .key = "crown", .value = i + 0.1 * j});
    worker.post({.kind = CommandKind::SetSlider, .key = "crown", .value = static_cast<double>(i)});
    worker.post({.kind = CommandKind::SolveToEquilibrium});
    if (i % 3 == 0) worker.post({.kind = CommandKind::Save});
    while (worker.take_update().busy) std::this_thread::yield();
  }
}

TEST_CASE("killed while dragging and saving, the scene is the old or the new one",
          "[apps][documents]") {
  const CliCase folder("killed");
  std::mt19937 random(7);
  int saves = 0, kept = 0;
  for (int round = 0; round < 50; ++round) {
    folder.file("s.toml", kDome);
    fs::remove(folder / "changes.toml");
    const pid_t child = start_victim_process(folder.folder());
    REQUIRE(child > 0);
    // Starts when the changes of the first equilibrium are there.
    for (int i = 0; i < 2000 && !fs::exists(folder / "changes.toml"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 60000));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const std::string text = contents(folder / "s.toml");
    INFO("round " << round << "\n" << text);
    CHECK(text.starts_with("# Whatever happens, this line is here.\n"));
    const double saved = crown_of(text);
    CHECK(saved == 3 * std::floor(saved / 3));  // the value of a complete save
    saves += saved > 0;
    if (!fs::exists(folder / "changes.toml")) continue;  // everything was saved
    ++kept;
    Document document;
    document.apply({.kind = CommandKind::Recover, .file = folder / "changes.toml"});
    CHECK(document.file() == folder / "s.toml");
    const double now = crown_of(document.text().text());
    CHECK(now == std::floor(now));
    CHECK(now >= saved - 1);
    CHECK(now <= saved + 3);
  }
  CHECK(saves > 5);
  CHECK(kept > 5);
}
