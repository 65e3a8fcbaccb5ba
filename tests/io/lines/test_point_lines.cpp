// SPDX-License-Identifier: MPL-2.0
// Point files give the same result in all dialects, and every error message contains its position.
#include "batten/io/lines/curve_files.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
namespace fs = std::filesystem;

namespace {

fs::path file_with(const std::string& name, const std::string& text) {
  static const fs::path folder = batten_test::scratch("point_lines");
  std::ofstream(folder / name, std::ios::binary) << text;
  return folder / name;
}

/// The message after the file's name.
std::string read_error(const std::string& name, const std::string& text) {
  const fs::path path = file_with(name, text);
  try {
    read_point_lines(path);
  } catch (const InputError& error) {
    const std::string message = error.what();
    REQUIRE(message.starts_with(path.string() + ":"));
    return message.substr(path.string().size() + 1);
  }
  return "no mistake";
}

const std::vector<Vec3> kThree{{1, 2, 3}, {-4.5, 5e-1, 6}, {7, 8, 9}};

}  // namespace

TEST_CASE("all dialects of a table give the same points", "[io][points]") {
  const std::string text = GENERATE(
      "1,2,3\n-4.5,.5,6\n7,8,9\n",                              //
      "1;2;3\n-4.5; 5e-1 ;6\n7;8;9",                            //
      "1\t2\t3\n-4.5\t0.5\t6\n7\t8\t9\n",                       //
      "  1  2   3\n -4.50 +0.5 6.\n 7 8 9 \n\n\n",              //
      "\xEF\xBB\xBFx,y,z\r\n1,2,3\r\n-4.5,0.5,6\r\n7,8,9\r\n",  //
      "# a comment\n\n\"x [mm]\" y z\n1 2 3 # first\n// between\n-4.5 0.5 6 // second\n7 8 9",
      "x y z\n# a comment does not end the line\n1 2 3\n#\n-4.5 0.5 6\n7 8 9\n,,\n ; ;\n",
      "1,2,3,\n-4.5,.5,6,\n7,8,9,\n",                          //
      "x;y;z;\n1;2;3;\n-4,5;0,5;6;\n7;8;9;\n",                //
      "\"1\",\"2\",\"3\"\n\"-4.5\",\"0.5\",\"6\"\n\"7\",\"8\",\"9\"\n",
      "\"1,0\",\"2,0\",\"3,0\"\n\"-4,5\",\"0,5\",\"6\"\n7,8,9\n",
      "\"x, along\",\"y, across\",\"z\"\n\"1\",\"2\",\"3\"\n\"-4,5\",\"0,5\",\"6,0\"\n7,8,9\n",
      "\"1,0\"\t\"2,0\"\t\"3,0\"\n\"-4,5\"\t\"0,5\"\t\"6\"\n7\t8\t9\n");
  for (const char* name : {"a.csv", "a.TXT", "a.xyz", "a.dat"}) {
    const auto lines = read_point_lines(file_with(name, text));
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].name == "a");
    CHECK(lines[0].points == kThree);
  }
}

TEST_CASE("blank rows separate curves, units scale, two columns lie in z = 0", "[io][points]") {
  const auto path = file_with("two lines.csv", "u,v\n\n1,2\n3,4\n,\n\n5,6\n7,8\n9,10\n");
  const auto lines = read_point_lines(path, 0.001);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].name == "two lines_1");
  CHECK(lines[1].name == "two lines_2");
  CHECK(lines[0].first_line == 3);
  CHECK(lines[1].first_line == 7);
  REQUIRE(lines[1].points.size() == 3);
  CHECK(lines[1].points[2] == Vec3(9 * 0.001, 10 * 0.001, 0));
  CHECK_THROWS_AS(read_point_lines(path, 0), InputError);
}

