// SPDX-License-Identifier: MPL-2.0
// A deck that is written back equals the deck that was read, except for the positions of moved
// nodes.
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const std::string kNastran =
    "SOL 101\n"
    "CEND\n"
    "TITLE = plate $ GRID    99              1.      1.      1.\n"
    "BEGIN BULK\n"
    "$ nodes\n"
    "GRID    1               0.0     0.0     0.0\n"
    "GRID           2             1.5    -2.5  1.25-1       0\n"
    "grid,3,,1.,1.,0.\n"
    "GRID*                  4                0.0             1.0\n"
    "*                    0.5               0\n"
    "GRID*   5                               2.000000000     0.0             *X\n"
    "$ a comment between\n"
    "*X      1.5+1\n"
    "GRID    6               2.      1.\n"
    "GRID    7               .5\n"
    "GRID,8,0,2.5\n"
    "GRID    9       5       1.      2.      3.\n"
    "GRID    10              1.+1    3.      4.              123456\n"
    "GRID\t11\t\t7.\t8.\t9.\n"
    "GRID    12              1.5     .5      0.       $ a comment\n"
    "$ shells\n"
    "CTRIA3  1       7       1       2       3\n"
    "CQUAD4,2,7,1,2,3,4\n"
    "CTRIAR* 3               8               2               5\n"
    "*       6\n"
    "CTRIA6  4       8       2       5       6       7       8       12\n"
    "CTRIA6  5       8       1       2       3       7\n"
    "CQUAD8  6       8       1       2       5       6       7       8       +A\n"
    "+A      11      12\n"
    "CQUAD8,7,,1,2,5,6\n"
    "CBAR    20      1       1       10      0.      0.      1.\n"
    "RBE2    30      1       123456  2       9\n"
    "RBE2    31      1       123456  2       10\n"
    "SET1    4       1       THRU    4       12      77\n"
    "CORD2R  5               0.      0.      0.      0.      0.      1.\n"
    "        1.      0.      0.\n"
    "ENDDATA\n"
    "GRID    1               trailing text";

std::vector<int> nodes_of(const MeshFile& file, long face) {
  std::vector<int> labels;
  for (const int node : file.shells().face(*file.face_of_label(face)))
    labels.push_back(static_cast<int>(file.node_label(node)));
  return labels;
}

Vec3 place(const MeshFile& file, long label) {
  return file.shells().points.row(*file.node_of_label(label)).transpose();
}

/// Reference parser of Nastran's real numbers: sign, digits with a point, a signed exponent without
/// a letter.
double nastran_real(const std::string& text) {
  REQUIRE(text.find('.') != text.npos);
  const size_t sign = text.find_first_of("+-", 1);
  if (sign == text.npos) return std::strtod(text.c_str(), nullptr);
  return std::strtod((text.substr(0, sign) + "e" + text.substr(sign)).c_str(), nullptr);
}

std::string without_blanks(const std::string& text) {
  std::string result;
  for (const char c : text)
    if (c != ' ') result += c;
  return result;
}

/// Smallest possible error of any text of `width` characters, by exhaustive search over exponents
/// and positions of the point, with the digits below and above.
double best_possible(double x, int width) {
  double best = INFINITY;
  const std::string sign = x < 0 ? "-" : "";
  const int e10 = static_cast<int>(std::floor(std::log10(std::abs(x))));
  for (int power = e10 - 12; power <= e10 + 13; ++power)
    for (const bool with_exponent : {false, true}) {
      if (!with_exponent && power != 0) continue;
      std::string exponent;
      if (with_exponent) exponent = (power < 0 ? "" : "+") + std::to_string(power);
      for (int decimals = 0; decimals < width; ++decimals) {
        const long double scaled =
            std::abs(static_cast<long double>(x)) * std::pow(10.0L, decimals - power);
        if (scaled > 1e12L) break;
        for (const long digits : {static_cast<long>(scaled), static_cast<long>(scaled) + 1}) {
          std::string text = std::to_string(digits);
          if (static_cast<int>(text.size()) < decimals)
            text.insert(0, static_cast<size_t>(decimals) - text.size(), '0');
          if (digits == 0) continue;
          text.insert(text.size() - static_cast<size_t>(decimals), ".");
          text = sign + text + exponent;
          if (static_cast<int>(text.size()) > width) continue;
          best = std::min(best, std::abs(nastran_real(text) - x));
        }
      }
    }
  return best;
}

