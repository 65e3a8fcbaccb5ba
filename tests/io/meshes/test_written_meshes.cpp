// SPDX-License-Identifier: MPL-2.0
// Meshes written for other programs: parts, colours, units and normals as these read them.
#include <Model/COM/NMR_DLLInterfaces.h>
#include <vtkActor.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkDataArray.h>
#include <vtkGLTFReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/io/meshes/mesh_file_properties.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// A block of 1 × 2 × 3 as quads; face 4 is at z = 3.
ShellMesh block() {
  ShellMesh mesh;
  mesh.points.resize(8, 3);
  for (int i = 0; i < 8; ++i) mesh.points.row(i) << (i & 1), (i & 2), (i & 4 ? 3 : 0);
  for (const std::array<int, 4>& f : std::vector<std::array<int, 4>>{
           {0, 2, 3, 1}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {4, 5, 7, 6}, {1, 3, 7, 5}})
    mesh.add_face(f);
  return mesh;
}

/// Two sets, one of them without a colour; face 5 is in none.
std::vector<MeshSet> sets() {
  return {{"sides", "", {}, {0, 1, 2, 3}, "#ff8000"}, {"the lid", "", {}, {4}, ""}};
}

nlohmann::json json_of_glb(const fs::path& file) {
  const std::string bytes = bytes_of(file);
  const auto number = [&](size_t at) {
    return static_cast<unsigned char>(bytes[at]) +
           256u * static_cast<unsigned char>(bytes[at + 1]) +
           65536u * static_cast<unsigned char>(bytes[at + 2]);
  };
  CHECK(bytes.substr(0, 4) == "glTF");
  CHECK(number(8) == bytes.size());
  return nlohmann::json::parse(bytes.substr(20, number(12)));
}