TEST_CASE("titles may hold digits, and headers say which columns are meant", "[io][points]") {
  const std::string text =
      GENERATE("NACA 2412\n1,2,3\n-4.5,.5,6\n7,8,9\n", "MH 32  8.7% \n1 2 3\n-4.5 .5 6\n7 8 9\n",
               "2412\n1 2 3\n-4.5 .5 6\n7 8 9\n", "63 215 MOD B\n\n1 2 3\n-4.5 .5 6\n7 8 9\n",
               "2412 AIRFOIL\n(13.9%) thick, 2 % camber\n1 2 3\n-4.5 .5 6\n7 8 9\n",
               "1,0;2,0;3,0\n-4,5;0,5;6,0\n7,0;8,0;9,0\n", "1,0;2;3\n-4,5;0,5;6\n7;8;9\n",
               "1,0 2,0 3,0\n-4,5 0,5 6,0\n7,0 8,0 9,0\n", "7 1 2 3\n8 -4.5 .5 6\n9 7 8 9\n",
               "z,x,y\n3,1,2\n6,-4.5,.5\n9,7,8\n",
               "id;X [mm];Y [mm];Z [mm];note\nA 1;1;2;3;\n2b;-4.5;0.5;6;a corner\n7;7;8;9;\n",
               "x,y,z\nmm,mm,mm\n1,2,3\n-4.5,.5,6\n7,8,9\n",
               "\"Points:0\",\"Points:1\",\"Points:2\",\"kappa\"\n1,2,3,0\n-4.5,.5,6,0\n7,8,9,0\n");
  const auto lines = read_point_lines(file_with("a.csv", text));
  INFO(text);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].name == "a");
  CHECK(lines[0].points == kThree);
}

TEST_CASE("how a table was interpreted is reported where it is not obvious", "[io][points]") {
  const auto said = [](const std::string& text) {
    return read_point_lines(file_with("a.csv", text))[0].format_note;
  };
  CHECK(said("x,y,z\n1,2,3\n4,5,6\n") == "columns named by the header");
  CHECK(said("1,2,3\n4,5,6\n").empty());
  CHECK(said("NACA 2412\n1 2\n4 5\n") == "title 'NACA 2412'");
  CHECK(said("1,5;2\n4;5\n") == "decimal commas");
  CHECK(said("1;2;\n4;5;\n") == "a separator at the end of each row");
  CHECK(said("\"1,5\",\"2\"\n\"4\",\"5\"\n") == "fields in quotes, decimal commas");
  CHECK(said("1 1 2 3\n2 4 5 6\n") == "the first column is a point number");
  CHECK(said("999999999999999 1 2 3\n1000000000000000 4 5 6\n") ==
        "the first column is a point number");
  CHECK_THROWS_AS(read_point_lines(file_with("a.csv", std::string(38, '5') + ",2,0,1\n1,2,3,4\n")),
                  InputError);
}

TEST_CASE("curves of one table are named by a column or by the rows above them", "[io][points]") {
  const auto by_column = read_point_lines(
      file_with("a.csv", "line,x,y,z\nkeel,0,0,0\nkeel,1,0,0\ndeck,0,0,1\ndeck,1,0,1\n"));
  REQUIRE(by_column.size() == 2);
  CHECK(by_column[0].name == "keel");
  CHECK(by_column[1].name == "deck");
  CHECK(by_column[1].points == std::vector<Vec3>{{0, 0, 1}, {1, 0, 1}});
  const auto by_rows =
      read_point_lines(file_with("a.csv", "section 1\n0 0\n1 0\n\nsection 2\n0 1\n1 1\n"));
  REQUIRE(by_rows.size() == 2);
  CHECK(by_rows[0].name == "section 1");
  CHECK(by_rows[1].name == "section 2");
  CHECK(by_rows[1].points == std::vector<Vec3>{{0, 1, 0}, {1, 1, 0}});
}

TEST_CASE("Selig's and Lednicer's airfoils are the same curve", "[io][points]") {
  const std::string selig = "TEST 12\n1 0.01\n0.5 0.1\n0 0\n0.4 -0.1\n1 -0.01\n";
  const std::string lednicer =
      GENERATE("TEST 12\n  3. 3.\n\n0 0\n0.5 0.1\n1 0.01\n\n0 0\n0.4 -0.1\n1 -0.01\n",
               "TEST 12\n3 3\n0 0\n0.5 0.1\n1 0.01\n0 0\n0.4 -0.1\n1 -0.01\n");
  const auto a = read_point_lines(file_with("a.dat", selig), 2);
  const auto b = read_point_lines(file_with("b.dat", lednicer), 2);
  REQUIRE(a.size() == 1);
  REQUIRE(b.size() == 1);
  CHECK(a[0].points == b[0].points);
  CHECK(b[0].name == "b");
  CHECK(b[0].format_note ==
        "both sides of an airfoil, joined at the leading edge, title 'TEST 12'");
}

