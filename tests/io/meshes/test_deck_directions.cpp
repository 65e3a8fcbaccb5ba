// SPDX-License-Identifier: MPL-2.0
// Directions in decks rotate with the mesh: the deck of a rotated mesh is the rotated deck.
#include <cmath>
#include <numbers>
#include <sstream>

#include <Eigen/Geometry>

#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using Row = std::vector<std::string>;

std::vector<std::string> text_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Row between_commas(const std::string& line) {
  Row values;
  std::istringstream in(line);
  for (std::string value; std::getline(in, value, ',');) values.push_back(value);
  return values;
}

Vec3 numbers_at(const Row& row, size_t first) {
  Vec3 v = Vec3::Zero();
  for (size_t c = 0; c < 3 && first + c < row.size(); ++c)
    v[static_cast<int>(c)] = std::strtod(row[first + c].c_str(), nullptr);
  return v;
}

/// An oblique quarter turn about a point away from the origin.
struct Turn {
  Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  Vec3 centre{30, -20, 10};
  Vec3 operator()(const Vec3& p) const { return centre + R * (p - centre); }
  Points operator()(const Points& points) const {
    Points result = points;
    for (int i = 0; i < points.rows(); ++i)
      result.row(i) = (*this)(Vec3(points.row(i).transpose())).transpose();
    return result;
  }
};

/// The deck before and after it is written with new positions.
struct Rewritten {
  std::vector<std::string> before, after;
  std::vector<std::string> notes;
  template <class Move>
  Rewritten(const std::string& extension, const std::string& text, const Move& move) {
    const MeshFile file = MeshFile::read(file_with("directions" + extension, text));
    const auto to = mesh_scratch() / ("rotated" + extension);
    notes = file.write(to, move(file.shells().points)).notes;
    before = text_lines(text);
    after = text_lines(bytes_of(to));
    REQUIRE(before.size() == after.size());
  }
  /// Numbers `first` to `first` + 2 of the line that starts with `start`.
  Vec3 old_vector(const std::string& start, size_t first) const {
    return vector_in(before, start, first);
  }
  Vec3 new_vector(const std::string& start, size_t first) const {
    return vector_in(after, start, first);
  }

 private:
  Vec3 vector_in(const std::vector<std::string>& lines, const std::string& start,
                 size_t first) const {
    for (size_t i = 0; i < lines.size(); ++i)
      if (before[i].starts_with(start)) return numbers_at(between_commas(lines[i]), first);
    FAIL("no line " << start);
    return Vec3::Zero();
  }
};

std::string nastran_plate(const std::string& cards) {
  std::string text = "BEGIN BULK\n";
  for (int i = 0; i < 9; ++i)
    text += "GRID," + std::to_string(i + 1) + ",," + std::to_string(10 * (i % 3)) + ".," +
            std::to_string(10 * (i / 3)) + "." + ",0.\n";
  return text + cards + "ENDDATA\n";
}

std::string abaqus_plate(const std::string& cards) {
  std::string text = "*NODE\n";
  for (int i = 0; i < 9; ++i)
    text += std::to_string(i + 1) + ", " + std::to_string(10 * (i % 3)) + ".0, " +
            std::to_string(10 * (i / 3)) + ".0, 0.0, 0., 0.6, 0.8\n";
  return text +
         "*ELEMENT, TYPE=S4, ELSET=E\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n3, 4, 5, 8, 7\n4, 5, 6, 9, 8\n"
         "*ELEMENT, TYPE=B31, ELSET=B\n11, 1, 2\n12, 2, 3\n" +
         cards;
}

const std::string kAbaqusDirections =
    "*NSET, NSET=END\n3, 6, 9\n"
    "*ORIENTATION, NAME=FIBRE\n1., 0., 0., 0., 1., 0.\n3, 45.\n"
    "*ORIENTATION, NAME=ROUND, SYSTEM=CYLINDRICAL\n0., 0., -5., 0., 0., 7.\n"
    "*TRANSFORM, NSET=END, TYPE=R\n0.8, 0.6, 0., -0.6, 0.8, 0.\n"
    "*SHELL SECTION, ELSET=E, MATERIAL=M, ORIENTATION=FIBRE\n1.\n"
    "*SOLID SECTION, ELSET=B, MATERIAL=M, ORIENTATION=ROUND\n"
    "*BEAM SECTION, ELSET=B, MATERIAL=M, SECTION=RECT\n2., 3.\n0., 0., 1.\n"
    "*NORMAL\n1, 2, 0., 1., 0.\n"
    "*MATERIAL, NAME=M\n*ELASTIC\n210000., .3\n";

}  // namespace