/// A sphere's points, as triangles of n × n cells.
ShellMesh ball(int n) {
  ShellMesh mesh;
  mesh.points.resize((n - 1) * n + 2, 3);
  const double pi = std::acos(-1.0);
  for (int j = 1; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double u = 2 * pi * i / n, v = pi * j / n;
      mesh.points.row((j - 1) * n + i) << std::sin(v) * std::cos(u), std::sin(v) * std::sin(u),
          -std::cos(v);
    }
  const int south = (n - 1) * n, north = south + 1;
  mesh.points.row(south) << 0, 0, -1;
  mesh.points.row(north) << 0, 0, 1;
  const auto at = [&](int i, int j) { return (j - 1) * n + i % n; };
  for (int i = 0; i < n; ++i) {
    mesh.add_face(std::array{south, at(i + 1, 1), at(i, 1)});
    mesh.add_face(std::array{north, at(i, n - 1), at(i + 1, n - 1)});
    for (int j = 1; j + 1 < n; ++j) {
      mesh.add_face(std::array{at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.add_face(std::array{at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("a mesh as GLB is a named mesh for each set, in metres, y up", "[io][meshes]") {
  const fs::path file = scratch("written_glb") / "block.glb";
  CHECK(write_mesh(file, block(), sets(), 0.01).empty());
  const auto json = json_of_glb(file);
  REQUIRE(json["meshes"].size() == 3);
  CHECK(json["meshes"][0]["name"] == "sides");
  CHECK(json["nodes"][1]["name"] == "the lid");
  CHECK_FALSE(json["meshes"][2].contains("name"));
  REQUIRE(json["materials"].size() == 1);
  CHECK(json["meshes"][0]["primitives"][0]["material"] == 0);
  CHECK_FALSE(json["meshes"][1]["primitives"][0].contains("material"));
  const auto colour = json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
  CHECK(colour[0] == 1.0);
  CHECK(colour[1].get<double>() == Approx(std::pow((128 / 255.0 + 0.055) / 1.055, 2.4)));
  CHECK(colour[2] == 0.0);

  vtkNew<vtkGLTFReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  double box[6] = {9, -9, 9, -9, 9, -9};
  long triangles = 0, parts = 0;
  const auto iterator = vtk::TakeSmartPointer(reader->GetOutput()->NewIterator());
  for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem()) {
    auto* part = vtkPolyData::SafeDownCast(iterator->GetCurrentDataObject());
    REQUIRE(part);
    ++parts;
    triangles += part->GetNumberOfPolys();
    const double* of = part->GetBounds();
    for (int c = 0; c < 3; ++c) {
      box[2 * c] = std::min(box[2 * c], of[2 * c]);
      box[2 * c + 1] = std::max(box[2 * c + 1], of[2 * c + 1]);
    }
    REQUIRE(part->GetPointData()->GetNormals());
  }
  CHECK(parts == 3);
  CHECK(triangles == 12);
  // x, y, z of 1 × 2 × 3 cm are x, -z, y in metres.
  const double expected[6] = {0, 0.01, 0, 0.03, -0.02, 0};
  for (int c = 0; c < 6; ++c) CHECK(box[c] == Approx(expected[c]).margin(1e-9));
}

TEST_CASE("normals of GLB are those of a ball, and break at the edges of a block", "[io][meshes]") {
  const fs::path folder = scratch("written_normals");
  const auto normals = [&](const ShellMesh& mesh, const std::string& name) {
    write_mesh(folder / name, mesh, {}, 1);
    vtkNew<vtkGLTFReader> reader;
    reader->SetFileName((folder / name).c_str());
    reader->Update();
    const auto iterator = vtk::TakeSmartPointer(reader->GetOutput()->NewIterator());
    iterator->InitTraversal();
    vtkSmartPointer<vtkPolyData> part = vtkPolyData::SafeDownCast(iterator->GetCurrentDataObject());
    return part;
  };
  const auto round = normals(ball(48), "ball.glb");
  CHECK(round->GetNumberOfPoints() == ball(48).node_count());
  double worst = 0;
  for (vtkIdType p = 0; p < round->GetNumberOfPoints(); ++p) {
    const Vec3 x(round->GetPoint(p)), n(round->GetPointData()->GetNormals()->GetTuple(p));
    worst = std::max(worst, (n - x).norm());
  }
  CHECK(worst < 0.01);
  const auto flat = normals(block(), "block.glb");
  CHECK(flat->GetNumberOfPoints() == 24);
  for (vtkIdType p = 0; p < 24; ++p) {
    const Vec3 n(flat->GetPointData()->GetNormals()->GetTuple(p));
    CHECK(n.cwiseAbs().maxCoeff() == 1);
  }
}

TEST_CASE("colours of sets are materials of OBJ, in a file beside it", "[io][meshes]") {
  const fs::path folder = scratch("written_obj");
  const fs::path file = folder / "a block.obj";
  const auto beside = write_mesh(file, block(), sets());
  REQUIRE(beside == std::vector<fs::path>{folder / "a_block.mtl"});
  CHECK_THAT(bytes_of(beside[0]), Contains("newmtl ff8000\nKd 1 "));
  const std::string text = bytes_of(file);
  CHECK_THAT(text, Contains("mtllib a_block.mtl\n") && Contains("g sides\nusemtl ff8000\nf ") &&
                       Contains("g the_lid\nusemtl none\nf "));
  const MeshFile back = MeshFile::read(file);
  CHECK(back.shells().points == block().points);
  REQUIRE(back.properties().size() == 2);
  CHECK(back.properties()[0].colour == "#ff8000");
  CHECK(back.properties()[0].faces == std::vector<int>{0, 1, 2, 3});
  // Missing or damaged materials lose only the colours.
  std::ofstream(beside[0]) << "newmtl ff8000\nKd one two\n";
  CHECK(MeshFile::read(file).properties()[0].colour.empty());
  fs::remove(beside[0]);
  CHECK(MeshFile::read(file).shells().face_count() == 6);
  // Without any colour there is one file.
  CHECK(write_mesh(folder / "plain.obj", block(), {{"sides", "", {}, {0}}}).empty());
  CHECK_FALSE(fs::exists(folder / "plain.mtl"));
}

TEST_CASE("where one of two files cannot be written there is none, and old ones stay",
          "[io][meshes]") {
  const fs::path folder = scratch("written_both");
  fs::create_directories(folder / "b.mtl");  // the name is that of a folder
  std::ofstream(folder / "b.obj") << "old";
  CHECK_THAT(error_message([&] { write_mesh(folder / "b.obj", block(), sets()); }),
             Contains("b.mtl"));
  CHECK(bytes_of(folder / "b.obj") == "old");
  CHECK(std::distance(fs::directory_iterator(folder), fs::directory_iterator()) == 2);
  std::vector<MeshSet> wrong = sets();
  wrong[0].colour = "red";
  for (const char* name : {"c.obj", "c.ply", "c.glb", "c.3mf"}) {
    CHECK_THAT(error_message([&] { write_mesh(folder / name, block(), wrong, 1); }),
               Contains("the colour 'red'"));
    CHECK_FALSE(fs::exists(folder / name));
  }
}

TEST_CASE("PLY holds the colours of faces, and is read as before", "[io][meshes]") {
  const fs::path file = scratch("written_ply") / "block.ply";
  write_mesh(file, block(), sets());
  CHECK(MeshFile::read(file).shells().points == block().points);
  CHECK(MeshFile::read(file).shells().face_count() == 6);
  vtkNew<vtkPLYReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  CHECK(reader->GetOutput()->GetNumberOfPolys() == 6);
  auto* colours = reader->GetOutput()->GetCellData()->GetArray("RGB");
  REQUIRE(colours);
  const std::array<std::array<double, 3>, 2> expected{{{255, 128, 0}, {204, 204, 204}}};
  for (int f = 0; f < 6; ++f)
    for (int c = 0; c < 3; ++c) CHECK(colours->GetComponent(f, c) == expected[f >= 4][c]);
}

TEST_CASE("3MF holds one closed object in millimetres, with materials", "[io][meshes]") {
  const fs::path folder = scratch("written_3mf");
  write_mesh(folder / "a.3mf", block(), sets(), 0.0254);
  write_mesh(folder / "b.3mf", block(), sets(), 0.0254);
  CHECK(bytes_of(folder / "a.3mf") == bytes_of(folder / "b.3mf"));
  using namespace NMR;
  PLib3MFModel* model = nullptr;
  PLib3MFModelReader* reader = nullptr;
  REQUIRE(lib3mf_createmodel(&model) == 0);
  REQUIRE(lib3mf_model_queryreader(model, "3mf", &reader) == 0);
  REQUIRE(lib3mf_reader_readfromfileutf8(reader, (folder / "a.3mf").c_str()) == 0);
  DWORD warnings = 9, unit = 9, vertices = 0, triangles = 0;
  lib3mf_reader_getwarningcount(reader, &warnings);
  CHECK(warnings == 0);
  lib3mf_model_getunit(model, &unit);
  CHECK(unit == MODELUNIT_MILLIMETER);
  PLib3MFModelResourceIterator* objects = nullptr;
  lib3mf_model_getmeshobjects(model, &objects);
  BOOL more = false, closed = false;
  lib3mf_resourceiterator_movenext(objects, &more);
  REQUIRE(more);
  PLib3MFModelResource* object = nullptr;
  lib3mf_resourceiterator_getcurrent(objects, &object);
  lib3mf_meshobject_getvertexcount(object, &vertices);
  lib3mf_meshobject_gettrianglecount(object, &triangles);
  lib3mf_meshobject_ismanifoldandoriented(object, &closed);
  CHECK(vertices == 8);
  CHECK(triangles == 12);
  CHECK(closed);
  MODELMESHVERTEX corner;
  lib3mf_meshobject_getvertex(object, 7, &corner);
  CHECK(corner.m_fPosition[2] == Approx(3 * 25.4));
  PLib3MFPropertyHandler* handler = nullptr;
  REQUIRE(lib3mf_meshobject_createpropertyhandler(object, &handler) == 0);
  DWORD group = 0, index = 9;
  lib3mf_propertyhandler_getbasematerial(handler, 9, &group, &index);
  CHECK(index == 1);  // the lid
  PLib3MFModelBaseMaterial* materials = nullptr;
  REQUIRE(lib3mf_model_getbasematerialbyid(model, group, &materials) == 0);
  char name[40] = {};
  ULONG length = 0;
  lib3mf_basematerial_getnameutf8(materials, 1, name, sizeof name, &length);
  CHECK(std::string(name) == "the lid");
  BYTE red, green, blue, alpha;
  lib3mf_basematerial_getdisplaycolor(materials, 0, &red, &green, &blue, &alpha);
  CHECK((red == 255 && green == 128 && blue == 0 && alpha == 255));
  lib3mf_resourceiterator_movenext(objects, &more);
  CHECK_FALSE(more);
  for (void** each : {materials, handler, object, objects, reader, model}) lib3mf_release(each);
}

TEST_CASE("GLB and 3MF need a unit, and report a missing one", "[io][meshes]") {
  const fs::path folder = scratch("written_units");
  for (const char* name : {"a.glb", "a.3mf"}) {
    CHECK_THAT(error_message([&] { write_mesh(folder / name, block()); }),
               Contains("expected one: files of this type state it"));
    CHECK_FALSE(fs::exists(folder / name));
  }
  ShellMesh far = block();
  far.points(3, 0) = 1e39;
  for (const char* name : {"a.glb", "a.3mf"})
    CHECK_THAT(error_message([&] { write_mesh(folder / name, far, {}, 1); }),
               Contains("node 3 is too large for single precision"));
}

TEST_CASE("new decks hold nodes, shells of four kinds, and sets", "[io][decks]") {
  ShellMesh mesh;
  mesh.points.resize(14, 3);
  for (int i = 0; i < 14; ++i) mesh.points.row(i) << i / 3.0, std::cos(i), 1e-7 * i * i;
  mesh.add_face(std::array{0, 1, 2});
  mesh.add_face(std::array{2, 3, 4, 5});
  mesh.add_face(std::array{0, 1, 2, 6, 7, 8}, true);
  mesh.add_face(std::array{2, 3, 4, 5, 10, 11, 12, 13}, true);
  mesh.add_face(std::array{0, 1, 2, 3, 4});  // three triangles
  mesh.add_face(std::array{5, 6, 6, 7});     // a triangle
  mesh.add_face(std::array{8, 9, 9});        // left out
  CHECK(is_degenerate(mesh, 6));
  CHECK_FALSE(is_degenerate(mesh, 5));
  const std::vector<MeshSet> groups{{"top skin", "", {}, {0, 4}, ""},
                                    {"top-skin", "", {}, {3}, ""},
                                    {"TOP SKIN", "", {}, {1}, ""}};
  for (const std::string name : {"new.inp", "new.bdf", "new.nas", "new.fem"}) {
    CAPTURE(name);
    const fs::path file = scratch("new_decks") / name;
    CHECK(write_mesh(file, mesh, groups).empty());
    const MeshFile read = MeshFile::read(file);
    REQUIRE(read.shells().node_count() == 14);
    // 20 or 16 characters a coordinate.
    CHECK((read.shells().points - mesh.points).cwiseAbs().maxCoeff() < 1e-12);
    std::map<size_t, int> counts;
    for (int f = 0; f < read.shells().face_count(); ++f) ++counts[read.shells().face(f).size()];
    CHECK(counts == std::map<size_t, int>{{3, 5}, {4, 1}, {6, 1}, {8, 1}});
    std::map<std::string, size_t> sizes;
    for (const MeshSet& set : name == "new.inp" ? read.sets() : read.properties())
      sizes[set.name] = set.faces.size();
    if (name == "new.inp")
      CHECK(sizes ==
            std::map<std::string, size_t>{{"TOP_SKIN", 4}, {"TOP-SKIN", 1}, {"TOP_SKIN_2", 1}});
    else
      CHECK(sizes == std::map<std::string, size_t>{{"1", 2}, {"2", 4}, {"3", 1}, {"4", 1}});
    if (name == "new.bdf" && have_python_with("gmsh"))
      for (const auto& [label, at] : positions_from(other_reader("gmsh", file)))
        CHECK((mesh.points.row(label - 1).transpose() - at).cwiseAbs().maxCoeff() < 1e-12);
  }
}
