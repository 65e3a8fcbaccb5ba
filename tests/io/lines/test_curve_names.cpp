// SPDX-License-Identifier: MPL-2.0
// Names of curves survive writing and reading in every format, and drawings contain exactly the
// curves.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <sstream>

#include "batten/fairing/curves/input_curve.h"
#include "batten/fem/curves/bspline.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/lines/drawing.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using batten_test::error_message;
namespace fs = std::filesystem;
using Catch::Matchers::Contains;

namespace {

/// A generic C1 curve: uneven segments, no symmetry, size about 100. `flat`: index of a coordinate
/// that is constant; 3: none.
HermiteCurve wild_curve(int segments, bool closed, std::vector<int> corners, unsigned seed,
                        int flat = 3, double level = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> between(-1, 1);
  std::vector<double> u = {0.3};
  for (int s = 0; s < segments; ++s) u.push_back(u.back() + 1.5 + between(random));
  const CurveMesh mesh(u, closed, std::move(corners));
  Points dofs(mesh.dof_count(), 3);
  for (int d = 0; d < mesh.dof_count(); ++d)
    dofs.row(d) << 50 * between(random), 50 * between(random), 50 * between(random);
  if (flat < 3) dofs.col(flat).setZero();
  for (int n = 0; flat < 3 && n < mesh.node_count(); ++n) dofs(mesh.position_dof(n), flat) = level;
  return {mesh, dofs};
}

/// A curve of straight segments between corners.
HermiteCurve polygon(const std::vector<Vec3>& vertices, bool closed) {
  const int count = static_cast<int>(vertices.size());
  std::vector<double> u = {0};
  std::vector<int> corners;
  for (int i = 1; i < count + closed; ++i)
    u.push_back(u.back() + (vertices[i % count] - vertices[i - 1]).norm());
  for (int i = closed ? 0 : 1; i < count - !closed; ++i) corners.push_back(i);
  const CurveMesh mesh(u, closed, corners);
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < count; ++i) dofs.row(mesh.position_dof(i)) = vertices[i];
  for (int s = 0; s < mesh.segment_count(); ++s) {
    const Vec3 slope = (vertices[(s + 1) % count] - vertices[s]) / mesh.length(s);
    dofs.row(mesh.slope_out(s)) = slope;
    dofs.row(mesh.slope_in((s + 1) % mesh.node_count())) = slope;
  }
  return {mesh, dofs};
}

NamedCurve named(const std::string& name, const HermiteCurve& curve) {
  NamedCurve line{name, curve, {}, {}};
  for (int i = 0; i <= 7; ++i)
    line.parameters.push_back(curve.start() + (curve.end() - curve.start()) * i / 7);
  return line;
}

/// Curves with these names, which lie apart from each other in the plane z = 0.
std::vector<NamedCurve> flat_curves(const std::vector<std::string>& names) {
  std::vector<NamedCurve> curves;
  for (size_t i = 0; i < names.size(); ++i)
    curves.push_back(named(names[i], wild_curve(3, false, {}, static_cast<unsigned>(i + 1), 2, 0)));
  return curves;
}

bool is_drawing(const fs::path& file) {
  return file.extension() == ".dxf" || file.extension() == ".svg";
}
bool is_cad(const fs::path& file) {
  const std::string ending = file.extension().string();
  return ending.starts_with(".st") || ending.starts_with(".ig");
}

