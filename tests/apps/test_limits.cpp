// SPDX-License-Identifier: MPL-2.0
// The limits of docs/limitations.md, each on both sides: input within the limit works, input beyond it
// is rejected before any work.
#include <sys/stat.h>

#include <cmath>
#include <numbers>

#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

std::string square(const std::string& mesh) {
  return "unit = \"mm\"\n[[curve]]\nname = \"a\"\npoints = [[0,0,0],[100,0,0]]\n"
         "[[curve]]\nname = \"b\"\npoints = [[100,0,0],[100,100,0]]\n"
         "[[curve]]\nname = \"c\"\npoints = [[100,100,0],[0,100,0]]\n"
         "[[curve]]\nname = \"d\"\npoints = [[0,100,0],[0,0,0]]\n[mesh]\n" +
         mesh + "\n[output]\nvtp = \"s.vtp\"\n";
}

std::string with_tolerance(const std::string& tolerance, std::string scene) {
  return scene.insert(scene.find("[[curve]]"), "fit_tolerance = " + tolerance + "\n");
}

std::string nested(int levels) {
  return "x = " + std::string(static_cast<size_t>(levels), '[') +
         std::string(static_cast<size_t>(levels), ']') + "\n";
}

}  // namespace

TEST_CASE("meshes that memory cannot hold are refused beforehand, with what fits",
          "[apps][limits]") {
  const CliCase c("limits_memory");
  c.fails(square("edge_length = 0.3"), 1,
          {"edge_length = 0.3 on a face of size", "triangles, which need", "GB of memory, but only",
           "are available; edge_length = ", " needs "},
          {"--memory", "0.5"});
  c.fails(square("edge_length = 0.05"), 1, {"triangles, expected at most 2e+06"});
  // The value in the message is within the limit.
  c.file("s.toml", square("edge_length = 0.3"));
  const std::string message = c.run({"run", "s.toml", "--out", "out", "--memory", "0.5"}).err;
  const size_t at = message.find("are available; edge_length = ");
  REQUIRE(at != std::string::npos);
  const std::string edge = message.substr(at + 29, message.find(' ', at + 29) - at - 29);
  c.file("s.toml", square("edge_length = " + edge));
  CHECK(c.run({"run", "s.toml", "--out", "out", "--memory", "0.5"}).code == 0);
}

TEST_CASE("the memory limit counts all faces of a network together", "[apps][limits]") {
  const CliCase c("limits_network");
  const fs::path box = fs::path(BATTEN_SOURCE_DIR) / "tests/fuzz/seeds/networks/box.csv";
  const CliResult r =
      c.run({"skin", box.string(), "--edge-length", "0.004", "--memory", "1", "--out", "out"});
  CHECK(r.code == 1);
  CHECK(r.err.find("edge_length = 0.004 on all faces of a network of size") != std::string::npos);
  CHECK(r.err.find("GB of memory, but only") != std::string::npos);
  CHECK_FALSE(fs::exists(c / "out"));
}

TEST_CASE("pictures, integers and threads have limits, which the messages state",
          "[apps][limits]") {
  const CliCase c("limits_numbers");
  const auto picture = [](const std::string& size) {
    return square("") + "[[picture]]\nfile = \"s.png\"\nsize = " + size + "\n";
  };
  const auto info = [&](const std::string& scene) {
    c.file("s.toml", scene);
    return c.run({"info", "s.toml"});
  };
  CHECK(info(picture("[64, 4096]")).code == 0);
  for (const char* size : {"[63, 100]", "[100, 4097]"})
    c.fails(picture(size), 1, {"s.toml:", "expected 64 to 4096 pixels each"});
  const auto looked = [](const std::string& contours) {
    return square("") + "[[picture]]\nfile = \"s.png\"\ncontours = " + contours + "\n";
  };
  CHECK(info(looked("1000000")).code == 0);
  c.fails(looked("1000001"), 1, {"s.toml:", "a whole number from 0 to 1000000 for 'contours'"});
  c.fails(square("edge_length = 60"), 1, {"1025"}, {"--threads", "1025"});
  CHECK(c.run({"run", "s.toml", "--out", "out", "--threads", "1024"}).code == 0);
}

