// SPDX-License-Identifier: MPL-2.0
// Nodes of decks in local coordinate systems.
#include <cmath>
#include <numbers>
#include <regex>
#include <sstream>

#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// An independent parser of decks with comma-separated cards; a leading comma continues a card.
class OwnReader {
 public:
  explicit OwnReader(const std::string& text) {
    for (std::string line : lines_of(std::regex_replace(text, std::regex("\n,"), ","))) {
      std::vector<std::string> values;
      std::istringstream in(line);
      for (std::string value; std::getline(in, value, ',');) values.push_back(value);
      values.resize(14);
      if (values[0] == "GRID") grids_[std::stol(values[1])] = values;
      if (values[0].starts_with("CORD")) systems_[std::stol(values[1])] = values;
    }
  }
  Vec3 position(long grid) const {
    const auto& values = grids_.at(grid);
    return out_of(integer(values[2]), three(values, 3));
  }
  std::map<long, Vec3> positions() const {
    std::map<long, Vec3> all;
    for (const auto& [label, values] : grids_) all[label] = position(label);
    return all;
  }

 private:
  static long integer(const std::string& text) { return text.empty() ? 0 : std::stol(text); }
  static double real(std::string text) {
    if (text.empty()) return 0;
    const size_t sign = text.find_first_of("+-", 1);
    if (sign != text.npos && text[sign - 1] != 'e') text.insert(sign, "e");
    return std::stod(text);
  }
  static Vec3 three(const std::vector<std::string>& values, size_t i) {
    return {real(values[i]), real(values[i + 1]), real(values[i + 2])};
  }
  Vec3 out_of(long system, const Vec3& n) const {
    if (system == 0) return n;
    const auto& values = systems_.at(system);
    Vec3 a, b, c;
    if (values[0][4] == '1') {
      a = position(integer(values[2]));
      b = position(integer(values[3]));
      c = position(integer(values[4]));
    } else {
      a = out_of(integer(values[2]), three(values, 3));
      b = out_of(integer(values[2]), three(values, 6));
      c = out_of(integer(values[2]), three(values, 9));
    }
    const Vec3 z = (b - a).normalized(), x = ((c - a) - z * z.dot(c - a)).normalized();
    const double first = n[1] * std::numbers::pi / 180, second = n[2] * std::numbers::pi / 180;
    Vec3 local = n;
    if (values[0][5] == 'C') local = {n[0] * std::cos(first), n[0] * std::sin(first), n[2]};
    if (values[0][5] == 'S')
      local = n[0] * Vec3(std::sin(first) * std::cos(second), std::sin(first) * std::sin(second),
                          std::cos(first));
    return a + x * local[0] + z.cross(x) * local[1] + z * local[2];
  }

  std::map<long, std::vector<std::string>> grids_, systems_;
};

/// Six systems, the last three relative to others, one of them defined by nodes; 20 nodes in them
/// alternately.
std::string deck_of_systems() {
  std::string text =
      "BEGIN BULK\nCORD2R,1,,10.,0.,0.,10.,0.,1.\n,10.,1.,0.\n"
      "CORD2C,2,0,0.,5.,0.,1.,5.,1.\n,0.,6.,3.\n"
      "CORD2S,3,0,1.,2.,3.,1.,3.,3.\n,4.,2.,3.\n"
      "CORD2R,4,2,2.,30.,1.,2.,30.,5.\n,3.,60.,1.\n"
      "CORD2C,5,4,0.,0.,0.,0.,1.,1.\n,1.,0.,0.\n"
      "CORD1S,6,101,102,103\n";
  for (int i = 0; i < 20; ++i) {
    const int system = i % 7;
    text += "GRID," + std::to_string(101 + i) + "," + (system ? std::to_string(system) : "") + "," +
            std::to_string(1 + i % 4) + ".5," + std::to_string((37 * i) % 170 + 3) + ".25," +
            std::to_string(i % 9 + 2) + ".125\n";
  }
  return text + "CTRIA3,1,1,101,102,103\nENDDATA\n";
}

