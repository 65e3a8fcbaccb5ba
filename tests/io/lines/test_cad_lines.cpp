// SPDX-License-Identifier: MPL-2.0
// Curves and faces of CAD files: all of them, once, in the unit of the model, and none from
// incomplete files.
#include "batten/io/lines/cad_lines.h"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRep_Builder.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Writer.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <UnitsMethods.hxx>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
namespace fs = std::filesystem;

namespace {

/// Shapes in millimetres as an IGES file in the given unit. `labels`: of the entities, in order.
/// `mode` 0: trimmed surfaces, 1: boundary representation. `first_use`: use flag of the first
/// entity.
void write_iges(const fs::path& file, const std::vector<TopoDS_Shape>& shapes, const char* unit,
                const std::vector<const char*>& labels = {}, int mode = 0, int first_use = 0) {
  OccSettings occ;
  IGESControl_Writer writer(unit, mode);
  for (const TopoDS_Shape& shape : shapes) REQUIRE(writer.AddShape(shape));
  writer.ComputeModel();
  for (size_t i = 0; i < labels.size(); ++i)
    writer.Model()
        ->Entity(static_cast<int>(i) + 1)
        ->SetLabel(new TCollection_HAsciiString(labels[i]));
  if (first_use) writer.Model()->Entity(1)->InitStatus(0, 0, first_use, 0);
  REQUIRE(writer.Write(file.string().c_str()));
}

void write_step_file(const fs::path& file, const TopoDS_Shape& shape, const char* unit) {
  OccSettings occ;
  occ.set("write.step.unit", unit);
  STEPControl_Writer writer;
  REQUIRE(writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone);
  REQUIRE(writer.Write(file.string().c_str()) == IFSelect_RetDone);
}

/// A corner at t = 1 (multiplicity equal to the degree), maximal continuity at t = 2, exactly C1 at
/// t = 3.
Handle(Geom_BSplineCurve) cornered_spline(int degree, bool rational = false) {
  TColStd_Array1OfReal knots(1, 5);
  TColStd_Array1OfInteger multiplicities(1, 5);
  const int multiplicity[] = {degree + 1, degree, 1, degree - 1, degree + 1};
  int poles = -degree - 1;
  for (int k = 0; k < 5; ++k) {
    knots(k + 1) = k;
    multiplicities(k + 1) = multiplicity[k];
    poles += multiplicity[k];
  }
  TColgp_Array1OfPnt points(1, poles);
  TColStd_Array1OfReal weights(1, poles);
  for (int i = 1; i <= poles; ++i) {
    points(i) = gp_Pnt(100 * i, 300 * std::sin(1.7 * i), 50 * std::cos(i));
    weights(i) = rational ? 1 + 0.3 * (i % 2) : 1;
  }
  return new Geom_BSplineCurve(points, weights, knots, multiplicities, degree);
}

Vec3 start(const CharacterLine& line) { return line.curve->evaluate(line.curve->start()); }
Vec3 end(const CharacterLine& line) { return line.curve->evaluate(line.curve->end()); }

/// Compares derivatives with finite differences of positions, away from breaks.
void expect_true_derivatives(const InputCurve& curve) {
  const auto breaks = curve.breaks();
  REQUIRE(breaks.front() == curve.start());
  REQUIRE(breaks.back() == curve.end());
  for (size_t piece = 0; piece + 1 < breaks.size(); ++piece) {
    const double length = breaks[piece + 1] - breaks[piece], h = 3e-6 * length;
    REQUIRE(length > 0);
    for (const double place : {0.13, 0.41, 0.83}) {
      const double t = breaks[piece] + place * length;
      const Vec3 first = (curve.evaluate(t + h) - curve.evaluate(t - h)) / (2 * h);
      const Vec3 second = (curve.evaluate(t + h, 1) - curve.evaluate(t - h, 1)) / (2 * h);
      const double size = curve.evaluate(t, 1).norm();
      const double rounding = 1e-15 / h;
      CHECK((first - curve.evaluate(t, 1)).norm() <=
            1e-6 * size + rounding * curve.evaluate(t).norm());
      CHECK((second - curve.evaluate(t, 2)).norm() <= 1e-5 * size / length + rounding * size);
    }
  }
}

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("Curves of a CAD file have the size that the file's unit gives them", "[io][cad]") {
  const fs::path folder = batten_test::scratch("cad");
  const TopoDS_Shape arc = BRepBuilderAPI_MakeEdge(
      GC_MakeArcOfCircle(gp_Pnt(0, 0, 0), gp_Pnt(1250, 500, 0), gp_Pnt(2500, 0, 250)).Value());
  const TopoDS_Shape line = BRepBuilderAPI_MakeEdge(gp_Pnt(2500, 0, 250), gp_Pnt(2500, 0, -250));
  for (const char* unit : {"M", "MM", "INCH"}) {
    CAPTURE(unit);
    const fs::path file = folder / "lines.igs";
    write_iges(file, {arc, line}, unit);
    const auto metres = read_cad_lines(file, 1), millimetres = read_cad_lines(file, 1e-3);
    REQUIRE(metres.size() == 2);
    REQUIRE(millimetres.size() == 2);
    CHECK((start(metres[0]) - Vec3(0, 0, 0)).norm() < 1e-9);
    CHECK((end(metres[0]) - Vec3(2.5, 0, 0.25)).norm() < 1e-9);
    CHECK((end(metres[1]) - Vec3(2.5, 0, -0.25)).norm() < 1e-9);
    CHECK((end(millimetres[1]) - Vec3(2500, 0, -250)).norm() < 1e-6);
    CHECK(!metres[0].curve->piecewise_cubic());
    CHECK(metres[1].curve->piecewise_cubic());
    for (const auto& l : millimetres) expect_true_derivatives(*l.curve);
  }
  write_step_file(folder / "line.stp", line, "M");
  const auto from_step = read_cad_lines(folder / "line.stp", 1);
  REQUIRE(from_step.size() == 1);
  CHECK((end(from_step[0]) - Vec3(2.5, 0, -0.25)).norm() < 1e-9);
}

TEST_CASE("A spline's breaks are its corners, and all its knots when it is cubic", "[io][cad]") {
  const fs::path file = batten_test::scratch("cad") / "spline.iges";
  const struct {
    int degree;
    bool rational, cubic;
    std::vector<double> breaks;
  } cases[] = {{3, false, true, {0, 1, 2, 3, 4}},
               {2, false, true, {0, 1, 2, 3, 4}},
               {3, true, false, {0, 1, 4}},
               {5, false, false, {0, 1, 4}}};
  for (const auto& c : cases) {
    CAPTURE(c.degree, c.rational);
    const auto spline = cornered_spline(c.degree, c.rational);
    write_iges(file, {BRepBuilderAPI_MakeEdge(spline)}, "MM");
    const auto lines = read_cad_lines(file, 1e-3);
    REQUIRE(lines.size() == 1);  // corners do not split it
    const InputCurve& curve = *lines[0].curve;
    CHECK(curve.breaks() == c.breaks);
    CHECK(curve.piecewise_cubic() == c.cubic);
    expect_true_derivatives(curve);
    // At a corner: the derivative of the following segment.
    const Vec3 after = curve.evaluate(1 + 1e-9, 1), before = curve.evaluate(1 - 1e-9, 1);
    CHECK((curve.evaluate(1, 1) - after).norm() < 1e-5 * after.norm());
    CHECK((before - after).norm() > 0.1 * after.norm());
  }
  // An edge on a part of the spline has the breaks of that part.
  write_iges(file, {BRepBuilderAPI_MakeEdge(cornered_spline(3), 0.5, 2.5)}, "MM");
  CHECK(read_cad_lines(file, 1e-3)[0].curve->breaks() == std::vector<double>{0.5, 1, 2, 2.5});
}

TEST_CASE("Every edge comes once, and curves of parameter planes never", "[io][cad]") {
  const fs::path folder = batten_test::scratch("cad");
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(gp_Pnt(100, 100, 100), 200, 300, 400).Shape();
  write_step_file(folder / "box.step", box, "MM");
  write_iges(folder / "box.igs", {box}, "MM", {}, 1);
  for (const char* name : {"box.step", "box.igs"}) {
    CAPTURE(name);
    const auto lines = read_cad_lines(folder / name, 1e-3);
    CHECK(lines.size() == 12);
    double length = 0;
    for (const auto& line : lines) length += (end(line) - start(line)).norm();
    CHECK(length == Approx(4 * (200 + 300 + 400)));
    CHECK(lines[0].name == "edge1");
    CHECK(lines[11].name == "edge12");
  }
  // Of two free curves, one is marked as lying in a parameter plane (use flag 5).
  const TopoDS_Shape inside = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 0, 0));
  const TopoDS_Shape keel = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(700, 0, 0));
  write_iges(folder / "flag.igs", {inside, keel}, "MM", {}, 0, 5);
  const auto flagged = read_cad_lines(folder / "flag.igs", 1e-3);
  REQUIRE(flagged.size() == 1);
  CHECK(end(flagged[0]).x() == Approx(700));

  // A trimmed surface (type 144) contains its pcurves: they are in [0, 1]².
  TColgp_Array2OfPnt poles(1, 3, 1, 3);
  for (int i = 1; i <= 3; ++i)
    for (int j = 1; j <= 3; ++j) poles(i, j) = gp_Pnt(100 * i, 100 * j, i == 2 && j == 2 ? 90 : 50);
  const TopoDS_Shape face = BRepBuilderAPI_MakeFace(new Geom_BezierSurface(poles), 1e-7);
  write_iges(folder / "face.igs", {face}, "MM");
  const auto lines = read_cad_lines(folder / "face.igs", 1e-3);
  CHECK(lines.size() == 4);
  for (const auto& line : lines) {
    CHECK(start(line).z() == Approx(50));
    CHECK(start(line).minCoeff() > 40);
  }
}