TEST_CASE("offset tables give stations", "[io][points]") {
  const std::string text =
      GENERATE("station,0,0.5,1\n0,,,1\n2,,0.5,1.5\n4,0,1,2\n",
               "x/z 0 0.5 1\n0 - - 1\n2 - 0.5 1.5\n4 0 1 2\n",
               ";0;0.5;1\n0;;;1\n2;;0.5;1.5\n4;0;1;2\n", "z,0,2,4\n0,,,0\n0.5,,0.5,1\n1,1,1.5,2\n",
               "station,1,0.5,0\n0,1,,\n2,1.5,0.5,\n4,2,1,0\n",           // downwards
               "Station;WL 0;WL 0,5;WL 1\n0;;;1\n2;;0,5;1,5\n4;0;1;2\n",  // decimal commas
               "Half-breadths,WL 0,WL 0.5,WL 1\nSt. 0,,,1\nSt. 2,,0.5,1.5\nSt. 4,0,1,2\n",
               "Half-breadths,Station 0,Station 2,Station 4\nWL 0,,,0\nWL 0.5,,0.5,1\nWL 1,1,1.5,2\n",
               "waterline,4,2,0\n1,2,1.5,1\n0.5,1,0.5,\n0,0,,\n",
               "station;0;0.5;1;\n0;;;1;\n2;;0.5;1.5;\n4;0;1;2;\n",
               "\"station\",\"0\",\"0.5\",\"1\"\n\"0\",\"\",\"\",\"1\"\n\"2\",,\"0.5\",\"1.5\"\n4,0,1,2\n");
  INFO(text);
  const auto lines = read_point_lines(file_with("hull.csv", text), 10);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].name == "station 2");
  CHECK(lines[0].points == std::vector<Vec3>{{20, 5, 5}, {20, 15, 10}});
  CHECK(lines[1].name == "station 4");
  CHECK(lines[1].points == std::vector<Vec3>{{40, 0, 0}, {40, 10, 5}, {40, 20, 10}});
  CHECK(lines[0].format_note.starts_with("from an offset table, whose rows are "));
}

TEST_CASE("all published airfoils are read", "[io][points]") {
  const fs::path folder = batten_test::optional_data("lines-airfoils");
  if (folder.empty()) {
    WARN("skipped: lines-airfoils is not there (set BATTEN_TEST_DATA)");
    return;
  }
  int sections = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".dat") continue;
    INFO(entry.path());
    const auto lines = read_point_lines(entry.path());
    REQUIRE(lines.size() == 1);
    CHECK(std::abs(lines[0].points.front().x() - 1) < 0.01);
    CHECK(std::abs(lines[0].points.back().x() - 1) < 0.01);
    ++sections;
  }
  CHECK(sections >= 12);
}

TEST_CASE("OBJ polylines: indices, names, continued rows", "[io][points]") {
  const auto lines = read_point_lines(file_with("net.obj",
                                                "# a net\r\n"
                                                "mtllib none.mtl\r\n"
                                                "v 0 0 0\r\nv 1 0 0 1.0\r\nv 1 1 0\r\n"
                                                "l 1 2\r\n"
                                                "o side rail\r\n"
                                                "l -1 -2 -3\r\n"
                                                "l 2/1 3/2\r\n"
                                                "vt 0 0\r\nvn 0 0 1\r\nf 1 2 3\r\n"
                                                "g top\r\n"
                                                "v 0 1 2\r\n"
                                                "l 1 \\\r\n  4 \\\r\n  2\r\n"));
  REQUIRE(lines.size() == 4);
  CHECK(lines[0].name == "net");
  CHECK(lines[1].name == "side rail_1");
  CHECK(lines[2].name == "side rail_2");
  CHECK(lines[3].name == "top");
  CHECK(lines[0].points == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}});
  CHECK(lines[1].points == std::vector<Vec3>{{1, 1, 0}, {1, 0, 0}, {0, 0, 0}});
  CHECK(lines[2].points == std::vector<Vec3>{{1, 0, 0}, {1, 1, 0}});
  CHECK(lines[3].points == std::vector<Vec3>{{0, 0, 0}, {0, 1, 2}, {1, 0, 0}});
  CHECK(lines[1].first_line == 8);
  CHECK(lines[3].first_line == 15);
}

