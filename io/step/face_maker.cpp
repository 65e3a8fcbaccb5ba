// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/face_maker.h"

#include <Approx_CurveOnSurface.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Line.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/fem/curves/bspline.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/cad/occ_settings.h"

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
    for (const FaceBoundarySegment& segment : loop) box.extend(box_of(segment.curve));
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

/// The same spline reparametrised to [first, last].
CubicSpline over(CubicSpline spline, double first, double last) {
  const double from = spline.knots.front(), to = spline.knots.back();
  for (double& k : spline.knots) k = first + (k - from) / (to - from) * (last - first);
  spline.knots.back() = last;
  return spline;
}

/// The curve S(l(t)) on a surface along a pcurve, approximated within `tolerance`, and then
/// translated by `location`.
Handle(Geom_BSplineCurve)
    curve_on_surface(const Handle(Geom_Surface) & surface, const Handle(Geom2d_BSplineCurve) & line,
                     double tolerance, const gp_Pnt& location) {
  const double first = line->FirstParameter(), last = line->LastParameter();
  Approx_CurveOnSurface found(new Geom2dAdaptor_Curve(line), new GeomAdaptor_Surface(surface),
                              first, last, tolerance);
  constexpr int max_segments = 10'000, degree = 8;
  found.Perform(max_segments, degree, GeomAbs_C1, true);
  if (!found.HasResult())
    throw Error("STEP: OpenCASCADE finds no curve along the boundary of a face");
  const Handle(Geom_BSplineCurve) curve = found.Curve3d();
  curve->Translate(gp_Pnt(), location);
  return curve;
}

Vec3 end_of(const HermiteCurve& curve) { return curve.evaluate({curve.segment_count() - 1, 1.0}); }

}  // namespace

// ---- shared edges and vertices --------------------------------------------------------------

int SharedEdges::cut_of(const FaceBoundarySegment& segment, bool end) const {
  const double at = segment.line_parameter(end ? segment.curve.end() : segment.curve.start());
  const double other = segment.line_parameter(end ? segment.curve.start() : segment.curve.end());
  const double hair = 1e-6 * std::abs(at - other);
  int cuts = 0;
  for (const double cut : plan_.lines.at(segment.line).cuts)
    if (++cuts; std::abs(cut - at) <= hair) return cuts;
  return at > other ? cuts + 1 : 0;
}

TopoDS_Vertex& SharedEdges::vertex(const std::string& name, int cut) {
  const StepLine& line = plan_.lines.at(name);
  const int last = isize(line.cuts) + 1;
  if (cut == 0 || cut == last) return end_points_[line.places[cut == last]];
  return vertices_[{name, cut}];
}

TopoDS_Vertex& SharedEdges::vertex(const FaceBoundarySegment& segment, bool end) {
  return vertex(segment.line, cut_of(segment, end));
}
TopoDS_Edge& SharedEdges::edge(const FaceBoundarySegment& segment) {
  return edge(segment.line, std::max(cut_of(segment, false), cut_of(segment, true)));
}

std::vector<CadCurveItem> SharedEdges::along_lines() const {
  std::vector<CadCurveItem> result;
  for (const auto& [location, edge] : edges_)
    if (!edge.IsNull()) result.push_back({edge, location.first, ""});
  return result;
}

// ---- one model face ------------------------------------------------------------------------

FaceMaker::FaceMaker(const SkinnedRegion& region, const StepFaceOptions& options,
                     const StepPlan* common, const AnalyticFace* analytic)
    : region_(region),
      options_(options),
      boundary_(
          region, common,
          analytic ? FaceBoundary::AnnulusBoundary::Whole : FaceBoundary::AnnulusBoundary::AtSeam),
      middle_(middle(boundary_)),
      near_origin_(moved_by(region.surface, -middle_)),
      analytic_(analytic) {
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceBoundarySegment& segment : loop) box_.extend(box_of(segment.curve));
  size_ = box_.diagonal().norm();
  // The tangent planes on both sides may miss the common one in any direction, so the errors add
  // up.
  goal_ = {0.9 * options.tolerance, 0.4 * options.join_deg};
}

