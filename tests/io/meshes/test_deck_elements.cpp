// SPDX-License-Identifier: MPL-2.0
// Elements of decks other than shells, by their nodes.
#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
using Catch::Matchers::Contains;
using Kind = NonShellElement::Kind;

namespace {

/// "Kind name label: nodes by their numbers; weights" of each element.
std::vector<std::string> element_texts(const MeshFile& file) {
  static const std::map<Kind, std::string> kinds{
      {Kind::Solid, "solid"}, {Kind::Beam, "beam"},          {Kind::Bush, "bush"},
      {Kind::Rigid, "rigid"}, {Kind::Interpolation, "mean"}, {Kind::Mass, "mass"},
      {Kind::Other, "other"}};
  std::vector<std::string> all;
  for (const NonShellElement& element : file.other_elements()) {
    std::string text =
        kinds.at(element.kind) + " " + element.name + " " + std::to_string(element.label) + ":";
    for (const int node : element.nodes) text += " " + std::to_string(file.node_label(node));
    if (!element.weights.empty()) text += ";";
    for (const double weight : element.weights) text += " " + format_number(weight);
    all.push_back(text);
  }
  return all;
}

using Lines = std::vector<std::string>;

std::string nastran_grids(int count) {
  std::string text;
  for (int i = 1; i <= count; ++i)
    text += "GRID," + std::to_string(i) + ",," + std::to_string(i % 5) + ".," +
            std::to_string(i / 5) + ".,0.\n";
  return text + "CTRIA3,1,1,1,2,6\n";
}

Lines nastran(const std::string& cards) {
  return element_texts(MeshFile::read(file_with("others.bdf", nastran_grids(30) + cards)));
}

}  // namespace

TEST_CASE("Nastran: solids have their corners and middle nodes in the deck's order",
          "[io][decks]") {
  CHECK(nastran("CHEXA   10      1       1       2       3       4       5       6       +A\n"
                "+A      7       8\n"
                "CTETRA  11      1       4       3       2       1\n"
                "CHEXA*  12                             1               1               2\n"
                "*                      3               4               5               6\n"
                "*                      7               8               9              10\n"
                "*                     11              12              13              14\n"
                "*                     15              16              17              18\n"
                "*                     19              20\n"
                "CPENTA,13,1,1,2,3,4,5,6\n,7,,9,10,,12,13,14,\n,15\n"
                "CPYRAM,14,1,1,2,3,4,5\n") ==
        Lines{"solid CHEXA 10: 1 2 3 4 5 6 7 8", "solid CTETRA 11: 4 3 2 1",
              "solid CHEXA 12: 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20",
              "solid CPENTA 13: 1 2 3 4 5 6 7 9 10 12 13 14 15", "solid CPYRAM 14: 1 2 3 4 5"});
}

TEST_CASE("Nastran: bars, springs and masses, with the node of their direction", "[io][decks]") {
  CHECK(nastran("CBAR    10      1       1       2       0.      0.      1.\n"
                "CBAR    11      1       1       2       9\n"
                "CBEAM,12,1,3,4,7,,\nCBEAM3,13,1,1,2,3,8\n"
                "CROD,14,1,5,6\nCONROD,15,5,6,1,2.5\nCTUBE,16,1,7,8\n") ==
        Lines{"beam CBAR 10: 1 2", "beam CBAR 11: 1 2 9", "beam CBEAM 12: 3 4 7",
              "beam CBEAM3 13: 1 2 3 8", "beam CROD 14: 5 6", "beam CONROD 15: 5 6",
              "beam CTUBE 16: 7 8"});
  // Ends connected to the ground, and points without a position, are omitted.
  CHECK(nastran("CBUSH,10,1,1,2,,,,0\nCBUSH,11,1,3,,0.,0.,1.\nCBUSH,12,1,3,4,5\n"
                "CELAS1,13,1,1,3,2,3\nCELAS2,14,1.+4,7,1\nCELAS2,15,1.+4,0,,8,2\n"
                "SPOINT,1001,THRU,1005\nSPOINT,77\nCDAMP2,16,.5,1,1,1003\nCELAS1,17,1,77,,1\n"
                "CGAP,18,1,4,5,1.,0.,0.\nCFAST,19,1,PROP,3,4,7,8,9\nCWELD,20,1,7,ELPAT,8,9\n"
                "CELAS4,21,1.,1001,1002\n") ==
        Lines{"bush CBUSH 10: 1 2", "bush CBUSH 11: 3", "bush CBUSH 12: 3 4 5",
              "bush CELAS1 13: 1 2", "bush CELAS2 14: 7", "bush CELAS2 15: 8", "bush CDAMP2 16: 1",
              "bush CELAS1 17: 1", "bush CGAP 18: 4 5", "bush CFAST 19: 8 9 7",
              "bush CWELD 20: 8 9 7"});
  CHECK(nastran("CONM2,10,3,0,1.5\nCONM1,11,4,,1.\nPLOTEL,12,1,2\nCSHEAR,13,1,1,2,3,4\n") ==
        Lines{"mass CONM2 10: 3", "mass CONM1 11: 4", "other PLOTEL 12: 1 2",
              "other CSHEAR 13: 1 2 3 4"});
}