TEST_CASE("directions of Abaqus decks rotate with the mesh", "[io][decks]") {
  const Turn turn;
  const Rewritten deck(".inp", abaqus_plate(kAbaqusDirections),
                       [&](const Points& p) { return turn(p); });
  CHECK(deck.notes.empty());
  const auto turned = [&](const std::string& line, size_t first) {
    INFO(line);
    CHECK((deck.new_vector(line, first) - turn.R * deck.old_vector(line, first)).norm() < 1e-12);
  };
  const auto moved = [&](const std::string& line, size_t first) {
    INFO(line);
    CHECK((deck.new_vector(line, first) - turn(deck.old_vector(line, first))).norm() < 1e-11);
  };
  moved("5, 10.0", 1);
  turned("5, 10.0", 4);
  turned("1., 0., 0., 0., 1., 0.", 0);
  turned("1., 0., 0., 0., 1., 0.", 3);
  moved("0., 0., -5.", 0);
  moved("0., 0., -5.", 3);
  turned("0.8, 0.6", 0);
  turned("0.8, 0.6", 3);
  turned("0., 0., 1.", 0);
  turned("1, 2, 0., 1., 0.", 2);
  // Nothing else changes.
  for (size_t i = 0; i < deck.before.size(); ++i)
    for (const char* same : {"*", "3, 45.", "1.", "2., 3.", "11,", "1, 1,", "210000"})
      if (deck.before[i] == same || (same[0] == '*' && deck.before[i].starts_with('*')))
        CHECK(deck.after[i] == deck.before[i]);
}

TEST_CASE("directions in a rotated instance of Abaqus are those of the part", "[io][decks]") {
  // A turn of the whole part, in its own coordinates, turns its directions in these coordinates.
  std::string text = "*PART, NAME=P\n" + abaqus_plate(kAbaqusDirections) +
                     "*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=P\n1., 2., 3.\n"
                     "0., 0., 0., 0., 0., 1., 90.\n*END INSTANCE\n*END ASSEMBLY\n";
  const Turn turn;
  const Rewritten deck(".inp", text, [&](const Points& p) { return turn(p); });
  const Mat3 Q = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()).toRotationMatrix();
  const Mat3 local = Q.transpose() * turn.R * Q;
  for (const auto& [line, first] : {std::pair("1., 0., 0., 0., 1., 0.", 3),
                                    {"0.8, 0.6", 0},
                                    {"0., 0., 1.", 0},
                                    {"5, 10.0", 4}}) {
    INFO(line);
    const auto at = static_cast<size_t>(first);
    CHECK((deck.new_vector(line, at) - local * deck.old_vector(line, at)).norm() < 1e-12);
  }
}

TEST_CASE("directions of Nastran decks rotate with the mesh", "[io][decks]") {
  const std::string cards =
      "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
      "CORD2R,6,,1.,1.,1.,1.,1.,2.\n,2.,1.,1.\n"
      "CQUAD4,1,1,1,2,5,4,0\nCQUAD4,2,1,2,3,6,5,5\nCQUAD4,3,1,4,5,8,7,30.\nCQUAD4,4,1,5,6,9,8\n"
      "CBAR,11,2,1,2,0.,0.,1.\n,,,1.,2.,3.,-1.,0.,2.\n"
      "CBEAM,12,2,2,3,0.,1.,1.\nCBUSH,13,3,5,6,0.,0.,1.\n"
      "CONM2,14,9,,2.5,0.,0.,4.\n";
  const Turn turn;
  const Rewritten deck(".bdf", nastran_plate(cards), [&](const Points& p) { return turn(p); });
  CHECK(deck.notes.empty());
  const auto turned = [&](const std::string& line, size_t first) {
    INFO(line);
    CHECK((deck.new_vector(line, first) - turn.R * deck.old_vector(line, first)).norm() < 1e-12);
  };
  turned("CBAR,11", 5);
  turned(",,,1.,2.,3.", 3);
  turned(",,,1.,2.,3.", 6);
  turned("CBEAM,12", 5);
  turned("CBUSH,13", 5);
  turned("CONM2,14", 5);
  turned("CORD2R,5", 6);  // its origin is the basic one
  turned(",1.,0.,0.", 1);
  // System 6 is used by nothing, and angles against a side of the element stay.
  for (const char* line : {"CORD2R,6", ",2.,1.,1.", "CQUAD4,2", "CQUAD4,3", "CQUAD4,4"})
    for (size_t i = 0; i < deck.before.size(); ++i)
      if (deck.before[i].starts_with(line)) CHECK(deck.after[i] == deck.before[i]);
  // The material direction x of element 1 lies along its first side.
  for (size_t i = 0; i < deck.before.size(); ++i)
    if (deck.before[i].starts_with("CQUAD4,1,"))
      CHECK(std::abs(std::stod(between_commas(deck.after[i])[7])) < 1e-9);
}

