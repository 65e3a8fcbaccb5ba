// SPDX-License-Identifier: MPL-2.0
// Ways of writing the same mesh: each is read as the mesh that it means.
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;

namespace {

std::string grid_cards(int count) {
  std::string text = "BEGIN BULK\n";
  for (int i = 0; i < count; ++i)
    text += "GRID," + std::to_string(i + 1) + ",," + std::to_string(i % 5) + ".," +
            std::to_string(i / 5) + ".,0.\n";
  return text;
}

const std::string kSquare = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n";

std::vector<int> set_of(const MeshFile& file, const std::string& name) {
  for (const auto& set : file.sets())
    if (set.name == name) return set.nodes;
  FAIL("no set " << name);
  return {};
}

}  // namespace

TEST_CASE("free-field lines of Nastran may have any length", "[io][decks]") {
  for (const int spider : {3, 6, 7, 8, 20, 60}) {
    std::string line = "RBE2,50,1,123456";
    for (int i = 0; i < spider; ++i) line += "," + std::to_string(i + 6);
    const std::string text = grid_cards(70) + "CQUAD4,1,1,1,2,7,6\n" + line + "\nENDDATA\n";
    for (const char* name : {"long.bdf", "long.fem"}) {
      const MeshFile file = MeshFile::read(file_with(name, text));
      REQUIRE(file.other_elements().size() == 1);
      CHECK(isize(file.other_elements()[0].nodes) == spider + 1);
    }
  }
  // A continuation field is no node.
  const MeshFile file = MeshFile::read(file_with(
      "continued.bdf", grid_cards(70) + "CQUAD4,1,1,1,2,7,6\n"
                                        "RBE2,50,1,123456,6,7,8,9,10,+A\n+A,11,12\nENDDATA\n"));
  CHECK(file.other_elements()[0].nodes.size() == 8);
}

TEST_CASE("members of sets of Abaqus may have dots, and ranges may descend", "[io][decks]") {
  const MeshFile file = MeshFile::read(
      file_with("sets.inp", kSquare + "*ELEMENT, TYPE=S4, ELSET=A\n1, 1, 2, 3, 4\n"
                                      "*NSET, NSET=CORNER.1\n3,\n*NSET, NSET=ALL2\nCORNER.1, 4\n"
                                      "*NSET, NSET=DOWN, GENERATE\n4, 1, -2\n"
                                      "*NSET, NSET=PART\nP-1.2, P-1.CORNER.1\n"
                                      "*EQUATION, REMOVE\nALL2, 1\n"));
  CHECK(set_of(file, "ALL2") == std::vector<int>{2, 3});
  CHECK(set_of(file, "PART") == std::vector<int>{1, 2});
  CHECK(set_of(file, "DOWN") == std::vector<int>{1, 3});
}

TEST_CASE("element lines of Abaqus may be broken anywhere", "[io][decks]") {
  for (const std::string element :
       {"1, 1, 2, 3, 4", "1, 1, 2, 3,\n4", "1,\n1, 2,\n3, 4", "1, 1, 2,\n3, 4,", "1, 1\n2, 3\n4"}) {
    INFO(element);
    const MeshFile file = MeshFile::read(
        file_with("broken.inp", kSquare + "*ELEMENT, TYPE=S4, ELSET=A\n" + element + "\n"));
    REQUIRE(file.shells().face_count() == 1);
    const auto face = file.shells().face(0);
    CHECK(std::vector<int>(face.begin(), face.end()) == std::vector<int>{0, 1, 2, 3});
  }
}

TEST_CASE("plane, axisymmetric, thermal and nine-node elements of Abaqus are faces",
          "[io][decks]") {
  for (const char* type : {"CPE4", "CPE4RH", "CPS4", "CAX4", "CAX4RT", "CGAX4", "CPEG4", "DC2D4",
                           "DCAX4", "DS4", "M3D4", "S4RSW", "AC2D4"}) {
    INFO(type);
    const MeshFile file = MeshFile::read(
        file_with("plane.inp", kSquare + "*ELEMENT, TYPE=" + type + ", ELSET=A\n1, 1, 2, 3, 4\n"));
    CHECK(file.shells().face_count() == 1);
  }
  const std::string nine = kSquare +
                           "5, .5, 0., 0.\n6, 1., .5, 0.\n7, .5, 1., 0.\n8, 0., .5, 0.\n"
                           "9, .5, .5, 0.\n*ELEMENT, TYPE=S9R5\n1, 1, 2, 3, 4, 5, 6, 7, 8, 9\n";
  const MeshFile file = MeshFile::read(file_with("nine.inp", nine));
  REQUIRE(file.shells().face_count() == 1);
  CHECK(file.shells().second_order(0));
  // The node in the middle follows the others.
  REQUIRE(file.other_elements().size() == 1);
  CHECK(file.other_elements()[0].nodes[0] == 8);
}

TEST_CASE("a quad with a straight corner is split along its other diagonal", "[io][decks]") {
  for (const std::string off : {"0.", "1e-13", "-1e-13", "1e-9", "-1e-6", "1e-3"}) {
    INFO(off);
    const MeshFile file =
        MeshFile::read(file_with("straight.inp", "*NODE\n1, 0., 0., 0.\n2, 50., " + off +
                                                     ", 0.\n3, 100., 0., 0.\n4, 100., 100., 0.\n"
                                                     "*ELEMENT, TYPE=S4\n1, 1, 2, 3, 4\n"));
    const PreparedMesh prepared = prepare(file.shells());
    REQUIRE(prepared.mesh.triangle_count() == 2);
    for (int t = 0; t < 2; ++t) CHECK(prepared.mesh.area_vector(t).norm() / 2 > 2000);
  }
}

TEST_CASE("cells of VTK are read by VTK's tables, also in legacy files", "[io][vtk]") {
  // A biquadratic quad, a strip, a quad and a hexahedron.
  std::string points =
      "0 0 0 1 0 0 1 1 0 0 1 0 .5 0 0 1 .5 0 .5 1 0 0 .5 0 .5 .5 .1\n"
      "2 0 0 2 1 0 3 0 0 3 1 0\n0 0 1 1 0 1 1 1 1 0 1 1\n";
  const std::string text =
      "# vtk DataFile Version 3.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 17 double\n" +
      points +
      "CELLS 4 29\n9 0 1 2 3 4 5 6 7 8\n4 9 10 11 12\n4 1 9 10 2\n8 0 1 2 3 13 14 15 16\n"
      "CELL_TYPES 4\n28\n6\n9\n12\n";
  const MeshFile file = MeshFile::read(file_with("cells.vtk", text));
  REQUIRE(file.shells().face_count() == 4);  // the strip has two triangles
  CHECK(file.shells().second_order(0));
  CHECK(file.shells().face(0).size() == 8);
  REQUIRE(file.other_elements().size() == 2);
  CHECK(file.other_elements()[0].nodes[0] == 8);
  CHECK(file.other_elements()[1].kind == NonShellElement::Kind::Solid);
  const auto to = mesh_scratch() / "cells-moved.vtk";
  file.write(to, file.shells().points);
  CHECK(bytes_of(to) == text);
  Points moved = file.shells().points;
  moved.col(2).array() += 0.5;
  file.write(to, moved);
  const MeshFile again = MeshFile::read(to);
  CHECK((again.shells().points - moved).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(again.shells().face_count() == 4);
  CHECK(bytes_of(to).find("a title") != std::string::npos);
}
