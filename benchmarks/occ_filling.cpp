#include "occ_filling.h"

#if BATTEN_BENCH_OCC

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepOffsetAPI_MakeFilling.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_Surface.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <Standard_Version.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>

namespace batten::bench {
namespace {

gp_Pnt point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Vec3 point(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

TopoDS_Edge edge(const Cubic& c, const TopoDS_Vertex& start, const TopoDS_Vertex& end) {
  TColgp_Array1OfPnt poles(1, 4);
  for (int i = 0; i < 4; ++i) poles.SetValue(i + 1, point(c[static_cast<size_t>(i)]));
  return BRepBuilderAPI_MakeEdge(new Geom_BezierCurve(poles), start, end);
}

}  // namespace

std::string occ_version() { return OCC_VERSION_COMPLETE; }

struct Filling::Data {
  TopoDS_Face face;
  Handle(Geom_Surface) surface;
  Handle(ShapeAnalysis_Surface) analysis;
};

Filling::Filling(const std::vector<Cubic>& outline, const std::vector<Cubic>& inner,
                 const FillingSettings& s)
    : data_(std::make_unique<Data>()) {
  BRepOffsetAPI_MakeFilling filling(3, s.points_on_curve, 2, Standard_False, 1e-5, s.tolerance,
                                    0.01, 0.1, 8, s.max_segments);
  std::vector<TopoDS_Vertex> corner;
  for (const Cubic& c : outline) corner.push_back(BRepBuilderAPI_MakeVertex(point(c[0])));
  for (size_t i = 0; i < outline.size(); ++i)
    filling.Add(edge(outline[i], corner[i], corner[(i + 1) % outline.size()]), GeomAbs_C0);
  for (const Cubic& c : inner)
    filling.Add(
        edge(c, BRepBuilderAPI_MakeVertex(point(c[0])), BRepBuilderAPI_MakeVertex(point(c[3]))),
        GeomAbs_C0, Standard_False);
  filling.Build();
  if (!filling.IsDone()) return;
  data_->face = TopoDS::Face(filling.Shape());
  data_->surface = BRep_Tool::Surface(data_->face);
}
Filling::~Filling() = default;

bool Filling::done() const { return !data_->surface.IsNull(); }

// On the whole surface, not on the face that is cut out of it: the face's edges are the input
// curves themselves, which would hide how far the surface is from them.
double Filling::distance(const Vec3& p) const {
  double nearest = 1e100;
  const GeomAPI_ProjectPointOnSurf projection(point(p), data_->surface);
  if (projection.NbPoints() > 0) nearest = projection.LowerDistance();
  if (data_->analysis.IsNull()) data_->analysis = new ShapeAnalysis_Surface(data_->surface);
  const gp_Pnt2d uv = data_->analysis->ValueOfUV(point(p), 1e-12);
  return std::min(nearest, data_->analysis->Value(uv).Distance(point(p)));
}

std::vector<Vec3> Filling::boundary_points(int an_edge) const {
  std::vector<Vec3> points;
  for (TopExp_Explorer e(data_->face, TopAbs_EDGE); e.More(); e.Next()) {
    double first = 0, last = 0;
    const auto curve =
        BRep_Tool::CurveOnSurface(TopoDS::Edge(e.Current()), data_->face, first, last);
    for (int k = 0; !curve.IsNull() && k <= an_edge; ++k) {
      const gp_Pnt2d uv = curve->Value(first + (last - first) * k / an_edge);
      points.push_back(point(data_->surface->Value(uv.X(), uv.Y())));
    }
  }
  return points;
}

}  // namespace batten::bench

#else

#include <stdexcept>

namespace batten::bench {

std::string occ_version() { return ""; }

struct Filling::Data {};
Filling::Filling(const std::vector<Cubic>&, const std::vector<Cubic>&, const FillingSettings&) {
  throw std::logic_error("built without OpenCASCADE");
}
Filling::~Filling() = default;
bool Filling::done() const { return false; }
double Filling::distance(const Vec3&) const { return 0; }
std::vector<Vec3> Filling::boundary_points(int) const { return {}; }

}  // namespace batten::bench

#endif