TEST_CASE("material angles of a bent strip follow the strip", "[io][decks]") {
  // One element in the plane, one turned by 90 degrees about y: the direction x goes along both.
  const std::string cards = "CQUAD4,1,1,2,5,4,1,0\nCQUAD4,2,1,2,3,6,5,0\n";
  std::string text = nastran_plate(cards);
  const Rewritten deck(".bdf", text, [](Points p) {
    for (int i = 0; i < p.rows(); ++i) p.row(i) = Vec3(-p(i, 1), p(i, 0), p(i, 2)).transpose();
    return p;
  });
  for (size_t i = 0; i < deck.before.size(); ++i) {
    const Row row = between_commas(deck.after[i]);
    // Element 1 starts with its side along y: x is 90 degrees to the right of it.
    if (row[0] == "CQUAD4" && row[1] == "1") CHECK(std::stod(row[7]) == Approx(-90).margin(1e-9));
    if (row[0] == "CQUAD4" && row[1] == "2") CHECK(std::stod(row[7]) == Approx(0).margin(1e-9));
  }
}

TEST_CASE("fixed columns keep their places when directions rotate", "[io][decks]") {
  std::string text = nastran_plate(
      "CQUAD4         1       1       1       2       5       4\n"
      "CBAR          11       2       1       2      0.      0.      1.              PIN\n"
      "                              1.      2.      3.\n"
      "CBAR*                 12               2               2               3\n"
      "*                     0.              0.              1.\n"
      "*                                                     1.              2.\n"
      "*                     3.\n");
  const Rewritten deck(".bdf", text, [](Points p) {
    for (int i = 0; i < p.rows(); ++i) p.row(i) = Vec3(p(i, 0), -p(i, 2), p(i, 1)).transpose();
    return p;
  });
  const auto field = [](const std::string& line, size_t column, size_t width) {
    return line.size() > column ? std::strtod(line.substr(column, width).c_str(), nullptr) : 0.;
  };
  for (size_t i = 0; i < deck.before.size(); ++i) {
    const std::string& line = deck.after[i];
    if (deck.before[i].starts_with("CBAR   ")) {
      CHECK(line.substr(0, 40) == deck.before[i].substr(0, 40));
      CHECK(line.substr(64) == deck.before[i].substr(64));
      CHECK(field(line, 40, 8) == 0);
      CHECK(field(line, 48, 8) == -1);
      CHECK(field(line, 56, 8) == 0);
      CHECK(field(deck.after[i + 1], 24, 8) == 1);
      CHECK(field(deck.after[i + 1], 32, 8) == -3);
      CHECK(field(deck.after[i + 1], 40, 8) == 2);
    }
    if (deck.before[i].starts_with("CBAR*")) {
      CHECK(line == deck.before[i]);
      CHECK(field(deck.after[i + 1], 24, 16) == -1);
      CHECK(field(deck.after[i + 1], 40, 16) == 0);
      CHECK(field(deck.after[i + 2], 40, 16) == 1);
      CHECK(field(deck.after[i + 2], 56, 16) == -3);
      CHECK(field(deck.after[i + 3], 8, 16) == 2);
    }
  }
}