TEST_CASE("Nastran: rigid elements have their independent node first", "[io][decks]") {
  CHECK(nastran("RBAR,10,1,2,123456\nRBAR,11,1,2,,123456\nRROD,12,1,2\nRROD,13,1,2,1\n"
                "RBE2    14      9       123456  1       2       3       4       5       +\n"
                "+       6       7       8       1.2-5\n"
                "RBE2,15,9,123,1,THRU,4,7\n"
                "RBE2*   16                             9             123               1\n"
                "*                      2\n"
                "RBE1,17,9,123,10,456,11,1\n,,12,2\n,UM,1,123,2,3\n,,3,1,.5\n"
                "RSPLINE,18,.1,1,2,123,3,123456,4\n,,5\n"
                "MPC,19,1,1,1.,2,1,-1.,\n,,3,1,.5\n") ==
        Lines{"rigid RBAR 10: 1 2", "rigid RBAR 11: 2 1", "rigid RROD 12: 1 2",
              "rigid RROD 13: 2 1", "rigid RBE2 14: 9 1 2 3 4 5 6 7 8",
              "rigid RBE2 15: 9 1 2 3 4 7", "rigid RBE2 16: 9 1 2",
              "rigid RBE1 17: 9 10 11 12 1 2 3", "other RSPLINE 18: 1 2 3 4 5",
              "other MPC 19: 1 2 3"});
}

TEST_CASE("Nastran: averages have their reference node first, then nodes with weights",
          "[io][decks]") {
  CHECK(nastran("RBE3    10              9       123456  1.      123     1       2       +\n"
                "+       3       2.5     123456  4       5       1.      456     6       +\n"
                "+       UM      1       12      2       3\n"
                "RBE3,11,,9,123456,.5,123,1,THRU\n,4,UM,1,12,2,3\n"
                "RBE3,12,,9,123456,1.0,123,1,2\n,,,ALPHA,6.5-6\n") ==
        Lines{"mean RBE3 10: 9 1 2 3 4 5; 1 1 1 2.5 2.5",
              "mean RBE3 11: 9 1 2 3 4; 0.5 0.5 0.5 0.5", "mean RBE3 12: 9 1 2; 1 1"});
}

TEST_CASE("Nastran: missing nodes of other elements are named with their position", "[io][decks]") {
  const auto says = [](const std::string& cards) {
    return read_error("others_wrong.bdf", "GRID,1\nGRID,2\nGRID,3\nCTRIA3,1,1,1,2,3\n" + cards);
  };
  CHECK(says("CBAR,10,1,1,99,0.,0.,1.\n") ==
        "5:6: found node 99 in CBAR 10, expected the number of a node");
  CHECK(says("CBUSH   10      1       1       a\n") == "5:33: found 'a', expected a node number");
  CHECK(says("RBE3,10,,,123,1.,123,1,2\n") ==
        "5:6: found an RBE3 without its reference node, expected one");
  CHECK(says("RBE2,10,1,123,2,THRU,1000000000\n") == "5:22: found more nodes than an element has");
}

