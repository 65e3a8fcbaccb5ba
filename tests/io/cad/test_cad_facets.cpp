// SPDX-License-Identifier: MPL-2.0
// Triangles of CAD faces: closed if the shape is closed, within the stated distance, grouped by
// name.
#include "batten/io/cad/cad_convert.h"

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <IGESControl_Writer.hxx>
#include <TopExp_Explorer.hxx>
#include <gp_Pln.hxx>

#include <cmath>
#include <map>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/tests/io/cad/cad_files.h"
#include "batten/tests/support/error_message.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

double volume_of(const ShellMesh& mesh) {
  double six = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const auto n = mesh.face(f);
    const Vec3 a = mesh.points.row(n[0]), b = mesh.points.row(n[1]), c = mesh.points.row(n[2]);
    six += a.dot(b.cross(c));
  }
  return six / 6;
}

/// Number of triangles per directed edge: one in a closed mesh.
void check_closed(const CadFacets& facets) {
  CHECK(facets.free_edges == 0);
  CHECK(facets.cracks == 0);
  CHECK(facets.unmeshed == 0);
  std::map<std::pair<int, int>, int> uses;
  for (int f = 0; f < facets.mesh.face_count(); ++f) {
    const auto n = facets.mesh.face(f);
    for (size_t k = 0; k < 3; ++k) ++uses[{n[k], n[(k + 1) % 3]}];
  }
  int wrong = 0;
  for (const auto& [edge, count] : uses)
    wrong += count != 1 || uses.count({edge.second, edge.first}) != 1;
  CHECK(wrong == 0);
}

TopoDS_Shape filleted_block() {
  const TopoDS_Shape block = BRepPrimAPI_MakeBox(40, 30, 20).Shape();
  BRepFilletAPI_MakeFillet fillet(block);
  for (TopExp_Explorer e(block, TopAbs_EDGE); e.More(); e.Next())
    fillet.Add(3, TopoDS::Edge(e.Current()));
  return fillet.Shape();
}

/// Trimmed surfaces without shared edges.
fs::path unsewn(const fs::path& file, const TopoDS_Shape& shape) {
  OccSettings occ;
  IGESControl_Writer writer("MM", 0);
  REQUIRE(writer.AddShape(shape));
  writer.ComputeModel();
  REQUIRE(writer.Write(file.string().c_str()));
  return file;
}

}  // namespace

TEST_CASE("triangles of closed solids have no free edge and the solid's volume", "[io][cad]") {
  const fs::path folder = scratch("facets_closed");
  const std::pair<const char*, TopoDS_Shape> solids[] = {
      {"block", drilled_block()},
      {"sphere", BRepPrimAPI_MakeSphere(10).Shape()},  // a seam and two poles
      {"cone", BRepPrimAPI_MakeCone(8, 0, 20).Shape()},
      {"torus", BRepPrimAPI_MakeTorus(20, 6).Shape()},
      {"filleted", filleted_block()},
      {"fused",
       BRepAlgoAPI_Fuse(BRepPrimAPI_MakeSphere(10).Shape(), BRepPrimAPI_MakeCylinder(4, 25).Shape())
           .Shape()}};
  for (const auto& [name, shape] : solids)
    for (const std::string ending : {".step", ".iges"}) {
      const fs::path file = folder / (name + ending);
      INFO(file);
      ending == ".step" ? written(file, painted(name, shape)) : unsewn(file, shape);
      const CadFacets facets = tessellate_cad(file);
      check_closed(facets);
      CHECK(facets.chord == Approx(1e-3 * facets.size));
      CHECK(facets.deviation <= facets.chord);
      CHECK(facets.deviation > 0.01 * facets.chord);
      const CadContents c = read_cad_contents(folder / (std::string(name) + ".step"));
      CHECK(std::abs(volume_of(facets.mesh) - c.volume) < c.area * facets.chord);
    }
}

TEST_CASE("the reported deviation is that of the sphere, and follows the chord", "[io][cad]") {
  const fs::path folder = scratch("facets_sphere");
  const fs::path file =
      written(folder / "a.step", painted("ball", BRepPrimAPI_MakeSphere(10).Shape()));
  double last = 1;
  for (const double chord : {0.3, 0.1, 0.03}) {
    CadFacetOptions options;
    options.chord = chord;
    const CadFacets facets = tessellate_cad(file, options);
    double largest = 0;  // of many points of each triangle
    for (int f = 0; f < facets.mesh.face_count(); ++f) {
      const auto n = facets.mesh.face(f);
      const Vec3 a = facets.mesh.points.row(n[0]), b = facets.mesh.points.row(n[1]),
                 c = facets.mesh.points.row(n[2]);
      for (int i = 0; i <= 12; ++i)
        for (int j = 0; i + j <= 12; ++j)
          largest =
              std::max(largest, std::abs(10 - ((i * a + j * b + (12 - i - j) * c) / 12).norm()));
    }
    INFO(chord);
    CHECK(facets.deviation <= chord);
    CHECK(facets.deviation <= largest * (1 + 1e-9));
    CHECK(facets.deviation > 0.8 * largest);
    CHECK(facets.deviation < last);
    last = facets.deviation;
  }
}