TEST_CASE("OBJ segments are chained into the curves to which they belong", "[io][points]") {
  // A circle of 24 segments in random order and direction, a spoke at its first vertex, and the
  // sides of a square, whose turns are corners.
  constexpr int n = 24;
  std::string text;
  for (int i = 0; i < n; ++i)
    text += "v " + std::to_string(std::cos(i * 2 * std::numbers::pi / n)) + " " +
            std::to_string(std::sin(i * 2 * std::numbers::pi / n)) + " 0\n";
  text += "v 2 0 0\nv 3 0 0\nv 3 1 0\nv 2 1 0\n";
  for (int k = 0; k < n; ++k) {
    const int i = 7 * k % n, j = (i + 1) % n;
    text += "l " + std::to_string((k % 3 ? i : j) + 1) + " " + std::to_string((k % 3 ? j : i) + 1) +
            "\n";
  }
  const std::string square = "l 26 27\nl 27 28\nl 28 25\nl 25 26\n";
  SECTION("closed without an end") {
    const auto lines = read_point_lines(file_with("circle.obj", text + square));
    REQUIRE(lines.size() == 5);
    CHECK(lines[0].points.size() == n + 1);
    CHECK(lines[0].points.front() == lines[0].points.back());
    double length = 0;
    for (size_t i = 1; i < lines[0].points.size(); ++i)
      length += (lines[0].points[i] - lines[0].points[i - 1]).norm();
    CHECK(length == Approx(2 * n * std::sin(std::numbers::pi / n)));
    CHECK(lines[0].format_note == "28 records of the file joined to 5 curves");
    for (int k = 1; k < 5; ++k) CHECK(lines[k].points.size() == 2);
  }
  SECTION("cut where a third line ends") {
    const auto lines = read_point_lines(file_with("spoke.obj", text + "l 1 25\n"));
    REQUIRE(lines.size() == 2);
    CHECK(lines[0].points.size() == n + 1);
    CHECK((lines[0].points.front() - Vec3(1, 0, 0)).norm() == 0);
    CHECK((lines[0].points.back() - Vec3(1, 0, 0)).norm() == 0);
    CHECK(lines[1].points.size() == 2);
  }
  SECTION("names keep apart") {
    const auto lines = read_point_lines(file_with(
        "names.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\no a\nl 1 2\nl 2 3\no b\nl 3 4\n"));
    REQUIRE(lines.size() == 2);
    CHECK(lines[0].name == "a");
    CHECK(lines[0].points.size() == 3);
    CHECK(lines[1].points.size() == 2);
  }
}

TEST_CASE("drawn strokes: single and repeated points come through", "[io][points]") {
  const auto path = file_with("cup.curves",
                              "v 3\r\n1 2 3\r\n-4.5 .5 6\n7 8 9\n"
                              "\n# a dot\nv 1\n0.1 -0.2 1e-3\nv 2\n5 5 5\n5 5 5");
  const auto lines = read_point_lines(path);
  REQUIRE(lines.size() == 3);
  CHECK(lines[0].name == "cup_1");
  CHECK(lines[2].name == "cup_3");
  CHECK(lines[0].points == kThree);
  CHECK(lines[1].points == std::vector<Vec3>{{0.1, -0.2, 1e-3}});
  CHECK(lines[2].points == std::vector<Vec3>{{5, 5, 5}, {5, 5, 5}});
  CHECK(lines[1].first_line == 7);
  CHECK(read_point_lines(path, 2)[0].points[0] == Vec3(2, 4, 6));
}