namespace {

std::string abaqus_nodes(int count) {
  std::string text = "*NODE, NSET=ALL\n";
  for (int i = 1; i <= count; ++i)
    text +=
        std::to_string(i) + "," + std::to_string(i % 5) + ".," + std::to_string(i / 5) + ".,0.\n";
  return text + "*ELEMENT,TYPE=S4,ELSET=SHEET\n1,1,2,7,6\n2,2,3,8,7\n";
}

Lines abaqus(const std::string& text) {
  return element_texts(MeshFile::read(file_with("others.inp", abaqus_nodes(30) + text)));
}

}  // namespace

TEST_CASE("Abaqus: solids, beams, springs and masses by their nodes", "[io][decks]") {
  CHECK(abaqus("*ELEMENT,TYPE=C3D8R\n10,1,2,3,4,5,6,7,8\n*ELEMENT,TYPE=C3D10\n11,1,2,3,4,5,\n"
               "6,7,8,9,10\n*ELEMENT,TYPE=C3D20\n12,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,\n"
               "16,17,18,19,20\n*ELEMENT,TYPE=C3D6\n13,1,2,3,4,5,6\n") ==
        Lines{"solid C3D8R 10: 1 2 3 4 5 6 7 8", "solid C3D10 11: 1 2 3 4 5 6 7 8 9 10",
              "solid C3D20 12: 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20",
              "solid C3D6 13: 1 2 3 4 5 6"});
  CHECK(abaqus("*ELEMENT,TYPE=B31\n10,1,2\n11,2,3,9\n*ELEMENT,TYPE=B32R\n12,1,2,3\n"
               "*ELEMENT,TYPE=T3D2\n13,4,5\n*ELEMENT,TYPE=SPRINGA\n14,4,5\n"
               "*ELEMENT,TYPE=SPRING1\n15,4\n*ELEMENT,TYPE=MASS\n16,9\n"
               "*ELEMENT,TYPE=CONN3D2\n17,,9\n*ELEMENT,TYPE=UNKNOWN\n18,77,\n78\n") ==
        Lines{"beam B31 10: 1 2", "beam B31 11: 2 3 9", "beam B32R 12: 1 2 3", "beam T3D2 13: 4 5",
              "bush SPRINGA 14: 4 5", "bush SPRING1 15: 4", "mass MASS 16: 9",
              "bush CONN3D2 17: 9"});
  CHECK(MeshFile::read(mesh_scratch() / "others.inp").warnings() ==
        Lines{"2 B31, 1 B32R, 1 CONN3D2, 1 MASS, 1 SPRING1, 1 SPRINGA, 1 T3D2, 1 UNKNOWN; 24 nodes "
              "not used by a shell"});
}