TEST_CASE("a motion has a million steps at most", "[apps][limits]") {
  const CliCase c("limits_steps");
  c.file("s.toml",
         square("edge_length = 60") + "[[load]]\nname = \"p\"\ntype = \"pressure\"\nvalue = 1\n");
  const CliResult r =
      c.run({"sculpt", "s.toml", "--out", "out", "--time", "1000.01", "--dt", "0.001"});
  CHECK(r.code == 1);
  CHECK(r.err.find("found 1.00001e+06 time steps, expected at most a million") !=
        std::string::npos);
  CHECK_FALSE(fs::exists(c / "out"));
}

TEST_CASE("the tolerance of a network is at most a tenth of its size", "[apps][limits]") {
  const CliCase c("limits_tolerance");
  const fs::path box = fs::path(BATTEN_SOURCE_DIR) / "tests/fuzz/seeds/networks/box.csv";
  const auto run = [&](const char* meet) {
    return c.run({"skin", box.string(), "--gap-tolerance", meet, "--out", "out"});
  };
  const CliResult r = run("0.25");  // of 2.449
  CHECK(r.code == 1);
  CHECK(r.err.find("expected at most a tenth of the network's size 2.44949") != std::string::npos);
  CHECK(run("0.24").code == 0);
}

TEST_CASE("the tolerance of curves is at least 1e-9 of the size", "[apps][limits]") {
  const CliCase c("limits_fine");
  c.file("in.toml", with_tolerance("1.415e-7", square("edge_length = 60")));  // of 141.42
  CHECK(c.run({"run", "in.toml", "--out", "in"}).code == 0);
  c.fails(with_tolerance("1.414e-7", square("")), 1,
          {"fit_tolerance = 1.414e-07 for a size of 141.421, expected 1.41421e-07 or more"});
  const fs::path box = fs::path(BATTEN_SOURCE_DIR) / "tests/fuzz/seeds/networks/box.csv";
  c.file("n.toml",
         "unit = \"m\"\nfit_tolerance = 1e-9\n\n[[curves]]\nfile = \"" + box.string() + "\"\n");
  const CliResult r = c.run({"run", "n.toml", "--out", "net"});
  CHECK(r.code == 1);
  CHECK(r.err.find("fit_tolerance = 1e-09 for a size of 2.44949") != std::string::npos);
}

TEST_CASE("a curve of a network has at most two million element edges", "[apps][limits]") {
  const CliCase c("limits_edges");
  const auto run = [&](const std::string& far) {
    c.file("t.csv",
           "x,y,z\n0,0,0\n1,0,0\n\n1,0,0\n0,1,0\n\n0,1,0\n0,0,0\n\n0,0,0\n0,0," + far + "\n");
    return c.run({"skin", "t.csv", "--unit", "m", "--edge-length", "0.1", "--gap-tolerance", "0.01",
                  "--out", "out"});
  };
  const CliResult far = run("3e5");
  CHECK(far.code == 1);
  CHECK(far.err.find("the edge length 0.1 on curve") != std::string::npos);
  CHECK(far.err.find("element edges, expected at most 2e+06") != std::string::npos);
}

TEST_CASE("triangles at curves are halved up to 50,000, and the remaining error is reported",
          "[apps][limits]") {
  const CliCase c("limits_halving");
  std::string scene = square("edge_length = 4");
  for (const int r : {12, 17, 22, 27, 32, 37, 42}) {  // rings with alternating heights
    const auto at = [r](int x, int y, int z) {
      return "[" + std::to_string(50 + r * x) + "," + std::to_string(50 + r * y) + "," +
             std::to_string(z) + "]";
    };
    scene += "[[curve]]\nname = \"ring " + std::to_string(r) + "\"\nrole = \"inner\"\npoints = [" +
             at(1, 0, 0) + "," + at(0, 1, 4) + "," + at(-1, 0, 0) + "," + at(0, -1, 4) + "," +
             at(1, 0, 0) + "]\n";
  }
  c.file("s.toml", with_tolerance("2e-7", scene));
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.out << r.err);
  CHECK(r.code == 4);
  CHECK(r.err.find("not refined beyond 50000 triangles: the surface may miss embedded curves by "
                   "more than the tolerance 2e-07") != std::string::npos);
  CHECK(r.err.find("check failed: surface.max_curve_gap is ") != std::string::npos);
}

