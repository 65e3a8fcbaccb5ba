// SPDX-License-Identifier: MPL-2.0
// Measures the continuity between the faces of OpenCASCADE shapes and of CAD files.
#include "batten/io/cad/continuity_report.h"

#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <GeomLProp_CLProps.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/occ_settings.h"

namespace batten {
namespace {

constexpr int kFewPoints = 17, kMostPoints = 401;

/// A face adjacent to an edge.
struct AdjacentFace {
  Handle(Geom_Surface) surface;
  Handle(Geom2d_Curve) line;
  int face = 0;
};

/// Position, unit normal and curvature of a face at a point of its edge.
struct EdgeJet {
  Vec3 at, normal;
  double curvature = 0;  ///< normal curvature across the edge
};

/// Evaluates the face at its closest point to `p`, with Newton steps that start on the pcurve.
/// `along`: unit tangent of the edge.
std::optional<EdgeJet> edge_jet(const AdjacentFace& side, double parameter, const Vec3& p,
                                const Vec3& along) {
  gp_Pnt2d uv = side.line->Value(parameter);
  gp_Pnt at;
  gp_Vec du, dv, duu, dvv, duv;
  for (int step = 0; step < 4; ++step) {
    side.surface->D2(uv.X(), uv.Y(), at, du, dv, duu, dvv, duv);
    const Vec3 miss = p - from_occ(at.XYZ()), a = from_occ(du.XYZ()), b = from_occ(dv.XYZ());
    Mat2 I;
    I << a.dot(a), a.dot(b), a.dot(b), b.dot(b);
    if (!(I.determinant() > 1e-20 * I.trace() * I.trace())) return std::nullopt;
    const Vec2 move = I.inverse() * Vec2(a.dot(miss), b.dot(miss));
    uv.SetCoord(uv.X() + move[0], uv.Y() + move[1]);
    if (move.norm() < 1e-14) break;
  }
  side.surface->D2(uv.X(), uv.Y(), at, du, dv, duu, dvv, duv);
  const Vec3 a = from_occ(du.XYZ()), b = from_occ(dv.XYZ());
  EdgeJet jet{from_occ(at.XYZ()), a.cross(b), 0};
  if (!(jet.normal.norm() > 1e-12 * a.norm() * b.norm())) return std::nullopt;
  jet.normal.normalize();
  const Vec3 across = jet.normal.cross(along).normalized();
  Mat2 I, II;
  I << a.dot(a), a.dot(b), a.dot(b), b.dot(b);
  const Vec3 &n = jet.normal, uu = from_occ(duu.XYZ()), vv = from_occ(dvv.XYZ()),
             mixed = from_occ(duv.XYZ());
  II << uu.dot(n), mixed.dot(n), mixed.dot(n), vv.dot(n);
  const Vec2 direction = I.inverse() * Vec2(a.dot(across), b.dot(across));
  jet.curvature = direction.dot(II * direction);
  if (!jet.at.allFinite() || !std::isfinite(jet.curvature)) return std::nullopt;
  return jet;
}

/// The number of sample points: four for each knot interval that the edge may cross, because the
/// angle oscillates between the knots of splines.
int points_along(const AdjacentFace& a, const AdjacentFace& b) {
  int knots = 0;
  for (const AdjacentFace* side : {&a, &b})
    if (const auto spline = Handle(Geom_BSplineSurface)::DownCast(side->surface); !spline.IsNull())
      knots = std::max(knots, std::max(spline->NbUKnots(), spline->NbVKnots()) - 2);
  return std::clamp(4 * knots, kFewPoints, kMostPoints);
}

/// Measures an edge with two adjacent faces; nullopt if that is impossible.
std::optional<EdgeContinuity> measured(const TopoDS_Edge& edge, const AdjacentFace& a,
                                       const AdjacentFace& b, double size,
                                       const ContinuityOptions& options) {
  double first, last;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
  if (curve.IsNull() || a.line.IsNull() || b.line.IsNull()) return std::nullopt;
  EdgeContinuity result;
  result.faces = {a.face, b.face};
  GProp_GProps length;
  BRepGProp::LinearProperties(edge, length);
  result.length = length.Mass();
  Vec3 at_jump = Vec3::Zero();
  const int points = std::max(points_along(a, b), options.comb_samples);
  for (int k = 0; k < points; ++k) {
    const double f = 0.01 + 0.98 * k / (points - 1), t = first + f * (last - first);
    gp_Pnt p;
    gp_Vec tangent;
    curve->D1(t, p, tangent);
    const Vec3 at = from_occ(p.XYZ()), along = from_occ(tangent.XYZ());
    if (!(along.norm() > 0)) return std::nullopt;
    const auto one = edge_jet(a, t, at, along.normalized()),
               other = edge_jet(b, t, at, along.normalized());
    if (!one || !other) return std::nullopt;
    result.gap = std::max(result.gap, (one->at - other->at).norm());
    // Compare unoriented planes: normals of unsewn faces may be opposite.
    const double cosine = one->normal.dot(other->normal), same = cosine < 0 ? -1 : 1;
    const double angle = std::atan2(one->normal.cross(other->normal).norm(), std::abs(cosine)) *
                         180 / std::numbers::pi;
    if (angle >= result.angle_deg) {
      result.angle_deg = angle;
      result.at = at;
    }
    if (options.comb_samples > 0 && k % std::max(1, points / options.comb_samples) == 0)
      result.comb_samples.push_back(
          {at, {one->curvature * one->normal, other->curvature * other->normal}});
    const double jump = std::abs(one->curvature - same * other->curvature);
    const double largest =
        std::max({std::abs(one->curvature), std::abs(other->curvature), 1 / size});
    if (jump / largest >= result.relative_jump) {
      result.relative_jump = jump / largest;
      result.curvature_jump = jump;
      at_jump = at;
    }
  }
  using Kind = EdgeContinuity::Kind;
  result.kind = result.angle_deg > options.angle_deg       ? Kind::Crease
                : result.relative_jump > options.curvature ? Kind::Tangent
                                                           : Kind::Curvature;
  if (result.kind != Kind::Crease) result.at = at_jump;
  return result;
}

std::vector<Vec3> points_of(const TopoDS_Edge& edge) {
  std::vector<Vec3> points;
  double first, last;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
  constexpr int pieces = 64;
  for (int k = 0; !curve.IsNull() && k <= pieces; ++k)
    points.push_back(from_occ(curve->Value(first + (last - first) * k / pieces).XYZ()));
  return points;
}

Box3 box_of(const TopTools_IndexedMapOfShape& edges) {
  Box3 box;
  for (int e = 1; e <= edges.Extent(); ++e) {
    double first, last;
    const TopoDS_Edge& edge = TopoDS::Edge(edges(e));
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
    if (curve.IsNull()) continue;
    for (int k = 0; k <= 8; ++k)
      box.extend(from_occ(curve->Value(first + (last - first) * k / 8).XYZ()));
  }
  return box;
}

/// True if the face is narrower than a thousandth of its length, estimated from area and perimeter.
bool is_sliver(const TopoDS_Face& face, double area) {
  GProp_GProps length;
  BRepGProp::LinearProperties(face, length);
  const double half = length.Mass() / 2;
  return half > 0 && std::abs(area) < 1e-3 * half * half;
}

std::vector<std::vector<AdjacentFace>> sides_of(const TopTools_IndexedMapOfShape& edges,
                                                const TopoDS_Shape& shape,
                                                ContinuityReport& report) {
  std::vector<std::vector<AdjacentFace>> sides(edges.Extent());
  const std::vector<double> areas = face_areas(shape);
  report.area = std::accumulate(areas.begin(), areas.end(), 0.0);
  for (TopExp_Explorer f(shape, TopAbs_FACE); f.More(); f.Next()) {
    const TopoDS_Face& face = TopoDS::Face(f.Current());
    if (is_sliver(face, areas[static_cast<size_t>(report.faces++)]))
      report.slivers.push_back(report.faces);
    for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
      const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
      double first, last;
      sides[edges.FindIndex(edge) - 1].push_back(
          {BRep_Tool::Surface(face), BRep_Tool::CurveOnSurface(edge, face, first, last),
           report.faces});
    }
  }
  return sides;
}

}  // namespace

