// SPDX-License-Identifier: MPL-2.0
// Sketch graphs become curves with all segments unchanged.
#include "batten/io/lines/drawing.h"

#include <filesystem>
#include <fstream>

#include "batten/io/lines/curve_files.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using batten_test::error_message;

namespace {

std::filesystem::path file_with(const std::string& text, const std::string& name) {
  const auto folder = std::filesystem::path(BATTEN_BINARY_DIR) / "test_sketch_graph";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name) << text;
  return folder / name;
}

std::string error_message_of(const std::string& text) {
  return error_message([&] { read_sketch_graph(file_with(text, "bad.json")); });
}

const std::string good = R"({
 "strokes": [{"id": 5, "segments": [7, 8]}, {"id": 9, "segments": [11]}, {"id": 10, "segments": []}],
 "segments": [
  {"id": 7, "stroke_id": 5, "ctrl_pts": [[[0,0,0],[1,0,0],[2,1,0],[2,2,0]]], "nodes": [0, 1]},
  {"id": 8, "stroke_id": 5, "ctrl_pts": [[[2,2,0],[2,2,0]], [[2,2,0],[2,5,0]]], "nodes": [1, 2]},
  {"id": 11, "stroke_id": 9, "ctrl_pts": [[[0,0,1],[3,0,1]]], "nodes": [3, 4]}],
 "nodes": []})";

std::string with(const std::string& was, const std::string& is) {
  std::string text = good;
  const size_t at = text.find(was);
  REQUIRE(at != std::string::npos);
  return text.replace(at, was.size(), is);
}

}  // namespace

TEST_CASE("A stroke is one curve, its pieces exactly those of the file", "[io][sketches]") {
  const auto lines = read_sketch_graph(file_with(good, "good.json"));
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].name == "stroke 5");
  CHECK(lines[1].name == "stroke 9");
  const InputCurve& curve = *lines[0].curve;
  CHECK(curve.piecewise_cubic());
  CHECK(curve.breaks() == std::vector<double>{0, 1, 2});  // without the segment of length 0
  // De Casteljau at 1/2.
  CHECK((curve.evaluate(0.5) - Vec3(11.0 / 8, 5.0 / 8, 0)).norm() < 1e-15);
  CHECK((curve.evaluate(0, 1) - Vec3(3, 0, 0)).norm() < 1e-15);
  CHECK((curve.evaluate(1.25) - Vec3(2, 2.75, 0)).norm() < 1e-15);
  CHECK((curve.evaluate(2) - Vec3(2, 5, 0)).norm() < 1e-15);
  for (const double t : {0.1, 0.6, 1.3, 1.9})
    for (const int order : {1, 2}) {
      const double h = 1e-5;
      const Vec3 difference =
          (curve.evaluate(t + h, order - 1) - curve.evaluate(t - h, order - 1)) / (2 * h);
      CHECK((curve.evaluate(t, order) - difference).norm() < 1e-8);
    }
}

TEST_CASE("Errors in a sketch graph are reported with file and position", "[io][sketches]") {
  CHECK(error_message([] { read_sketch_graph("no/such.json"); }).find("no/such.json: ") == 0);
  CHECK(error_message_of("{").find("invalid JSON") != std::string::npos);
  CHECK(error_message_of("[]").find("\"segments\"") != std::string::npos);
  CHECK(error_message_of(R"({"segments": [], "strokes": []})").find("no stroke") !=
        std::string::npos);
  CHECK(error_message_of(with("[7, 8]", "[7, 12]")).find("stroke 5: found segment 12") !=
        std::string::npos);
  CHECK(error_message_of(with("[7, 8]", "[8, 7]")).find("stroke 5: ") != std::string::npos);
  CHECK(error_message_of(with("[1,0,0]", "[1,0]")).find("segment 7: found [1,0]") !=
        std::string::npos);
  CHECK(error_message_of(with("[1,0,0]", "[1,0,null]")).find("segment 7: ") != std::string::npos);
  CHECK(error_message_of(with("[1,0,0],", "")).find("4 control points") != std::string::npos);
  CHECK(error_message_of(with("\"id\": 8", "\"id\": 7")).find("segment 7: found its id twice") !=
        std::string::npos);
  CHECK(error_message_of(with("\"id\": 9", "\"id\": 5")).find("stroke 5: found its id twice") !=
        std::string::npos);
  CHECK(error_message_of(with("\"id\": 8", "\"id\": \"8\"")).find("a segment: ") !=
        std::string::npos);
}

TEST_CASE("Rows with CURVE begin and name curves of a point file", "[io][sketches]") {
  const auto lines = read_point_lines(
      file_with("CURVE 0\n0 0 0\n1 0 0\nCURVE 12\n0 1 0\n1 1 0\n2 1 5\n", "a.txt"));
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].name == "curve 0");
  CHECK(lines[1].name == "curve 12");
  CHECK(lines[0].points.size() == 2);
  CHECK(lines[1].points == std::vector<Vec3>{{0, 1, 0}, {1, 1, 0}, {2, 1, 5}});
  CHECK(error_message([] {
          read_point_lines(file_with("CURVE 0\nCURVE 1\n0 0 0\n1 0 0\n", "b.txt"));
        }).find("b.txt:1:1: found a curve with 0 points") != std::string::npos);
}
