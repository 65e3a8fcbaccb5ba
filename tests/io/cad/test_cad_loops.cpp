// SPDX-License-Identifier: MPL-2.0
// The boundary curves of faces of CAD files, and creases inside faces.

#include <BRepBuilderAPI_MakeFace.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>

#include <cmath>
#include <numbers>

#include "batten/io/lines/cad_lines.h"
#include "batten/tests/io/cad/cad_files.h"

using namespace batten_test;

namespace {

/// Two flat strips that meet at an angle of `degrees` along y = x = 0 …, as one surface of degree 2
/// in u with a double knot.
TopoDS_Shape folded(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  TColgp_Array2OfPnt poles(1, 5, 1, 2);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 2; ++j) {
      const double s = 5.0 * (i - 2);
      const double x = s < 0 ? s : s * std::cos(angle), z = s < 0 ? 0 : s * std::sin(angle);
      poles(i + 1, j + 1) = gp_Pnt(x, 30.0 * j, z);
    }
  TColStd_Array1OfReal u(1, 3), v(1, 2);
  TColStd_Array1OfInteger in_u(1, 3), in_v(1, 2);
  for (int k = 0; k < 3; ++k) u(k + 1) = k;
  in_u(1) = in_u(3) = 3;
  in_u(2) = 2;
  v(1) = 0;
  v(2) = 1;
  in_v(1) = in_v(2) = 2;
  return BRepBuilderAPI_MakeFace(new Geom_BSplineSurface(poles, u, v, in_u, in_v, 2, 1), 1e-7)
      .Shape();
}

fs::path file_of(const std::string& name, const TopoDS_Shape& shape) {
  return written(scratch("loops") / (name + ".step"), painted(name, shape));
}

}  // namespace

TEST_CASE("the loops of a block are the edges of its faces, which meet at right angles",
          "[io][cad]") {
  const fs::path file = file_of("block", BRepPrimAPI_MakeBox(10, 20, 30).Shape());
  const CadFaceTopology found = read_cad_loops(file, 1e-3);
  REQUIRE(found.faces.size() == 6);
  std::map<std::string, int> uses;
  for (const CadFaceBoundary& face : found.faces) {
    REQUIRE(face.loops.size() == 1);
    CHECK(face.loops[0].size() == 4);
    CHECK_FALSE(face.tube);
    for (const std::string& line : face.loops[0]) ++uses[line];
  }
  const auto lines = read_cad_lines(file, 1e-3);
  REQUIRE(uses.size() == lines.size());
  for (const auto& line : lines) CHECK(uses[line.name] == 2);
  REQUIRE(found.joins.size() == 12);
  for (const CadSharedEdge& join : found.joins) CHECK(join.angle_deg == Approx(90));
  CHECK(found.size == Approx(std::sqrt(1400)).epsilon(1e-3));
  CHECK(found.gap < 1e-9);
  // In metres.
  CHECK(read_cad_loops(file, 1).size == Approx(1e-3 * found.size));
}

TEST_CASE("a tube has two loops without its seam, a plate with a hole an outer and an inner one",
          "[io][cad]") {
  const auto tube = read_cad_loops(file_of("tube", BRepPrimAPI_MakeCylinder(4, 25).Shape()), 1e-3);
  REQUIRE(tube.faces.size() == 3);
  int rings = 0;
  for (const CadFaceBoundary& face : tube.faces) {
    rings += face.tube;
    CHECK(face.loops.size() == (face.tube ? 2 : 1));
    for (const auto& loop : face.loops) CHECK(loop.size() == 1);
  }
  CHECK(rings == 1);
  CHECK(read_cad_lines(file_of("tube", BRepPrimAPI_MakeCylinder(4, 25).Shape()), 1e-3, true)
            .size() == 2);
  const TopoDS_Shape hole =
      BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(20, 20, -5), gp_Dir(0, 0, 1)), 6, 30).Shape();
  const auto plate = read_cad_loops(
      file_of("plate", BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(50, 40, 10).Shape(), hole).Shape()),
      1e-3);
  int holed = 0;
  for (const CadFaceBoundary& face : plate.faces)
    if (face.loops.size() == 2 && !face.tube) {
      ++holed;
      CHECK(face.loops[0].size() == 4);  // the outer one first
      CHECK(face.loops[1].size() == 1);
    }
  CHECK(holed == 2);
}