/// The commands for ccx that bend a shell slightly.
std::string abaqus_plate() {
  std::string text =
      "*HEADING\nplate, * no keyword\n** a comment\n*NODE, NSET=ALL\n"
      "1, 0., 0., 0.\n 2 ,1.0 , 0.0,0\n3,2.,0.,0.,\n";
  for (int i = 3; i < 15; ++i) {
    const int column = i % 3, row = i / 3;
    text +=
        std::to_string(i + 1) + ", " + std::to_string(column) + ", " + std::to_string(row) + ".\n";
  }
  return text +
         "*Element, type=S4, elset=\"Skin A\"\n"
         "1, 1,2,5,4\n2,2,3,6,5\n 3, 4, 5,\n 8, 7\n"
         "*ELEMENT,ELSET=rest,TYPE=S4\n4,5,6,9,8\n5,7,8,11,10\n6,8,9,12,11\n7,10,11,14,13\n"
         "8,11,12,15,14\n"
         "*ELSET,ELSET=BOTH\nskin a, rest\n"
         "*ELSET,ELSET=ODD,GENERATE\n1,7,2\n"
         "*NSET,\n NSET=clamp\n1,2,\n3\n"
         "*NSET,NSET=MORE\nclamp,15,99\n"
         "*MATERIAL,NAME=M\n*ELASTIC\n210000.,.3\n"
         "*SHELL SECTION,MATERIAL=M,ELSET=BOTH\n.1\n"
         "*STEP\n*STATIC\n*BOUNDARY\nclamp,1,6\n*CLOAD\n15,3,1.\n*NODE FILE\nU\n*END STEP\n";
}

const std::string kDyna =
    "$ a comment\n"
    "*KEYWORD LONG=S\n"
    "*TITLE\n"
    "*a title\n"
    "*NODE\n"
    "$#   nid               x               y               z      tc      rc\n"
    "       1             0.0             0.0             0.0       0       0\n"
    "       2             1.0\n"
    "       3       1.0000000       1.0000000             0.5       0       0\n"
    "4,0.,1.,0.\n"
    "       5             2.0             0.0\n"
    "99999999             2.0             1.0         1.00E+0\n"
    "*ELEMENT_SHELL_THICKNESS_OFFSET\n"
    "       1      10       1       2       3       4\n"
    "             1.0             1.0             1.0             1.0             0.0\n"
    "             0.5\n"
    "       2      10       2       5       3       3\n"
    "             1.0             1.0             1.0             1.0             0.0\n"
    "             0.5\n"
    "*ELEMENT_SHELL (four nodes)\n"
    "       3      11       599999999       3       2\n"
    "4,11,1,2,3,0\n"
    "*ELEMENT_BEAM\n"
    "       9      12       1       2       3\n"
    "*PART\n"
    "the skin\n"
    "$ between\n"
    "        10         1         1\n"
    "the rest\n"
    "        11         1         1\n"
    "*SET_NODE_LIST_TITLE\n"
    "rim\n"
    "         7       0.0       0.0       0.0       0.0\n"
    "         1         2  99999999       123\n"
    "*SET_SHELL_LIST_GENERATE\n"
    "         8\n"
    "         2         3         0         0\n"
    "*END\n"
    "       7 what follows the end is not read\n";

}  // namespace

TEST_CASE("Nastran: nodes and shells of all three field formats", "[io][decks]") {
  const MeshFile file = MeshFile::read(file_with("plate.bdf", kNastran));
  CHECK(file.format() == "Nastran bulk data");
  REQUIRE(file.shells().node_count() == 12);
  REQUIRE(file.shells().face_count() == 7);
  CHECK(place(file, 1) == Vec3(0, 0, 0));
  CHECK(place(file, 2) == Vec3(1.5, -2.5, 0.125));
  CHECK(place(file, 3) == Vec3(1, 1, 0));
  CHECK(place(file, 4) == Vec3(0, 1, 0.5));
  CHECK(place(file, 5) == Vec3(2, 0, 15));
  CHECK(place(file, 6) == Vec3(2, 1, 0));
  CHECK(place(file, 7) == Vec3(0.5, 0, 0));
  CHECK(place(file, 8) == Vec3(2.5, 0, 0));
  CHECK(place(file, 10) == Vec3(10, 3, 4));
  CHECK(place(file, 11) == Vec3(7, 8, 9));
  CHECK(nodes_of(file, 1) == std::vector<int>{1, 2, 3});
  CHECK(nodes_of(file, 2) == std::vector<int>{1, 2, 3, 4});
  CHECK(nodes_of(file, 3) == std::vector<int>{2, 5, 6});
  CHECK(nodes_of(file, 4) == std::vector<int>{2, 5, 6, 7, 8, 12});
  CHECK(file.shells().second_order(*file.face_of_label(4)));
  // A mid-side node on only one edge belongs to the outline.
  CHECK(nodes_of(file, 5) == std::vector<int>{1, 7, 2, 3});
  CHECK_FALSE(file.shells().second_order(*file.face_of_label(5)));
  CHECK(nodes_of(file, 6) == std::vector<int>{1, 2, 5, 6, 7, 8, 11, 12});
  CHECK(file.shells().second_order(*file.face_of_label(6)));
  CHECK(nodes_of(file, 7) == std::vector<int>{1, 2, 5, 6});
  CHECK_FALSE(file.node_of_label(99));
  CHECK_FALSE(file.face_of_label(20));
  REQUIRE(file.properties().size() == 2);
  CHECK(file.properties()[0].name == "7");
  CHECK(file.properties()[0].faces == std::vector<int>{0, 1, 6});  // a blank PID is the EID
  CHECK(file.properties()[1].faces == std::vector<int>{2, 3, 4, 5});
  REQUIRE(file.sets().size() == 1);
  CHECK(file.sets()[0].name == "4");
  CHECK(file.sets()[0].nodes.size() == 5);
  REQUIRE(file.warnings().size() == 1);
  CHECK(file.warnings()[0] == "1 CBAR, 2 RBE2; 2 nodes not used by a shell");
}

