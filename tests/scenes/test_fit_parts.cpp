// SPDX-License-Identifier: MPL-2.0
// Models fitted to parts with analytic faces, measured by OpenCASCADE.

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_PointsToBSpline.hxx>
#include <Geom_BSplineCurve.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "batten/io/cad/cad_convert.h"
#include "batten/io/cad/cad_file.h"
#include "batten/scenes/fit_surface.h"
#include "batten/tests/io/cad/cad_files.h"

using namespace batten_test;

namespace {

double area_of(const TopoDS_Shape& shape) {
  GProp_GProps found;
  BRepGProp::SurfaceProperties(shape, found);
  return found.Mass();
}
double volume_of(const TopoDS_Shape& shape) {
  GProp_GProps found;
  BRepGProp::VolumeProperties(shape, found);
  return found.Mass();
}

int faces_of(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  return faces.Extent();
}

TopoDS_Shape filleted(const TopoDS_Shape& shape, double radius,
                      const std::function<bool(const gp_Pnt& middle)>& wanted) {
  BRepFilletAPI_MakeFillet fillet(shape);
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  for (int e = 1; e <= edges.Extent(); ++e) {
    double first, last;
    const auto curve = BRep_Tool::Curve(TopoDS::Edge(edges(e)), first, last);
    if (wanted(curve->Value((first + last) / 2))) fillet.Add(radius, TopoDS::Edge(edges(e)));
  }
  return fillet.Shape();
}

TopoDS_Shape drilled_plate() {
  const TopoDS_Shape plate = BRepPrimAPI_MakeBox(80, 50, 6).Shape();
  const TopoDS_Shape round = filleted(plate, 8, [](const gp_Pnt& at) {
    return std::abs(at.Z() - 3) < 1e-6;
  });
  return BRepAlgoAPI_Cut(
             round,
             BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(50, 20, -1), gp_Dir(0, 0, 1)), 7, 9).Shape())
      .Shape();
}

TopoDS_Shape vase() {
  TColgp_Array1OfPnt points(1, 5);
  const double radius[] = {15, 25, 18, 10, 14}, height[] = {0, 20, 45, 60, 75};
  for (int i = 0; i < 5; ++i) points(i + 1) = gp_Pnt(radius[i], 0, height[i]);
  const Handle(Geom_BSplineCurve) profile = GeomAPI_PointsToBSpline(points, 3, 8, GeomAbs_C2, 1e-3);
  return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeEdge(profile).Edge(),
                               gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)))
      .Shape();
}

struct Part {
  std::string name;
  TopoDS_Shape shape;
  bool solid = true;
};

std::vector<Part> parts() {
  gp_Trsf turn;
  turn.SetRotation(gp_Ax1(gp_Pnt(3, -20, 11), gp_Dir(1, 2, 3)), 0.7);
  const auto all = [](const gp_Pnt&) { return true; };
  return {{"cylinder", BRepPrimAPI_MakeCylinder(20, 50).Shape()},
          {"turned", BRepBuilderAPI_Transform(BRepPrimAPI_MakeCylinder(20, 50).Shape(), turn)},
          {"cone", BRepPrimAPI_MakeCone(20, 0, 40).Shape()},
          {"sphere", BRepPrimAPI_MakeSphere(25).Shape()},
          {"torus", BRepPrimAPI_MakeTorus(30, 8).Shape()},
          {"plate", drilled_plate()},
          {"box", filleted(BRepPrimAPI_MakeBox(60, 40, 20).Shape(), 4, all)},
          {"vase", vase(), false}};
}

/// The largest distance of points of one shape from the other, at the nodes of its triangles.
double distance_of_nodes(const TopoDS_Shape& from, const TopoDS_Shape& to, const fs::path& scratch) {
  CadFacetOptions options;
  options.unit_in_metres = 1e-3;
  const CadFacets facets = tessellate_cad(written(scratch, painted("part", from)), options);
  double largest = 0;
  const int step = std::max(1, static_cast<int>(facets.mesh.points.rows()) / 900);
  for (long i = 0; i < facets.mesh.points.rows(); i += step) {
    const gp_Pnt p(facets.mesh.points(i, 0), facets.mesh.points(i, 1), facets.mesh.points(i, 2));
    largest = std::max(largest,
                       BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(p).Vertex(), to).Value());
  }
  return largest;
}

}  // namespace

TEST_CASE("parts with analytic faces are fitted face by face, exactly",
          "[scenes][fit]") {
  for (const std::string unit : {"mm", "m"})
    for (const Part& part : parts()) {
      if (unit == "m" && part.name != "box" && part.name != "cone") continue;
      INFO(part.name << " in " << unit);
      const fs::path folder = scratch("fit_parts");
      const fs::path file = written(folder / (part.name + ".step"), painted(part.name, part.shape),
                                    unit == "m" ? 1 : 1e-3);
      FitSettings settings;
      settings.unit = unit;
      const Model model = fit_surface(file, settings);
      const fs::path out = folder / "out.step";
      CHECK(model.save(out).empty());
      const auto target = nlohmann::json::parse(model.report())["target"];
      const double size = target["fit_tolerance"].get<double>() / 1e-4;
      CHECK(target["reached"].get<bool>());
      if (part.solid) {
        CHECK(target["to_target"]["max"].get<double>() < 1e-5 * size);
        CHECK(target["from_target"]["max"].get<double>() < 1e-5 * size);
      }

      const TopoDS_Shape made = read_cad(out).shape;
      CHECK(faces_of(made) == faces_of(part.shape));
      CHECK(area_of(made) == Approx(area_of(part.shape)).epsilon(1e-6));
      if (part.solid) {
        CHECK(volume_of(made) == Approx(volume_of(part.shape)).epsilon(1e-6));
        CHECK(free_edges_of(made).Extent() == 0);
      }
      const double mm = size * (unit == "m" ? 1e3 : 1);
      CHECK(distance_of_nodes(made, part.shape, folder / "a.step") < 1e-5 * mm);
      CHECK(distance_of_nodes(part.shape, made, folder / "b.step") < 1e-5 * mm);
    }
}