void check_node_positions(const MeshFile& file, const std::map<long, Vec3>& positions,
                          double within) {
  REQUIRE(static_cast<int>(positions.size()) == file.shells().node_count());
  for (const auto& [label, position] : positions) {
    INFO("node " << label);
    const Vec3 there = file.shells().points.row(*file.node_of_label(label)).transpose();
    CHECK((there - position).norm() <= within);
  }
}

}  // namespace

TEST_CASE("Nastran: nodes of local systems have their position in the basic one", "[io][decks]") {
  const std::string text = deck_of_systems();
  check_node_positions(MeshFile::read(file_with("systems.bdf", text)), OwnReader(text).positions(),
                       1e-12);
  // Manual check: a rotation by a quarter turn, a point on the pole, an exact angle.
  const MeshFile file = MeshFile::read(file_with(
      "exact.bdf",
      "CORD2R,1,,10.,0.,0.,10.,0.,1.\n,10.,1.,0.\nCORD2C,2,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
      "CORD2S,3,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nGRDSET,,1\nGRID,1,,1.,2.,3.\n"
      "GRID,2,2,3.,90.,7.\nGRID,3,3,4.,90.,-90.\nGRID,4,0,1.,2.,3.\n"
      "GRID,5,2,-3.,450.,7.\nCTRIA3,1,1,1,2,3\n"));
  const auto row = [&](int i) -> Vec3 { return file.shells().points.row(i).transpose(); };
  CHECK(row(0) == Vec3(8, 1, 3));
  CHECK(row(1) == Vec3(0, 3, 7));
  CHECK(row(2) == Vec3(0, -4, 0));
  CHECK(row(3) == Vec3(1, 2, 3));
  CHECK(row(4) == Vec3(0, -3, 7));
}

TEST_CASE("Nastran: nodes that move are written in their own systems", "[io][decks]") {
  const std::string text = deck_of_systems();
  const auto path = file_with("systems.bdf", text);
  check_identity(path);
  const MeshFile file = MeshFile::read(path);
  for (const int every : {1, 2, 5}) {
    Points points = moved(file, 0.3, every);
    const auto target = check_round_trip(path, points, 1e-11);
    std::map<long, Vec3> wanted;
    for (int i = 0; i < points.rows(); ++i) wanted[file.node_label(i)] = points.row(i).transpose();
    const auto again = OwnReader(bytes_of(target)).positions();
    for (const auto& [label, position] : wanted) {
      INFO("node " << label);
      CHECK((again.at(label) - position).norm() <= 1e-11);
    }
  }
}

TEST_CASE("Nastran: of a node in a local system only the numbers that change are written",
          "[io][decks]") {
  const std::string head =
      "CORD2C  2               10.     0.      0.      10.     0.      1.\n"
      "        11.     0.      0.\n";
  const std::string grids =
      "GRID    1       2           2.50   370.0     1.0\n"
      "GRID    2       2            3.5   -5.00     2.0\n"
      "GRID    3                   0.      0.      0.  \n";
  const std::string tail = "CTRIA3  1       1       1       2       3\n";
  const auto path = file_with("angles.bdf", head + grids + tail);
  check_identity(path);
  const MeshFile file = MeshFile::read(path);
  Points points = file.shells().points;
  points(0, 2) += 0.5;  // along the axis
  // Around the axis by 10 degrees: the angle continues from its previous value.
  const double angle = 5 * std::numbers::pi / 180;
  points.row(1) = Vec3(10 + 3.5 * std::cos(angle), 3.5 * std::sin(angle), 2).transpose();
  const auto target = mesh_scratch() / "angles_moved.bdf";
  CHECK(file.write(target, points).largest < 1e-14);
  CHECK(bytes_of(target) == head +
                                "GRID    1       2           2.50   370.0     1.5\n"
                                "GRID    2       2            3.5      5.     2.0\n"
                                "GRID    3                   0.      0.      0.  \n" +
                                tail);
}