TEST_CASE("decks with unchanged nodes keep every byte", "[io][decks]") {
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"a.bdf", kNastran},
                                   {"a.inp", abaqus_plate()},
                                   {"a.k", kDyna}}) {
    check_identity(file_with(name, text));
    check_identity(file_with(name, with_carriage_returns(text)));
    check_identity(file_with(name, "\xEF\xBB\xBF" + text));
  }
}

TEST_CASE("Nastran: only coordinates of nodes that moved change", "[io][decks]") {
  // Coordinates that are blank, in columns or between commas.
  const auto masked = [](const std::string& text) {
    std::vector<std::string> lines = lines_of(text);
    bool after_grid = false;
    for (std::string& line : lines) {
      const std::string comment = line.find('$') < line.npos ? line.substr(line.find('$')) : "";
      line = line.substr(0, line.find('$'));
      const auto blank_out = [&](size_t from, size_t to) {
        line.resize(std::max(line.size(), to), ' ');
        line.replace(from, to - from, std::string(to - from, '#'));
      };
      const bool continues = after_grid && line.starts_with("*");
      if (line.find(',') != line.npos && line.substr(0, 4) != "CQUA") {
        std::vector<std::string> values;
        std::istringstream in(line);
        for (std::string value; std::getline(in, value, ',');) values.push_back(value);
        values.resize(std::max<size_t>(values.size(), 6));
        for (size_t i = 3; i < 6; ++i) values[i] = "#";
        line.clear();
        for (const auto& value : values) line += value + ",";
      } else if (line.starts_with("GRID ") || line.starts_with("GRID\t")) {
        if (line.find('\t') != line.npos)
          line = line.substr(0, line.find('\t', 5));
        else
          blank_out(24, 48);
      } else if (line.starts_with("GRID*")) {
        blank_out(40, 72);
      } else if (continues) {
        blank_out(8, 24);
      } else if (line.starts_with("CBAR ")) {
        blank_out(40, 64);  // its orientation vector
      }
      if (!line.empty() && line[0] != '$') after_grid = line.starts_with("GRID*");
      line += comment;
    }
    return lines;
  };
  const auto path = file_with("m.bdf", kNastran);
  const MeshFile file = MeshFile::read(path);
  for (const int every : {1, 2, 3, 4}) {
    const auto target = check_round_trip(path, moved(file, 0.3, every), 1e-4);
    CHECK(masked(bytes_of(target)) == masked(kNastran));
    // Lines of unmoved nodes are unchanged.
    const auto before = lines_of(kNastran), after = lines_of(bytes_of(target));
    REQUIRE(before.size() == after.size());
    int changed = 0;
    for (size_t i = 0; i < before.size(); ++i) changed += before[i] != after[i];
    CHECK(changed <= 12 / every + 3);
    CHECK(changed > 0);
  }
  // A single coordinate, in a line that ends before it.
  Points points = file.shells().points;
  points(*file.node_of_label(7), 2) = 0.25;
  points(*file.node_of_label(8), 2) = 0.25;
  points(*file.node_of_label(6), 2) = 0.25;
  points(*file.node_of_label(11), 1) = 0.25;
  const auto lines = lines_of(bytes_of(check_round_trip(path, points, 0)));
  CHECK(lines[13] == "GRID    6               2.      1.           .25");
  CHECK(lines[14] == "GRID    7               .5                   .25");
  CHECK(lines[15] == "GRID,8,0,2.5,,.25");
  CHECK(lines[18] == "GRID\t11\t\t7.\t.25     9.");
}

TEST_CASE("fixed fields: the coordinates beside the one that moved keep their columns",
          "[io][decks]") {
  const std::string cards =
      "GRID    2               1.      0.      0.\nGRID    3               0.      1.      0.\n"
      "CTRIA3  1       1       1       2       3\n";
  const std::string grid = "GRID    1                 1.0     2.0     3.0   0\n";
  const auto path = file_with("beside.bdf", grid + cards);
  Points points = MeshFile::read(path).shells().points;
  points(0, 1) = 0.25;
  CHECK(bytes_of(check_round_trip(path, points, 0)) ==
        "GRID    1                 1.0        .25  3.0   0\n" + cards);
}