TEST_CASE("Abaqus: connections by nodes, sets and surfaces", "[io][decks]") {
  const std::string sets =
      "*NSET,NSET=RIM\n11,12,13\n*NSET,NSET=CENTRE\n20\n"
      "*SURFACE,NAME=TOP\nSHEET,SPOS\n*SURFACE,NAME=SIDE\n1,E2\n2,E3\n"
      "*SURFACE,TYPE=NODE,NAME=NODES\nRIM,1.\n14\n";
  CHECK(abaqus(sets + "*RIGID BODY,NSET=RIM,REF NODE=20\n*RIGID BODY,ELSET=SHEET,REF NODE=CENTRE\n"
                      "*MPC\nBEAM,RIM,20\nSLIDER,1,2,3\n*EQUATION\n3\n1,1,1.,2,1,-1.,3,2,.5\n"
                      "5\n1,1,1.,2,1,-1.,3,2,.5,4,1,1.\n5,1,1.\n") ==
        Lines{"rigid *RIGID BODY 0: 20 11 12 13", "rigid *RIGID BODY 0: 20 1 2 3 6 7 8",
              "rigid *MPC 0: 20 11 12 13", "other *MPC 0: 1 2 3", "other *EQUATION 0: 1 2 3",
              "other *EQUATION 0: 1 2 3 4 5"});
  CHECK(abaqus(sets + "*COUPLING,CONSTRAINT NAME=C,REF NODE=20,SURFACE=TOP\n*KINEMATIC\n1,6\n"
                      "*COUPLING,CONSTRAINT NAME=D,REF NODE=20,SURFACE=SIDE\n*DISTRIBUTING\n1,3\n"
                      "*COUPLING,CONSTRAINT NAME=E,REF NODE=21,SURFACE=NODES\n*KINEMATIC\n"
                      "*KINEMATIC COUPLING,REF NODE=9\nRIM,1,3\n10,1\n"
                      "*ELEMENT,TYPE=DCOUP3D,ELSET=REF\n30,25\n"
                      "*DISTRIBUTING COUPLING,ELSET=REF\n1,2.\nRIM,.5\n") ==
        Lines{"other DCOUP3D 30: 25", "rigid *KINEMATIC 0: 20 1 2 3 6 7 8",
              "mean *DISTRIBUTING 0: 20 2 7 8; 1 1 1", "rigid *KINEMATIC 0: 21 11 12 13 14",
              "rigid *KINEMATIC COUPLING 0: 9 11 12 13 10",
              "mean *DISTRIBUTING COUPLING 0: 25 1 11 12 13; 2 0.5 0.5 0.5"});
}

TEST_CASE("Abaqus: missing nodes of other elements are named with their position", "[io][decks]") {
  const auto says = [](const std::string& text) {
    return read_error("others_wrong.inp",
                      "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT,TYPE=S3\n1,1,2,3\n" + text);
  };
  CHECK(says("*ELEMENT,TYPE=B31\n7,1,99\n") ==
        "8:1: found node 99 in B31 7, expected the number of a node");
  CHECK(says("*ELEMENT,TYPE=C3D4\n7,1,2,3\n") ==
        "8:1: found 3 nodes of an element of type C3D4, expected 4");
  CHECK(says("*MPC\nBEAM,1,9\n") ==
        "8:1: found *MPC with unknown nodes, expected nodes and sets of the deck");
  CHECK(says("*EQUATION\n3\n1,1,1.\n") ==
        "8:1: found an equation with missing terms, expected as many as stated");
}

namespace {

Lines dyna(const std::string& keyword, const std::string& text) {
  std::string deck = keyword + "\n*NODE\n";
  for (int i = 1; i <= 30; ++i)
    deck +=
        std::to_string(i) + "," + std::to_string(i % 5) + ".," + std::to_string(i / 5) + ".,0.\n";
  return element_texts(MeshFile::read(
      file_with("others.k", deck + "*ELEMENT_SHELL\n1,1,1,2,7,6\n" + text + "*END\n")));
}

}  // namespace

TEST_CASE("LS-DYNA: solids on one card or two, of fewer corners too", "[io][decks]") {
  CHECK(dyna("*KEYWORD",
             "*ELEMENT_SOLID\n"
             "      10       1       1       2       3       4       5       6       7       8\n"
             "      11       1\n"
             "       1       2       3       4       5       5       5       5       0       0\n"
             "12,1\n1,2,3,4,5,6,7,8,9,10\n13,1,1,2,3,4,5,5,6,6\n"
             "*ELEMENT_SOLID_ORTHO\n14,1\n1,2,3,4,5,6,7,8\n1.,0.,0.\n0.,1.,0.\n"
             "15,1,1,2,3,4,5,6,7,8\n1.,0.,0.\n0.,1.,0.\n"
             "*ELEMENT_SOLID_H20\n16,1\n1,2,3,4,5,6,7,8,9,10\n11,12,13,14,15,16,17,18,19,20\n"
             "*ELEMENT_SOLID_H27\n17,1\n1,2,3\n") ==
        Lines{"solid *ELEMENT_SOLID 10: 1 2 3 4 5 6 7 8", "solid *ELEMENT_SOLID 11: 1 2 3 4 5",
              "solid *ELEMENT_SOLID 12: 1 2 3 4 5 6 7 8 9 10",
              "solid *ELEMENT_SOLID 13: 1 2 3 4 5 6", "solid *ELEMENT_SOLID 14: 1 2 3 4 5 6 7 8",
              "solid *ELEMENT_SOLID 15: 1 2 3 4 5 6 7 8",
              "solid *ELEMENT_SOLID 16: 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20"});
}