std::vector<std::string> names_in(const fs::path& file) {
  std::vector<std::string> names;
  if (is_drawing(file))
    for (const DrawnLine& line : read_drawing(file).lines) names.push_back(line.name);
  else if (is_cad(file))
    for (const CharacterLine& line : read_cad_lines(file, 1e-3)) names.push_back(line.name);
  else
    for (const NamedPoints& line : read_point_lines(file)) names.push_back(line.name);
  return names;
}

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("odd names of curves survive in every format that has names", "[io][curves][names]") {
  const fs::path folder = batten_test::scratch("curve_names");
  const std::string ending =
      GENERATE(".csv", ".obj", ".dxf", ".svg", ".step", ".stp", ".iges", ".igs");
  const std::vector<std::string> names = {"rail",
                                          "Rail",
                                          "left rail 2",
                                          "Größe über 5 µm",
                                          "日本語",
                                          "\U0001F600 smile",
                                          "<&>",
                                          "&amp;",
                                          "it's",
                                          "say \"hi\", twice",
                                          "\"quoted\"",
                                          "#3 // no comment",
                                          "a/b\\c",
                                          "x,y;z",
                                          "100 %",
                                          "12",
                                          "1 2 3",
                                          "x",
                                          "x,y,z,curve",
                                          "0",
                                          "Defpoints",
                                          "a^b",
                                          "\\U+00FC",
                                          "line|star*?=`",
                                          "CURVE 3",
                                          "-",
                                          std::string(400, 'n') + "ü"};
  const fs::path file = folder / ("a" + ending);
  CHECK(write_curves(file, flat_curves(names)).empty());
  CHECK(names_in(file) == names);
}

TEST_CASE("random names survive, with blanks at their ends", "[io][curves][names]") {
  const fs::path folder = batten_test::scratch("random_names");
  const std::string ending = GENERATE(".csv", ".dxf", ".svg");
  const std::vector<std::string> parts = {
      "a", "Z",      "0",      "7",        " ",          "  ", "\"",  "\"\"", "'",  "<",   ">",
      "&", ",",      ";",      "#",        "/",          "//", "\\",  "^",    "^J", "%%d", "ü",
      "ß", "\u00A0", "\u2013", "字",       "|",          "*",  "?",   "=",    "`",  ":",   "_",
      "-", ".",      "&lt;",   "\\U+0041", "\U0001F600", "#",  "]]>", "<!--"};
  std::mt19937 random(7);
  std::vector<std::string> names;
  for (int i = 0; i < 300; ++i) {
    std::string name;
    const size_t count = 1 + random() % (i % 10 == 0 ? 120 : 6);
    for (size_t k = 0; k < count; ++k) name += parts[random() % parts.size()];
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  const fs::path file = folder / ("a" + ending);
  CHECK(write_curves(file, flat_curves(names)).empty());
  CHECK(names_in(file) == names);
}

TEST_CASE("names are written as UTF-8 in one row", "[io][curves][names]") {
  const fs::path folder = batten_test::scratch("utf8_names");
  const std::string ending = GENERATE(".csv", ".obj", ".dxf", ".svg", ".step", ".iges");
  const fs::path file = folder / ("a" + ending);
  // Latin-1, a truncated character, control characters.
  write_curves(file, flat_curves({"Gr\xF6\xDF"
                                  "e",
                                  "cut \xE6\x97", "two\nrows\tof it"}));
  CHECK(names_in(file) == std::vector<std::string>{"Größe", "cut æ\u0097", "two rows of it"});
}

TEST_CASE("UTF-8 is decoded and encoded without loss", "[io][text]") {
  const std::string text = "aé日\U0001F600\x7F";
  CHECK(code_points(text) == U"aé日\U0001F600\x7F");
  CHECK(utf8(code_points(text)) == text);
  // Too long, surrogate, beyond Unicode, not continued: each byte for itself.
  for (const char* bad :
       {"\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xE9x"}) {
    const std::u32string points = code_points(bad);
    CHECK(points.size() == std::string(bad).size());
    CHECK(points[0] == static_cast<unsigned char>(bad[0]));
    CHECK(code_points(utf8(points)) == points);
  }
}

TEST_CASE("equal and empty names are told apart when they are read", "[io][curves][names]") {
  const fs::path folder = batten_test::scratch("equal_names");
  const auto curves = flat_curves({"a", "", "b", "a", "", "a"});
  for (const std::string ending : {".csv", ".obj", ".dxf", ".svg"}) {
    INFO(ending);
    CHECK(write_curves(folder / ("f" + ending), curves).empty());
    CHECK(names_in(folder / ("f" + ending)) ==
          std::vector<std::string>{"a_1", "f_1", "b", "a_2", "f_2", "a_3"});
  }
  for (const std::string ending : {".step", ".iges"}) {
    INFO(ending);
    CHECK(write_curves(folder / ("f" + ending), curves).empty());
    CHECK(names_in(folder / ("f" + ending)) ==
          std::vector<std::string>{"a", "edge2", "b", "a_2", "edge5", "a_3"});
  }
}

TEST_CASE("a file of strokes reports that it has no names", "[io][curves][names]") {
  const fs::path file = batten_test::scratch("stroke_names") / "a.curves";
  const auto notes = write_curves(file, flat_curves({"rail", "rib"}));
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("a.curves: the names of the curves are not written"));
  CHECK(write_curves(file, flat_curves({"rail"})).size() == 1);
  // Numbers only, which readers assign again.
  CHECK(write_curves(file, flat_curves({"sketch_1", "sketch_2"})).empty());
  CHECK(names_in(file) == std::vector<std::string>{"a_1", "a_2"});
}