Vec3 FaceMaker::position(const Vec2& uv) const {
  return near_origin_.position(boundary_.domain_point(uv)) + middle_;
}

Vec3 FaceMaker::normal(const Vec2& uv) const {
  return near_origin_.surface().jet(near_origin_.locate(boundary_.domain_point(uv))).normal();
}

int FaceMaker::cells() const {
  constexpr int of_analytic = 64;
  return analytic_ ? of_analytic : fit_.patch.u.intervals() * fit_.patch.v.intervals();
}

Vec3 FaceMaker::fitted_position(const Vec2& uv) const {
  if (!analytic_) return fit_.patch.position(uv) + middle_;
  const Vec3 p = position(uv);
  return analytic_->surface.position(analytic_->surface.parameters(p, analytic_->near));
}

Vec3 FaceMaker::fitted_normal(const Vec2& uv) const {
  return analytic_ ? analytic_->surface.shape().normal(position(uv)) : fit_.patch.normal(uv);
}

TopoDS_Face FaceMaker::make(double coincidence, SharedEdges* shared) {
  coincidence_ = coincidence;
  shared_ = shared;
  used_.clear();
  along_lines_.clear();
  if (analytic_) {
    make_analytic();
    return face_;
  }
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
  surface_ = Handle(Geom_Surface)::DownCast(
      surface_near_origin_->Translated(gp_Vec(gp_Pnt(), to_occ(middle_))));
  widest_ = 1e-9 * size_;
  builder_.MakeFace(face_, surface_, widest_);

  if (boundary_.period > 0) {
    add_annulus();
  } else {
    add_wire(boundary_.loops[0]);
  }
  for (size_t k = boundary_.period > 0 ? 2 : 1; k < boundary_.loops.size(); ++k)
    add_wire(boundary_.loops[k]);
  return face_;
}

double FaceMaker::widened(double distance) {
  // The distance may be slightly larger between the samples.
  const double tolerance = std::max(1e-9 * size_, 1.02 * distance);
  widest_ = std::max(widest_, tolerance);
  return tolerance;
}