TEST_CASE("LS-DYNA: beams, springs, masses and connections", "[io][decks]") {
  CHECK(dyna("*KEYWORD",
             "*ELEMENT_BEAM\n      10       1       1       2       9\n11,1,2,3\n"
             "*ELEMENT_BEAM_THICKNESS_OFFSET\n12,1,2,3,9\n1.,1.,1.\n.5,.5\n13,1,4,5,9\n1.\n.5\n"
             "*ELEMENT_DISCRETE\n      14       1       3       4       0\n15,1,5,0\n"
             "*ELEMENT_MASS\n      16       7            2.50\n*ELEMENT_PLOTEL\n17,1,2\n"
             "*ELEMENT_INERTIA\n18,8\n1.,1.,1.\n*ELEMENT_SEATBELT\n19,1,3,4\n"
             "*ELEMENT_MASS_NODE_SET\n20,1,2.\n") ==
        Lines{"beam *ELEMENT_BEAM 10: 1 2 9", "beam *ELEMENT_BEAM 11: 2 3",
              "beam *ELEMENT_BEAM 12: 2 3 9", "beam *ELEMENT_BEAM 13: 4 5 9",
              "bush *ELEMENT_DISCRETE 14: 3 4", "bush *ELEMENT_DISCRETE 15: 5",
              "mass *ELEMENT_MASS 16: 7", "other *ELEMENT_PLOTEL 17: 1 2",
              "mass *ELEMENT_INERTIA 18: 8", "beam *ELEMENT_SEATBELT 19: 3 4"});
  CHECK(dyna("*KEYWORD",
             "*SET_NODE_LIST\n5\n1,2,3\n"
             "*CONSTRAINED_NODAL_RIGID_BODY\n         9         0         5        20\n5\n"
             "*CONSTRAINED_NODAL_RIGID_BODY_SPC_TITLE\na body\n9,0,5,2\n1,1,1\n"
             "*CONSTRAINED_SPOTWELD\n1,2,1.,1.\n*CONSTRAINED_SPOTWELD_ID\n77\n3,4\n"
             "*CONSTRAINED_INTERPOLATION\n8,20,123456\n1,123,.5\n2,123\n") ==
        Lines{"rigid *CONSTRAINED_SPOTWELD 0: 1 2", "rigid *CONSTRAINED_SPOTWELD 77: 3 4",
              "mean *CONSTRAINED_INTERPOLATION 8: 20 1 2; 0.5 1",
              "rigid *CONSTRAINED_NODAL_RIGID_BODY 9: 20 1 2 3",
              "rigid *CONSTRAINED_NODAL_RIGID_BODY 5: 1 2 3",
              "rigid *CONSTRAINED_NODAL_RIGID_BODY 9: 2 1 3"});
  CHECK(dyna("*KEYWORD I10=Y", "*ELEMENT_BEAM\n        10         1         1         2\n") ==
        Lines{"beam *ELEMENT_BEAM 10: 1 2"});
  CHECK(read_error("wrong.k",
                   "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT_SHELL\n1,1,1,2,3\n"
                   "*ELEMENT_BEAM\n7,1,1,99\n") ==
        "8:1: found node 99 in *ELEMENT_BEAM 7, expected the number of a node");
}