TEST_CASE("Nastran: no other 8 characters are nearer", "[io][decks]") {
  std::mt19937 random(3);
  std::vector<double> values{1.0 / 3,    -1.0 / 3, 9999999.6, -999999.96,  99999999.0, 1.2345678e10,
                             -1.2345e-9, 1e-10,    9.9999e9,  0.099999999, 5e-324,     1.7e308,
                             -123456.78, 1234.5,   1e100,     -9.99995e-5, 123456789.0};
  std::uniform_real_distribution<double> mantissa(-10, 10), exponent(-14, 14), near(-3, 9);
  while (values.size() < 1500)
    values.push_back(mantissa(random) *
                     std::pow(10, values.size() % 2 ? exponent(random) : near(random)));
  while (values.size() % 3) values.push_back(1);
  std::string deck = "CTRIA3  1       1       1       2       3\n";
  const size_t nodes = values.size() / 3;
  for (size_t i = 0; i < nodes; ++i) {
    std::string label = std::to_string(i + 1);
    label.resize(8, ' ');
    deck += "GRID    " + label + "        0.      0.      0.\n";
  }
  const MeshFile file = MeshFile::read(file_with("best.bdf", deck));
  Points points(static_cast<Eigen::Index>(nodes), 3);
  for (size_t i = 0; i < values.size(); ++i)
    points(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = values[i];
  const auto target = mesh_scratch() / "best_written.bdf";
  file.write(target, points);
  const auto lines = lines_of(bytes_of(target));
  for (size_t i = 0; i < values.size(); ++i) {
    const std::string field = lines[1 + i / 3].substr(24 + 8 * (i % 3), 8);
    const double written = nastran_real(without_blanks(field));
    INFO(values[i] << " as '" << field << "'");
    const double possible = best_possible(values[i], 8);
    CHECK(std::abs(written - values[i]) <= possible * (1 + 1e-9));
  }
}

TEST_CASE("Nastran: wide nodes keep the digits that small fields lose", "[io][decks]") {
  for (const std::string& text : {kNastran, with_carriage_returns(kNastran)}) {
    const auto path = file_with("w.bdf", text);
    const MeshFile file = MeshFile::read(path);
    const Points points = moved(file, 0.3, 1);
    const double small = file.write(mesh_scratch() / "s.bdf", points).largest;
    MeshWriteOptions options;
    options.large_field_nodes = true;
    const auto target = check_round_trip(path, points, 1e-4, options);
    CHECK(file.write(target, points, options).largest <= small);
    const std::string written = bytes_of(target);
    CHECK_THAT(written, Contains("GRID*                 12") && Contains("$ a comment"));
    CHECK(std::count(written.begin(), written.end(), '\r') ==
          (text == kNastran ? 0 : std::count(written.begin(), written.end(), '\n')));
    // Other fields of the line are preserved.
    Points one = file.shells().points;
    one(*file.node_of_label(10), 0) = 1.0 / 3;
    CHECK(file.write(target, one, options).largest < 1e-15);
    CHECK_THAT(
        bytes_of(target),
        Contains("GRID*                 10                .333333333333333              3."));
    CHECK_THAT(bytes_of(target),
               Contains("*                     4.                          123456"));
  }
}

TEST_CASE("Gmsh reads the nodes that were written to Nastran decks", "[io][decks]") {
  if (!have_python_with("gmsh")) return;
  std::string deck = "BEGIN BULK\n";
  const int n = 9;
  char line[120];
  for (int i = 0; i < n * n; ++i) {
    std::snprintf(line, sizeof line,
                  i % 2 ? "GRID    %-8d        %-8s%-8s%-8s\n"
                        : "GRID*   %-16d                %-16s%-16s\n*       %-16s\n",
                  i + 1, (std::to_string(i % n) + ".").c_str(),
                  (std::to_string(i / n) + ".").c_str(), "0.");
    deck += line;
  }
  for (int i = 0; i < n - 1; ++i)
    for (int j = 0; j < n - 1; ++j) {
      const int a = i * n + j + 1;
      std::snprintf(line, sizeof line, "CQUAD4  %-8d%-8d%-8d%-8d%-8d%-8d\n", a, 1, a, a + 1,
                    a + n + 1, a + n);
      deck += line;
    }
  const auto path = file_with("gmsh.bdf", deck + "ENDDATA\n");
  const MeshFile file = MeshFile::read(path);
  const Points points = moved(file, 0.4, 1);
  const auto target = mesh_scratch() / "gmsh_written.bdf";
  const auto rounding = file.write(target, points);
  CHECK(rounding.largest > 0);
  const auto positions = positions_from(other_reader("gmsh", target));
  REQUIRE(positions.size() == n * n);
  double largest = 0;
  for (const auto& [label, at] : positions)
    largest = std::max(
        largest, (points.row(*file.node_of_label(label)).transpose() - at).cwiseAbs().maxCoeff());
  CHECK(largest == Approx(rounding.largest));
}

TEST_CASE("Nastran: errors are reported with line and column", "[io][decks]") {
  const auto says = [](const std::string& text) { return read_error("e.bdf", text); };
  const std::string grids =
      "GRID    1               0.      0.      0.\nGRID    2               1.      0.      0.\n"
      "GRID    3               0.      1.      0.\n";
  CHECK(says(grids) == " found 3 nodes but no faces, expected at least one");
  CHECK(says(grids + "CTRIA3  1       1       1       2       4\n") ==
        "4:9: found node 4 in element 1, expected the number of a node");
  CHECK(says(grids + "GRID,2,,0.,0.,0.\n") ==
        "4:6: found node 2 a second time, the first is in line 2");
  CHECK(says(grids + "CTRIA3,5,1,1,2,3\nCTRIA3,5,1,1,2,3\n") ==
        "5:8: found element 5 a second time, the first is in line 4");
  CHECK(says(grids + "GRID,4,7,0.,0.,0.\nCTRIA3,1,1,1,2,4\n") ==
        "4:6: found node 4 in coordinate system 7, expected one that the deck defines");
  CHECK_THAT(says(grids + "GRDSET          3\nCTRIA3,1,1,1,2,3\n"),
             Contains("1:9: found node 1 in coordinate system 3, expected one"));
  CHECK(
      says("BEGIN BULK\n" + grids + "CTRIA3,5,1,1,2,3\n") ==
      "6:1: found the end of a deck with BEGIN BULK, expected ENDDATA: the file may be truncated");
  CHECK(says("BEGIN BULK\n" + grids + "BEGIN SUPER=1\n") ==
        "5:1: found 'BEGIN SUPER=1', expected one model without superelements");
  CHECK(says(grids + "CTRIA3  1       1       1       2\n") ==
        "4:1: found 2 corners of element 1, expected 3");
  CHECK(says("GRID    1               0.x     0.      0.\n") ==
        "1:25: found '0.x', expected a number");
  CHECK(says("GRID    1               1.+999  0.      0.\n") ==
        "1:25: found '1.+999', expected a number between 1e-307 and 1e308");
  CHECK(says("GRID    1               nan     0.      0.\n") ==
        "1:25: found 'nan', expected a finite number");
  CHECK(says("GRID    -1              0.      0.      0.\n") ==
        "1:9: found node number '-1', expected 1 or more");
  CHECK(says("GRID*   1\nGRID*   2\n") ==
        "1:1: found a GRID* without its second line, expected one");
  CHECK(says(grids + "=       *(1)\n") ==
        "4:1: found a repeated card '=       *(1)', expected every card in full");
}

TEST_CASE("Abaqus: nodes, shells, sets and sections", "[io][decks]") {
  const MeshFile file = MeshFile::read(file_with("plate.inp", abaqus_plate()));
  REQUIRE(file.shells().node_count() == 15);
  REQUIRE(file.shells().face_count() == 8);
  CHECK(place(file, 3) == Vec3(2, 0, 0));
  CHECK(nodes_of(file, 3) == std::vector<int>{4, 5, 8, 7});
  std::map<std::string, size_t> sizes;
  for (const auto& set : file.sets()) sizes[set.name] = set.nodes.size() + 100 * set.faces.size();
  CHECK(sizes == std::map<std::string, size_t>{{"ALL", 15},
                                               {"BOTH", 800},
                                               {"MORE", 4},
                                               {"ODD", 400},
                                               {"Skin A", 300},
                                               {"clamp", 3},
                                               {"rest", 500}});
  REQUIRE(file.properties().size() == 1);
  CHECK(file.properties()[0].name == "BOTH");
  CHECK(file.properties()[0].faces.size() == 8);
  CHECK(file.warnings().empty());
}

TEST_CASE("Abaqus: only coordinates between commas change", "[io][decks]") {
  const auto path = file_with("m.inp", abaqus_plate());
  const MeshFile file = MeshFile::read(path);
  // Small numbers would need more than the 20 characters that the programs accept.
  Points points = moved(file, 0.3, 1);
  points(3, 0) = -1.2345678901234567e-5;
  const auto target = check_round_trip(path, points, 1e-18);
  const auto before = lines_of(abaqus_plate()), after = lines_of(bytes_of(target));
  REQUIRE(before.size() == after.size());
  for (size_t i = 0; i < before.size(); ++i) {
    if (i < 4 || i > 18) {
      CHECK(before[i] == after[i]);
      continue;
    }
    CHECK(before[i].substr(0, before[i].find(',')) == after[i].substr(0, after[i].find(',')));
    std::istringstream values(after[i]);
    for (std::string value; std::getline(values, value, ',');) CHECK(value.size() <= 22);
  }
  // An omitted coordinate is 0, and can be moved.
  const auto shorter = file_with("short.inp", "*NODE\n1\n2,1.\n3,0.,1.\n*ELEMENT,TYPE=S3\n1,1,2,3");
  const MeshFile sparse = MeshFile::read(shorter);
  Points high = sparse.shells().points;
  high.col(2).setConstant(0.5);
  CHECK(bytes_of(check_round_trip(shorter, high, 0)) ==
        "*NODE\n1,,,.5\n2,1.,,.5\n3,0.,1.,.5\n*ELEMENT,TYPE=S3\n1,1,2,3");
}

TEST_CASE("CalculiX runs a deck that was written back", "[io][decks]") {
  if (std::system("command -v ccx >/dev/null && command -v python3 >/dev/null") != 0) {
    WARN("ccx or python3 is not installed: decks were written but not run");
    return;
  }
  // ccx does not continue a keyword in the next line, and needs quotes for names with blanks.
  std::string text = abaqus_plate();
  text.replace(text.find("*NSET,\n NSET"), 12, "*NSET,NSET");
  text.replace(text.find("skin a"), 6, "\"skin a\"");
  const MeshFile file = MeshFile::read(file_with("run.inp", text));
  Points points = moved(file, 0.05, 1);
  for (int i = 0; i < 3; ++i) points(i, 1) = 0;
  points.row(14) = Vec3(2.0 / 3 + 1, 4.0 / 3 + 3, -1e-5 / 3).transpose();
  const auto target = mesh_scratch() / "ran.inp";
  file.write(target, points);
  FILE* const pipe = popen(
      ("python3 '" BATTEN_SOURCE_DIR "/scripts/ccx_max_displacement' '" + target.string() + "'")
          .c_str(),
      "r");
  REQUIRE(pipe);
  double magnitude = 0;
  int node = 0;
  Vec3 at = Vec3::Zero();
  char answer[300] = "";
  REQUIRE(std::fgets(answer, sizeof answer, pipe));
  REQUIRE(std::sscanf(answer, "%lf node %d at (%lf, %lf, %lf)", &magnitude, &node, &at[0], &at[1],
                      &at[2]) == 5);
  pclose(pipe);
  CHECK(magnitude > 0);
  CHECK(node == 15);
  CHECK((at - points.row(14).transpose()).norm() < 2e-5);
}

TEST_CASE("Abaqus: errors are reported with line and column", "[io][decks]") {
  const auto says = [](const std::string& text) { return read_error("e.inp", text); };
  const std::string nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n";
  CHECK(says("*NODE,SYSTEM=X\n1,0,0,0\n") == "1:1: found SYSTEM=X, expected R, C or S");
  CHECK(says(nodes + "*NGEN\n1,3,1\n") ==
        "5:1: found *NGEN, expected nodes and elements written out");
  CHECK(says(nodes + "*System\n0,0,0,1,0,0\n2,0,0\n") ==
        "5:1: found a *SYSTEM whose points lie on a line");
  CHECK(says("*NODE\n1,<a>,0,0\n") ==
        "2:3: found '<a>', expected a number or a preceding parameter with a numeric value");
  CHECK(says("*PART,NAME=A\n*END PART\n*PART,NAME=B\n") ==
        "3:1: found a second *PART, expected one flat part");
  CHECK(says("*ASSEMBLY\n*INSTANCE,NAME=A,PART=B\n*END INSTANCE\n*INSTANCE,NAME=C,PART=B\n") ==
        "4:1: found a second *INSTANCE, expected one");
  CHECK(says(nodes + "*ELEMENT,TYPE=S4\n1,1,2,3\n") ==
        "6:1: found 3 nodes of an element of type S4, expected 4");
  CHECK(says(nodes + "*ELEMENT,TYPE=S3\n1,1,2,5\n") ==
        "6:1: found node 5 in element 1, expected the number of a node");
  CHECK(says(nodes + "*ELEMENT\n1,1,2,3\n") == "5:1: found *ELEMENT without TYPE=, expected one");
  CHECK(says(nodes + "*ELEMENT,TYPE=S3\n1,1,2,3\n*NSET,NSET=A\nb\n") ==
        "8:1: found 'B', expected a number or the name of a set before it");
  CHECK(says("*NODE\n1,0,zero,0\n") == "2:5: found 'zero', expected a number");
  CHECK(says(nodes + "3,1,1,1\n") == "5:1: found node 3 a second time, the first is in line 4");
  CHECK(says(nodes + "*ELEMENT,TYPE=C3D4\n1,1,2,3,1\n") ==
        " found 3 nodes but no faces, expected at least one");
}

TEST_CASE("Abaqus: one part in its position, with an assembly", "[io][decks]") {
  const MeshFile file = MeshFile::read(file_with(
      "cae.inp",
      "*Heading\n*Part, name=P\n*Node\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n"
      "*Element, type=S3R\n1, 1, 2, 3\n*Element, type=T3D2\n2, 1, 2\n*End Part\n"
      "*Assembly, name=A\n*Instance, name=P-1, part=P\n*End Instance\n*Node\n1, 5., 5., 5.\n"
      "*Nset, nset=ref\n1,\n*Nset, nset=edge, instance=P-1\n1, 2\n*Elset, elset=e\n"
      "*End Assembly\n"));
  CHECK(file.shells().node_count() == 4);
  CHECK(place(file, 11) == Vec3(5, 5, 5));  // node 1 of the assembly
  REQUIRE(file.sets().size() == 2);
  CHECK(file.sets()[0].name == "ref");
  CHECK(file.sets()[1].name == "edge");
  CHECK(file.sets()[1].nodes == std::vector<int>{0, 1});
  REQUIRE(file.warnings().size() == 2);
  CHECK_THAT(file.warnings()[0], Contains("1 T3D2"));
}

TEST_CASE("LS-DYNA: nodes, shells, parts and sets", "[io][decks]") {
  const MeshFile file = MeshFile::read(file_with("deck.k", kDyna));
  REQUIRE(file.shells().node_count() == 6);
  REQUIRE(file.shells().face_count() == 4);
  CHECK(place(file, 2) == Vec3(1, 0, 0));
  CHECK(place(file, 4) == Vec3(0, 1, 0));
  CHECK(place(file, 99999999) == Vec3(2, 1, 1));
  CHECK(nodes_of(file, 1) == std::vector<int>{1, 2, 3, 4});
  CHECK(nodes_of(file, 2) == std::vector<int>{2, 5, 3});
  CHECK(nodes_of(file, 3) == std::vector<int>{5, 99999999, 3, 2});
  CHECK(nodes_of(file, 4) == std::vector<int>{1, 2, 3});
  REQUIRE(file.properties().size() == 2);
  CHECK(file.properties()[0].name == "10");
  CHECK(file.properties()[0].title == "the skin");
  CHECK(file.properties()[1].title == "the rest");
  REQUIRE(file.sets().size() == 2);
  CHECK(file.sets()[0].name == "7");
  CHECK(file.sets()[0].title == "rim");
  CHECK(file.sets()[0].nodes == std::vector<int>{0, 1, 5});
  CHECK(file.sets()[1].faces == std::vector<int>{1, 2});
  REQUIRE(file.warnings().size() == 1);
  CHECK_THAT(file.warnings()[0], Contains("*ELEMENT_BEAM"));
}

TEST_CASE("LS-DYNA: standard, I10 and long cards are equivalent", "[io][decks]") {
  const auto deck = [](const std::string& keyword, const std::string& suffix, int id, int real) {
    std::string text = keyword + "\n*NODE" + suffix + "\n";
    char line[240];
    const double xyz[4][3] = {{0, 0, 0}, {1, 0, 0.125}, {1, 1, -3e-7}, {0, 1, 0}};
    for (int i = 0; i < 4; ++i) {
      std::snprintf(line, sizeof line, "%*d%*.6e%*.6e%*.6e%*d%*d\n", id, i + 1, real, xyz[i][0],
                    real, xyz[i][1], real, xyz[i][2], id, 0, id, 7);
      text += line;
    }
    std::snprintf(line, sizeof line, "%*d%*d%*d%*d%*d%*d\n", id, 1, id, 5, id, 1, id, 2, id, 3, id,
                  4);
    return text + "*ELEMENT_SHELL" + suffix + "\n" + line + "*END\n";
  };
  const std::vector<std::string> decks{
      deck("*KEYWORD", "", 8, 16),         deck("*KEYWORD I10=Y", "", 10, 16),
      deck("*KEYWORD LONG=Y", "", 20, 20), deck("*KEYWORD", "+", 20, 20),
      deck("*KEYWORD", " %", 10, 16),      deck("*KEYWORD long = y", "-", 8, 16),
      deck("*KEYWORD LONG=S", "", 8, 16),  deck("*KEYWORD MEMORY=200M I10=Y LONG=S", "", 10, 16)};
  for (const std::string& text : decks) {
    INFO(text);
    const auto path = file_with("width.key", text);
    const MeshFile file = MeshFile::read(path);
    REQUIRE(file.shells().node_count() == 4);
    CHECK(place(file, 2) == Vec3(1, 0, 0.125));
    CHECK(place(file, 3) == Vec3(1, 1, -3e-7));
    check_identity(path);
    const int id = text.find("\n                   1 ") < text.npos ? 20
                   : text.find("\n         1") < text.npos          ? 10
                                                                    : 8;
    const int real = id == 20 ? 20 : 16;
    // 13 of 16 columns and 17 of 20 hold the digits, whatever the number.
    const auto target = check_round_trip(path, moved(file, 0.3, 1), real == 20 ? 2e-16 : 2e-12);
    const auto before = lines_of(text), after = lines_of(bytes_of(target));
    REQUIRE(before.size() == after.size());
    for (size_t i = 0; i < before.size(); ++i) {
      if (i < 2 || i > 5) {
        CHECK(before[i] == after[i]);
        continue;
      }
      const auto first = static_cast<size_t>(id), last = static_cast<size_t>(id + 3 * real);
      CHECK(before[i].size() == after[i].size());
      CHECK(before[i].substr(0, first) == after[i].substr(0, first));
      CHECK(before[i].substr(last) == after[i].substr(last));
    }
  }
}

TEST_CASE("LS-DYNA: coordinates that are left out can be moved", "[io][decks]") {
  const auto path = file_with("short.k", kDyna);
  const MeshFile file = MeshFile::read(path);
  Points points = file.shells().points;
  points(1, 2) = 0.5;
  points(3, 2) = 0.5;
  points(4, 1) = 0.5;
  const auto lines = lines_of(bytes_of(check_round_trip(path, points, 0)));
  CHECK(lines[7] == "       2             1.0                              .5");
  CHECK(lines[9] == "4,0.,1.,.5");
  CHECK(lines[10] == "       5             2.0              .5");
}

TEST_CASE("LS-DYNA: second-order shells", "[io][decks]") {
  std::string text = "*NODE\n";
  for (int i = 1; i <= 9; ++i) text += std::to_string(i) + "," + std::to_string(i) + ".,0.,0.\n";
  const MeshFile file = MeshFile::read(
      file_with("second.k", text + "*ELEMENT_SHELL\n1,1,1,2,3,4,5,6,7,8\n2,1,1,2,3,3,5,6,3,8\n"
                                   "3,1,1,2,3,3,5,6,7,7\n4,1,1,2,3,4,5,6,0,0\n"));
  CHECK(nodes_of(file, 1) == std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8});
  CHECK(nodes_of(file, 2) == std::vector<int>{1, 2, 3, 5, 6, 8});
  CHECK(nodes_of(file, 3) == std::vector<int>{1, 2, 3, 5, 6, 7});
  CHECK(nodes_of(file, 4) == std::vector<int>{1, 2, 3, 4, 5, 6});
  for (int f = 0; f < 4; ++f) CHECK(file.shells().second_order(f));
}

