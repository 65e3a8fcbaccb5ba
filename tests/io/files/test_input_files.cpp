// SPDX-License-Identifier: MPL-2.0
// Which files may be read, the depth of nesting, and readers in separate processes.
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <locale>
#include <mutex>
#include <new>
#include <thread>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const fs::path seeds = fs::path(BATTEN_SOURCE_DIR) / "tests/fuzz/seeds";

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

// Reads in a child process until the end of a test.
struct SandboxScope {
  SandboxScope() { enable_sandboxed_read(true); }
  ~SandboxScope() { enable_sandboxed_read(false); }
};

}  // namespace

TEST_CASE("only regular files are read", "[io][files]") {
  const fs::path folder = batten_test::scratch("input_files");
  fs::create_directories(folder);
  const auto says = [&](const fs::path& path) {
    return batten_test::error_message([&] { read_input_file(path, "a thing", "here: "); });
  };
  const std::string bytes("a\0b\n\xff", 5);
  std::ofstream(folder / "file", std::ios::binary) << bytes;
  CHECK(read_input_file(folder / "file", "a thing") == bytes);
  fs::create_symlink("file", folder / "link");
  CHECK(read_input_file(folder / "link", "a thing") == bytes);

  CHECK(says(folder / "none") ==
        "here: " + (folder / "none").string() + ": found no such file, expected a thing");
  CHECK_THAT(says(folder / "file" / "below"), Contains("found no such file"));
  CHECK_THAT(says(folder), Contains("found a folder"));
  CHECK_THAT(says("/dev/zero"), Contains("found a device"));
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  CHECK_THAT(says(folder / "pipe"), Contains("found a pipe"));
  fs::create_symlink("round", folder / "trip");
  fs::create_symlink("trip", folder / "round");
  CHECK_THAT(says(folder / "trip"), Contains("found a cycle of symbolic links"));
  // A sparse file, which needs no space on the disk.
  std::ofstream(folder / "large").put('x');
  fs::resize_file(folder / "large", kMaxInputFileSize + 1);
  CHECK_THAT(says(folder / "large"), Contains("found 2048 MB, more than the limit of 2048 MB"));
  fs::remove(folder / "large");
}

TEST_CASE("text may be nested so deep and no deeper", "[io][files]") {
  const auto says = [](const std::string& text) {
    return batten_test::error_message([&] { check_nesting_depth(text, "f"); });
  };
  for (const char* open : {"[", "{"}) {
    CHECK_NOTHROW(check_nesting_depth(repeated(open, kMaxNestingDepth), "f"));
    CHECK(
        says("\n " + repeated(open, kMaxNestingDepth + 1)) ==
        "f:2:66: found lists, tables or parts of a key in each other, expected 64 levels at most");
  }
  CHECK_NOTHROW(check_nesting_depth(repeated("a.", kMaxNestingDepth) + "a = 1", "f"));
  CHECK_THAT(says(repeated("a.", 65) + "a = 1"), Contains("f:1:130: "));
  // Neighbouring brackets are not nested; brackets in quotes or comments do not count.
  CHECK_NOTHROW(check_nesting_depth("x = [" + repeated("[1.5, 2.5],\n", 1000) + "]", "f"));
  const std::string deep = repeated("[", 1000);
  for (const std::string& text :
       {"\"" + deep + "\"", "'" + deep + "'", "\"\"\"\n" + deep + "\n\"\"\"", "# " + deep,
        "\"\\\"" + deep + "\"", "'''" + deep + "'" + deep + "'''"})
    CHECK_NOTHROW(check_nesting_depth(text + "\nx = [1]", "f"));
  CHECK_THAT(says("\"\" " + deep), Contains("64 levels"));

  CHECK_NOTHROW(check_xml_nesting_depth(repeated("<g a='>'>", 64), "f"));
  CHECK_NOTHROW(check_xml_nesting_depth(repeated("<g/><p>x</p><!-- <g> -->", 1000), "f"));
  CHECK_THAT(batten_test::error_message([] { check_xml_nesting_depth(repeated("<g>", 65), "f"); }),
             Contains("f:1:193: found elements in each other"));
}

TEST_CASE("a crash of a reader in a child process is reported and harms nothing else",
          "[io][files]") {
  const SandboxScope guard;
  const fs::path file = seeds / "cad" / "two.step";
  const auto read = [&](const std::function<std::string()>& work) {
    return sandboxed_read(file, "The library", work);
  };
  const auto says = [&](const std::function<std::string()>& work) {
    return batten_test::error_message([&] { read(work); });
  };
  CHECK(read([] { return std::string(3 << 20, 'x'); }) == std::string(3 << 20, 'x'));
  CHECK(read([] { return std::string(); }).empty());
  CHECK(says([]() -> std::string { throw InputError("a: b"); }) == "a: b");
  CHECK_THAT(says([]() -> std::string { throw std::runtime_error("no luck"); }),
             Contains("two.step: The library cannot read this file: no luck"));
  CHECK_THAT(says([]() -> std::string {
               std::raise(SIGSEGV);
               return "";
             }),
             Contains("The library crashes while reading this file") && Contains("it is damaged"));
  CHECK_THAT(says([]() -> std::string { std::abort(); }), Contains("crashes"));
  CHECK_THAT(says([]() -> std::string { std::_Exit(0); }), Contains("terminates while reading"));
  CHECK_THAT(says([]() -> std::string { throw std::bad_alloc(); }), Contains("requires more than"));
#if !defined(__SANITIZE_ADDRESS__)
  CHECK_THAT(says([] { return std::string(std::size_t{8} << 30, 'x'); }),
             Contains("requires more than 1025 MB"));
#endif
  CHECK_THAT(says([]() -> std::string {
               // Earlier than the limit for this file.
               const rlimit one{1, 2};
               setrlimit(RLIMIT_CPU, &one);
               const volatile bool forever = true;
               while (forever) {
               }
               return "";
             }),
             Contains("did not finish reading this file within 7 s"));
  CHECK_THROWS_AS(read([]() -> std::string {
                    std::raise(SIGTERM);
                    return "";
                  }),
                  CancelledError);
}

