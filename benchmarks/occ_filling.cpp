// SPDX-License-Identifier: MPL-2.0
#include "occ_filling.h"

#if BATTEN_BENCH_OCC

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepOffsetAPI_MakeFilling.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_Surface.hxx>
#include <Precision.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <Standard_Failure.hxx>
#include <Standard_Version.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>

#if BATTEN_BENCH_OCC_STEP
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Writer.hxx>
#endif

namespace batten::bench {
namespace {

gp_Pnt point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Vec3 point(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

TopoDS_Edge edge(const Cubic& c, const TopoDS_Vertex& start, const TopoDS_Vertex& end) {
  TColgp_Array1OfPnt poles(1, 4);
  for (int i = 0; i < 4; ++i) poles.SetValue(i + 1, point(c[static_cast<size_t>(i)]));
  return BRepBuilderAPI_MakeEdge(new Geom_BezierCurve(poles), start, end);
}

// C1 cubics: every inner knot has multiplicity 2, and the junctions of cubics are not poles.
TopoDS_Edge edge(const HermiteCurve& c, const TopoDS_Vertex& start, const TopoDS_Vertex& end) {
  const int n = c.segment_count();
  TColgp_Array1OfPnt poles(1, 2 * n + 2);
  TColStd_Array1OfReal knots(1, n + 1);
  TColStd_Array1OfInteger times(1, n + 1);
  times.Init(2);
  times.SetValue(1, 4);
  times.SetValue(n + 1, 4);
  knots.SetValue(1, c.start());
  poles.SetValue(1, point(c.position(0)));
  for (int s = 0; s < n; ++s) {
    const int next = (s + 1) % c.node_count();
    const double h = c.mesh().length(s) / 3;
    poles.SetValue(2 * s + 2, point(c.position(s) + h * c.slope_out(s)));
    poles.SetValue(2 * s + 3, point(c.position(next) - h * c.slope_in(next)));
    knots.SetValue(s + 2, s + 1 < n ? c.parameters()[static_cast<size_t>(s) + 1] : c.end());
  }
  poles.SetValue(2 * n + 2, point(c.evaluate({n - 1, 1.0})));
  return BRepBuilderAPI_MakeEdge(new Geom_BSplineCurve(poles, knots, times, 3), start, end,
                                 c.start(), c.end());
}

TopoDS_Vertex vertex(const Vec3& p) { return BRepBuilderAPI_MakeVertex(point(p)); }

}  // namespace

std::string occ_version() { return OCC_VERSION_COMPLETE; }

struct OccFilling::Data {
  TopoDS_Face face;
  Handle(Geom_Surface) surface;
  Handle(ShapeAnalysis_Surface) analysis;
  std::string error_message;

