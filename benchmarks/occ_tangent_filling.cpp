// SPDX-License-Identifier: MPL-2.0
#include "occ_tangent_filling.h"

#if BATTEN_BENCH_OCC

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepOffsetAPI_MakeFilling.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <GeomLProp_SLProps.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Precision.hxx>
#include <ShapeFix_Edge.hxx>
#include <Standard_Failure.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <cmath>

namespace batten::bench {
namespace {

gp_Pnt point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

gp_Dir normal(const Handle(Geom_Surface) & surface, const gp_Pnt& p) {
  GeomAPI_ProjectPointOnSurf foot(p, surface);
  double u, v;
  foot.LowerDistanceParameters(u, v);
  return GeomLProp_SLProps(surface, u, v, 1, 1e-9).Normal();
}

}  // namespace

struct OccTangentFilling::Data {
  TopoDS_Face face;
  std::string error;
  double max_deg = 0, mean_deg = 0;
};

OccTangentFilling::OccTangentFilling(const std::vector<Vec3>& grid, int columns,
                                     const std::vector<std::vector<Vec3>>& sides, int order)
    : data_(std::make_unique<Data>()) {
  try {
    const int rows = static_cast<int>(grid.size()) / columns;
    TColgp_Array2OfPnt points(1, columns, 1, rows);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i)
        points(i + 1, j + 1) = point(grid[static_cast<size_t>(j * columns + i)]);
    GeomAPI_PointsToBSplineSurface through;
    through.Interpolate(points);
    const Handle(Geom_BSplineSurface) given = through.Surface();
    const TopoDS_Face beside = BRepBuilderAPI_MakeFace(given, Precision::Confusion());
    BRepOffsetAPI_MakeFilling filling;
    std::vector<TopoDS_Vertex> corners;
    for (const auto& side : sides) corners.push_back(BRepBuilderAPI_MakeVertex(point(side[0])));
    const GeomAbs_Shape shapes[] = {GeomAbs_C0, GeomAbs_G1, GeomAbs_G2};
    for (size_t k = 0; k < sides.size(); ++k) {
      const auto count = static_cast<int>(sides[k].size());
      const bool closed = sides.size() == 1;
      Handle(TColgp_HArray1OfPnt) at = new TColgp_HArray1OfPnt(1, closed ? count - 1 : count);
      for (int i = 1; i <= at->Length(); ++i)
        at->SetValue(i, point(sides[k][static_cast<size_t>(i) - 1]));
      GeomAPI_Interpolate curve(at, closed, Precision::Confusion());
      curve.Perform();
      const TopoDS_Edge edge =
          BRepBuilderAPI_MakeEdge(curve.Curve(), corners[k], corners[(k + 1) % sides.size()]);
      ShapeFix_Edge().FixAddPCurve(edge, beside, false);
      filling.Add(edge, beside, shapes[order]);
    }
    filling.Build();
    if (!filling.IsDone()) {
      data_->error = "not done";
      return;
    }
    data_->face = TopoDS::Face(filling.Shape());
    const Handle(Geom_Surface) made = BRep_Tool::Surface(data_->face);
    double sum = 0;
    int samples = 0;
    for (const auto& side : sides)
      for (size_t i = 0; i < side.size(); i += 4) {
        const double angle = normal(given, point(side[i])).Angle(normal(made, point(side[i])));
        const double deg = std::min(angle, M_PI - angle) * 180 / M_PI;
        data_->max_deg = std::max(data_->max_deg, deg);
        sum += deg;
        ++samples;
      }
    data_->mean_deg = sum / samples;
  } catch (const Standard_Failure& failure) {
    data_->error = failure.DynamicType()->Name();
  }
}
OccTangentFilling::~OccTangentFilling() = default;
const std::string& OccTangentFilling::error_message() const { return data_->error; }
double OccTangentFilling::max_deg() const { return data_->max_deg; }
double OccTangentFilling::mean_deg() const { return data_->mean_deg; }

std::vector<Vec3> OccTangentFilling::points(int n) const {
  double u0, u1, v0, v1;
  BRepTools::UVBounds(data_->face, u0, u1, v0, v1);
  BRepTopAdaptor_FClass2d inside(data_->face, Precision::PConfusion());
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(data_->face);
  std::vector<Vec3> found;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const gp_Pnt2d uv(u0 + i * (u1 - u0) / n, v0 + j * (v1 - v0) / n);
      if (inside.Perform(uv) == TopAbs_OUT) continue;
      const gp_Pnt p = surface->Value(uv.X(), uv.Y());
      found.emplace_back(p.X(), p.Y(), p.Z());
    }
  return found;
}

}  // namespace batten::bench

#else

namespace batten::bench {
struct OccTangentFilling::Data {
  std::string error = "no OpenCASCADE";
};
OccTangentFilling::OccTangentFilling(const std::vector<Vec3>&, int,
                                     const std::vector<std::vector<Vec3>>&, int)
    : data_(std::make_unique<Data>()) {}
OccTangentFilling::~OccTangentFilling() = default;
const std::string& OccTangentFilling::error_message() const { return data_->error; }
double OccTangentFilling::max_deg() const { return 0; }
double OccTangentFilling::mean_deg() const { return 0; }
std::vector<Vec3> OccTangentFilling::points(int) const { return {}; }
}  // namespace batten::bench

#endif
