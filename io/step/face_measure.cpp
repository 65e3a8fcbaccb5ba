// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/face_measure.h"

#include <BRepGProp.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_Curve.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "batten/io/cad/occ_settings.h"
#include "batten/io/step/step_check.h"

namespace batten {
namespace {

/// An edge of the file, parametrised along the loop.
struct FileEdge {
  Handle(Geom_Curve) curve;
  Handle(Geom2d_Curve) line;
  double first, last;
  bool backwards;     // true if it runs against the loop
  double weight = 1;  // see parameter_weight()
  /// The parameter that corresponds to a fraction of the edge's original parameter range.
  double at(double fraction) const {
    return first +
           reparametrized_fraction(backwards ? 1 - fraction : fraction, weight) * (last - first);
  }
};

/// The edges of a face of the file, without seams. `gap`: the largest distance of any edge from the
/// face and from its vertices.
struct FileEdges {
  std::vector<FileEdge> edges;
  double gap = 0;
};

/// Reads the edges of a face; nullopt if one of them has no curve.
std::optional<FileEdges> edges_of_face(const TopoDS_Face& face, const Geom_Surface& surface,
                                       int knots) {
  FileEdges found;
  double& gap = found.gap;
  for (TopExp_Explorer it(face.Oriented(TopAbs_FORWARD), TopAbs_EDGE); it.More(); it.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
    FileEdge e{};
    e.backwards = edge.Orientation() != face.Orientation();
    double first, last;
    e.curve = BRep_Tool::Curve(edge, e.first, e.last);
    e.line = BRep_Tool::CurveOnSurface(edge, face, first, last);
    // Readers insert degenerate edges where curves meet at a tangent.
    if (BRep_Tool::Degenerated(edge)) continue;
    if (e.curve.IsNull() || e.line.IsNull()) return std::nullopt;
    e.weight = parameter_weight(*e.curve);
    const int n = 4 * knots;
    for (int i = 0; i <= n; ++i) {
      const double t = e.at(double(i) / n);
      const gp_Pnt2d uv = e.line->Value(t);
      gap = std::max(gap, e.curve->Value(t).Distance(surface.Value(uv.X(), uv.Y())));
    }
    TopoDS_Vertex a, b;
    TopExp::Vertices(edge, a, b);
    if (!a.IsNull()) gap = std::max(gap, BRep_Tool::Pnt(a).Distance(e.curve->Value(e.first)));
    if (!b.IsNull()) gap = std::max(gap, BRep_Tool::Pnt(b).Distance(e.curve->Value(e.last)));
    if (!BRep_Tool::IsClosed(edge, face)) found.edges.push_back(e);
  }
  return found;
}

/// Sample points inside the trim of the file's face, by its knot cells. (Close to the boundary, the
/// model face's own loops decide whether a point is inside. They are much faster, and the distance
/// between the two boundaries is measured elsewhere.)
std::vector<Vec2> points_of_face(const TopoDS_Face& face, const Geom_BSplineSurface& surface,
                                 const std::vector<FileEdge>& edges, const FaceMaker& made) {
  std::vector<double> u, v;
  for (int i = 1; i <= surface.NbUKnots(); ++i) u.push_back(surface.UKnot(i));
  for (int j = 1; j <= surface.NbVKnots(); ++j) v.push_back(surface.VKnot(j));
  KnotCells cells(u, v);
  for (const FileEdge& e : edges) {
    const int n = 8 * (surface.NbUKnots() + surface.NbVKnots());
    gp_Pnt2d before = e.line->Value(e.at(0));
    for (int i = 1; i <= n; ++i) {
      const gp_Pnt2d here = e.line->Value(e.at(double(i) / n));
      cells.pass({before.X(), before.Y()}, {here.X(), here.Y()});
      before = here;
    }
  }
  BRepTopAdaptor_FClass2d classifier(face, 1e-9);
  return cells.points([&](const Vec2& uv) { return made.boundary().contains(uv); },
                      [&](const Vec2& uv) {
                        return classifier.Perform({uv.x(), uv.y()}) == TopAbs_IN;
                      });
}

/// Distance of an edge of the file from the curve, at the same fraction of the parameter. If no
/// other model face has the curve, the distance from the model face's own boundary.
double apart(const FileEdge& e, const FaceBoundarySegment& segment, double fraction,
             const FaceMaker& made) {
  const double start = segment.curve.start(), end = segment.curve.end();
  const double t = fraction < 1 ? start + fraction * (end - start) : end;
  const Vec3 p = from_occ(e.curve->Value(e.at(fraction)));
  return (p - (segment.shared ? segment.curve.evaluate(t) : made.position(segment.uv(t)))).norm();
}

/// The index of the unused file edge that is closest to a boundary segment; edges.size() if all are
/// used.
size_t nearest_edge(const std::vector<FileEdge>& edges, const std::vector<char>& used,
                    const FaceBoundarySegment& segment, const FaceMaker& made) {
  size_t mine = edges.size();
  double nearest = kInfinity;
  for (size_t k = 0; k < edges.size(); ++k) {
    double distance = 0;
    for (const double fraction : {0.1, 0.3, 0.5, 0.7, 0.9})
      distance = std::max(distance, apart(edges[k], segment, fraction, made));
    if (used[k] || distance >= nearest) continue;
    nearest = distance;
    mine = k;
  }
  return mine;
}

/// Measures a boundary segment against its file edge at n + 1 points, and adds these to `points`.
void measure_segment(const FaceBoundarySegment& segment, const FileEdge& edge, int n,
                     const FaceMaker& made, StepPatch& report, std::vector<Vec2>& points) {
  const double start = segment.curve.start(), end = segment.curve.end();
  for (int i = 0; i <= n; ++i) {
    const double fraction = double(i) / n, t = start + fraction * (end - start);
    report.edge_deviation = std::max(report.edge_deviation, apart(edge, segment, fraction, made));
    const Vec2 uv = i < n ? segment.uv(t) : segment.last();
    points.push_back(uv);
    const Vec3 x = i < n ? segment.curve.evaluate(t)
                         : segment.curve.evaluate({segment.curve.segment_count() - 1, 1.0});
    report.line_gap = std::max(report.line_gap, (made.position(uv) - x).norm());
    if (made.analytic()) continue;
    const gp_Pnt2d of_file = edge.line->Value(edge.at(fraction));
    points.emplace_back(of_file.X(), of_file.Y());
  }
}

/// The normals along a segment with normal corrections, in the direction of its curve. `of_face`
/// returns the normal of the face, given the fraction of the segment and (u, v).
template <class Function>
JoinNormals normals_along(const FaceBoundarySegment& segment, const FaceMaker& made,
                          const Function& of_face) {
  JoinNormals found;
  found.region = made.region().name;
  constexpr int pieces = 400;  // a face has no more knots in a direction
  const double start = segment.curve.start(), end = segment.curve.end();
  for (int k = 0; k <= pieces; ++k) {
    const double fraction = double(segment.reversed ? pieces - k : k) / pieces;
    const double t = start + fraction * (end - start);
    const auto normal_correction = segment.normal_correction(t);
    const Vec2 uv = fraction < 1 ? segment.uv(t) : segment.last();
    const Vec3 n = normal_correction ? made.normal(uv) : Vec3::Zero();
    found.of_face.push_back(n.isZero() ? n : of_face(fraction, uv));
    found.of_surface.push_back(n);
    found.target_normals.push_back(n.isZero() ? n : n + *normal_correction);
  }
  return found;
}

template <class Function>
FaceNormals normals_along_joins(const FaceMaker& made, const StepPlan& plan,
                                const Function& of_face) {
  FaceNormals normals;
  for (const FaceLoop& loop : made.boundary().loops)
    for (const FaceBoundarySegment& segment : loop)
      if (!segment.normal_corrections.empty())
        normals[segment_id_of(plan, segment)] =
            normals_along(segment, made, [&](double, const Vec2& uv) { return of_face(uv); });
  return normals;
}

/// The normal of the file's face; zero if it is singular.
Vec3 normal_of_file(const FileEdge& edge, const Geom_Surface& surface, double fraction) {
  const gp_Pnt2d uv = edge.line->Value(edge.at(fraction));
  gp_Pnt p;
  gp_Vec du, dv;
  surface.D1(uv.X(), uv.Y(), p, du, dv);
  const gp_Vec across = du.Crossed(dv);
  const bool flat = across.Magnitude() > 1e-3 * du.Magnitude() * dv.Magnitude();
  return flat ? Vec3(across.X(), across.Y(), across.Z()) : Vec3(Vec3::Zero());
}

/// Angles at one point of a join, degrees.
struct JoinAngles {
  double of_faces, of_surfaces;
  /// Only points where the surfaces themselves meet within `join_deg` count: faces close to them
  /// cannot do better.
  bool exceeds_tolerance(double join_deg) const {
    return of_faces > join_deg && of_surfaces <= join_deg;
  }
};

/// The faces adjacent to a piece of a curve, by index.
struct JoinSides {
  std::array<size_t, 2> faces{};
  std::array<const JoinNormals*, 2> normals{};  // null: no fitted face on that side