TEST_CASE("errors in drawn strokes are reported with line and column", "[io][points]") {
  const std::string two = "v 2\n1 2 3\n4 5 6\n";
  CHECK(read_error("a.curves", "1 2 3\n") ==
        "1:1: found '1', expected 'v N' before the N points of a curve");
  CHECK(read_error("a.curves", two + "7 8 9\n") ==
        "4:1: found '7', expected 'v N' before the N points of a curve");
  CHECK(read_error("a.curves", "v\n") ==
        "1:1: found 0 words after 'v', expected the number of points");
  CHECK(read_error("a.curves", two + "v two\n") ==
        "4:3: found 'two', expected a number of points from 1");
  CHECK(read_error("a.curves", "v 0\n" + two) ==
        "1:3: found '0', expected a number of points from 1");
  CHECK(read_error("a.curves", "v 2.5\n") ==
        "1:3: found '2.5', expected a number of points from 1");
  CHECK(read_error("a.curves", two + "v 3\n1 2 3\n4 5 6\n") ==
        "6:1: found the end of the file after 2 points, expected 3 as stated in line 4");
  CHECK(read_error("a.curves", "v 3\n1 2 3\n" + two) ==
        "3:1: found the next curve after 1 point, expected 3 as stated in line 1");
  CHECK(read_error("a.curves", "v 1\n 1 2\n") == "2:2: found 2 numbers, expected 3 (x y z)");
  CHECK(read_error("a.curves", "v 1\n1 2 nan\n") == "2:5: found 'nan', expected a finite number");
  CHECK(read_error("a.curves", "v 1\n1 2 x\n") == "2:5: found 'x', expected a number");
  CHECK(read_error("a.curves", "# nothing\n") == "1:1: found no points, expected at least one");
}

TEST_CASE("published sketches are read whole", "[io][points]") {
  const fs::path folder = batten_test::optional_data("sketch-cassie/curves");
  if (folder.empty()) {
    WARN("skipped: sketch-cassie is not there (set BATTEN_TEST_DATA)");
    return;
  }
  int sketches = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".curves") continue;
    ++sketches;
    // Rows of the file: one per stroke, one per point.
    std::ifstream in(entry.path());
    size_t strokes = 0, points = 0, found = 0;
    for (std::string row; std::getline(in, row);) ++(row.starts_with("v") ? strokes : points);
    const auto lines = read_point_lines(entry.path());
    for (const auto& line : lines) found += line.points.size();
    INFO(entry.path());
    CHECK(lines.size() == strokes);
    CHECK(found == points);
  }
  CHECK(sketches > 10);
}

TEST_CASE("errors in tables are reported with line and column", "[io][points]") {
  CHECK(read_error("a.csv", "") == "1:1: found an empty file, expected points");
  CHECK(read_error("a.csv", "\r\n \n") == "1:1: found an empty file, expected points");
  CHECK(read_error("a.csv", "x,y,z\n# only words\n") ==
        "1:1: found no points, expected at least one");
  CHECK(read_error("a.csv", "1,2\n3,4\n5,six\n") == "3:3: found 'six', expected a number");
  CHECK(read_error("a.csv", "1,2\n3 ,  4x\n") == "2:6: found '4x', expected a number");
  CHECK(read_error("a.csv", "x y 3\n1 2 3\n") ==
        "1:1: found 'x', expected a number (a header row contains names only)");
  CHECK(read_error("a.csv", "1,2,3\n4,5\n") == "2:1: found 2 columns, expected 3 as in line 1");
  CHECK(read_error("a.csv", "1\n2\n") == "2:1: found 1 column, expected 2 or 3 (x, y, z)");
  CHECK(
      read_error("a.csv", "  1.5 2 3 4\n") ==
      "1:3: found 4 columns, expected 2 or 3 (x, y, z), or a header row that names those columns");
  CHECK(
      read_error("a.csv", "1,2,3,4,5\n") ==
      "1:1: found 5 columns, expected 2 or 3 (x, y, z), or a header row that names those columns");
  CHECK(read_error("a.csv", "1 2 3 4\n2 3 4 5\n4 4 5 6\n") ==
        "3:1: found '4' in the first of 4 columns, expected 3 as point number, or a header "
        "row that names the columns x, y, z");
  CHECK(read_error("a.csv", "1,5;2,5;0\n2,5;1,x;0\n") == "2:5: found '1,x', expected a number");
  CHECK(read_error("a.csv", "l.0 0.5\n2 3\n") ==
        "1:1: found 'l.0', expected a number (a header row contains names only)");
  CHECK(read_error("a.csv", "5,six\n1,2\n") ==
        "1:3: found 'six', expected a number (a header row contains names only)");
  CHECK(read_error("a.csv", "1,2\n3,4\n\n5,six\n6,7\n") == "4:3: found 'six', expected a number");
  CHECK(read_error("a.csv", "x,y,w\n1,2,3\n4,5\n") ==
        "3:1: found 2 columns, expected 3 as in line 2");
  CHECK(read_error("a.csv", "x/z,0,1,2\n0,1,2,3\n1,2,3\n") ==
        "3:1: found 3 columns, expected 4 as in the first row");
  CHECK(read_error("a.csv", "1,2,3\n4,,6\n") == "2:3: found an empty column 2, expected a number");
  CHECK(read_error("a.csv", "1,2,3,,\n") == "1:7: found an empty column 4, expected a number");
  CHECK(read_error("a.csv", "1,2\n3,nan\n") == "2:3: found 'nan', expected a finite number");
  CHECK(read_error("a.csv", "-inf,2\n3,4\n") == "1:1: found '-inf', expected a finite number");
  CHECK(read_error("a.csv", "1,2\n3,1e999\n") ==
        "2:3: found '1e999', expected a number between 1e-307 and 1e308");
  CHECK(read_error("a.csv", "1,2\n3,+-4\n") == "2:3: found '+-4', expected a number");
  CHECK(read_error("a.csv", "1,2\n\n3,4\n\n5,6\n7,8\n") ==
        "1:1: found a curve with 1 point, expected 2 or more");
  CHECK(read_error("a.csv", "1,2\n3,4\n\n5,6\n") ==
        "4:1: found a curve with 1 point, expected 2 or more");
  CHECK(read_error("a.csv",
                   "\xFF\xFE"
                   "1,2\n") == "1:1: found UTF-16 text, expected UTF-8 or ASCII");
}