TEST_CASE("LS-DYNA: errors are reported with line and column", "[io][decks]") {
  const auto says = [](const std::string& text) { return read_error("e.k", text); };
  const std::string nodes = "*KEYWORD\n*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n";
  CHECK(says(nodes + "*ELEMENT_SHELL\n1,1,1,2,9,9\n") ==
        "7:1: found node 9 in element 1, expected the number of a node");
  CHECK(
      says(nodes + "*INCLUDE_NASTRAN\nx.nas\n*ELEMENT_SHELL\n1,1,1,2,9,9\n") ==
      "9:1: found node 9 in element 1, expected the number of a node (some included files are not "
      "followed)");
  CHECK(says(nodes + "*ELEMENT_SHELL_THICKNESS\n1,1,1,2,3,3\n*END\n") ==
        "7:1: found element 1 without its 1 more card of *ELEMENT_SHELL_THICKNESS");
  CHECK_THAT(says(nodes + "*ELEMENT_SHELL_COMPOSITE\n1,1,1,2,3,3\n"), Contains("6:1: found"));
  CHECK(says("*NODE\n       1       &x\n") == "2:16: found '&x', expected a number");
  CHECK(says(nodes + "*ELEMENT_SHELL\n1,1,1,2\n") == "7:1: found element 1 of fewer than 3 nodes");
  CHECK(says("hello\n") == " found 0 nodes but no faces, expected at least one");
}