  /// nullopt if a side has no normal.
  std::optional<JoinAngles> angles(size_t k) const {
    const auto& [one, other] = normals;
    const Vec3& n = other ? other->of_face[k] : one->target_normals[k];
    if (one->of_face[k].isZero() || n.isZero()) return std::nullopt;
    return JoinAngles{angle_between_planes(one->of_face[k], n),
                      other ? angle_between_planes(one->of_surface[k], other->of_surface[k]) : 0.0};
  }
  /// Angle between a side's face and the common target normal, degrees; 0 if that side has no
  /// fitted face.
  double angle_from_target(size_t side, size_t k) const {
    const JoinNormals* normals = this->normals[side];
    return normals ? angle_between_planes(normals->of_face[k], normals->target_normals[k]) : 0;
  }
};

std::map<LineSegmentId, JoinSides> sides_of(const std::vector<FaceNormals>& faces) {
  std::map<LineSegmentId, JoinSides> sides;
  for (size_t face = 0; face < faces.size(); ++face)
    for (const auto& [piece, normals] : faces[face]) {
      JoinSides& beside = sides[piece];
      const size_t side = beside.normals[0] ? 1 : 0;
      beside.faces[side] = face;
      beside.normals[side] = &normals;
    }
  return sides;
}

}  // namespace

bool has_area_of_region(const TopoDS_Face& face, const FaceMaker& made) {
  GProp_GProps found;
  BRepGProp::SurfaceProperties(face, found);
  // Another part of the surface, or all of it, would differ by far more.
  constexpr double fraction = 0.01;
  const double area = made.region().surface.area();
  return std::abs(found.Mass() - area) <= fraction * area;
}

FaceNormals measure_face(const TopoDS_Face& face, const FaceMaker& made, const StepPlan& plan,
                         StepPatch& report) {
  FaceNormals normals;
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  const Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(surface);
  const FittedPrimitive shape = shape_of(surface);
  const bool analytic = made.analytic() != nullptr;
  report.deviation = report.edge_gap = report.edge_deviation = kInfinity;
  if (analytic
          ? shape.kind != made.analytic()->surface.shape().kind || !has_area_of_region(face, made)
          : spline.IsNull())
    return normals;
  constexpr int as_fine = 32;  // in place of the knots that an analytic face does not have
  const int knots = analytic ? as_fine : spline->NbUKnots() + spline->NbVKnots();
  const double begin = made.boundary().seam, period = made.boundary().period;
  const auto off_file = [&](const Vec2& uv) {
    const Vec3 p = made.position(uv);
    if (analytic) return std::abs(shape.distance(p));
    const double u = period > 0 ? uv.x() - std::floor((uv.x() - begin) / period) * period : uv.x();
    return (from_occ(spline->Value(u, uv.y())) - p).norm();
  };
  std::vector<Vec2> points = points_of_region(made);

  // Measure each boundary segment against the file edge that is closest to it at equal fractions of
  // the parameter.
  const auto found = edges_of_face(face, *surface, knots);
  if (!found) return normals;
  const std::vector<FileEdge>& edges = found->edges;
  if (!analytic)
    for (const Vec2& uv : points_of_face(face, *spline, edges, made)) points.push_back(uv);
  report.edge_deviation = 0;
  std::vector<char> used(edges.size());
  for (const FaceLoop& loop : made.boundary().loops)
    for (const FaceBoundarySegment& segment : loop) {
      const size_t mine = nearest_edge(edges, used, segment, made);
      if (mine == edges.size()) {
        report.edge_deviation = kInfinity;
        continue;
      }
      used[mine] = 1;
      const int n = 8 * (segment.curve.segment_count() + segment.pcurve.segment_count() + knots);
      measure_segment(segment, edges[mine], n, made, report, points);
      if (!segment.normal_corrections.empty())
        normals[segment_id_of(plan, segment)] =
            normals_along(segment, made, [&](double fraction, const Vec2&) {
              return normal_of_file(edges[mine], *surface, fraction);
            });
    }
  if (std::find(used.begin(), used.end(), 0) != used.end()) report.edge_deviation = kInfinity;
  report.edge_gap = found->gap;
  report.deviation = largest(points.size(), [&](size_t i) { return off_file(points[i]); });
  return normals;
}

FaceNormals normals_of_fit(const FaceMaker& made, const StepPlan& plan) {
  return normals_along_joins(made, plan, [&](const Vec2& uv) { return made.fitted_normal(uv); });
}

FaceNormals normals_before_fit(const FaceMaker& made, const StepPlan& plan) {
  if (made.analytic()) return normals_of_fit(made, plan);
  return normals_along_joins(made, plan, [&](const Vec2& uv) { return made.normal(uv); });
}

std::vector<StepJoin> joins_between(const std::vector<FaceNormals>& faces, double join_deg) {
  std::map<std::string, StepJoin> joins;
  for (const auto& [piece, beside] : sides_of(faces)) {
    const JoinNormals& one = *beside.normals[0];
    StepJoin join{piece.first, {one.region, beside.normals[1] ? beside.normals[1]->region : ""}};
    join.reached = true;
    bool tangent = false;
    for (size_t k = 0; k < one.of_face.size(); ++k) {
      const auto angles = beside.angles(k);
      if (!angles) continue;
      tangent = true;
      join.angle_deg = std::max(join.angle_deg, angles->of_faces);
      join.surface_deg = std::max(join.surface_deg, angles->of_surfaces);
      join.reached = join.reached && !angles->exceeds_tolerance(join_deg);
    }
    if (!tangent) continue;
    StepJoin& all = joins.emplace(piece.first, join).first->second;
    all.angle_deg = std::max(all.angle_deg, join.angle_deg);
    all.surface_deg = std::max(all.surface_deg, join.surface_deg);
    all.reached = all.reached && join.reached;
  }
  std::vector<StepJoin> found;
  for (auto& [line, join] : joins) found.push_back(join);
  return found;
}

std::vector<double> correctable_angles(const std::vector<FaceNormals>& faces, double join_deg) {
  std::vector<double> largest(faces.size(), 0.0);
  for (const auto& [piece, beside] : sides_of(faces))
    for (size_t k = 0; k < beside.normals[0]->of_face.size(); ++k) {
      const auto angles = beside.angles(k);
      if (!angles || !angles->exceeds_tolerance(join_deg)) continue;
      for (const size_t side : {0, 1}) {
        if (!beside.normals[side]) continue;
        const double other = beside.angle_from_target(1 - side, k);
        // If the other side is also off, count this side's error twice.
        const double mine =
            other > join_deg ? 2 * beside.angle_from_target(side, k) : angles->of_faces;
        double& most = largest[beside.faces[side]];
        if (mine > join_deg) most = std::max(most, mine);
      }
    }
  return largest;
}

std::vector<double> angles_from_target(const std::vector<FaceNormals>& faces, double join_deg) {
  std::vector<double> largest(faces.size(), 0.0);
  for (const auto& [piece, beside] : sides_of(faces))
    for (size_t k = 0; k < beside.normals[0]->of_face.size(); ++k) {
      const auto angles = beside.angles(k);
      if (!angles || angles->of_surfaces > join_deg) continue;
      for (const size_t side : {0, 1})
        if (beside.normals[side]) {
          double& most = largest[beside.faces[side]];
          most = std::max(most, beside.angle_from_target(side, k));
        }
    }
  return largest;
}

std::vector<Vec2> points_of_region(const FaceMaker& made) {
  const ParametricMesh& mesh = made.region().surface.mesh();
  const double per_triangle = 6.0 * made.cells() / mesh.triangle_count();
  const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(per_triangle))), 3, 24);
  std::vector<Vec2> points;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape shape = mesh.shape(t);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const double a = (i + 1.0 / 3) / n, b = (j + 1.0 / 3) / n;
        const Vec2 uv = made.boundary().parameters(shape.point({a, b, 1 - a - b}));
        if (made.boundary().contains(uv)) points.push_back(uv);
      }
  }
  return points;
}

}  // namespace batten
