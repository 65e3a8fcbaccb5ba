// SPDX-License-Identifier: MPL-2.0
// Curves of drawings: exact arcs, at the right position, in the stated unit.
#include "batten/core/errors.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/io/lines/drawing.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

#include <numbers>

using namespace batten;
namespace fs = std::filesystem;

namespace {

fs::path file_with(const std::string& name, const std::string& text) {
  static const fs::path folder = batten_test::scratch("drawings");
  std::ofstream(folder / name, std::ios::binary) << text;
  return folder / name;
}

// Group codes and values with blanks between them; the entities of a DXF file.
Drawing dxf(const std::string& entities, const std::string& blocks = "", int unit = 4) {
  std::string pairs = "0 SECTION 2 HEADER 9 $INSUNITS 70 " + std::to_string(unit) +
                      " 0 ENDSEC 0 SECTION 2 BLOCKS " + blocks + " 0 ENDSEC 0 SECTION 2 ENTITIES " +
                      entities + " 0 ENDSEC 0 EOF";
  for (char& c : pairs)
    if (c == ' ') c = '\n';
  for (size_t i; (i = pairs.find("\n\n")) != pairs.npos;) pairs.erase(i, 1);
  return read_drawing(file_with("a.dxf", pairs + "\n"));
}

Drawing svg(const std::string& body, const std::string& head = "") {
  return read_drawing(
      file_with("a.svg", "<?xml version='1.0'?><svg xmlns='http://www.w3.org/2000/svg' " + head +
                             ">" + body + "</svg>"));
}

double length(const DrawnLine& line) { return ArcLength(line.curve).total(); }
Vec3 first(const DrawnLine& line) { return line.curve->evaluate(line.curve->start()); }
Vec3 last(const DrawnLine& line) { return line.curve->evaluate(line.curve->end()); }
double off_circle(const DrawnLine& line, const Vec3& centre, double radius) {
  double worst = 0;
  for (int i = 0; i <= 100; ++i) {
    const double t = line.curve->start() + (line.curve->end() - line.curve->start()) * i / 100;
    worst = std::max(worst, std::abs((line.curve->evaluate(t) - centre).norm() - radius));
  }
  return worst;
}
bool near(const Vec3& a, const Vec3& b) { return (a - b).norm() < 1e-9; }
std::string error_message(const fs::path& path) {
  try {
    read_drawing(path);
  } catch (const InputError& e) {
    return std::string(e.what()).substr(path.string().size() + 2);
  }
  return "";
}

using std::numbers::pi;

}  // namespace