TEST_CASE("groups of triangles lie on the faces whose names they have", "[io][cad]") {
  const fs::path folder = scratch("facets_groups");
  CadPart part = painted("block", BRepPrimAPI_MakeBox(40, 30, 20).Shape());
  for (CadFace& face : part.faces) face.name.clear();
  part.faces[0].name = "left";  // OpenCASCADE's box starts with x = 0
  const CadFacets facets = tessellate_cad(written(folder / "a.step", part));
  int all = 0;
  for (const FacetGroup& group : facets.groups) {
    all += static_cast<int>(group.triangles.size());
    double off = 0;
    for (const int t : group.triangles)
      for (const int n : facets.mesh.face(t)) off = std::max(off, facets.mesh.points(n, 0));
    INFO(group.name);
    CHECK((group.name == "left" || group.name == "block"));
    CHECK((group.name == "left") == (off < 1e-9));
  }
  CHECK(all == facets.mesh.face_count());
}

TEST_CASE("an open shell has free edges only at its boundary, and separate faces are not joined",
          "[io][cad]") {
  const fs::path folder = scratch("facets_open");
  TopoDS_Compound two;  // one face is half the wall of a pipe, another one a distant plane
  BRep_Builder builder;
  builder.MakeCompound(two);
  builder.Add(two, BRepPrimAPI_MakeCylinder(10, 20).Face());
  builder.Add(
      two, BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(100, 0, 0), gp_Dir(0, 0, 1)), 0, 5, 0, 5).Face());
  const CadFacets facets = tessellate_cad(written(folder / "a.step", painted("two", two)));
  CHECK(facets.cracks == 0);
  CHECK(facets.free_edges > 20);
  CHECK(facets.unmeshed == 0);
}

TEST_CASE("instances of an assembly are meshed at their positions, in the requested unit",
          "[io][cad]") {
  const fs::path folder = scratch("facets_places");
  const CadPart part = painted("block", drilled_block());
  const auto document = document_of({part});
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  TDF_LabelSequence free;
  shapes->GetFreeShapes(free);
  const TDF_Label block = free.First(), pair = shapes->NewShape();
  gp_Trsf far, mirrored;
  far.SetTranslation(gp_Vec(1000, 0, 0));
  shapes->AddComponent(pair, block, TopLoc_Location());
  shapes->AddComponent(pair, block, TopLoc_Location(far));
  shapes->UpdateAssemblies();
  const fs::path file = written(folder / "a.step", document, XCAFDoc_ShapeTool::GetShape(pair));
  CadFacetOptions metres;
  metres.unit_in_metres = 1;
  const CadFacets facets = tessellate_cad(file, metres);
  check_closed(facets);
  CHECK(facets.mesh.points.col(0).maxCoeff() == Approx(1.04));
  CHECK(facets.mesh.points.col(0).minCoeff() == Approx(0).margin(1e-12));
  CHECK(volume_of(facets.mesh) == Approx(2e-9 * (24000 - std::numbers::pi * 500)).epsilon(0.01));
}