TEST_CASE("tables may quote fields with separators, comment signs and quotes", "[io][points]") {
  const fs::path file = batten_test::scratch("quoted_fields") / "a.csv";
  const std::string text = GENERATE(
      "curve,x,y,z\n\"a, \"\"b\"\" #1\",0,0,0\n\"a, \"\"b\"\" #1\",1,0,0\n",
      "x;y;z;name\n0;0;0; \"a, \"\"b\"\" #1\" // first\n1;0;0;\"a, \"\"b\"\" #1\"\n",
      "line\tx\ty\tz\n\"a, \"\"b\"\" #1\"\t0\t0\t0\n\"a, \"\"b\"\" #1\"\t1\t0\t0 # last\n");
  std::ofstream(file) << text;
  const auto lines = read_point_lines(file);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].name == "a, \"b\" #1");
  CHECK(lines[0].points == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}});
}

// ---- exactness of drawings ------------------------------------------------------------------

TEST_CASE("DXF files contain exactly the curves, each as one spline", "[io][drawings][curves]") {
  const fs::path file = batten_test::scratch("dxf_splines") / "a.dxf";
  const std::vector<NamedCurve> curves = {
      named("open", wild_curve(7, false, {}, 1)),
      named("with corners", wild_curve(6, false, {2, 5}, 2)),
      named("loop", wild_curve(5, true, {}, 3)),
      named("kinked loop", wild_curve(6, true, {1, 4}, 4)),
      named("seam is a corner", wild_curve(4, true, {0}, 5)),
      named("all corners", wild_curve(4, true, {0, 1, 2, 3}, 6)),
      named("one segment", wild_curve(1, false, {}, 7)),
      named("far away", wild_curve(3, false, {1}, 8, 0, 1e6))};
  CHECK(write_curves(file, curves).empty());
  const Drawing drawing = read_drawing(file);
  CHECK(drawing.notes.empty());
  REQUIRE(drawing.lines.size() == curves.size());
  for (size_t i = 0; i < curves.size(); ++i) {
    const HermiteCurve& curve = curves[i].curve;
    REQUIRE(drawing.lines[i].curve);
    const InputCurve& read = *drawing.lines[i].curve;
    INFO(curves[i].name);
    CHECK(drawing.lines[i].name == curves[i].name);
    CHECK(read.piecewise_cubic());
    CHECK(read.start() == curve.start());
    CHECK(read.end() == curve.end());
    const double size = drawing_box({curves[i]}).max().norm();
    for (int k = 0; k < 500; ++k) {
      const double u = curve.start() + (curve.end() - curve.start()) * k / 500;
      CHECK((read.evaluate(u) - curve.evaluate(u)).norm() <= 1e-12 * size);
    }
    CHECK(whole_spline("", curve).closed == (curve.closed() && !curve.mesh().is_corner(0)));
  }
}

