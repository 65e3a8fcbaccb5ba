// SPDX-License-Identifier: MPL-2.0
// Continuity between faces of CAD files: known solids, as STEP with shared edges and as IGES
// without.
#include "batten/io/cad/continuity_report.h"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <IGESControl_Writer.hxx>
#include <STEPControl_Writer.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Wire.hxx>

#include "batten/core/errors.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/text.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using Kind = EdgeContinuity::Kind;
namespace fs = std::filesystem;

namespace {

/// Two straight sides of length 20, half circles of radius 5 between them, height 30: mm.
/// `rotation_deg`: angle between the first side and the arc's tangent.
TopoDS_Shape obround(double rotation_deg = 0) {
  const double rise = 20 * std::tan(rotation_deg * EIGEN_PI / 180);
  const gp_Pnt a(0, -5 - rise, 0), b(20, -5, 0), c(20, 5, 0), d(0, 5, 0);
  BRepBuilderAPI_MakeWire wire;
  wire.Add(BRepBuilderAPI_MakeEdge(a, b));
  wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(b, gp_Pnt(25, 0, 0), c).Value()));
  wire.Add(BRepBuilderAPI_MakeEdge(c, d));
  if (rotation_deg == 0)
    wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(d, gp_Pnt(-5, 0, 0), a).Value()));
  else
    wire.Add(BRepBuilderAPI_MakeEdge(d, a));
  return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), gp_Vec(0, 0, 30));
}

fs::path written(const std::string& name, const TopoDS_Shape& shape) {
  const fs::path file = fs::temp_directory_path() / ("batten_continuity_" + name);
  OccSettings occ;
  if (name.ends_with(".step")) {
    STEPControl_Writer writer;
    REQUIRE(writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone);
    REQUIRE(writer.Write(file.string().c_str()) == IFSelect_RetDone);
  } else {
    IGESControl_Writer writer("MM", 0);  // trimmed surfaces without shared edges
    REQUIRE(writer.AddShape(shape));
    writer.ComputeModel();
    REQUIRE(writer.Write(file.string().c_str()));
  }
  return file;
}

}  // namespace

TEST_CASE("edges of an obround are tangent and its curvature jumps by one over the radius",
          "[io][step]") {
  for (const char* name : {"obround.step", "obround.iges"})
    for (const char* unit : {"mm", "m"}) {
      INFO(name << " in " << unit);
      const double mm = 1e-3 / unit_in_metres(unit);
      const auto r = measure_continuity(written(name, obround()), unit_in_metres(unit));
      CHECK(r.faces == 6);
      CHECK(r.edges == 12);
      CHECK(r.free_edges == 0);
      CHECK(r.non_manifold_edges == 0);
      CHECK(r.unmeasured == 0);
      CHECK(r.count(Kind::Crease) == 8);
      CHECK(r.count(Kind::Tangent) == 4);
      CHECK(r.slivers.empty());
      for (const auto& edge : r.inner) {
        CHECK(edge.gap < 1e-6 * mm);
        if (edge.kind == Kind::Crease) {
          CHECK(edge.angle_deg == Approx(90).epsilon(1e-9));
          continue;
        }
        CHECK(edge.angle_deg < 1e-6);
        CHECK(edge.curvature_jump == Approx(0.2 / mm).epsilon(1e-9));
        CHECK(edge.length == Approx(30 * mm));
        CHECK(std::abs(std::abs(edge.at.y()) - 5 * mm) < 1e-6 * mm);
      }
    }
}

TEST_CASE("a side that misses an arc's tangent by half a degree is a crease of half a degree",
          "[io][step]") {
  const auto r = measure_continuity(written("nearly.step", obround(0.5)), 1e-3);
  double smallest = 180;
  for (const auto& edge : r.inner) smallest = std::min(smallest, edge.angle_deg);
  CHECK(smallest < 1e-6);  // the other end of the arc
  const auto nearly = std::count_if(r.inner.begin(), r.inner.end(), [](const auto& edge) {
    return std::abs(edge.angle_deg - 0.5) < 1e-9 && edge.kind == Kind::Crease;
  });
  CHECK(nearly == 1);
  CHECK(continuity_text(r, {}, "mm").find("nearly tangent: up to 0.5 degrees") !=
        std::string::npos);
  ContinuityOptions wide;
  wide.angle_deg = 1;
  CHECK(measure_continuity(written("nearly.step", obround(0.5)), 1e-3, wide).count(Kind::Tangent) ==
        2);
}

TEST_CASE("a sphere's seam goes on with one curvature, a box has twelve creases and no gap",
          "[io][step]") {
  const auto sphere =
      measure_continuity(written("sphere.step", BRepPrimAPI_MakeSphere(7.0).Shape()), 1e-3);
  CHECK(sphere.faces == 1);
  CHECK(sphere.count(Kind::Curvature) == 1);
  CHECK(sphere.free_edges == 0);
  const auto box =
      measure_continuity(written("box.step", BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()), 1e-3);
  CHECK(box.count(Kind::Crease) == 12);
  CHECK(box.solids == 1);
  CHECK(box.worst(Kind::Tangent) == nullptr);
  REQUIRE(box.worst(Kind::Crease));
  CHECK(box.worst(Kind::Crease)->gap < 1e-12);
}

TEST_CASE("continuity of nothing is refused", "[io][step]") {
  const fs::path none = fs::temp_directory_path() / "batten_continuity_none.step";
  CHECK_THROWS_AS(measure_continuity(none, 1e-3), InputError);
  const auto box = written("box.step", BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape());
  CHECK_THROWS_AS(measure_continuity(box, 0), InputError);
  ContinuityOptions wrong;
  wrong.sewing = 1;
  CHECK_THROWS_AS(measure_continuity(box, 1e-3, wrong), InputError);
}