TEST_CASE(
    "Nastran: a system by nodes follows them, and its nodes are written when their numbers "
    "change",
    "[io][decks]") {
  const std::string text =
      "CORD1R,1,1,2,3\nGRID,1,,0.,0.,0.\nGRID,2,,0.,0.,1.\nGRID,3,,1.,0.,0.\n"
      "GRID,4,1,1.,1.,1.\nGRID,5,1,2.,0.,1.\nCTRIA3,1,1,1,2,3\n";
  const auto path = file_with("followed.bdf", text);
  const MeshFile file = MeshFile::read(path);
  // All move together: the numbers of nodes 4 and 5 stay.
  Points points = file.shells().points;
  points.col(1).array() += 0.25;
  const auto target = check_round_trip(path, points, 0);
  CHECK_THAT(bytes_of(target),
             Contains("GRID,4,1,1.,1.,1.\nGRID,5,1,2.,0.,1.\n") && Contains("GRID,1,,0.,.25,0.\n"));
  // The system rotates and its nodes stay: all their numbers change.
  points = file.shells().points;
  points.row(2) = Vec3(0, 1, 0).transpose();
  CHECK_THAT(bytes_of(check_round_trip(path, points, 0)),
             Contains("GRID,4,1,1.,-1.,1.\n") && Contains("GRID,5,1,0.,-2.,1.\n"));
  points.row(2) = Vec3(0, 0, 5).transpose();
  CHECK_THROWS_WITH(file.write(mesh_scratch() / "flat.bdf", points),
                    Contains("followed.bdf:1:8: found coordinate system 1 whose three points"));
}

TEST_CASE("Nastran: unsupported systems are named with their position", "[io][decks]") {
  const auto says = [](const std::string& text) {
    return read_error(
        "no_system.bdf",
        "GRID,1,7,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nCTRIA3,1,1,1,2,3\n" + text);
  };
  const std::string points = ",0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n";
  CHECK(says("") == "1:6: found node 1 in coordinate system 7, expected one that the deck defines");
  CHECK(says("CORD2R,7,8" + points) ==
        "5:8: found coordinate system 8, in which system 7 is given, expected one that the deck "
        "defines");
  CHECK(says("CORD2R,7,8" + points + "CORD2R,8,7" + points) ==
        "5:8: found coordinate system 7, which is defined by itself");
  CHECK(says("CORD1R,7,1,2,3\n") == "5:8: found coordinate system 7, which is defined by itself");
  CHECK(says("CORD1R,8,2,2,3,7,2,3,9\n") ==
        "5:16: found node 9 in coordinate system 7, expected the number of a node");
  CHECK(says("CORD2R,7,,0.,0.,0.,0.,0.,1.\n,0.,0.,3.\n") ==
        "5:8: found coordinate system 7 whose three points lie on a line");
  CHECK(says("CORD3G,7,E,1,2,3\n") ==
        "5:8: found nodes in coordinate system 7, a CORD3G, expected rectangular, cylindrical or "
        "spherical systems");
  CHECK(says("CORD2R,7,0" + points + "CORD2R,7,0" + points) ==
        "7:8: found coordinate system 7 a second time, the first is in line 5");
  // Systems that no node uses may be invalid.
  CHECK(MeshFile::read(file_with("unused.bdf",
                                 "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n"
                                 "CTRIA3,1,1,1,2,3\nCORD3G,9,E,1,2,3\nCORD2R,7,8" +
                                     points))
            .shells()
            .node_count() == 3);
}

namespace {

const std::string kSheet = "*ELEMENT,TYPE=S3\n1,1,2,3\n";

Vec3 at(const MeshFile& file, long label) {
  return file.shells().points.row(*file.node_of_label(label)).transpose();
}

}  // namespace