// The vertex between two segments: the end of `before` and the start of `after`.
TopoDS_Vertex FaceMaker::vertex(const FaceBoundarySegment& before,
                                const FaceBoundarySegment& after) {
  const bool of_lines = before.shared || after.shared;
  const Vec2 first = after.first();
  const auto on_surface = [&](const Vec2& uv, const Vec3& x) {
    return analytic_
               ? analytic_->surface.position(analytic_->surface.parameters(x, analytic_->near))
               : from_occ(surface_->Value(uv.x(), uv.y()));
  };
  const Vec3 start = after.curve.position(0), end = end_of(before.curve);
  const Vec3 p = of_lines ? start : on_surface(first, start);
  double distance = of_lines ? (p - end).norm() : 0;
  distance = std::max({distance, (on_surface(before.last(), end) - p).norm(),
                       (on_surface(first, start) - p).norm()});
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

// The edge of a segment, oriented along the loop. A shared edge that is made here runs along its
// curve.
TopoDS_Edge FaceMaker::edge(const FaceBoundarySegment& segment, const TopoDS_Vertex& a,
                            const TopoDS_Vertex& b) {
  bool reversed = shared_ && segment.reversed;
  const auto along = [&](const HermiteCurve& curve) {
    return cubic_splines("", reversed ? curve.backwards() : curve).front();
  };
  TopoDS_Edge mine;
  TopoDS_Edge* result = &mine;
  if (shared_) {
    result = &shared_->edge(segment);
    // A curve with one face on both sides becomes two edges, because readers do not agree about
    // slits.
    if (!result->IsNull() && used_.count(result->TShape().get())) result = &mine;
    if (!result->IsNull() && result->Orientation() == TopAbs_REVERSED) reversed = !reversed;
  }
  const CubicSpline plane = along(segment.pcurve);
  const auto pcurve = [&](const Geom_Curve& curve, double first, double last) {
    return analytic_ ? analytic_pcurve(segment, curve, first, last, reversed)
                     : to_flat_occ(over(plane, first, last));
  };
  Handle(Geom2d_BSplineCurve) own_pcurve;
  if (result->IsNull()) {
    Handle(Geom_BSplineCurve) curve = to_occ(along(segment.curve));
    if (!segment.shared && analytic_) {
      own_pcurve = pcurve(*curve, curve->FirstParameter(), curve->LastParameter());
      curve = curve_on_surface(surface_, own_pcurve, 0.3 * coincidence_, gp_Pnt());
    } else if (!segment.shared) {
      curve = curve_on_surface(surface_near_origin_, to_flat_occ(plane), 0.3 * coincidence_,
                               to_occ(middle_));
    }
    builder_.MakeEdge(*result, curve, widened(0));
    finish(*result, reversed ? b : a, reversed ? a : b, curve->FirstParameter(),
           curve->LastParameter());
  }
  double first, last;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(*result, first, last);
  const Handle(Geom2d_BSplineCurve) line =
      own_pcurve.IsNull() ? pcurve(*curve, first, last) : own_pcurve;

  double distance = 0;
  const int of_curve = static_cast<int>(segment.curve.segment_count()) + 1;
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
  along_lines_.push_back({*result, segment.line, ""});
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

// The edges of a closed loop.
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

void FaceMaker::add_annulus() {
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
  // The loop meets the seam on the right side first, and traverses it forward there.
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

// ---- an analytic face ------------------------------------------------------------------------

void FaceMaker::make_analytic() {
  using Closing = AnalyticFace::Closing;
  surface_ = analytic_->surface.geometry();
  widest_ = 1e-9 * size_;
  builder_.MakeFace(face_, surface_, widest_);
  // A face lies to the left of its wires, seen against the normal of the surface.
  struct BoundaryCircle {
    std::vector<TopoDS_Edge> edges;
    Vec2 start = Vec2::Zero();
    TopoDS_Vertex vertex() const { return TopExp::FirstVertex(edges.front(), true); }
  };
  const auto wire_of = [&](const std::vector<TopoDS_Edge>& edges) {
    TopoDS_Wire wire;
    builder_.MakeWire(wire);
    for (const TopoDS_Edge& e : edges) builder_.Add(wire, e);
    wire.Closed(true);
    return wire;
  };
  // By winding number as seen from the surface's normal.
  std::map<int, BoundaryCircle> boundary_circles;
  std::vector<TopoDS_Wire> holes;
  for (size_t k = 0; k < boundary_.loops.size(); ++k) {
    const int winding = analytic_->winding[k];
    std::vector<TopoDS_Edge> edges = analytic_edges(boundary_.loops[k], winding);
    const Vec2 start = pcurve_ends_.front()[0];
    if (analytic_->flipped) {
      std::reverse(edges.begin(), edges.end());
      for (TopoDS_Edge& e : edges) e.Reverse();
    }
    if (winding == 0)
      holes.push_back(wire_of(edges));
    else
      boundary_circles[analytic_->flipped ? -winding : winding] = {edges, start};
  }
  constexpr double whole = 2 * std::numbers::pi;
  std::vector<TopoDS_Edge> outer;
  const auto add = [&](const std::vector<TopoDS_Edge>& edges) {
    outer.insert(outer.end(), edges.begin(), edges.end());
  };
  if (analytic_->closing == Closing::Pole) {
    const BoundaryCircle& circle = boundary_circles.at(1);
    const auto sphere = analytic_->surface.shape();
    TopoDS_Vertex pole;
    builder_.MakeVertex(pole, to_occ(Vec3(sphere.origin + sphere.radius * sphere.axis)), widest_);
    const double north = std::numbers::pi / 2;
    const TopoDS_Edge seam = analytic_seam(circle.vertex(), pole, {0, circle.start.y()}, north);
    TopoDS_Edge point = degenerate_edge(pole, {0, north}, {whole, north});
    add(circle.edges);
    add({TopoDS::Edge(seam.Oriented(TopAbs_FORWARD)), TopoDS::Edge(point.Oriented(TopAbs_REVERSED)),
         TopoDS::Edge(seam.Oriented(TopAbs_REVERSED))});
  } else if (analytic_->closing != Closing::None) {
    // Around u: along the lower circle, up the seam, back along the upper circle, down the seam.
    // Around v (tube of a torus): the same, beginning with the circle at the larger u.
    const bool around_u = analytic_->closing == Closing::AroundU;
    const BoundaryCircle &low = boundary_circles.at(around_u ? 1 : -1),
                         &high = boundary_circles.at(around_u ? -1 : 1);
    const TopoDS_Edge seam =
        around_u ? analytic_seam(low.vertex(), high.vertex(), {0, low.start.y()}, high.start.y())
                 : analytic_seam(low.vertex(), high.vertex(), {low.start.x(), analytic_->seam},
                                 high.start.x());
    const TopoDS_Edge up = TopoDS::Edge(seam.Oriented(TopAbs_FORWARD)),
                      down = TopoDS::Edge(seam.Oriented(TopAbs_REVERSED));
    add(low.edges);
    add({up});
    add(high.edges);
    add({down});
  }
  if (!outer.empty()) builder_.Add(face_, wire_of(outer));
  for (const TopoDS_Wire& wire : holes) builder_.Add(face_, wire);
  if (analytic_->flipped) face_.Reverse();
}

Handle(Geom2d_BSplineCurve) FaceMaker::analytic_pcurve(const FaceBoundarySegment&,
                                                       const Geom_Curve& curve, double first,
                                                       double last, bool reversed) {
  // Small compared with the tolerance by which the edge misses the surface; finer pcurves would
  // make large files.
  const double tolerance = std::max(0.2 * coincidence_, 1e-3 * options_.tolerance);
  const Handle(Geom2d_BSplineCurve) pcurve =
      analytic_->surface.pcurve(curve, first, last, reversed, tolerance, near_);
  const gp_Pnt2d begin = pcurve->Value(reversed ? last : first);
  pcurve_ends_.push_back({Vec2(begin.X(), begin.Y()), near_});
  return pcurve;
}

// The edges of a loop of an analytic face. A loop that winds around starts at the seam. A loop that
// passes an apex gets a degenerate edge there.
std::vector<TopoDS_Edge> FaceMaker::analytic_edges(FaceLoop loop, int winding) {
  near_ = analytic_->near;
  if (winding != 0) {
    std::rotate(loop.begin(), loop.begin() + static_cast<long>(analytic_->seam_segment(loop)),
                loop.end());
    const double seam = analytic_->seam + (winding < 0 ? 2 * std::numbers::pi : 0);
    (analytic_->closing == AnalyticFace::Closing::AroundV ? near_.y() : near_.x()) = seam;
  }
  const size_t n = loop.size();
  std::vector<TopoDS_Vertex> vertices;
  for (size_t k = 0; k < n; ++k) vertices.push_back(vertex(loop[(k + n - 1) % n], loop[k]));
  std::vector<TopoDS_Edge> result;
  std::vector<std::array<Vec2, 2>> ends;
  const double at_apex = 1e-6 * size_;
  for (size_t k = 0; k < n; ++k) {
    const bool from_apex = analytic_->surface.singular(loop[k].curve.position(0), at_apex);
    if (from_apex && winding == 0) near_ = analytic_->near;
    pcurve_ends_.clear();
    const TopoDS_Edge next = edge(loop[k], vertices[k], vertices[(k + 1) % n]);
    ends.push_back(pcurve_ends_.back());
    if (from_apex && k > 0 && std::abs(ends[k - 1][1].x() - ends[k][0].x()) > 1e-9)
      result.push_back(degenerate_edge(vertices[k], ends[k - 1][1], ends[k][0]));
    result.push_back(next);
  }
  if (winding == 0 && analytic_->surface.singular(loop[0].curve.position(0), at_apex))
    result.push_back(degenerate_edge(vertices[0], ends.back()[1], ends.front()[0]));
  pcurve_ends_ = ends;
  return result;
}

namespace {

Handle(Geom2d_BSplineCurve)
    straight_pcurve(const Vec2& from, const Vec2& to, double first, double last) {
  TColgp_Array1OfPnt2d poles(1, 2);
  TColStd_Array1OfReal values(1, 2);
  TColStd_Array1OfInteger times(1, 2);
  poles(1) = {from.x(), from.y()};
  poles(2) = {to.x(), to.y()};
  values(1) = first;
  values(2) = last;
  times.Init(2);
  return new Geom2d_BSplineCurve(poles, values, times, 1);
}

}  // namespace

TopoDS_Edge FaceMaker::degenerate_edge(const TopoDS_Vertex& at, const Vec2& from, const Vec2& to) {
  TopoDS_Edge edge;
  builder_.MakeEdge(edge);
  builder_.UpdateEdge(edge, straight_pcurve(from, to, 0, 1), face_, widened(0));
  builder_.Add(edge, at.Oriented(TopAbs_FORWARD));
  builder_.Add(edge, at.Oriented(TopAbs_REVERSED));
  builder_.Range(edge, face_, 0, 1);
  builder_.Degenerated(edge, true);
  return edge;
}

// The seam from vertex `a`, with parameters `from`, to vertex `b`, where the other parameter is
// `to`.
TopoDS_Edge FaceMaker::analytic_seam(const TopoDS_Vertex& a, const TopoDS_Vertex& b,
                                     const Vec2& from, double to) {
  constexpr double whole = 2 * std::numbers::pi;
  const bool around_u = analytic_->closing != AnalyticFace::Closing::AroundV;
  Handle(Geom_Curve) line = around_u ? surface_->UIso(from.x()) : surface_->VIso(from.y());
  const double low = around_u ? from.y() : from.x();
  if (!(to > low))
    throw Error("face '" + region_.name +
                "': the boundary loops of its STEP face are in the wrong order");
  const Vec3 p = from_occ(BRep_Tool::Pnt(a)), q = from_occ(BRep_Tool::Pnt(b));
  const Vec3 off_p = p - from_occ(line->Value(low)), off_q = q - from_occ(line->Value(to));
  double first = low, last = to, tolerance = std::max(off_p.norm(), off_q.norm());
  if (tolerance > coincidence_) {
    // Let the seam pass through the vertices. Otherwise it would meet the neighbouring faces
    // outside the tolerance of the vertices.
    if (!Handle(Geom_Line)::DownCast(line).IsNull()) {
      first = 0;
      last = (q - p).norm();
      line = new Geom_Line(to_occ(p), gp_Dir(to_occ(q - p).XYZ()));
    } else {
      constexpr int pieces = 64;  // per circular arc: accurate to 1e-9 of the radius
      std::vector<double> t;
      Points x(pieces + 1, 3), slopes(pieces + 1, 3);
      for (int k = 0; k <= pieces; ++k) {
        const double s = double(k) / pieces;
        t.push_back(k < pieces ? low + s * (to - low) : to);
        gp_Pnt on_line;
        gp_Vec slope;
        line->D1(t.back(), on_line, slope);
        x.row(k) = from_occ(on_line) + (1 - s) * off_p + s * off_q;
        slopes.row(k) = from_occ(slope.XYZ()) + (off_q - off_p) / (to - low);
      }
      line = to_occ(cubic_splines("", HermiteCurve(t, x, slopes)).front());
    }
  } else {
    tolerance = 0;
  }
  const auto pcurve = [&](double at) {
    return around_u ? straight_pcurve({at, low}, {at, to}, first, last)
                    : straight_pcurve({low, at}, {to, at}, first, last);
  };
  const double seam = around_u ? from.x() : from.y();
  TopoDS_Edge edge;
  builder_.MakeEdge(edge, line, widened(tolerance));
  if (around_u)
    builder_.UpdateEdge(edge, pcurve(seam + whole), pcurve(seam), face_, widened(0));
  else
    builder_.UpdateEdge(edge, pcurve(seam), pcurve(seam + whole), face_, widened(0));
  finish(edge, a, b, first, last);
  return edge;
}

// The fit of a FaceMaker: its target, its tangent planes along joins, and the effort spent on them.

namespace {

/// Parameters along an arc, at the middle of consecutive steps. No step is longer than `longest` at
/// its start.
std::vector<double> parameters_along(const PlanarCubic& arc, const BoundaryStep& longest) {
  Vec2 fastest = Vec2::Zero();  // upper bound of |dc/dt|
  for (const size_t k : {0, 1, 2})
    fastest = fastest.cwiseMax(3 * (arc.b[k + 1] - arc.b[k]).cwiseAbs());
  std::vector<double> sample_parameters;
  for (double t = 0; t < 1;) {
    const double steps = fastest.cwiseQuotient(longest(arc.at(t))).maxCoeff();
    const double next = std::min(t + 1 / steps, 1.0);
    sample_parameters.push_back((t + next) / 2);
    t = next;
  }
  return sample_parameters;
}

}  // namespace

bool FaceMaker::refine(double deviation, double angle_deg) {
  if (analytic_ || !fit_.reached || !std::isfinite(deviation)) return false;
  const bool far = deviation > options_.tolerance;
  constexpr int most_failures = 2;
  const bool askew = angle_deg > options_.join_deg && goal_.angle_deg < options_.join_deg &&
                     failed_angles_ < most_failures;
  if (!far && !askew) return false;
  const PatchFit before = fit_;
  // The error lies between the samples of the fit, so tighten the goals in proportion to the
  // measured excess.
  constexpr double at_once = 0.02;
  const auto tighten = [](double& goal, double requested) {
    goal = std::max(std::min(goal, requested), at_once * goal);
  };
  if (far) tighten(goal_.deviation, 0.9 * options_.tolerance / deviation * before.deviation);
  if (askew) tighten(goal_.angle_deg, 0.9 * options_.join_deg / angle_deg * before.angle_deg);
  constexpr int most_steps = 3;
  for (int i = 0; i < most_steps; ++i) {
    const double asked = goal_.angle_deg;
    fit(&before.patch);
    if (!fit_.reached) break;
    const bool nearer = (!far || fit_.deviation < before.deviation) &&
                        (!askew || fit_.angle_deg < before.angle_deg);
    if (nearer && fit_.patch.poles.rows() > before.patch.poles.rows()) return true;
    if (goal_.angle_deg > asked) break;  // out of reach
    if (far) goal_.deviation *= 0.8;
    if (askew) goal_.angle_deg *= 0.8;
  }
  fit_ = before;
  if (askew) ++failed_angles_;
  return false;
}

std::vector<PatchTangent> FaceMaker::tangents(const BoundaryStep& longest) const {
  std::vector<PatchTangent> found;
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceBoundarySegment& segment : loop) {
      if (segment.normal_corrections.empty()) continue;
      const auto arcs = planar_cubics(segment.pcurve);
      for (size_t k = 0; k < arcs.size(); ++k) {
        for (const double s : parameters_along(arcs[k], longest)) {
          const double t = segment.pcurve.parameters()[k] +
                           s * segment.pcurve.mesh().length(static_cast<int>(k));
          const auto normal_correction = segment.normal_correction(t);
          if (!normal_correction) continue;
          const Vec2 uv = arcs[k].at(s);
          const SurfaceJet jet =
              near_origin_.surface().jet(near_origin_.locate(boundary_.domain_point(uv)));
          // Near a degenerate corner the tangent planes rotate without limit.
          if (!(jet.area_vector().norm() > 1e-3 * jet.x_u.norm() * jet.x_v.norm())) continue;
          const Vec3 n_both = (jet.normal() + *normal_correction).normalized();
          const Mat2 J = boundary_.to_domain ? boundary_.to_domain->jacobian(uv) : Mat2::Identity();
          const Vec3 x_u = J(0, 0) * jet.x_u + J(1, 0) * jet.x_v,
                     x_v = J(0, 1) * jet.x_u + J(1, 1) * jet.x_v;
          found.push_back({uv, x_u - n_both.dot(x_u) * n_both, x_v - n_both.dot(x_v) * n_both});
        }
      }
    }
  return found;
}

PatchTarget FaceMaker::target() const {
  PatchTarget target;
  target.inside = [&](const Vec2& uv) { return boundary_.contains(uv); };
  target.position = [&](const Vec2& uv) {
    return near_origin_.position(boundary_.domain_point(uv));
  };
  target.boundary = [&](const BoundaryStep& longest) {
    std::vector<Vec2> points;
    for (const FaceLoop& loop : boundary_.loops)
      for (const FaceBoundarySegment& segment : loop)
        for (const PlanarCubic& arc : planar_cubics(segment.pcurve)) {
          for (const double s : parameters_along(arc, longest)) points.push_back(arc.at(s));
          points.push_back(arc.b[3]);
        }
    return points;
  };
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceBoundarySegment& segment : loop) target.fixed.push_back(segment.first());
  target.low = boundary_.domain.low();
  target.high = boundary_.domain.high();
  target.periodic = boundary_.period > 0;
  if (target.periodic) {
    target.low.x() = boundary_.seam;
    target.high.x() = boundary_.seam + boundary_.period;
  }
  return target;
}

void FaceMaker::fit() { fit(nullptr); }

void FaceMaker::fit(const BicubicPatch* start) {
  PatchTarget target = this->target();
  constexpr int few = 6'000;
  const int triangles = region_.surface.mesh().triangle_count();
  const int in_proportion = std::max(few, options_.max_poles_per_triangle * triangles);
  // A cell of the first fit holds up to eight triangles.
  const int first = std::clamp(static_cast<int>(std::lround(std::sqrt(triangles / 8.0))), 2, 8);
  const PatchLimits limits{options_.max_poles, std::min(options_.max_poles_total, in_proportion),
                           first};
  bool tangent = false;
  for (const FaceLoop& loop : boundary_.loops)
    for (const FaceBoundarySegment& segment : loop)
      tangent = tangent || !segment.normal_corrections.empty();
  if (tangent) {
    // A few poles per triangle follow the surface that the elements approximate; more would follow
    // their kinks.
    constexpr int fewest = 3'000, a_triangle = 8;
    PatchLimits for_angle = limits;
    for_angle.max_poles = std::min(
        limits.max_poles, std::max({fewest, a_triangle * triangles,
                                    start ? static_cast<int>(2 * start->poles.rows()) : 0}));
    target.tangents = [&](const BoundaryStep& longest) { return tangents(longest); };
    fit_ = fit_bicubic_patch(target, goal_, for_angle, start);
    if (!fit_.reached && fit_.deviation > goal_.deviation) {
      // First find the knots that the deviation alone needs; from there the angle may be within
      // reach.
      fit_ = fit_bicubic_patch(target, {goal_.deviation}, limits, start);
      for_angle.max_poles =
          std::max(for_angle.max_poles, static_cast<int>(4 * fit_.patch.poles.rows()));
      const PatchFit nearer = fit_bicubic_patch(target, goal_, for_angle, &fit_.patch);
      if (nearer.deviation <= goal_.deviation && nearer.angle_deg < fit_.angle_deg) fit_ = nearer;
    }
    if (fit_.deviation <= goal_.deviation) {
      goal_.angle_deg = std::max(goal_.angle_deg, 1.05 * fit_.angle_deg);
      fit_.reached = true;
      return;
    }
    target.tangents = nullptr;
    goal_.angle_deg = PatchGoal{}.angle_deg;
  }
  fit_ = fit_bicubic_patch(target, {goal_.deviation}, limits, start);
}

}  // namespace batten
