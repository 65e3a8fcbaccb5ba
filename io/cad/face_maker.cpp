#include "batten/io/cad/face_maker.h"

#include <Approx_CurveOnSurface.hxx>
#include <BRep_Tool.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Wire.hxx>

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/fem/cubic_splines.h"
#include "batten/fem/spline_axis.h"
#include "batten/io/cad/occ_values.h"

namespace batten {
namespace {

Box3 box_of(const HermiteCurve& curve) {
  Box3 box;
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 0; k <= 4; ++k) box.extend(curve.evaluate({s, k / 4.0}));
  return box;
}
Vec3 middle(const FaceBoundary& boundary) {
  Box3 box;
  for (const FaceLoop& loop : boundary.loops)
    for (const FaceStretch& stretch : loop) box.extend(box_of(stretch.curve));
  return box.center();
}
Surface moved_by(const Surface& surface, const Vec3& shift) {
  Points dofs = surface.dofs();
  for (int v = 0; v < surface.mesh().vertex_count(); ++v)
    dofs.row(surface.dof_map().vertex(v)) += shift.transpose();
  return {surface.shared_mesh(), surface.kind(), std::move(dofs)};
}

std::pair<TColStd_Array1OfReal, TColStd_Array1OfInteger> knots(const SplineAxis& axis) {
  const int n = axis.intervals() + 1;
  TColStd_Array1OfReal values(1, n);
  TColStd_Array1OfInteger times(1, n);
  for (int i = 1; i <= n; ++i) {
    values(i) = axis.knots()[i - 1];
    times(i) = !axis.periodic() && (i == 1 || i == n) ? 4 : 1;
  }
  return {values, times};
}
std::pair<TColStd_Array1OfReal, TColStd_Array1OfInteger> knots(const CubicSpline& spline) {
  const int n = count_of(spline.knots);
  TColStd_Array1OfReal values(1, n);
  TColStd_Array1OfInteger times(1, n);
  for (int i = 1; i <= n; ++i) {
    values(i) = spline.knots[i - 1];
    times(i) = spline.multiplicities[i - 1];
  }
  return {values, times};
}

Handle(Geom_BSplineCurve) curve_of(const CubicSpline& spline) {
  TColgp_Array1OfPnt poles(1, count_of(spline.poles));
  for (int i = 1; i <= poles.Length(); ++i) poles(i) = to_occ(spline.poles[i - 1]);
  const auto [t, times] = knots(spline);
  return new Geom_BSplineCurve(poles, t, times, 3);
}
Handle(Geom2d_BSplineCurve) to_flat_occ(const CubicSpline& spline) {
  TColgp_Array1OfPnt2d poles(1, count_of(spline.poles));
  for (int i = 1; i <= poles.Length(); ++i)
    poles(i) = {spline.poles[i - 1].x(), spline.poles[i - 1].y()};
  const auto [t, times] = knots(spline);
  return new Geom2d_BSplineCurve(poles, t, times, 3);
}

/// The same spline over other parameters.
CubicSpline over(CubicSpline spline, double first, double last) {
  const double from = spline.knots.front(), to = spline.knots.back();
  for (double& k : spline.knots) k = first + (k - from) / (to - from) * (last - first);
  spline.knots.back() = last;
  return spline;
}

/// The curve S(l(t)) of a surface along a line of its parameters, within a tolerance, moved from the
/// origin to a place.
Handle(Geom_BSplineCurve) curve_on_surface(const Handle(Geom_BSplineSurface) & surface,
                                           const Handle(Geom2d_BSplineCurve) & line,
                                           double tolerance, const gp_Pnt& place) {
  const double first = line->FirstParameter(), last = line->LastParameter();
  Approx_CurveOnSurface found(new Geom2dAdaptor_Curve(line), new GeomAdaptor_Surface(surface),
                              first, last, tolerance);
  constexpr int most_segments = 10'000, degree = 8;
  found.Perform(most_segments, degree, GeomAbs_C1, true);
  if (!found.HasResult()) throw Error("STEP: OpenCASCADE finds no curve along a face's rim");
  const Handle(Geom_BSplineCurve) curve = found.Curve3d();
  curve->Translate(gp_Pnt(), place);
  return curve;
}

Vec3 end_of(const HermiteCurve& curve) { return curve.evaluate({curve.segment_count() - 1, 1.0}); }

}  // namespace

// ---- what faces have in common --------------------------------------------------------------

int SharedEdges::cut_of(const FaceStretch& stretch, bool end) const {
  const double at = stretch.line_parameter(end ? stretch.curve.end() : stretch.curve.start());
  const double other = stretch.line_parameter(end ? stretch.curve.start() : stretch.curve.end());
  const double hair = 1e-6 * std::abs(at - other);
  int cuts = 0;
  for (const double cut : plan_.lines.at(stretch.line).cuts)
    if (++cuts; std::abs(cut - at) <= hair) return cuts;
  return at > other ? cuts + 1 : 0;
}