TEST_CASE("Abaqus: nodes of local systems have their global position and are written in their own",
          "[io][decks]") {
  const std::string text =
      "*SYSTEM\n10.,0.,0.,10.,1.,0.\n9.,0.,0.\n*NODE\n1,1.,2.,3.\n"
      "*NODE,SYSTEM=C\n2,2.,90.,1.\n*NODE,SYSTEM=S\n3,2.,90.,30.\n"
      "*SYSTEM\n5.,0.,0.\n*NODE\n4,1.,2.,3.\n*SYSTEM\n0.,0.,0.,0.,1.,0.\n*NODE\n5,1.,2.,3.\n"
      "*SYSTEM\n*NODE\n6,1.,2.,3.\n*NODE,SYSTEM=S\n7,2.,0.,-90.\n" +
      kSheet;
  const auto path = file_with("system.inp", text);
  check_identity(path);
  const MeshFile file = MeshFile::read(path);
  // Its x axis is the global y, its y axis the global -x.
  CHECK((at(file, 1) - Vec3(8, 1, 3)).norm() < 1e-14);
  CHECK((at(file, 2) - Vec3(8, 0, 1)).norm() < 1e-14);
  CHECK((at(file, 3) - Vec3(10 - std::sqrt(3), 0, 1)).norm() < 1e-14);
  CHECK((at(file, 4) - Vec3(6, 2, 3)).norm() < 1e-14);
  CHECK((at(file, 5) - Vec3(-2, 1, 3)).norm() < 1e-14);
  CHECK((at(file, 6) - Vec3(1, 2, 3)).norm() < 1e-14);
  CHECK((at(file, 7) - Vec3(0, 0, -2)).norm() < 1e-14);
  check_round_trip(path, moved(file, 0.3, 1), 1e-14);
  Points points = file.shells().points;
  points(0, 1) += 0.5;
  points(1, 2) += 0.5;
  const std::string written = bytes_of(check_round_trip(path, points, 1e-14));
  CHECK_THAT(written, Contains("\n1,1.5,2.,3.\n") && Contains("\n2,2.,90.,1.5\n"));
  CHECK_THAT(written, Contains("\n3,2.,90.,30.\n") && Contains("\n5,1.,2.,3.\n"));
}

TEST_CASE("Abaqus: an instance that is moved and turned has global nodes, its part is written",
          "[io][decks]") {
  const std::string text =
      "*PART,NAME=P\n*NODE\n1,0.,0.,0.\n2,1.,0.,0.\n3,0.,1.,0.\n" + kSheet +
      "*END PART\n*ASSEMBLY,NAME=A\n*INSTANCE,NAME=P-1,PART=P\n10.,0.,0.\n"
      "10.,0.,0.,10.,0.,1.,90.\n*END INSTANCE\n*NODE\n1,0.,0.,0.\n*END ASSEMBLY\n";
  const auto path = file_with("instance.inp", text);
  check_identity(path);
  const MeshFile file = MeshFile::read(path);
  CHECK((at(file, 1) - Vec3(10, 0, 0)).norm() < 1e-14);
  CHECK((at(file, 2) - Vec3(10, 1, 0)).norm() < 1e-14);
  CHECK((at(file, 3) - Vec3(9, 0, 0)).norm() < 1e-14);
  Points points = file.shells().points;
  points(1, 1) += 0.5;
  CHECK_THAT(bytes_of(check_round_trip(path, points, 1e-14)),
             Contains("\n1,0.,0.,0.\n2,1.5,0.,0.\n3,0.,1.,0.\n"));
}

TEST_CASE("Abaqus: nodes with parameters are read, and refused when they move", "[io][decks]") {
  const auto path = file_with("parameters.inp",
                              "*PARAMETER\nw = 2.5 # wide\nv=w\n*NODE\n1,0.,0.,0.\n"
                              "2,<v>,0.,0.\n3,0., <w> ,0.\n" +
                                  kSheet);
  check_identity(path);
  const MeshFile file = MeshFile::read(path);
  CHECK(at(file, 2) == Vec3(2.5, 0, 0));
  CHECK(at(file, 3) == Vec3(0, 2.5, 0));
  Points points = file.shells().points;
  points(0, 0) += 1;
  check_round_trip(path, points, 0);
  points(1, 2) += 1;
  const auto target = mesh_scratch() / "refused.inp";
  CHECK_THROWS_WITH(file.write(target, points),
                    Contains("parameters.inp:6:3: node 2 cannot be moved: it has a coordinate that "
                             "is the parameter <v>"));
  CHECK_FALSE(std::filesystem::exists(target));
}

TEST_CASE("damaged decks of systems, elements and connections give a result or an error",
          "[io][decks]") {
  const auto seeds = std::filesystem::path(BATTEN_SOURCE_DIR) / "tests/fuzz/seeds/meshes";
  for (const char* name : {"systems.bdf", "parts.inp", "beside.k", "plate.rad"}) {
    INFO(name);
    check_identity(seeds / name);
    check_round_trip(seeds / name, moved(MeshFile::read(seeds / name), 0.1, 2), 1e-4);
    check_damage(std::filesystem::path(name).extension().string(), bytes_of(seeds / name), 700);
  }
}