TEST_CASE("SVG files contain exactly the segments of plane curves", "[io][drawings][curves]") {
  const fs::path file = batten_test::scratch("svg_paths") / "a.svg";
  const std::vector<NamedCurve> curves = {named("open", wild_curve(7, false, {}, 1, 2)),
                                          named("with corners", wild_curve(6, false, {2, 5}, 2, 2)),
                                          named("loop", wild_curve(5, true, {}, 3, 2)),
                                          named("kinked loop", wild_curve(6, true, {0, 4}, 4, 2))};
  CHECK(write_curves(file, curves).empty());
  const Drawing drawing = read_drawing(file);
  CHECK(drawing.notes.empty());
  CHECK(drawing.unit_in_metres == 1e-3);
  REQUIRE(drawing.lines.size() == curves.size());
  for (size_t i = 0; i < curves.size(); ++i) {
    const HermiteCurve& curve = curves[i].curve;
    REQUIRE(drawing.lines[i].curve);
    const InputCurve& read = *drawing.lines[i].curve;
    INFO(curves[i].name);
    REQUIRE(static_cast<int>(read.breaks().size()) == curve.segment_count() + 1);
    for (int s = 0; s < curve.segment_count(); ++s)
      for (int k = 0; k < 50; ++k) {
        const double t = k / 50.0, from = read.breaks()[s], to = read.breaks()[s + 1];
        const Vec3 p = read.evaluate(from + t * (to - from));
        CHECK((p - curve.evaluate(CurveMesh::SegmentPoint{s, t})).norm() <= 1e-12 * 100);
      }
  }
}

TEST_CASE("straight segments become polylines with the same vertices", "[io][drawings][curves]") {
  const fs::path folder = batten_test::scratch("polylines");
  const std::vector<Vec3> flat = {{0.1, 0.7, 7}, {100.3, 0, 7}, {1e-7, 50, 7}, {-20, 1e5, 7}};
  const std::vector<Vec3> space = {{0.1, 0.7, 0}, {100.3, 0, 1.3}, {1e-7, 50, 7}};
  const std::vector<Vec3> ends = {{0.1, 0.2, 0.3}, {-5, 1e-3, 7}};
  std::vector<Vec3> flat_loop = flat, space_loop = space;
  flat_loop.push_back(flat[0]);
  space_loop.push_back(space[0]);
  const NamedCurve points_only{"<points>", {}, {}, space};
  write_curves(folder / "a.dxf",
               {named("flat", polygon(flat, false)), named("flat loop", polygon(flat, true)),
                named("space", polygon(space, false)), named("space <loop>", polygon(space, true)),
                named("line", polygon(ends, false)), points_only});
  const Drawing dxf = read_drawing(folder / "a.dxf");
  REQUIRE(dxf.lines.size() == 6);
  const std::vector<std::vector<Vec3>> expected = {flat, flat_loop, space, space_loop, ends, space};
  for (size_t i = 0; i < 6; ++i) CHECK(dxf.lines[i].points == expected[i]);
  CHECK(dxf.lines[3].name == "space <loop>");
  CHECK(dxf.lines[5].name == "<points>");
  const std::string text = contents(folder / "a.dxf");
  for (const char* entity : {"\nLINE\n", "\nLWPOLYLINE\n", "\nPOLYLINE\n", "\nSEQEND\n"})
    CHECK_THAT(text, Contains(entity));
  CHECK_THAT(text, !Contains("\nSPLINE\n"));

  CHECK(write_curves(folder / "a.svg",
                     {named("flat", polygon(flat, false)), named("loop", polygon(flat, true))})
            .size() == 1);
  const Drawing svg = read_drawing(folder / "a.svg");
  REQUIRE(svg.lines.size() == 2);
  for (std::vector<Vec3>* vertices : {&flat_loop})
    for (Vec3& p : *vertices) p.z() = 0;
  CHECK(svg.lines[0].points == std::vector<Vec3>(flat_loop.begin(), flat_loop.end() - 1));
  CHECK(svg.lines[1].points == flat_loop);
}

