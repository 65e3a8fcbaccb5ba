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

TEST_CASE("DXF: only curves of the model are read, others are named", "[io][drawings]") {
  const std::string line = "10 0 20 0 30 0 11 1 21 0 31 0 ";
  const Drawing d =
      dxf("0 LINE 8 0 " + line + "0 LINE 8 frame 67 1 " + line +
          "0 DIMENSION 8 0 0 VIEWPORT 8 0 67 1 " +
          "0 POLYLINE 8 fit 66 1 70 4 0 VERTEX 8 fit 10 0 20 9 70 16 0 VERTEX 8 fit 10 0 20 0 70 8 "
          "0 VERTEX 8 fit 10 5 20 3 70 8 0 SEQEND 8 fit "
          "0 LINE 8 other 102 {APP 10 7 8 wrong 102 } " +
          line);
  REQUIRE(d.lines.size() == 3);
  CHECK(d.lines[1].points == std::vector<Vec3>{{0, 0, 0}, {5, 3, 0}});
  CHECK(d.lines[2].name == "other");
  CHECK(d.lines[2].points == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}});
  CHECK(d.notes == std::vector<std::string>{"skipped: 1 DIMENSION, 1 LINE in paper space"});
}

TEST_CASE("DXF: rational splines, elevations and text forms of other programs", "[io][drawings]") {
  // A quarter of a circle as a rational quadratic spline.
  const Drawing d =
      dxf("0 SPLINE 8 0 70 4 71 2 72 6 73 3 40 0 40 0 40 0 40 1 40 1 40 1 "
          "10 5 20 0 30 0 10 5 20 5 30 0 10 0 20 5 30 0 41 1 41 0.7071067811865476 41 1 "
          "0 POLYLINE 8 p 66 1 10 0 20 0 30 7 70 1 0 VERTEX 8 p 10 0 20 0 42 1 "
          "0 VERTEX 8 p 10 2,5 20 +0 0 SEQEND");
  REQUIRE(d.lines.size() == 2);
  CHECK(off_circle(d.lines[0], Vec3::Zero(), 5) < 1e-9);
  CHECK(off_circle(d.lines[1], Vec3(1.25, 0, 7), 1.25) > 1);  // half a circle and its chord
  CHECK(near(first(d.lines[1]), Vec3(0, 0, 7)));

  std::string text =
      "\xEF\xBB\xBF  0\r\nSECTION\r\n  2\r\nHEADER\r\n  9\r\n$UCSNAME\r\n  2\r\nTOP\r\n"
      "  9\r\n$INSUNITS\r\n 70\r\n     5\r\n  0\r\nENDSEC\r\n999\r\n";
  text += std::string(100000, 'x') +
          "\r\n  0\r\nSECTION\r\n  2\r\nENTITIES\r\n  0\r\nCIRCLE\r\n 40\r\n1.\r\n"
          "  0\r\nENDSEC\r\n  0\r\nEOF\r\n\r\n";
  const Drawing foreign = read_drawing(file_with("foreign.dxf", text));
  CHECK(foreign.unit_in_metres == 0.01);
  CHECK(foreign.lines.size() == 1);
}

TEST_CASE("DXF: errors have the line of the value", "[io][drawings]") {
  const auto error = [](const std::string& entities) -> std::string {
    try {
      dxf(entities);
    } catch (const InputError& e) {
      const std::string message = e.what();
      return message.substr(message.find("a.dxf") + 5);
    }
    return "";
  };
  CHECK(error("0 LINE 8 0 10 1 20 abc") ==
        ":28: found 'abc' with group code 20 of LINE, expected a number");
  CHECK(error("0 LINE 8 0 10 nan") ==
        ":26: found 'nan' with group code 10 of LINE, expected a number between -1e100 and 1e100, "
        "and not below 1e-307");
  CHECK(error("0 POLYLINE 70 1.5") ==
        ":24: found '1.5' with group code 70 of POLYLINE, expected an integer");
  CHECK(error("0 LINE x 0") == ":23: found 'x', expected a group code of a DXF file");
  CHECK(error("0 1.5 8 0") == ":22: found '1.5', expected the type of an entity or object");
  CHECK(error("0 ARC 40 1 50 0 51 360 0 SPLINE 71 3 10 1 10 2").starts_with(":30: found 2 poles"));
}

TEST_CASE("DXF: blocks that contain each other many times end", "[io][drawings]") {
  std::string blocks;
  for (int level = 0; level < 9; ++level) {
    blocks += "0 BLOCK 2 b" + std::to_string(level) + " ";
    for (int i = 0; i < 20; ++i) blocks += "0 INSERT 2 b" + std::to_string(level + 1) + " ";
    blocks += "0 ENDBLK ";
  }
  CHECK_THROWS_WITH(dxf("0 INSERT 2 b0", blocks),
                    Catch::Matchers::Contains("curves of inserted blocks, or inserted blocks"));
  CHECK_THROWS_WITH(dxf("0 INSERT 2 b", "0 BLOCK 2 b 0 INSERT 2 b 0 ENDBLK"),
                    Catch::Matchers::Contains("blocks that contain each other"));
}