TopoDS_Vertex& SharedEdges::vertex(const std::string& name, int cut) {
  const StepLine& line = plan_.lines.at(name);
  const int last = count_of(line.cuts) + 1;
  if (cut == 0 || cut == last) return places_[line.places[cut == last]];
  return vertices_[{name, cut}];
}

TopoDS_Vertex& SharedEdges::vertex(const FaceStretch& stretch, bool end) {
  return vertex(stretch.line, cut_of(stretch, end));
}
TopoDS_Edge& SharedEdges::edge(const FaceStretch& stretch) {
  return edge(stretch.line, std::max(cut_of(stretch, false), cut_of(stretch, true)));
}

std::vector<CadCurveItem> SharedEdges::along_lines() const {
  std::vector<CadCurveItem> result;
  for (const auto& [place, edge] : edges_)
    if (!edge.IsNull()) result.push_back({edge, place.first, ""});
  return result;
}

// ---- one region -----------------------------------------------------------------------------

FaceMaker::FaceMaker(const SkinnedRegion& region, const StepFaceOptions& options,
                     const StepPlan* common)
    : region_(region),
      options_(options),
      boundary_(region, common),
      middle_(middle(boundary_)),
      near_origin_(moved_by(region.surface, -middle_)) {
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceStretch& stretch : loop) box_.extend(box_of(stretch.curve));
  size_ = box_.diagonal().norm();
  // The faces on both sides may miss the common plane, in any direction.
  goal_ = {0.9 * options.tolerance, 0.4 * options.join_deg};
}

Vec3 FaceMaker::position(const Vec2& uv) const { return near_origin_.position(uv) + middle_; }

Vec3 FaceMaker::normal(const Vec2& uv) const {
  return near_origin_.surface().jet(near_origin_.locate(uv)).normal();
}

Vec3 FaceMaker::fitted_position(const Vec2& uv) const { return fit_.patch.position(uv) + middle_; }

TopoDS_Face FaceMaker::make(double coincidence, SharedEdges* shared) {
  coincidence_ = coincidence;
  shared_ = shared;
  used_.clear();
  along_lines_.clear();
  const BicubicPatch& patch = fit_.patch;
  const auto [u, u_times] = knots(patch.u);
  const auto [v, v_times] = knots(patch.v);
  TColgp_Array2OfPnt poles(1, patch.u.functions(), 1, patch.v.functions());
  for (int i = 0; i < patch.u.functions(); ++i)
    for (int j = 0; j < patch.v.functions(); ++j)
      poles(i + 1, j + 1) =
          to_occ(patch.poles.row(static_cast<long>(i) * patch.v.functions() + j).transpose());
  surface_near_origin_ =
      new Geom_BSplineSurface(poles, u, v, u_times, v_times, 3, 3, patch.u.periodic());
  surface_ = Handle(Geom_BSplineSurface)::DownCast(
      surface_near_origin_->Translated(gp_Vec(gp_Pnt(), to_occ(middle_))));
  widest_ = 1e-9 * size_;
  builder_.MakeFace(face_, surface_, widest_);

  if (boundary_.period > 0) {
    add_ring();
  } else {
    add_wire(boundary_.loops[0]);
  }
  for (size_t k = boundary_.period > 0 ? 2 : 1; k < boundary_.loops.size(); ++k)
    add_wire(boundary_.loops[k]);
  return face_;
}

double FaceMaker::widened(double distance) {
  // Between the samples the distance may be a little larger.
  const double tolerance = std::max(1e-9 * size_, 1.02 * distance);
  widest_ = std::max(widest_, tolerance);
  return tolerance;
}

// The vertex where two stretches meet, at the end of `before` and the start of `after`.
TopoDS_Vertex FaceMaker::vertex(const FaceStretch& before, const FaceStretch& after) {
  const bool of_lines = before.shared || after.shared;
  const Vec2 first = after.first();
  const Vec3 p =
      of_lines ? after.curve.position(0) : from_occ(surface_->Value(first.x(), first.y()));
  double distance = of_lines ? (p - end_of(before.curve)).norm() : 0;
  for (const Vec2& uv : {before.last(), first})
    distance = std::max(distance, (from_occ(surface_->Value(uv.x(), uv.y())) - p).norm());
  TopoDS_Vertex mine;
  TopoDS_Vertex& result = shared_ ? shared_->vertex(after, false) : mine;
  if (result.IsNull()) {
    builder_.MakeVertex(result, to_occ(p), widened(distance));
    return result;
  }
  distance += (from_occ(BRep_Tool::Pnt(result)) - p).norm();
  builder_.UpdateVertex(result, widened(distance));
  return result;
}

