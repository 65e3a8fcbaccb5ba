// SPDX-License-Identifier: MPL-2.0
// Path data of SVG: all commands, and arcs that lie on their ellipses.
#include <numbers>
#include <random>
#include <sstream>

#include "batten/io/lines/svg_path.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

// The segments as absolute commands, subpath by subpath.
std::string absolute(std::string_view data) {
  std::ostringstream text;
  for (const SvgSubpath& part : parse_svg_path(data)) {
    text << "M" << part.start.x() << "," << part.start.y();
    for (const SvgSegment& s : part.segments) {
      text << (s.type == SvgSegment::Type::line  ? " L"
               : s.type == SvgSegment::Type::arc ? " A"
                                                 : " C");
      for (int i = s.type == SvgSegment::Type::cubic ? 1 : 3; i < 4; ++i)
        text << s.points[i].x() << "," << s.points[i].y() << (i < 3 ? " " : "");
    }
    text << ";";
  }
  return text.str();
}

Vec2 point_at(const SvgArc& arc, double t) {
  const Vec2 p(arc.radii.x() * std::cos(t), arc.radii.y() * std::sin(t));
  const double c = std::cos(arc.rotation), s = std::sin(arc.rotation);
  return arc.centre + Vec2(c * p.x() - s * p.y(), s * p.x() + c * p.y());
}

std::string error_of(const char* data) {
  try {
    parse_svg_path(data);
  } catch (const SvgPathError& e) {
    return std::to_string(e.index) + ": " + e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("commands of SVG paths are absolute, relative and repeated", "[io][drawings]") {
  CHECK(absolute("M1,2 3,4 5 6") == "M1,2 L3,4 L5,6;");
  CHECK(absolute("m1,2 3,4h1v-1H0V0z") == "M1,2 L4,6 L5,6 L5,5 L0,5 L0,0 L1,2;");
  CHECK(absolute("M0 0L1 0 1 1zl2 2") == "M0,0 L1,0 L1,1 L0,0;M0,0 L2,2;");
  CHECK(absolute("M0 0L1 0zm1 1 1 0z") == "M0,0 L1,0 L0,0;M1,1 L2,1 L1,1;");
  CHECK(absolute("M0,0C1,1 2,1 3,0S5-1 6,0s1,1 2,0") ==
        "M0,0 C1,1 2,1 3,0 C4,-1 5,-1 6,0 C7,1 7,1 8,0;");
  CHECK(absolute("M0 0Q3 3 6 0T12 0t6 0") == "M0,0 C2,2 4,2 6,0 C8,-2 10,-2 12,0 C14,2 16,2 18,0;");
  // Without a curve of the same kind before it, the reflected control point is the current point.
  CHECK(absolute("M3 0S3 3 6 0M3 0T6 3") == "M3,0 C3,0 3,3 6,0;M3,0 C3,0 4,1 6,3;");
  CHECK(absolute("M0 0Q3 3 6 0zT3 0") == "M0,0 C2,2 4,2 6,0 L0,0;M0,0 C0,0 1,0 3,0;");
  CHECK(absolute("M.5.5-1e1.5+2-3.") == "M0.5,0.5 L-10,0.5 L2,-3;");
  CHECK(absolute("M0 0A5 5 0 1020 0a5,5,0,01-10 0A0 5 0 0 1 3 3") == "M0,0 A20,0 A10,0 L3,3;");
  CHECK(absolute("").empty());
  CHECK(absolute("M1 1") == "M1,1;");
  CHECK(absolute("M1 1L1 1 2 2A1 1 0 0 0 2 2z") == "M1,1 L2,2 L1,1;");  // zero length
}

TEST_CASE("errors in SVG paths have a position", "[io][drawings]") {
  CHECK(error_of("L0 0") == "0: found 'L0', expected the command M");
  CHECK(error_of("M0 0 L 1") == "8: found the end, expected a number");
  CHECK(error_of("M0 0 L 1 x") == "9: found 'x', expected a number");
  CHECK(error_of("M0,,0") == "3: found ',0', expected a number");
  CHECK(error_of("M,0 0") == "1: found ',0', expected a number");
  CHECK(error_of("M0 0,") == "4: found ',', expected a command (M, Z, L, H, V, C, S, Q, T or A)");
  CHECK(error_of("M0 0z1 1").starts_with("5: found '1', expected a command"));
  CHECK(error_of("M0 0A1 1 0 2 0 1 1") == "11: found '2', expected a flag (0 or 1)");
  CHECK(error_of("M0 nan") == "3: found 'nan', expected a number");
  CHECK(error_of("M0 1e999").starts_with("3: found '1e999', expected a number between"));
  CHECK(error_of("M0 0 X").starts_with("5: found 'X', expected a command"));
}

TEST_CASE("SVG arcs go from end to end on their ellipse", "[io][drawings]") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(-10, 10), radius(0.1, 20);
  for (int i = 0; i < 400; ++i) {
    const Vec2 a(at(random), at(random)), b(at(random), at(random));
    const Vec2 radii(radius(random), radius(random));
    const bool large = i & 1, sweep = i & 2;
    const SvgArc arc = svg_arc(a, b, radii, at(random), large, sweep);
    CHECK((point_at(arc, arc.from) - a).norm() < 1e-12 * arc.radii.norm());
    CHECK((point_at(arc, arc.to) - b).norm() < 1e-12 * arc.radii.norm());
    CHECK((arc.to > arc.from) == sweep);
    const double turn = std::abs(arc.to - arc.from), half = std::numbers::pi;
    CHECK((large ? turn >= half - 1e-12 : turn <= half + 1e-12));
    // Radii that are too small are enlarged, by one factor, to half a turn.
    const double factor = arc.radii.x() / radii.x();
    CHECK(factor >= 1);
    CHECK(arc.radii.y() / radii.y() == Approx(factor));
    if (factor > 1) CHECK(turn == Approx(half));
  }
}