TEST_CASE("systems of LS-DYNA and Radioss rotate with the whole mesh, and are named otherwise",
          "[io][decks]") {
  const std::string nodes =
      "1,0.,0.,0.\n2,10.,0.,0.\n3,10.,10.,0.\n4,0.,10.,0.\n5,20.,0.,0.\n6,20.,10.,0.\n";
  const std::string dyna = "*KEYWORD\n*NODE\n" + nodes +
                           "*ELEMENT_SHELL\n1,1,1,2,3,4\n2,1,2,5,6,3\n"
                           "*DEFINE_COORDINATE_SYSTEM\n7,1.,1.,1.,2.,1.,1.\n1.,2.,1.\n"
                           "*DEFINE_COORDINATE_VECTOR\n8,1.,0.,0.,0.,1.,0.\n*END\n";
  const Turn turn;
  const Rewritten whole(".k", dyna, [&](const Points& p) { return turn(p); });
  CHECK(whole.notes.empty());
  const Vec3 o(1, 1, 1);
  CHECK((whole.new_vector("7,", 1) - o).norm() == 0);
  // Ten characters hold about eight digits.
  CHECK((whole.new_vector("7,", 4) - (o + turn.R * Vec3::UnitX())).norm() < 1e-7);
  CHECK((whole.new_vector("1.,2.,1.", 0) - (o + turn.R * Vec3::UnitY())).norm() < 1e-7);
  CHECK((whole.new_vector("8,", 1) - turn.R * Vec3::UnitX()).norm() < 1e-7);
  const auto bend = [](Points p) {
    for (const int i : {4, 5}) p.row(i) = Vec3(10, p(i, 1), 10).transpose();
    return p;
  };
  const Rewritten bent(".k", dyna, bend);
  CHECK(bent.notes.size() == 2);
  for (const auto& note : bent.notes) CHECK_THAT(note, Contains("*DEFINE_COORDINATE_"));
  CHECK((bent.new_vector("8,", 1) - Vec3::UnitX()).norm() == 0);

  const std::string radioss = "/BEGIN\ntitle\n2022\n/NODE\n" + nodes +
                              "/SHELL/1\n1,1,2,3,4\n2,2,5,6,3\n"
                              "/SKEW/FIX/3\nskew\n1.,1.,1.\n0.,1.,0.\n0.,0.,1.\n/END\n";
  const Rewritten skew(".rad", radioss, [&](const Points& p) { return turn(p); });
  CHECK((skew.new_vector("0.,1.,0.", 0) - turn.R * Vec3::UnitY()).norm() < 1e-12);
  CHECK((skew.new_vector("0.,0.,1.", 0) - turn.R * Vec3::UnitZ()).norm() < 1e-12);
  CHECK((skew.new_vector("1.,1.,1.", 0) - o).norm() == 0);
}

TEST_CASE("nodal normals of a bent strip are normal to it", "[io][decks]") {
  // A strip of length 50, bent to a quarter circle: also at its ends, where elements lie on one side.
  const int n = 20;
  const double length = 50, radius = length / (std::numbers::pi / 2);
  std::string text = "*NODE\n";
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i <= n; ++i)
      text += std::to_string(1 + i + j * (n + 1)) + ", " + std::to_string(length * i / n) + ", " +
              std::to_string(5 * j) + ".0, 0.0, 0., 0., 1.\n";
  text += "*ELEMENT, TYPE=S4, ELSET=E\n";
  for (int i = 0; i < n; ++i)
    text += std::to_string(i + 1) + ", " + std::to_string(i + 1) + ", " + std::to_string(i + 2) +
            ", " + std::to_string(i + n + 3) + ", " + std::to_string(i + n + 2) + "\n";
  const Rewritten deck(".inp", text, [&](Points p) {
    for (int i = 0; i < p.rows(); ++i) {
      const double a = p(i, 0) / radius;
      p.row(i) = Vec3(radius * std::sin(a), p(i, 1), radius * (1 - std::cos(a))).transpose();
    }
    return p;
  });
  for (int i = 0; i <= n; ++i) {
    const Row row = between_commas(deck.after[static_cast<size_t>(1 + i)]);
    const double a = length * i / n / radius;
    INFO("node " << i + 1);
    CHECK((numbers_at(row, 4) - Vec3(-std::sin(a), 0, std::cos(a))).norm() < 2e-3);
  }
}

TEST_CASE("translations leave directions as they are, to the byte", "[io][decks]") {
  const auto shift = [](Points p) {
    p.col(0).array() += 0.1;
    p.col(2).array() -= 1234.5;
    return p;
  };
  const Rewritten deck(".inp", abaqus_plate(kAbaqusDirections), shift);
  for (size_t i = 10; i < deck.before.size(); ++i)
    if (!deck.before[i].starts_with("0., 0., -5.")) CHECK(deck.after[i] == deck.before[i]);
  for (size_t i = 1; i < 10; ++i) CHECK(deck.after[i].ends_with("0., 0.6, 0.8"));
}