// The edge of a stretch, forward along the loop. A shared edge that is made here runs along its
// line.
TopoDS_Edge FaceMaker::edge(const FaceStretch& stretch, const TopoDS_Vertex& a,
                            const TopoDS_Vertex& b) {
  bool reversed = shared_ && stretch.reversed;
  const auto along = [&](const HermiteCurve& curve) {
    return cubic_splines("", reversed ? curve.backwards() : curve).front();
  };
  TopoDS_Edge mine;
  TopoDS_Edge* result = &mine;
  if (shared_) {
    result = &shared_->edge(stretch);
    // A line on both sides of one face is two edges: readers do not agree about slits.
    if (!result->IsNull() && used_.count(result->TShape().get())) result = &mine;
    if (!result->IsNull() && result->Orientation() == TopAbs_REVERSED) reversed = !reversed;
  }
  const CubicSpline plane = along(stretch.image);
  if (result->IsNull()) {
    const Handle(Geom_BSplineCurve) curve =
        stretch.shared ? curve_of(along(stretch.curve))
                       : curve_on_surface(surface_near_origin_, to_flat_occ(plane),
                                          0.3 * coincidence_, to_occ(middle_));
    builder_.MakeEdge(*result, curve, widened(0));
    finish(*result, reversed ? b : a, reversed ? a : b, curve->FirstParameter(),
           curve->LastParameter());
  }
  double first, last;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(*result, first, last);
  const Handle(Geom2d_BSplineCurve) line = to_flat_occ(over(plane, first, last));

  double distance = 0;
  const int of_curve = static_cast<int>(stretch.curve.segment_count()) + 1;
  const int n = std::max(24 * (of_curve + line->NbKnots()), 16 * (poles_u() + poles_v()));
  for (int i = 0; i <= n; ++i) {
    const double at = first + (last - first) * i / n;
    const gp_Pnt2d uv = line->Value(at);
    distance = std::max(distance, curve->Value(at).Distance(surface_->Value(uv.X(), uv.Y())));
  }
  builder_.UpdateEdge(*result, line, face_, widened(distance));
  builder_.Range(*result, face_, first, last);
  builder_.SameRange(*result, true);
  builder_.SameParameter(*result, true);
  used_.insert(result->TShape().get());
  along_lines_.push_back({*result, stretch.line, ""});
  return TopoDS::Edge(result->Oriented(reversed ? TopAbs_REVERSED : TopAbs_FORWARD));
}

void FaceMaker::finish(TopoDS_Edge& edge, const TopoDS_Vertex& a, const TopoDS_Vertex& b,
                       double first, double last) {
  builder_.Add(edge, a.Oriented(TopAbs_FORWARD));
  builder_.Add(edge, b.Oriented(TopAbs_REVERSED));
  builder_.Range(edge, first, last);
  builder_.SameRange(edge, true);
  builder_.SameParameter(edge, true);
}

// Edges of a loop; the vertices at which it begins and ends are the same.
std::vector<TopoDS_Edge> FaceMaker::edges(const FaceLoop& loop) {
  const size_t n = loop.size();
  std::vector<TopoDS_Vertex> vertices;
  for (size_t k = 0; k < n; ++k) vertices.push_back(vertex(loop[(k + n - 1) % n], loop[k]));
  std::vector<TopoDS_Edge> result;
  for (size_t k = 0; k < n; ++k)
    result.push_back(edge(loop[k], vertices[k], vertices[(k + 1) % n]));
  return result;
}

void FaceMaker::add_wire(const FaceLoop& loop) {
  TopoDS_Wire wire;
  builder_.MakeWire(wire);
  for (const TopoDS_Edge& e : edges(loop)) builder_.Add(wire, e);
  wire.Closed(true);
  builder_.Add(face_, wire);
}

void FaceMaker::add_ring() {
  const auto low = edges(boundary_.loops[0]), high = edges(boundary_.loops[1]);
  const Vec2 from = boundary_.loops[0].front().first();
  const Vec2 to = boundary_.loops[1].back().last();
  const auto line = [&](double u) {
    TColgp_Array1OfPnt2d poles(1, 2);
    TColStd_Array1OfReal values(1, 2);
    TColStd_Array1OfInteger times(1, 2);
    poles(1) = {u, values(1) = from.y()};
    poles(2) = {u, values(2) = to.y()};
    times.Init(2);
    return new Geom2d_BSplineCurve(poles, values, times, 1);
  };
  const double left = boundary_.seam, right = left + boundary_.period;
  const TopoDS_Vertex a = TopExp::FirstVertex(low.front(), true),
                      b = TopExp::FirstVertex(high.front(), true);
  const Handle(Geom_Curve) curve = surface_->UIso(left);
  double distance = std::max(curve->Value(from.y()).Distance(BRep_Tool::Pnt(a)),
                             curve->Value(to.y()).Distance(BRep_Tool::Pnt(b)));
  TopoDS_Edge seam;
  builder_.MakeEdge(seam, curve, widened(0));
  // The loop meets the seam on the right side first, and runs forward along it there.
  builder_.UpdateEdge(seam, line(right), line(left), face_, widened(0));
  widened(distance);
  finish(seam, a, b, from.y(), to.y());
  TopoDS_Wire wire;
  builder_.MakeWire(wire);
  for (const TopoDS_Edge& e : low) builder_.Add(wire, e);
  builder_.Add(wire, seam.Oriented(TopAbs_FORWARD));
  for (const TopoDS_Edge& e : high) builder_.Add(wire, e);
  builder_.Add(wire, seam.Oriented(TopAbs_REVERSED));
  wire.Closed(true);
  builder_.Add(face_, wire);
}

}  // namespace batten