TEST_CASE("glTF has a mesh for each product, its colours, metres, and no cracks", "[io][cad]") {
  const fs::path folder = scratch("facets_glb");
  for (const std::string ending : {".step", ".iges"}) {
    const fs::path file = folder / ("a" + ending);
    INFO(ending);
    ending == ".step" ? written(file, painted("block", drilled_block()))
                      : unsewn(file, drilled_block());
    const CadConversion c = convert_cad(file, folder / "a.glb");
    CHECK(c.cracks == 0);
    CHECK(c.deviation <= c.chord);
    std::ostringstream bytes;
    bytes << std::ifstream(folder / "a.glb", std::ios::binary).rdbuf();
    const std::string text = bytes.str();
    const auto uint32_at = [&](size_t at) {
      std::uint32_t value;
      std::memcpy(&value, text.data() + at, 4);
      return value;
    };
    REQUIRE(text.size() > 20);
    REQUIRE(text.substr(0, 4) == "glTF");
    const auto json = nlohmann::json::parse(text.substr(20, uint32_at(12)));
    const size_t binary = 20 + uint32_at(12) + 8;
    if (ending == ".step") {
      CHECK(json["meshes"][0]["name"] == "block");
      CHECK(json["materials"].size() == 2);  // red and green
    }
    std::map<std::array<float, 3>, int> nodes;
    std::map<std::pair<int, int>, int> uses;
    for (const auto& mesh : json["meshes"])
      for (const auto& primitive : mesh["primitives"]) {
        const auto at = [&](const nlohmann::json& accessor) {
          const auto& view = json["bufferViews"][accessor["bufferView"].get<size_t>()];
          return binary + view.value("byteOffset", size_t{0}) +
                 accessor.value("byteOffset", size_t{0});
        };
        const auto& points = json["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
        const auto& indices = json["accessors"][primitive["indices"].get<size_t>()];
        std::vector<int> number;
        for (size_t i = 0; i < points["count"]; ++i) {
          std::array<float, 3> p;
          std::memcpy(p.data(), text.data() + at(points) + 12 * i, 12);
          for (float& x : p) x = std::round(x * 1e8f) / 1e8f;  // 0 is 1e-18 on one side
          number.push_back(nodes.try_emplace(p, static_cast<int>(nodes.size())).first->second);
        }
        const size_t width = indices["componentType"] == 5123 ? 2 : 4;
        std::vector<int> corners;
        for (size_t i = 0; i < indices["count"]; ++i) {
          std::uint32_t index = 0;
          std::memcpy(&index, text.data() + at(indices) + width * i, width);
          corners.push_back(number.at(index));
        }
        for (size_t t = 0; t < corners.size(); ++t) {
          const int a = corners[t], b = corners[t % 3 == 2 ? t - 2 : t + 1];
          ++uses[{std::min(a, b), std::max(a, b)}];
        }
      }
    int free = 0;
    for (const auto& [edge, count] : uses) free += count != 2;
    CHECK(free == 0);
    float highest = 0;  // metres, y up: the block is 20 mm high along z
    for (const auto& [p, n] : nodes) highest = std::max(highest, p[1]);
    CHECK(highest == Approx(0.02));
    CHECK(std::distance(fs::directory_iterator(folder), fs::directory_iterator()) ==
          (ending == ".step" ? 2 : 3));  // no temporary files remain
  }
}

TEST_CASE("a chord that is no length, or far too small, is refused", "[io][cad]") {
  const fs::path folder = scratch("facets_refused");
  const fs::path file = written(folder / "a.step", painted("block", drilled_block()));
  CadFacetOptions options;
  options.chord = 1e-9;
  CHECK_THAT(error_message([&] { tessellate_cad(file, options); }),
             Contains("expected 1e-7 of the size"));
  options.chord = std::nan("");
  CHECK_THAT(error_message([&] { tessellate_cad(file, options); }), Contains("chord"));
}

TEST_CASE("curved triangles keep a chord with fewer, and bulge as the face does", "[io][cad]") {
  const fs::path folder = scratch("facets_curved");
  const fs::path file =
      written(folder / "a.step", painted("tube", BRepPrimAPI_MakeTorus(20, 6).Shape()));
  CadFacetOptions options;
  options.chord = 2e-3;
  const CadFacets flat = tessellate_cad(file, options);
  options.curved = true;
  const CadFacets curved = tessellate_cad(file, options);
  CHECK(flat.normals.empty());
  REQUIRE(isize(curved.normals) == curved.mesh.face_count());
  REQUIRE(isize(curved.faces) == curved.mesh.face_count());
  CHECK(curved.mesh.face_count() < flat.mesh.face_count() / 2);
  CHECK(curved.deviation <= options.chord);
  double off = 0, flat_off = 0;
  const auto distance = [](const Vec3& p) {
    return std::abs(Vec2(p.head<2>().norm() - 20, p.z()).norm() - 6);
  };
  for (int f = 0; f < curved.mesh.face_count(); ++f) {
    PnTriangle::Corners p;
    for (size_t c = 0; c < 3; ++c) p[c] = curved.mesh.points.row(curved.mesh.face(f)[c]);
    const PnTriangle triangle(p, curved.normals[f]);
    for (const Vec3& w :
         {Vec3(1, 1, 1), Vec3(1, 1, 0), Vec3(0, 1, 1), Vec3(1, 0, 1), Vec3(3, 1, 1)}) {
      off = std::max(off, distance(triangle.at(w / w.sum())));
      flat_off = std::max(flat_off, distance((w[0] * p[0] + w[1] * p[1] + w[2] * p[2]) / w.sum()));
    }
  }
  CHECK(off <= options.chord);
  CHECK(flat_off > 3 * options.chord);
}