TEST_CASE("a child that waits for a lock of another thread is replaced", "[io][files]") {
  const SandboxScope guard;
  const fs::path file = seeds / "cad" / "two.step";
  std::timed_mutex mutex;
  std::atomic<bool> held{false}, release{false};
  std::thread holder([&] {
    const std::lock_guard lock(mutex);
    held = true;
    while (!release) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  while (!held) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::thread releaser([&] {
    std::this_thread::sleep_for(std::chrono::seconds(1));
    release = true;
  });
  // In the first child, the mutex stays locked for ever.
  const std::string bytes = sandboxed_read(file, "The library", [&] {
    const std::lock_guard lock(mutex);
    return std::string("read");
  });
  CHECK(bytes == "read");
  holder.join();
  releaser.join();
  CHECK_THAT(batten_test::error_message([&] {
               sandboxed_read(file, "The library", []() -> std::string {
                 for (;;) ::pause();
               });
             }),
             Contains("waits without end while reading this file"));
}

TEST_CASE("data read in a child process are the same", "[io][files]") {
  for (const char* name : {"two.step", "two.igs", "square.step"}) {
    CAPTURE(name);
    const auto here = read_cad_lines(seeds / "cad" / name, 1e-3);
    const SandboxScope guard;
    const auto there = read_cad_lines(seeds / "cad" / name, 1e-3);
    REQUIRE(here.size() == there.size());
    for (size_t i = 0; i < here.size(); ++i) {
      CHECK(here[i].name == there[i].name);
      const double a = here[i].curve->start(), b = here[i].curve->end();
      CHECK(a == there[i].curve->start());
      CHECK(b == there[i].curve->end());
      for (int k = 0; k <= 10; ++k)
        CHECK(here[i].curve->evaluate(a + (b - a) * k / 10, 0) ==
              there[i].curve->evaluate(a + (b - a) * k / 10, 0));
    }
  }
  for (const char* name : {"sheet.vtp", "binary.vtp", "sheet.vtu", "binary.vtu"}) {
    CAPTURE(name);
    const MeshFile here = MeshFile::read(seeds / "meshes" / name);
    const SandboxScope guard;
    const MeshFile there = MeshFile::read(seeds / "meshes" / name);
    CHECK(here.shells().points == there.shells().points);
    REQUIRE(here.shells().face_count() == there.shells().face_count());
    for (int f = 0; f < here.shells().face_count(); ++f) {
      const auto a = here.shells().face(f), b = there.shells().face(f);
      CHECK(std::vector<int>(a.begin(), a.end()) == std::vector<int>(b.begin(), b.end()));
    }
  }
}

TEST_CASE("files are read and written the same whatever the process's locale is", "[io][files]") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\1"; }
  };
  const auto seen = [] {
    std::string all =
        format_number(1234.5) + " " + format_number(-1e-9) + " " + format_number(1e300);
    const auto add = [&](const Vec3& p) {
      for (int k = 0; k < 3; ++k) all += " " + std::to_string(std::llround(1e6 * p[k]));
    };
    for (const char* name : {"arc.txt", "foil.dat", "lines.obj", "names.csv", "two.xyz"})
      for (const NamedPoints& line : read_point_lines(seeds / "lines" / name, 1))
        for (const Vec3& p : line.points) add(p);
    for (const char* name : {"two.step", "two.igs", "square.step"})
      for (const CharacterLine& line : read_cad_lines(seeds / "cad" / name, 1e-3))
        add(line.curve->evaluate(line.curve->start(), 0));
    for (const char* name : {"part.dxf", "plate.svg"})
      for (const DrawnLine& line : read_drawing(seeds / "drawings" / name).lines)
        for (const Vec3& p : line.points) add(p);
    for (const auto& entry : fs::directory_iterator(seeds / "meshes")) {
      const MeshFile mesh = MeshFile::read(entry.path());
      for (int i = 0; i < mesh.shells().node_count(); ++i) add(mesh.shells().points.row(i));
      const fs::path copy = batten_test::scratch("locale") / entry.path().filename();
      fs::create_directories(copy.parent_path());
      const Points moved = mesh.shells().points * 1.5;
      mesh.write(copy, moved);
      all += std::to_string(fs::file_size(copy));
      const MeshFile again = MeshFile::read(copy);
      for (int i = 0; i < again.shells().node_count(); ++i) add(again.shells().points.row(i));
    }
    return all;
  };
  const std::string usual = seen();
  const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
  const std::string there = seen();
  std::locale::global(before);
  CHECK(usual.size() > 1000);
  CHECK(there == usual);
}