TEST_CASE("DXF: splines through fit points are smooth, with the given tangents", "[io][drawings]") {
  const auto derivative = [](const DrawnLine& line, double t) {
    const double h = 1e-5;
    return Vec3((line.curve->evaluate(t + h) - line.curve->evaluate(t - h)) / (2 * h));
  };
  const std::string points = "11 0 21 0 31 0 11 10 21 0 31 0 ";
  // An S between two points with parallel tangents.
  Drawing d = dxf("0 SPLINE 8 0 70 0 71 3 74 2 12 0 22 1 32 0 13 0 23 1 33 0 " + points);
  REQUIRE(d.lines.size() == 1);
  const InputCurve& s = *d.lines[0].curve;
  const double third = s.start() + (s.end() - s.start()) / 4;
  CHECK(s.evaluate(third).y() > 0.5);
  CHECK(s.evaluate(s.end() - (third - s.start())).y() < -0.5);
  // Without tangents, and a closed curve.
  d = dxf("0 SPLINE 70 0 71 3 74 4 11 0 21 0 31 0 11 4 21 3 31 0 11 9 21 3 31 1 11 12 21 0 31 0");
  const InputCurve& open = *d.lines[0].curve;
  CHECK(near(first(d.lines[0]), Vec3(0, 0, 0)));
  CHECK(near(last(d.lines[0]), Vec3(12, 0, 0)));
  CHECK(near(open.evaluate(open.start() + 5), Vec3(4, 3, 0)));  // the chord length
  for (const double side : {-2e-5, 2e-5})
    CHECK((derivative(d.lines[0], open.start() + 5 + side) -
           derivative(d.lines[0], open.start() + 5 - side))
              .norm() < 1e-3);
  d = dxf("0 SPLINE 70 1 71 3 74 4 11 5 21 0 31 0 11 0 21 5 31 0 11 -5 21 0 31 0 11 0 21 -5 31 0");
  CHECK(near(first(d.lines[0]), last(d.lines[0])));
  CHECK(off_circle(d.lines[0], Vec3::Zero(), 5) < 0.14);  // 5 (1 - sqrt(2) 11/16)
  CHECK(std::abs(derivative(d.lines[0], d.lines[0].curve->start() + 1e-4).normalized().y()) >
        0.9999);
}

TEST_CASE("DXF: helices are exact, in both directions", "[io][drawings]") {
  for (const int right : {0, 1}) {
    const Drawing d =
        dxf("0 HELIX 8 spring 100 AcDbSpline 10 9 20 9 30 9 40 7 100 AcDbHelix 10 1 20 2 "
            "30 3 11 1 21 7 31 3 12 1 22 0 32 0 40 5 41 1.5 42 4 290 " +
            std::to_string(right));
    REQUIRE(d.lines.size() == 1);
    CHECK(near(first(d.lines[0]), Vec3(1, 7, 3)));
    CHECK((last(d.lines[0]) - Vec3(7, -3, 3)).norm() < 1e-6);
    const InputCurve& curve = *d.lines[0].curve;
    const Vec3 quarter = curve.evaluate(curve.start() + (curve.end() - curve.start()) / 6);
    CHECK((quarter - Vec3(2, 2, right ? 8 : -2)).norm() < 1e-6);
  }
}

TEST_CASE("DXF: layers that are off or frozen, and invisible entities, are not read",
          "[io][drawings]") {
  const std::string file =
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n0\nLAYER\n2\nOff\n70\n0\n62\n-7\n"
      "0\nLAYER\n2\nfrozen\n70\n1\n62\n7\n0\nLAYER\n2\non\n70\n0\n62\n7\n0\nENDTAB\n0\nENDSEC\n"
      "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\nOFF\n11\n1\n0\nCIRCLE\n8\nFrozen\n40\n1\n"
      "0\nPOLYLINE\n8\nfrozen\n0\nVERTEX\n8\nfrozen\n10\n1\n0\nVERTEX\n10\n2\n0\nSEQEND\n"
      "0\nLINE\n8\non\n60\n1\n11\n1\n0\nLINE\n8\non\n11\n5\n0\nENDSEC\n0\nEOF\n";
  const Drawing d = read_drawing(file_with("layers.dxf", file));
  REQUIRE(d.lines.size() == 1);
  CHECK(d.lines[0].points.back() == Vec3(5, 0, 0));
  CHECK(d.notes == std::vector<std::string>{
                       "skipped: 1 CIRCLE on layers that are off or frozen, 1 LINE on layers that "
                       "are off or frozen, 1 LINE that is invisible, 1 POLYLINE on layers that are "
                       "off or frozen"});
  CHECK(d.warnings.empty());
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
  CHECK_THAT(
      error_message(file_with("b.svg", "<svg><path id='p' d='M 0 0 L one'/></svg>")),
      Contains("found d = 'M 0 0 L one' of a path with id 'p', expected path data (M, L, C, A, "
               "z …); at character 9: found 'one', expected a number"));
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