TEST_CASE("drawings declare the unit of the curves", "[io][drawings][curves]") {
  const fs::path folder = batten_test::scratch("drawing_units");
  const auto curves = flat_curves({"a"});
  for (const std::string& unit : length_units())
    for (const std::string ending : {".dxf", ".svg"}) {
      INFO(unit << " " << ending);
      const fs::path file = folder / (unit + ending);
      write_curves(file, curves, {unit_in_metres(unit)});
      const Drawing drawing = read_drawing(file);
      CHECK(drawing.unit_in_metres == unit_in_metres(unit));
      const InputCurve& read = *drawing.lines[0].curve;
      CHECK(read.evaluate(read.start()) == curves[0].curve.position(0));
    }
  CHECK_THAT(contents(folder / "in.svg"), Contains("in\" height="));
  std::ofstream(folder / "old.dxf") << "old";
  CHECK_THAT(error_message([&] { write_curves(folder / "old.dxf", curves, {0.123}); }),
             Contains("old.dxf") && Contains("length unit 0.123 m"));
  CHECK(contents(folder / "old.dxf") == "old");
  write_curves(folder / "odd.svg", curves, {0.123});
  CHECK(read_drawing(folder / "odd.svg").unit_in_metres == Approx(0.123).epsilon(1e-14));
}

TEST_CASE("SVG files contain curves of one coordinate plane, others are refused",
          "[io][drawings][curves]") {
  const fs::path folder = batten_test::scratch("svg_planes");
  const auto start = [&](const std::string& name) {
    const Drawing drawing = read_drawing(folder / name);
    const InputCurve& read = *drawing.lines[0].curve;
    return read.evaluate(read.start());
  };
  const HermiteCurve level = wild_curve(3, false, {}, 1, 2, 5),
                     front = wild_curve(3, false, {}, 1, 1),
                     side = wild_curve(3, false, {}, 1, 0, -2);
  const auto notes = write_curves(folder / "level.svg", {named("a", level)});
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("level.svg") && Contains("plane z = 5"));
  CHECK(start("level.svg") == Vec3(level.position(0).x(), level.position(0).y(), 0));
  CHECK_THAT(write_curves(folder / "front.svg", {named("a", front)}).at(0),
             Contains("plane y = 0") && Contains("x points to the right and z upwards"));
  CHECK(start("front.svg") == Vec3(front.position(0).x(), front.position(0).z(), 0));
  CHECK_THAT(write_curves(folder / "side.svg", {named("a", side)}).at(0),
             Contains("plane x = -2") && Contains("y points to the right and z upwards"));
  CHECK(start("side.svg") == Vec3(side.position(0).y(), side.position(0).z(), 0));

  std::ofstream(folder / "old.svg") << "old";
  for (const std::vector<NamedCurve>& curves :
       {std::vector{named("wild", wild_curve(3, false, {}, 1))},
        std::vector{named("low", wild_curve(3, false, {}, 1, 2, 0)),
                    named("high", wild_curve(3, false, {}, 2, 2, 1))}})
    CHECK_THAT(error_message([&] { write_curves(folder / "old.svg", curves); }),
               Contains("old.svg: found curves with z from") && Contains("a plane z = const") &&
                   Contains("write a .dxf file"));
  CHECK(contents(folder / "old.svg") == "old");
}

TEST_CASE("the page of an SVG file contains all curves", "[io][drawings][curves]") {
  const fs::path file = batten_test::scratch("svg_page") / "a.svg";
  const double size = GENERATE(1e-6, 1.0, 3e7), x = GENERATE(0.0, -5e3), y = GENERATE(0.0, 400.0);
  const std::vector<Vec3> ends = {{size * x, size * y, 0}, {size * (x + 1), size * y, 0}};
  write_curves(file, {named("level line", polygon(ends, false))});
  CHECK(read_drawing(file).lines[0].points == ends);
  const std::string text = contents(file);
  std::istringstream box(text.substr(text.find("viewBox=\"") + 9));
  double left = 0, top = 0, width = 0, height = 0;
  REQUIRE(box >> left >> top >> width >> height);
  CHECK(left <= ends[0].x() - 0.04 * size);
  CHECK(left + width >= ends[1].x() + 0.04 * size);
  CHECK(top <= -ends[0].y() - 0.04 * size);
  CHECK(top + height >= -ends[0].y() + 0.04 * size);
  CHECK(width < 1.3 * size);
}