TEST_CASE("DXF: lines, arcs and circles keep layer, position and unit", "[io][drawings]") {
  const Drawing d =
      dxf("0 LINE 8 0 10 1 20 2 30 3 11 4 21 5 31 6 "
          "0 ARC 8 rim 10 1 20 0 30 5 40 2 50 270 51 90 "
          "0 CIRCLE 8 rim 10 0 20 0 30 0 40 3 "
          "0 TEXT 8 0 10 0 20 0 40 1 1 words",
          "", 1);
  CHECK(d.unit_in_metres == 0.0254);
  REQUIRE(d.lines.size() == 3);
  CHECK(d.lines[0].name == "a");
  CHECK(d.lines[0].points == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
  CHECK(d.lines[1].name == "rim_1");
  CHECK(near(first(d.lines[1]), Vec3(1, -2, 5)));
  CHECK(near(last(d.lines[1]), Vec3(1, 2, 5)));
  CHECK(off_circle(d.lines[1], Vec3(1, 0, 5), 2) < 1e-7);
  CHECK(std::abs(length(d.lines[1]) - 2 * pi) < 1e-6);
  CHECK(std::abs(length(d.lines[2]) - 6 * pi) < 1e-6);
  CHECK(d.notes == std::vector<std::string>{"skipped: 1 TEXT"});
}

TEST_CASE("DXF: arcs of planes that look the other way are mirrored", "[io][drawings]") {
  const Drawing d = dxf("0 ARC 8 0 10 1 20 0 30 5 40 2 50 0 51 90 210 0 220 0 230 -1");
  CHECK(near(first(d.lines[0]), Vec3(-3, 0, -5)));
  CHECK(near(last(d.lines[0]), Vec3(-1, 2, -5)));
}

TEST_CASE("DXF: bulges are arcs to the left, polylines without them are points", "[io][drawings]") {
  // A slot: two straight sides, two half circles.
  const Drawing d =
      dxf("0 LWPOLYLINE 8 slot 90 4 70 1 38 7 10 0 20 0 10 10 20 0 42 1 10 10 20 4 10 0 20 4 42 1 "
          "0 LWPOLYLINE 8 open 90 3 70 0 10 0 20 0 10 1 20 0 10 1 20 1");
  REQUIRE(d.lines.size() == 2);
  REQUIRE(d.lines[0].curve);
  CHECK(std::abs(length(d.lines[0]) - (20 + 4 * pi)) < 1e-6);
  CHECK(near(first(d.lines[0]), Vec3(0, 0, 7)));
  double right = 0;
  for (int i = 0; i <= 1000; ++i) {
    const auto& c = *d.lines[0].curve;
    right = std::max(right, c.evaluate(c.start() + (c.end() - c.start()) * i / 1000).x());
  }
  CHECK(std::abs(right - 12) < 1e-4);
  CHECK(d.lines[1].points == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
}

TEST_CASE("DXF: splines and ellipses are kept", "[io][drawings]") {
  const Drawing d =
      dxf("0 SPLINE 8 0 70 8 71 3 72 8 73 4 40 0 40 0 40 0 40 0 40 1 40 1 40 1 40 1 "
          "10 0 20 0 30 0 10 1 20 3 30 0 10 2 20 3 30 1 10 3 20 0 30 2 "
          "0 ELLIPSE 8 e 10 1 20 1 30 0 11 0 21 2 31 0 40 0.5 41 0 42 1.5707963267948966");
  REQUIRE(d.lines.size() == 2);
  CHECK(near(d.lines[0].curve->evaluate(0.5), Vec3(1.5, 2.25, 0.625)));
  CHECK(near(first(d.lines[1]), Vec3(1, 3, 0)));
  CHECK(near(last(d.lines[1]), Vec3(0, 1, 0)));
}

TEST_CASE("DXF: blocks are placed with scale, turn and base point", "[io][drawings]") {
  const std::string blocks =
      "0 BLOCK 8 0 2 part 70 0 10 1 20 0 30 0 3 part 0 LINE 8 0 10 1 20 0 30 0 11 2 21 0 31 0 "
      "0 ENDBLK 8 0";
  const Drawing d = dxf("0 INSERT 8 wall 2 part 10 5 20 5 30 0 41 2 42 2 43 1 50 90", blocks);
  REQUIRE(d.lines.size() == 1);
  CHECK(d.lines[0].name == "wall");
  CHECK(near(d.lines[0].points[0], Vec3(5, 5, 0)));
  CHECK(near(d.lines[0].points[1], Vec3(5, 7, 0)));
}

TEST_CASE("SVG: shapes stand upright in the page's unit", "[io][drawings]") {
  const Drawing d =
      svg("<line id='l' x1='0' y1='200' x2='10' y2='200'/>"
          "<g transform='translate(10 20) rotate(90)' id='g'>"
          "<circle id='c' cx='5' cy='0' r='3'/></g>"
          "<rect id='r' x='0' y='0' width='10' height='6' rx='2'/>"
          "<polygon id='p' points='0,0 4,0 4,3'/><text>words</text><defs><circle r='1'/></defs>",
          "width='100mm' height='200mm' viewBox='0 0 100 200'");
  CHECK(std::abs(d.unit_in_metres - 0.001) < 1e-15);
  REQUIRE(d.lines.size() == 4);
  CHECK(d.lines[0].name == "l");
  CHECK(d.lines[0].points == std::vector<Vec3>{{0, 0, 0}, {10, 0, 0}});
  CHECK(off_circle(d.lines[1], Vec3(10, 175, 0), 3) < 1e-7);
  CHECK(std::abs(length(d.lines[2]) - (2 * 6 + 2 * 2 + 4 * pi)) < 1e-6);
  REQUIRE(d.lines[3].points.size() == 4);
  CHECK(near(d.lines[3].points[2], Vec3(4, 197, 0)));
  CHECK(d.lines[3].points.front() == d.lines[3].points.back());
  CHECK(d.notes == std::vector<std::string>{"skipped: 1 text"});
}

TEST_CASE("SVG: paths keep their curves, straight ones are points", "[io][drawings]") {
  const Drawing d =
      svg("<path id='a' d='M 0 0 h 10 a 2 2 0 0 1 0 4 h -10 a 2 2 0 0 1 0 -4 z'/>"
          "<path id='b' d='m 1,1 2,0 0,2 z'/>"
          "<path id='q' d='M 0 0 Q 1 2 2 0 M 5 5 C 5 6 6 7 7 7'/>");
  CHECK(std::abs(d.unit_in_metres - 0.0254 / 96) < 1e-15);
  REQUIRE(d.lines.size() == 4);
  CHECK(std::abs(length(d.lines[0]) - (20 + 4 * pi)) < 1e-6);
  CHECK(d.lines[1].points == std::vector<Vec3>{{1, -1, 0}, {3, -1, 0}, {3, -3, 0}, {1, -1, 0}});
  CHECK(d.lines[2].name == "q_1");
  const auto& c = *d.lines[2].curve;
  CHECK(near(c.evaluate((c.start() + c.end()) / 2), Vec3(1, -1, 0)));
  CHECK(near(last(d.lines[3]), Vec3(7, -7, 0)));
}

TEST_CASE("drawings that are damaged or empty are named", "[io][drawings]") {
  using Catch::Matchers::Contains;
  CHECK_THAT(error_message(file_with("b.dxf", "AutoCAD Binary DXF\r\n")), Contains("binary DXF"));
  CHECK_THAT(error_message(file_with("b.dxf", "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n1")),
             Contains("truncated"));
  CHECK_THAT(error_message(file_with("b.dxf", "0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n")),
             Contains("found no curve"));
  CHECK_THAT(error_message(file_with("b.svg", "<svg><path d='M 0 0 L 1")), Contains("XML"));
  CHECK_THAT(error_message(file_with("b.svg", "<svg><path id='p' d='M 0 0 L one'/></svg>")),
             Contains("found d = 'M 0 0 L one' of a path with id 'p', expected path data"));
  CHECK_THAT(error_message(file_with("b.svg", "<svg><rect id='r' width='wide' height='1'/></svg>")),
             Contains("found width = 'wide'"));
  CHECK_THAT(error_message(file_with("b.svg", "<svg><rect x='inf' width='1' height='1'/></svg>")),
             Contains("found x = 'inf' of a rect"));
  CHECK_THAT(error_message(
                 file_with("b.svg", "<svg><rect x='1e50' y='1e50' width='1' height='1'/></svg>")),
             Contains("found no curve to concatenate"));
  CHECK_THAT(error_message(file_with("b.svg", "<svg><polyline points='1,2 nan,4'/></svg>")),
             Contains("pairs of numbers"));
  CHECK_THAT(
      error_message(file_with("b.svg", "<svg><g transform='spin(3)'><line x2='1'/></g></svg>")),
      Contains("transform"));
  CHECK_THAT(error_message(file_with("b.svg", "<html></html>")), Contains("found no <svg>"));
}