TEST_CASE("closed faces are divided into parts without seams, whose curves fit together",
          "[io][cad]") {
  const TopoDS_Shape ball = BRepPrimAPI_MakeSphere(10).Shape(),
                     bar = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-30, 0, 12), gp_Dir(1, 0, 0)), 3, 60)
                               .Shape();
  struct Part {
    std::string name;
    TopoDS_Shape shape;
    size_t faces;  // of the file
    double length;  // of the curves of the divided file
  };
  constexpr double pi = std::numbers::pi;
  const std::vector<Part> parts = {
      {"ball", ball, 1, 3 * 2 * pi * 10},                     // three great circles
      {"ring", BRepPrimAPI_MakeTorus(20, 6).Shape(), 1, 2 * pi * (26 + 14 + 6 + 6)},
      {"cone", BRepPrimAPI_MakeCone(8, 0, 6).Shape(), 2, 2 * pi * 8 + 4 * 10},
      {"cap", BRepAlgoAPI_Cut(ball, BRepPrimAPI_MakeBox(gp_Pnt(-20, -20, -20), 40, 40, 20).Shape())
                  .Shape(), 2, 2 * pi * 10 + 4 * pi * 10 / 2},
      {"crossed", BRepAlgoAPI_Cut(BRepPrimAPI_MakeCylinder(10, 25).Shape(), bar).Shape(), 4, 0}};
  for (const Part& part : parts) {
    INFO(part.name);
    const fs::path file = file_of(part.name, part.shape);
    const CadFaceTopology found = read_cad_loops(file, 1e-3);
    const auto lines = read_cad_lines(file, 1e-3, true);
    std::map<std::string, int> uses;
    std::set<std::string> whole;
    for (const CadFaceBoundary& face : found.faces) {
      whole.insert(face.name.substr(0, face.name.find('.')));
      std::set<std::string> own;
      REQUIRE(face.loops.size() >= 1);
      for (const auto& loop : face.loops)
        for (const std::string& line : loop) {
          CHECK(own.insert(line).second);  // no part has a curve on both sides
          ++uses[line];
        }
    }
    CHECK(whole.size() == part.faces);
    CHECK(found.faces.size() > part.faces);
    double length = 0;
    for (const auto& line : lines) {
      CHECK(uses[line.name] == 2);  // the shells are closed
      constexpr int steps = 400;
      const double start = line.curve->start(), step = (line.curve->end() - start) / steps;
      for (int i = 0; i < steps; ++i)
        length += (line.curve->evaluate(start + (i + 1) * step, 0) -
                   line.curve->evaluate(start + i * step, 0))
                      .norm();
    }
    CHECK(uses.size() == lines.size());
    if (part.length > 0) CHECK(length == Approx(part.length).epsilon(1e-4));
    // Divisions are inside smooth faces.
    for (const CadSharedEdge& join : found.joins)
      if (join.line.starts_with("division")) CHECK(join.angle_deg < 1e-4);
  }
}

TEST_CASE("a crease inside a face is a curve, with the angle between the two sides", "[io][cad]") {
  const fs::path file = file_of("fold", folded(40));
  CHECK(read_cad_lines(file, 1e-3).size() == 4);
  const auto lines = read_cad_lines(file, 1e-3, true);
  CHECK(lines.size() == 7);  // two edges are split, plus the crease
  const CadFaceTopology found = read_cad_loops(file, 1e-3);
  REQUIRE(found.faces.size() == 2);
  for (const CadFaceBoundary& face : found.faces) {
    REQUIRE(face.loops.size() == 1);
    CHECK(face.loops[0].size() == 4);
  }
  REQUIRE(found.joins.size() == 1);
  CHECK(found.joins[0].angle_deg == Approx(40).epsilon(1e-6));
  int creases = 0;
  for (const auto& line : lines)
    if (line.name == found.joins[0].line) {
      ++creases;
      for (const double t : {line.curve->start(), line.curve->end()}) {
        CHECK(std::abs(line.curve->evaluate(t).x()) < 1e-9);
        CHECK(std::abs(line.curve->evaluate(t).z()) < 1e-9);
      }
    }
  CHECK(creases == 1);
}