TEST_CASE("curves without length are not drawn, and named", "[io][drawings][curves]") {
  const fs::path folder = batten_test::scratch("drawn_dots");
  auto curves = flat_curves({"a"});
  curves.push_back({"dot", {}, {}, {{1, 2, 0}}});
  curves.push_back({"dots", {}, {}, {{1, 2, 0}, {1, 2, 0}}});
  for (const char* name : {"a.dxf", "a.svg"}) {
    const auto notes = write_curves(folder / name, curves);
    REQUIRE(notes.size() == 2);
    CHECK_THAT(notes[0], Contains("'dot' is not written"));
    CHECK_THAT(notes[1], Contains("'dots' is not written"));
    CHECK(names_in(folder / name) == std::vector<std::string>{"a"});
  }
}

// ---- layers ---------------------------------------------------------------------------------

TEST_CASE("names of layers are valid in DXF, and different for different names",
          "[io][drawings][names]") {
  const fs::path file = batten_test::scratch("layers") / "a.dxf";
  write_curves(file, flat_curves({"Rail", "rail", "a<b", "a>b", "a_b", "0", "", "Größe", " "}));
  std::istringstream rows(contents(file));
  std::vector<std::string> layers;
  for (std::string code, value; std::getline(rows, code) && std::getline(rows, value);)
    if (code == "8" && value != "0") layers.push_back(value);
  std::vector<std::string> folded;
  for (const std::string& layer : layers) {
    INFO(layer);
    CHECK(layer.find_first_of("<>/\":;?*|=,`'") == layer.npos);
    CHECK(std::all_of(layer.begin(), layer.end(), [](char c) { return c >= 32 && c < 127; }));
    folded.push_back(lower_case(layer));
  }
  std::sort(folded.begin(), folded.end());
  CHECK(std::adjacent_find(folded.begin(), folded.end()) == folded.end());
  CHECK(layers.size() == 8);  // all except the curve without a name, which is in layer 0
  CHECK_THAT(contents(file), Contains("\nGr\\U+00F6\\U+00DFe\n"));
}

TEST_CASE("a curve that was moved to another layer is named after it", "[io][drawings][names]") {
  const fs::path file = batten_test::scratch("moved") / "a.dxf";
  write_curves(file, flat_curves({"a<b", "plain"}));
  std::string text = contents(file);
  const std::string entity = "\n8\na_b\n100\nAcDbSpline\n";
  REQUIRE(text.find(entity) != text.npos);
  text.replace(text.find(entity), entity.size(), "\n8\nother\n100\nAcDbSpline\n");
  std::ofstream(file) << text;
  CHECK(names_in(file) == std::vector<std::string>{"other", "plain"});
}

TEST_CASE("layers of other programs are decoded", "[io][drawings][names]") {
  const fs::path file = batten_test::scratch("foreign_layers") / "a.dxf";
  std::string text = "0\nSECTION\n2\nENTITIES\n";
  for (const char* layer : {"Gr\\U+00F6\\U+00DFe",
                            "Gr\xF6\xDF"
                            "e 2",
                            "Größe 3", "\\U+D83D\\U+DE00", "\\U+00", "\\U+D83D!"})
    text += std::string("0\nLINE\n8\n") + layer + "\n10\n0\n20\n0\n11\n1\n21\n0\n";
  std::ofstream(file) << text + "0\nENDSEC\n0\nEOF\n";
  CHECK(names_in(file) ==
        std::vector<std::string>{"Größe", "Größe 2", "Größe 3", "\U0001F600", "\\U+00", "\uFFFD!"});
}

// ---- other programs -------------------------------------------------------------------------