TEST_CASE("Curves carry the labels of the file", "[io][cad]") {
  const fs::path file = batten_test::scratch("cad") / "named.igs";
  std::vector<TopoDS_Shape> shapes;
  for (int i = 0; i < 4; ++i)
    shapes.push_back(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, i), gp_Pnt(10, 0, i)).Shape());
  write_iges(file, shapes, "MM", {"KEEL", "RIB", "RIB", ""});
  std::vector<std::string> names;
  for (const auto& line : read_cad_lines(file, 1e-3)) names.push_back(line.name);
  CHECK(names == std::vector<std::string>{"KEEL", "RIB", "RIB_2", "edge4"});
}

TEST_CASE("A truncated CAD file is refused with the line where that shows", "[io][cad]") {
  const fs::path folder = batten_test::scratch("cad");
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(1, 2, 3).Shape();
  write_iges(folder / "box.igs", {box}, "MM");
  write_step_file(folder / "box.step", box, "MM");
  const std::string iges = text_of(folder / "box.igs"), step = text_of(folder / "box.step");
  const auto refused = [&](const std::string& name, const std::string& text,
                           const std::string& message) {
    CAPTURE(name, message);
    std::ofstream(folder / name, std::ios::binary) << text;
    CHECK_THROWS_AS(read_cad_lines(folder / name, 1), InputError);
    CHECK_THROWS_WITH(read_cad_lines(folder / name, 1),
                      Catch::Contains(name) && Catch::Contains(message));
    CHECK_THROWS_AS(read_cad_surfaces(folder / name, 1), InputError);
  };
  const size_t line = iges.find('\n') + 1;  // all lines have the same length
  const size_t lines = iges.size() / line;
  const auto first_lines = [&](size_t n) { return iges.substr(0, n * line); };
  refused("a.igs", first_lines(lines - 1),
          "line " + std::to_string(lines - 1) + ": the file ends in section P");
  refused("a.igs", first_lines(8), "line 8: the file ends in section D");
  refused("a.igs", first_lines(lines / 2) + iges.substr(lines / 2 * line, 40),
          "line " + std::to_string(lines / 2 + 1) + ": the line ends before column 73");
  refused("a.igs", first_lines(lines / 2) + iges.substr((lines / 2 + 1) * line),
          "line " + std::to_string(lines / 2 + 1) + ": line number");
  refused("a.iges", "", "empty");
  refused("a.iges", "\n\n", "empty");
  refused("a.iges", "x y z\n0 0 0\n", "line 1");
  refused("a.igs", step, "line 1");
  refused("a.stp", iges, "line 1: found");
  refused("a.step", "", "empty");
  refused("a.step", step.substr(0, step.size() / 2), "truncated");
  refused("a.step", step.substr(0, step.find("DATA;")) + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n", "");
  refused("a.dxf", "0\nSECTION\n", "expected .igs, .iges, .stp, .step, .brep, .brp or .xml");
  CHECK_THROWS_WITH(read_cad_lines(folder / "none.igs", 1), Catch::Contains("no such file"));
  CHECK_THROWS_WITH(read_cad_lines(folder / "box.igs", 0), Catch::Contains("unit"));

  // Complete files without curves.
  const TopoDS_Shape point = BRepBuilderAPI_MakeVertex(gp_Pnt(1, 2, 3));
  write_iges(folder / "point.igs", {point}, "MM");
  CHECK_THROWS_WITH(read_cad_lines(folder / "point.igs", 1), Catch::Contains("no curve"));
  CHECK(read_cad_surfaces(folder / "point.igs", 1).empty());
}

TEST_CASE("The distance to a stored face is that to its nearest point, edges included",
          "[io][cad]") {
  const fs::path file = batten_test::scratch("cad") / "face.step";
  SECTION("a disc") {
    const gp_Circ circle(gp::XOY(), 500);
    const TopoDS_Edge rim = BRepBuilderAPI_MakeEdge(circle);
    const TopoDS_Wire wire = BRepBuilderAPI_MakeWire(rim);
    write_step_file(file, BRepBuilderAPI_MakeFace(wire), "MM");
    const auto faces = read_cad_surfaces(file, 1);
    REQUIRE(faces.size() == 1);
    for (const double radius : {0.0, 0.2, 0.49, 0.5, 0.7, 3.0})
      for (const double angle : {0.1, 2.0, 4.4})
        for (const double z : {0.0, 0.003, -1.0}) {
          const Vec3 p(radius * std::cos(angle), radius * std::sin(angle), z);
          CHECK(faces[0].distance(p) ==
                Approx(std::hypot(std::max(radius - 0.5, 0.0), z)).margin(1e-9));
        }
  }
  SECTION("many discs: boxes leave none out that is nearest") {
    BRep_Builder builder;
    TopoDS_Compound all;
    builder.MakeCompound(all);
    for (int k = 0; k < 12; ++k) {
      const gp_Ax2 axes(gp_Pnt(700.0 * (k % 4), 900.0 * (k / 4), 100.0 * ((5 * k) % 7)),
                        gp_Dir(0.1 * k, 0.3, 1));
      const TopoDS_Edge rim = BRepBuilderAPI_MakeEdge(gp_Circ(axes, 300 + 20 * k));
      const TopoDS_Wire wire = BRepBuilderAPI_MakeWire(rim);
      builder.Add(all, BRepBuilderAPI_MakeFace(wire).Face());
    }
    write_step_file(file, all, "MM");
    const auto faces = read_cad_surfaces(file, 1);
    REQUIRE(faces.size() == 12);
    size_t first = 0;
    for (int k = 0; k < 200; ++k) {
      const Vec3 p(0.013 * ((37 * k) % 250) - 0.5, 0.011 * ((53 * k) % 230) - 0.5,
                   0.007 * ((71 * k) % 190) - 0.4);
      double nearest = 1e300;
      for (const auto& face : faces) {
        nearest = std::min(nearest, face.distance(p));
        CHECK(face.distance_lower_bound(p) <= face.distance(p) + 1e-12);
      }
      CHECK(distance(faces, p, first) == nearest);
      CHECK(faces[first].distance(p) == nearest);
    }
  }
  SECTION("a part of a sphere") {
    const double quarter = std::numbers::pi / 2;
    const Handle(Geom_SphericalSurface) sphere = new Geom_SphericalSurface(gp::XOY(), 1000);
    write_step_file(file, BRepBuilderAPI_MakeFace(sphere, 0, quarter, 0.1, 1.2, 1e-7), "M");
    const auto faces = read_cad_surfaces(file, 1e-3);
    REQUIRE(faces.size() == 1);
    for (const double u : {0.02, 0.7, 1.5})
      for (const double v : {0.11, 0.6, 1.19})
        for (const double r : {400.0, 1000.0, 2500.0}) {
          const Vec3 p =
              r * Vec3(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v));
          CHECK(faces[0].distance(p) == Approx(std::abs(r - 1000)).margin(1e-6));
        }
    // Beyond the edge at u = 0: the closest point is on the edge, not on another part of the
    // sphere.
    const Vec3 edge_point(1000 * std::cos(0.6), 0, 1000 * std::sin(0.6));
    CHECK(faces[0].distance(edge_point - Vec3(0, 300, 0)) == Approx(300).margin(1e-6));
  }
}

