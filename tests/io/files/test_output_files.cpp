// SPDX-License-Identifier: MPL-2.0
// Files that appear together, temporary folders, and inputs that are not replaced.
#include <fstream>
#include <optional>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/input_file.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using batten_test::error_message;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

void put(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
std::string contents_of(const fs::path& file) { return read_input_file(file, "a text"); }
int entries(const fs::path& folder) {
  return static_cast<int>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

fs::path new_folder(const std::string& name) {
  fs::path folder = batten_test::scratch(name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

}  // namespace

TEST_CASE("files are moved together, or stay as they were", "[io][files]") {
  const fs::path folder = new_folder("move_together");
  for (const char* name : {"a", "b", "report"}) put(folder / name, std::string("old ") + name);
  const auto prepare = [&] {
    for (const char* name : {"a", "b", "c", "report"})
      put(folder / ("new_" + std::string(name)), std::string("new ") + name);
  };
  const auto move = [&](const std::string& c) {
    move_together({{folder / "new_a", folder / "a"},
                   {folder / "new_c", folder / c},
                   {folder / "new_b", folder / "b"},
                   {folder / "new_report", folder / "report"}});
  };
  prepare();
  CHECK_THAT(error_message([&] { move("missing/c"); }),
             Contains("missing/c: cannot write this file"));
  for (const char* name : {"a", "b", "report"})
    CHECK(contents_of(folder / name) == std::string("old ") + name);
  for (const char* name : {"a", "b", "c", "report"})
    CHECK(contents_of(folder / ("new_" + std::string(name))) == std::string("new ") + name);

  move("c");
  for (const char* name : {"a", "b", "c", "report"})
    CHECK(contents_of(folder / name) == std::string("new ") + name);
  CHECK(entries(folder) == 4);
}

TEST_CASE("the same output file twice is refused", "[io][files]") {
  const fs::path folder = new_folder("same_output");
  const AtomicFile one(folder / "a.txt"), other(folder / "b.txt"), same(folder / "./a.txt");
  CHECK_NOTHROW(require_distinct({&one, &other}));
  CHECK_THAT(error_message([&] {
               require_distinct({&one, &other, &same});
             }),
             Contains("two output files"));
}

TEST_CASE("temporary folders have unique names and disappear", "[io][files]") {
  const fs::path folder = new_folder("temporary_folders");
  {
    const TemporaryFolder a(folder, "x"), b(folder, "x");
    CHECK(a.path() != b.path());
    CHECK(is_temporary(a.path() / "file.txt"));
    CHECK(without_temporary_folders(a.path() / "file.txt") == folder / "file.txt");
    CHECK(fs::exists(a.path()));  // a folder in use is no leftover
    CHECK(entries(folder) == 2);
  }
  CHECK(entries(folder) == 0);
  for (const char* name : {"file.txt", ".hidden", ".x.0123", "a.01234567-0123456789abcdef",
                           ".x.0123456g-0123456789abcdef"})
    CHECK_FALSE(is_temporary(folder / name));
}

TEST_CASE("a file that a command has read is not replaced", "[io][files]") {
  const fs::path folder = new_folder("protected_inputs");
  put(folder / "in.txt", "in");
  put(folder / "other.txt", "other");
  const auto write = [&](const char* name) {
    return error_message(
        [&] { write_file_atomically(folder / name, [](std::ostream& out) { out << "new"; }); });
  };
  {
    std::optional<CommandFiles> outer(std::in_place), inner(std::in_place);
    contents_of(folder / "in.txt");
    inner.reset();
    fs::create_symlink("in.txt", folder / "link.txt");
    CHECK_THAT(write("in.txt"), Contains("input file of this command"));
    CHECK_THAT(write("link.txt"), Contains("input file of this command"));
    CHECK(write("other.txt").empty());
    {
      const ReplaceableInput saved(folder / "in.txt");
      CHECK(write("in.txt").empty());
    }
    CHECK_THAT(write("in.txt"), Contains("input file of this command"));
    const CommandFiles in_place(CommandFiles::Inputs::Replaceable);
    CHECK(write("in.txt").empty());
  }
  contents_of(folder / "in.txt");  // without a command
  CHECK(write("in.txt").empty());
}