std::vector<double> face_areas(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Face> faces;
  for (TopExp_Explorer f(shape, TopAbs_FACE); f.More(); f.Next())
    faces.push_back(TopoDS::Face(f.Current()));
  std::vector<double> areas(faces.size());
  parallel_for(isize(faces), [&](int k) {
    GProp_GProps area;
    BRepGProp::SurfaceProperties(faces[k], area);
    areas[k] = area.Mass();
  });
  return areas;
}

ContinuityReport shape_continuity(const TopoDS_Shape& shape, double size,
                                  const ContinuityOptions& options) {
  ContinuityReport report;
  report.size = size;
  TopTools_IndexedMapOfShape edges, shells;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  TopExp::MapShapes(shape, TopAbs_SHELL, shells);
  report.shells = shells.Extent();
  const auto sides = sides_of(edges, shape, report);
  std::vector<int> pairs;  // edges with two faces
  for (int e = 1; e <= edges.Extent(); ++e) {
    const TopoDS_Edge& edge = TopoDS::Edge(edges(e));
    const auto& beside = sides[e - 1];
    if (BRep_Tool::Degenerated(edge) || beside.empty()) continue;
    ++report.edges;
    if (beside.size() == 1) {
      ++report.free_edges;
      if (options.comb_samples > 0) report.free_edge_lines.push_back(points_of(edge));
    }
    if (beside.size() > 2) ++report.non_manifold_edges;
    if (beside.size() == 2) pairs.push_back(e);
  }
  std::vector<std::optional<EdgeContinuity>> found(pairs.size());
  const int parts = std::min(isize(pairs), 64);
  parallel_for(parts, [&](int part) {
    for (size_t k = pairs.size() * part / parts; k < pairs.size() * (part + 1) / parts; ++k) {
      const auto& beside = sides[pairs[k] - 1];
      found[k] = measured(TopoDS::Edge(edges(pairs[k])), beside[0], beside[1], size, options);
      if (found[k]) found[k]->edge = pairs[k];
    }
  });
  for (const auto& one : found) {
    if (one) report.inner.push_back(*one);
    report.unmeasured += !one;
  }
  return report;
}