TEST_CASE("OpenCASCADE's settings are as before when a guard has gone", "[io][cad]") {
  OccSettings outer;  // isolates the settings of other tests
  outer.set("xstep.cascade.unit", "INCH");
  const auto unit = [] { return std::string(Interface_Static::CVal("xstep.cascade.unit")); };
  const double cascade_unit = UnitsMethods::GetCasCadeLengthUnit();
  {
    OccSettings inner;
    UnitsMethods::SetCasCadeLengthUnit(7 * cascade_unit);  // as readers do
    inner.set_unit("M");
    inner.set("xstep.cascade.unit", "KM");
    inner.set("read.iges.bspline.continuity", 2);
    CHECK(unit() == "KM");
  }
  CHECK(unit() == "INCH");
  CHECK(UnitsMethods::GetCasCadeLengthUnit() == cascade_unit);
  CHECK(Interface_Static::IVal("read.iges.bspline.continuity") == 1);
  CHECK_THROWS_AS(outer.set("no.such.setting", 1), std::logic_error);
  CHECK(OccSettings::unit_name(0.3048) == "FT");
  CHECK(OccSettings::unit_name(0.3).empty());
}

TEST_CASE("Ship hulls in metres: edges lie on the stored surface", "[io][cad][optional]") {
  const struct {
    const char* name;
    size_t edges;
    double length;  // of the hull in m
  } hulls[] = {{"lines-ship-iges/wigley.iges", 4, 2.5},
               {"lines-ship-iges/series_60.iges", 4, 127.997},
               {"lines-dealii-iges/DTMB-5415_bulbous_bow.iges", 4, 1.0489}};
  for (const auto& hull : hulls) {
    const fs::path file = batten_test::optional_data(hull.name);
    if (file.empty()) {
      WARN("optional input " << hull.name << " is absent: not tested");
      continue;
    }
    CAPTURE(hull.name);
    const auto lines = read_cad_lines(file, 1);
    const auto faces = read_cad_surfaces(file, 1);
    REQUIRE(lines.size() == hull.edges);
    REQUIRE(faces.size() == 1);
    double low = 1e9, high = -1e9;
    for (const auto& line : lines) {
      expect_true_derivatives(*line.curve);
      for (int i = 0; i <= 50; ++i) {
        const double t = line.curve->start() + (line.curve->end() - line.curve->start()) * i / 50;
        const Vec3 p = line.curve->evaluate(t);
        low = std::min(low, p.x());
        high = std::max(high, p.x());
        CHECK(faces[0].distance(p) < 1e-9 * hull.length);
      }
    }
    CHECK(high - low == Approx(hull.length).epsilon(1e-4));
  }
}