TEST_CASE("STEP files hold surfaces up to 20 km", "[apps][limits]") {
  const CliCase c("limits_step");
  const auto triangle = [](double size) {
    const std::string s = std::to_string(size);
    return "x,y,z\n0,0,0\n" + s + ",0,0\n\n" + s + ",0,0\n0," + s + ",0\n\n0," + s + ",0\n0,0,0\n";
  };
  const auto run = [&](double size) {
    c.file("t.csv", triangle(size));
    return c.run({"skin", "t.csv", "--unit", "m", "--out", "out"});
  };
  const CliResult near = run(14'142), far = run(14'143);  // √2 of it
  INFO(near.err);
  CHECK(near.code == 0);
  CHECK(far.code == 4);
  CHECK(far.err.find("surface of size 20001.2, expected at most 20000 (20 km") !=
        std::string::npos);
  CHECK(fs::exists(c / "out/t.vtp"));
}

TEST_CASE("scenes may be nested so deep and no deeper", "[apps][limits]") {
  const CliCase c("limits_nesting");
  c.fails(nested(64) + square(""), 1, {"found key 'x'"});
  c.fails(nested(65) + square(""), 1, {"s.toml:1:69: found lists", "64 levels at most"});
  c.fails(nested(1000000) + square(""), 1, {"64 levels at most"});
}

TEST_CASE("pipes, devices and links in a circle are no files", "[apps][limits]") {
  const CliCase c("limits_files");
  REQUIRE(mkfifo((c / "pipe.csv").c_str(), 0600) == 0);
  fs::create_symlink("b.csv", c / "a.csv");
  fs::create_symlink("a.csv", c / "b.csv");
  fs::create_symlink("/dev/zero", c / "zero.csv");
  fs::create_directory(c / "folder.csv");
  const std::vector<std::pair<std::string, std::string>> all = {
      {"pipe", "found a pipe"},
      {"a", "found a cycle of symbolic links"},
      {"zero", "found a device"},
      {"folder", "found a folder"}};
  for (const auto& [name, expected] : all)
    for (const char* ending : {".csv", ".toml", ".json", ".step", ".igs", ".svg", ".dxf", ".obj",
                               ".vtp", ".bdf", ".stl"}) {
      const std::string file = name + ending;
      if (!fs::exists(fs::symlink_status(c / file))) fs::rename(c / (name + ".csv"), c / file);
      CAPTURE(file);
      const CliResult r = c.run({"info", file});
      CHECK(r.code == 1);
      CHECK(r.err.find(expected) != std::string::npos);
      fs::rename(c / file, c / (name + ".csv"));
      if (name == "a") break;  // the cycle is broken by another name
    }
}

TEST_CASE("a face of a mesh may have so many corners", "[apps][limits]") {
  const CliCase c("limits_face");
  const auto face = [](int corners) {
    std::string text, all = "f";
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners, r = i % 2 ? 1 : 0.9;  // a star
      text += "v " + std::to_string(r * std::cos(angle)) + " " +
              std::to_string(r * std::sin(angle)) + " 0\n";
      all += " " + std::to_string(i + 1);
    }
    return text + all + "\n";
  };
  c.file("a.obj", face(10'000));
  const CliResult r = c.run({"info", "a.obj"});
  INFO(r.err);
  CHECK(r.code == 0);
  c.file("a.obj", face(10'001));
  const CliResult more = c.run({"info", "a.obj"});
  CHECK(more.code == 1);
  CHECK(more.err.find("found a face of 10001 corners, expected at most 10000") !=
        std::string::npos);
}