  void fill(const std::vector<TopoDS_Edge>& bounds, const std::vector<TopoDS_Edge>& inner,
            const OccFillingSettings& s) {
    try {
      BRepOffsetAPI_MakeFilling filling(3, s.points_on_curve, 2, Standard_False, 1e-5, s.tolerance,
                                        0.01, 0.1, 8, s.max_segments);
      for (const TopoDS_Edge& e : bounds) filling.Add(e, GeomAbs_C0);
      for (const TopoDS_Edge& e : inner) filling.Add(e, GeomAbs_C0, Standard_False);
      filling.Build();
      if (!filling.IsDone()) {
        error_message = "not done";
        return;
      }
      face = TopoDS::Face(filling.Shape());
      surface = BRep_Tool::Surface(face);
      if (!BRepCheck_Analyzer(face).IsValid()) error_message = "done, but the face is not valid";
    } catch (const Standard_Failure& e) {
      error_message = e.DynamicType()->Name();
      if (e.GetMessageString() && *e.GetMessageString())
        error_message += std::string(": ") + e.GetMessageString();
    }
  }
};

OccFilling::OccFilling(const std::vector<Cubic>& outline, const std::vector<Cubic>& inner,
                       const OccFillingSettings& s)
    : data_(std::make_unique<Data>()) {
  std::vector<TopoDS_Vertex> corner;
  for (const Cubic& c : outline) corner.push_back(vertex(c[0]));
  std::vector<TopoDS_Edge> bounds, across;
  for (size_t i = 0; i < outline.size(); ++i)
    bounds.push_back(edge(outline[i], corner[i], corner[(i + 1) % outline.size()]));
  for (const Cubic& c : inner) across.push_back(edge(c, vertex(c[0]), vertex(c[3])));
  data_->fill(bounds, across, s);
}

OccFilling::OccFilling(const std::vector<std::vector<HermiteCurve>>& loops,
                       const std::vector<HermiteCurve>& inner, const OccFillingSettings& s)
    : data_(std::make_unique<Data>()) {
  std::vector<TopoDS_Edge> bounds, across;
  try {
    for (const auto& loop : loops) {
      std::vector<TopoDS_Vertex> corner;
      for (const HermiteCurve& c : loop) corner.push_back(vertex(c.position(0)));
      for (size_t i = 0; i < loop.size(); ++i)
        bounds.push_back(edge(loop[i], corner[i], corner[(i + 1) % loop.size()]));
    }
    for (const HermiteCurve& c : inner) {
      const Vec3 first = c.position(0), last = c.evaluate({c.segment_count() - 1, 1.0});
      const TopoDS_Vertex start = vertex(first);
      const bool closed = (last - first).norm() <= Precision::Confusion();
      across.push_back(edge(c, start, closed ? start : vertex(last)));
    }
  } catch (const Standard_Failure& e) {
    data_->error_message = std::string("no edge: ") + e.DynamicType()->Name();
    return;
  }
  data_->fill(bounds, across, s);
}

OccFilling::~OccFilling() = default;

bool OccFilling::done() const { return !data_->surface.IsNull(); }
const std::string& OccFilling::error_message() const { return data_->error_message; }

// Uses the whole surface, not the trimmed face: the face's edges are the input curves themselves,
// which would hide the distance of the surface from them.
double OccFilling::distance(const Vec3& p) const {
  double nearest = 1e100;
  try {
    const GeomAPI_ProjectPointOnSurf projection(point(p), data_->surface);
    if (projection.NbPoints() > 0) nearest = projection.LowerDistance();
  } catch (const Standard_Failure&) {  // only the second method succeeds
  }
  if (data_->analysis.IsNull()) data_->analysis = new ShapeAnalysis_Surface(data_->surface);
  const gp_Pnt2d uv = data_->analysis->ValueOfUV(point(p), 1e-12);
  return std::min(nearest, data_->analysis->Value(uv).Distance(point(p)));
}

std::vector<Vec3> OccFilling::boundary_points(int an_edge) const {
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

std::vector<Vec3> OccFilling::points(int n) const {
  std::vector<Vec3> points;
  // Faces whose wires are not closed have no interior.
  if (!BRepCheck_Analyzer(data_->face).IsValid()) return points;
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  BRepTools::UVBounds(data_->face, u0, u1, v0, v1);
  BRepTopAdaptor_FClass2d inside(data_->face, 1e-9);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const gp_Pnt2d uv(u0 + (u1 - u0) * (i + 0.5) / n, v0 + (v1 - v0) * (j + 0.5) / n);
      if (inside.Perform(uv) == TopAbs_IN)
        points.push_back(point(data_->surface->Value(uv.X(), uv.Y())));
    }
  return points;
}

std::array<int, 2> OccFilling::poles() const {
  const auto spline = Handle(Geom_BSplineSurface)::DownCast(data_->surface);
  if (spline.IsNull()) return {0, 0};
  return {spline->NbUPoles(), spline->NbVPoles()};
}

#if BATTEN_BENCH_OCC_STEP
bool OccFilling::write_step(const std::string& file) const {
  Message::DefaultMessenger()->ChangePrinters().Clear();
  STEPControl_Writer writer;
  return writer.Transfer(data_->face, STEPControl_AsIs) == IFSelect_RetDone &&
         writer.Write(file.c_str()) == IFSelect_RetDone;
}
#else
bool OccFilling::write_step(const std::string&) const { return false; }
#endif

}  // namespace batten::bench

#else

#include <stdexcept>

namespace batten::bench {

std::string occ_version() { return ""; }

struct OccFilling::Data {};
OccFilling::OccFilling(const std::vector<Cubic>&, const std::vector<Cubic>&,
                       const OccFillingSettings&) {
  throw std::logic_error("built without OpenCASCADE");
}
OccFilling::OccFilling(const std::vector<std::vector<HermiteCurve>>&,
                       const std::vector<HermiteCurve>&, const OccFillingSettings&) {
  throw std::logic_error("built without OpenCASCADE");
}
OccFilling::~OccFilling() = default;
bool OccFilling::done() const { return false; }
const std::string& OccFilling::error_message() const {
  static const std::string nothing;
  return nothing;
}
double OccFilling::distance(const Vec3&) const { return 0; }
std::vector<Vec3> OccFilling::boundary_points(int) const { return {}; }
std::vector<Vec3> OccFilling::points(int) const { return {}; }
std::array<int, 2> OccFilling::poles() const { return {0, 0}; }
bool OccFilling::write_step(const std::string&) const { return false; }

}  // namespace batten::bench

#endif