TEST_CASE("damaged decks give a result or an error", "[io][decks]") {
  check_damage(".bdf", kNastran, 1500);
  check_damage(".inp", abaqus_plate(), 1500);
  check_damage(".k", kDyna, 1500);
}

namespace {

std::string joined(const std::vector<std::string>& sentences) {
  std::string all;
  for (const std::string& sentence : sentences) all += sentence + "\n";
  return all;
}

}  // namespace

TEST_CASE("decks and polygons that may be cut short are named", "[io][decks]") {
  const std::filesystem::path folder =
      std::filesystem::path(BATTEN_SOURCE_DIR) / "tests/fuzz/seeds/meshes";
  const auto cut = batten_test::scratch("cut_decks");
  std::filesystem::create_directories(cut);
  for (const char* name : {"sheet.bdf", "sheet.k", "sheet.inp", "sheet.obj"}) {
    CAPTURE(name);
    std::ostringstream text;
    text << std::ifstream(folder / name, std::ios::binary).rdbuf();
    CHECK_THAT(joined(MeshFile::read(folder / name).warnings()), !Contains("truncated"));
    // Truncates the last two characters: of the end keyword, or of the last faces.
    std::ofstream(cut / name, std::ios::binary) << text.str().substr(0, text.str().size() - 3);
    if (std::string(name) == "sheet.bdf") {
      CHECK_THROWS_WITH(MeshFile::read(cut / name), Contains("the file may be truncated"));
      continue;
    }
    CHECK_THAT(joined(MeshFile::read(cut / name).warnings()),
               Contains("the file may be truncated"));
  }
}

TEST_CASE("writing decks refuses changes that would alter the mesh", "[io][decks]") {
  const MeshFile file = MeshFile::read(file_with("r.bdf", kNastran));
  const auto target = mesh_scratch() / "refused.nas";
  Points points = file.shells().points;
  CHECK_THROWS_WITH(file.write(mesh_scratch() / "refused.inp", points),
                    Contains("expected .bdf, .nas, .dat or .fem: the mesh was read as Nastran"));
  CHECK_THROWS_WITH(file.write(target, Points::Zero(3, 3)),
                    Contains("found 3 points, expected 12"));
  points(4, 1) = NAN;
  CHECK_THROWS_WITH(file.write(target, points), Contains("node 5 is not finite"));
  CHECK_FALSE(fs::exists(target));
}