ContinuityReport measure_continuity(const std::filesystem::path& file, double model_unit_in_metres,
                                    const ContinuityOptions& options) {
  if (!(model_unit_in_metres > 0) || !(options.angle_deg > 0) || !(options.curvature > 0) ||
      !(options.sewing >= 0 && options.sewing < 0.1))
    throw InputError(file.string() +
                     ": found a unit, angle or relative tolerance that is not above 0");
  const CadFile cad = read_cad(file);
  if (cad.faces.Extent() == 0)
    throw InputError(file.string() + ": found no faces, expected at least one");
  const OccSettings occ;  // only now: read_cad() may have forked a child process
  try {
    const double size = box_of(cad.edges).diagonal().norm();
    ContinuityReport report = shape_continuity(
        options.sewing > 0 ? sewn(cad.shape, options.sewing * size) : TopoDS_Shape(cad.shape), size,
        options);
    TopTools_IndexedMapOfShape solids;  // sewing turns solids into shells
    TopExp::MapShapes(cad.shape, TopAbs_SOLID, solids);
    report.solids = solids.Extent();
    const double unit = 1e-3 / model_unit_in_metres;  // one millimetre in model units
    report.size *= unit;
    report.area *= unit * unit;
    for (auto& edge : report.inner) {
      edge.length *= unit;
      edge.gap *= unit;
      edge.curvature_jump /= unit;
      edge.at *= unit;
      for (EdgeCombSample& sample : edge.comb_samples) {
        sample.at *= unit;
        for (Vec3& curvature_vectors : sample.curvature_vectors) curvature_vectors /= unit;
      }
    }
    for (auto& line : report.free_edge_lines)
      for (Vec3& p : line) p *= unit;
    return report;
  } catch (const Standard_Failure& e) {
    throw InputError(file.string() + ": OpenCASCADE cannot measure it: " +
                     (e.GetMessageString() ? e.GetMessageString() : "no reason given"));
  }
}

}  // namespace batten