namespace {

const std::string kRadioss =
    "#RADIOSS STARTER\n/BEGIN\nplate\n      2022         0\n/UNIT\nkg mm ms\n"
    "/NODE\n#  node_ID                  Xc                  Yc                  Zc\n"
    "         1                 0.0                 0.0                 0.0\n"
    "         2                 1.0                 0.0\n"
    "         3               1.000                 1.0                 0.0\n"
    "         4                 0.0                 1.0                 0.0\n"
    "        20                 0.5                 0.5                 1.0\n"
    "/SHELL/7\n         1         1         2         3         4\n"
    "/SH3N/8\n         2         1         2        20\n"
    "/PART/7\nskin\n         1         1\n"
    "/BRICK/9\n        10         1         2         3         4        20        20        20"
    "        20\n"
    "/BEAM/9\n        11         1         2        20\n/SPRING/9\n        12         1         0\n"
    "/TETRA10/9\n        13\n         1         2         3        20         0         0         0"
    "         0         0         0\n"
    "/GRNOD/NODE/5\nrim\n         1         2\n         3\n"
    "/RBODY/6\n\n        20         0         0         0                           5         0\n"
    "/ADMAS/5/3\nm\n                 1.0         1\n/END\nwhat follows\n";

}  // namespace

TEST_CASE("Radioss: nodes, shells, parts, groups and other entities", "[io][decks]") {
  const auto path = file_with("plate_0000.rad", kRadioss);
  const MeshFile file = MeshFile::read(path);
  CHECK(file.format() == "Radioss starter");
  REQUIRE(file.shells().node_count() == 5);
  CHECK(file.shells().points.row(2) == Vec3(1, 1, 0).transpose());
  REQUIRE(file.shells().face_count() == 2);
  CHECK(file.shells().face(0).size() == 4);
  CHECK(file.shells().face(1).size() == 3);
  REQUIRE(file.properties().size() == 2);
  CHECK(file.properties()[0].title == "skin");
  REQUIRE(file.sets().size() == 1);
  CHECK(file.sets()[0].title == "rim");
  CHECK(file.sets()[0].nodes == std::vector<int>{0, 1, 2});
  CHECK(element_texts(file) == Lines{"solid /BRICK 10: 1 2 3 4 20", "beam /BEAM 11: 1 2 20",
                                     "bush /SPRING 12: 1", "solid /TETRA10 13: 1 2 3 20",
                                     "rigid /RBODY 6: 20 1 2 3"});
  CHECK(file.warnings() == Lines{"/ADMAS, 1 /BEAM, 1 /BRICK, 1 /RBODY, 1 /SPRING, 1 /TETRA10"});
}

TEST_CASE("Radioss: only columns of coordinates change", "[io][decks]") {
  const auto path = file_with("plate_0000.rad", kRadioss);
  check_identity(path);
  check_identity(file_with("cr_0000.rad", with_carriage_returns(kRadioss)));
  const MeshFile file = MeshFile::read(path);
  check_round_trip(path, moved(file, 0.3, 1), 2e-16);
  Points points = file.shells().points;
  points(1, 2) = 0.25;
  points(2, 0) = 1.0 / 3;
  std::string wanted = kRadioss;
  const auto put = [&](const std::string& old, const std::string& by) {
    wanted.replace(wanted.find(old), old.size(), by);
  };
  put("         2                 1.0                 0.0\n",
      "         2                 1.0                 0.0                 .25\n");
  put("         3               1.000 ", "         3   .3333333333333333 ");
  CHECK(bytes_of(check_round_trip(path, points, 0)) == wanted);
  check_damage(".rad", kRadioss, 500);
}

TEST_CASE("Radioss: files other than one model in its position are named", "[io][decks]") {
  const auto says = [](const std::string& text) {
    return read_error("e.rad", "/NODE\n         1\n         2                 1.0\n" + text);
  };
  CHECK(says("/TRANSFORM/TRA/1\n") ==
        "4:1: found '/TRANSFORM/TRA/1', expected one model without transformed nodes");
  CHECK_THAT(says("//SUBMODEL/1\n"), Contains("4:1: found '//SUBMODEL/1'"));
  CHECK(says("/BEGIN\nx\n        44\n") ==
        "6:9: found input of version 44, expected 51 or later, whose fields have 10 columns");
  CHECK(says("/SH3N/1\n         1         1         2         9\n") ==
        "5:10: found node 9 in element 1, expected the number of a node");
  CHECK_THAT(says("#include none.rad\n"), Contains("none.rad: found no such file"));
}