TEST_CASE("Python's XML reader reads the names in an SVG file", "[io][drawings][names]") {
  if (std::system("/usr/bin/python3 -c 'import xml.etree.ElementTree' > /dev/null 2>&1") != 0) {
    WARN("skipped: no python3");
    return;
  }
  const fs::path folder = batten_test::scratch("svg_python");
  write_curves(folder / "a.svg", flat_curves({"<&>", "it's \"odd\"", "Größe", "Größe 2", ""}));
  std::ofstream(folder / "script.py") << R"(
import re, xml.etree.ElementTree as tree
paths = list(tree.parse("a.svg").getroot().iter("{http://www.w3.org/2000/svg}path"))
label = "{http://www.inkscape.org/namespaces/inkscape}label"
assert [p.get(label) for p in paths] == ["<&>", "it's \"odd\"", "Größe", "Größe 2", None]
ids = [p.get("id") for p in paths if p.get("id")]
assert len(set(ids)) == 4 and all(re.fullmatch("[A-Za-z_][-.\\w]*", i) for i in ids), ids
)";
  CHECK(std::system(("cd '" + folder.string() + "' && /usr/bin/python3 script.py").c_str()) == 0);
}

TEST_CASE("FreeCAD reads a DXF file with the lengths of its curves", "[io][drawings][curves]") {
  if (std::system("command -v freecadcmd > /dev/null 2>&1") != 0) {
    WARN("skipped: no freecadcmd");
    return;
  }
  const fs::path folder = batten_test::scratch("dxf_freecad");
  const std::vector<NamedCurve> curves = {
      named("open", wild_curve(7, false, {}, 1)), named("kinks", wild_curve(6, true, {1, 4}, 4)),
      named("<flat>", polygon({{0, 0, 1}, {30, 0, 1}, {30, 40, 1}}, true)),
      named("<space>", polygon({{0, 0, 1}, {30, 0, 1}, {30, 40, 2}}, true))};
  write_curves(folder / "a.dxf", curves);
  std::ofstream(folder / "script.py") << R"(
import FreeCAD, Import
document = FreeCAD.newDocument("a")
Import.readDXF("a.dxf", "a")
lengths = sorted(e.Length for o in document.Objects if hasattr(o, "Shape") for e in o.Shape.Edges)
print(*lengths, file=open("lengths", "w"))
)";
  const std::string here = "'" + folder.string() + "'";
  REQUIRE(std::system(("cd " + here + " && HOME=" + here +
                       " QT_QPA_PLATFORM=offscreen "
                       "freecadcmd script.py > talk 2>&1")
                          .c_str()) == 0);
  std::ifstream in(folder / "lengths");
  const std::vector<double> lengths{std::istream_iterator<double>(in), {}};
  double whole = 0, expected = 0;
  for (const double length : lengths) whole += length;
  for (const NamedCurve& c : curves) expected += ArcLength(curve_from_hermite(c.curve)).total();
  CHECK(lengths.size() >= 8);
  CHECK(whole == Approx(expected).epsilon(1e-6));
}

TEST_CASE("printable text keeps letters and escapes what controls a terminal", "[io][names]") {
  const std::string letters = "aé日\U0001F600 \\ 'x'";
  CHECK(printable(letters) == letters);
  CHECK(printable("a\x1B[31m\tb\r\n\x7F") == R"(a\x1B[31m\tb\r\n\x7F)");
  CHECK(printable(std::string_view("\0", 1)) == R"(\x00)");
  CHECK(printable("\u009B\u202E\u2028\u2066") == R"(\u009B\u202E\u2028\u2066)");
  // Not UTF-8: a single byte, a truncated and a redundant sequence, a surrogate.
  CHECK(printable("\xE9t\xE9") == R"(\xE9t\xE9)");
  CHECK(printable("\xE6\x97") == R"(\xE6\x97)");
  CHECK(printable("\xC0\x8A") == R"(\xC0\x8A)");
  CHECK(printable("\xED\xA0\x80") == R"(\xED\xA0\x80)");
}

TEST_CASE("messages keep line feeds before indented lines only", "[io][names]") {
  const std::string text = "a:\n  b\nc\n d\n";
  CHECK(printable(text, LineFeeds::KeepBeforeIndent) == "a:\n  b\\nc\\n d\\n");
  CHECK(printable(text, LineFeeds::Keep) == text);
  CHECK(printable(text) == R"(a:\n  b\nc\n d\n)");
}