TEST_CASE("errors in OBJ files are reported with line and column", "[io][points]") {
  const std::string v = "v 0 0 0\nv 1 0 0\n";
  CHECK(read_error("a.obj", v + "l 1 3\n") ==
        "3:5: found vertex number 3, expected 1 to 2 or -1 to -2");
  CHECK(read_error("a.obj", v + "l 0 1\n") ==
        "3:3: found vertex number 0, expected 1 to 2 or -1 to -2");
  CHECK(read_error("a.obj", v + "l -3 1\n") ==
        "3:3: found vertex number -3, expected 1 to 2 or -1 to -2");
  CHECK(read_error("a.obj", "l 1 2\n" + v) ==
        "1:3: found vertex number 1, expected vertices (v records) before it");
  CHECK(read_error("a.obj", v + "l 1 two\n") == "3:5: found 'two', expected a vertex number");
  CHECK(read_error("a.obj", v + "l 1\n") == "3:4: found a curve with 1 point, expected 2 or more");
  CHECK(read_error("a.obj", v + "l 1 \\") == "3:6: found a curve with 1 point, expected 2 or more");
  CHECK(read_error("a.obj", "v 1 2\n") == "1:6: found 2 coordinates, expected 3 (v x y z)");
  CHECK(read_error("a.obj", "v 1 2 inf\n") == "1:7: found 'inf', expected a finite number");
  CHECK(read_error("a.obj", v) ==
        " found 2 vertex records but no curve, expected records 'l 1 2 3 …'");
}

TEST_CASE("files that are not there or not point files are named", "[io][points]") {
  using Catch::Matchers::Contains;
  const auto says = [](const fs::path& path) -> std::string {
    try {
      read_point_lines(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const fs::path folder = batten_test::scratch("point_lines_folder.csv");
  CHECK_THAT(says(folder / "none.csv"), Contains("none.csv: found no such file"));
  CHECK_THAT(says(folder), Contains("found a folder"));
  CHECK_THAT(says(folder / "a.step"), Contains("'.step'") && Contains(".csv"));
  CHECK_THAT(says(folder / "a"), Contains("no extension"));
}

TEST_CASE("a million points are read exactly", "[io][points]") {
  std::string text;
  for (int i = 0; i < 1000000; ++i)
    text += std::to_string(i) + ".25," + std::to_string(-i) + ",0.1\n";
  const auto lines = read_point_lines(file_with("many.csv", text));
  REQUIRE(lines.size() == 1);
  REQUIRE(lines[0].points.size() == 1000000);
  bool exact = true;
  for (int i = 0; i < 1000000; ++i) exact = exact && lines[0].points[i] == Vec3(i + 0.25, -i, 0.1);
  CHECK(exact);
}
