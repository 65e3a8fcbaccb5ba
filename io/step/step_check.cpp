// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/step_check.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_CurveOnSurface.hxx>
#include <BRep_GCurve.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Eigen/Geometry>
#include <GProp_GProps.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace {

constexpr int kEdgePoints = 9;

/// A face as seen from one of its edges.
struct Side {
  Handle(Geom_Surface) surface;
  Handle(Geom2d_Curve) line;
  bool reversed = false;
  int region = 0;

  gp_Pnt point(double parameter) const {
    const gp_Pnt2d uv = line->Value(parameter);
    return surface->Value(uv.X(), uv.Y());
  }
  /// Outward unit normal; zero if the surface is singular there.
  Vec3 normal(double parameter) const {
    const gp_Pnt2d uv = line->Value(parameter);
    gp_Pnt p;
    gp_Vec du, dv;
    surface->D1(uv.X(), uv.Y(), p, du, dv);
    const Vec3 n = from_occ(du.Crossed(dv).XYZ());
    if (!(n.norm() > 1e-12 * du.Magnitude() * dv.Magnitude())) return Vec3::Zero();
    return (reversed ? -1 : 1) * n.normalized();
  }
};

/// The adjacent faces of each edge, in the order of `edges`.
std::vector<std::vector<Side>> sides_of(const TopTools_IndexedMapOfShape& edges,
                                        const TopoDS_Shape& shape,
                                        const std::vector<int>& region_of_face) {
  std::vector<std::vector<Side>> sides(edges.Extent());
  size_t count = 0;
  for (TopExp_Explorer f(shape, TopAbs_FACE); f.More(); f.Next(), ++count) {
    const TopoDS_Face& face = TopoDS::Face(f.Current());
    const int region = count < region_of_face.size() ? region_of_face[count] : -1;
    for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
      const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
      double first, last;
      sides[edges.FindIndex(edge) - 1].push_back(
          {BRep_Tool::Surface(face), BRep_Tool::CurveOnSurface(edge, face, first, last),
           face.Orientation() == TopAbs_REVERSED, region});
    }
  }
  return sides;
}

void measure_edge(const TopoDS_Edge& edge, const std::vector<Side>& sides, Bnd_Box& box,
                  StepReport& report) {
  if (BRep_Tool::Degenerated(edge)) return;
  report.max_tolerance = std::max(report.max_tolerance, BRep_Tool::Tolerance(edge));
  if (sides.size() == 1) ++report.free_edges;
  double first, last;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
  if (curve.IsNull()) {
    ++report.unmeasured;
    return;
  }
  const auto gap = [&](const gp_Pnt& a, const gp_Pnt& b) {
    report.max_gap = std::max(report.max_gap, a.Distance(b));
  };
  TopoDS_Vertex start, end;
  TopExp::Vertices(edge, start, end);
  if (!start.IsNull()) gap(BRep_Tool::Pnt(start), curve->Value(first));
  if (!end.IsNull()) gap(BRep_Tool::Pnt(end), curve->Value(last));
  for (int i = 0; i < kEdgePoints; ++i) {
    const double parameter = first + (last - first) * i / (kEdgePoints - 1);
    const gp_Pnt on_edge = curve->Value(parameter);
    box.Add(on_edge);
    std::vector<std::pair<int, Vec3>> normals;
    for (const Side& side : sides) {
      if (side.line.IsNull()) {
        ++report.unmeasured;
        continue;
      }
      gap(on_edge, side.point(parameter));
      normals.emplace_back(side.region, side.normal(parameter));
      if (normals.back().second.isZero()) ++report.unmeasured;
    }
    for (size_t a = 0; a < normals.size(); ++a)
      for (size_t b = 0; b < a; ++b) {
        const auto& [region, n] = normals[a];
        const auto& [other, m] = normals[b];
        if (region != other) continue;
        const double angle = std::atan2(n.cross(m).norm(), n.dot(m));
        report.max_normal_jump_deg =
            std::max(report.max_normal_jump_deg, angle * 180 / std::numbers::pi);
      }
  }
}

void measure_shells(const TopoDS_Shape& shape, StepReport& report) {
  for (TopExp_Explorer it(shape, TopAbs_SOLID); it.More(); it.Next()) {
    ++report.solids;
    GProp_GProps properties;
    BRepGProp::VolumeProperties(it.Current(), properties);
    report.volume += properties.Mass();
  }
  for (TopExp_Explorer it(shape, TopAbs_SHELL); it.More(); it.Next()) {
    ++report.shells;
    TopTools_IndexedDataMapOfShapeListOfShape faces_of_edge;
    TopExp::MapShapesAndAncestors(it.Current(), TopAbs_EDGE, TopAbs_FACE, faces_of_edge);
    bool closed = true;
    for (int e = 1; e <= faces_of_edge.Extent(); ++e)
      closed = closed && faces_of_edge(e).Extent() == 2;  // a seam counts its face twice
    report.closed_shells += closed;
  }
}

/// Sample points inside the face, on a grid over its parameter box; the centre of the box if no
/// point is inside.
std::vector<gp_Pnt2d> points_inside(const TopoDS_Face& face) {
  constexpr int n = 5;
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  BRepTopAdaptor_FClass2d classifier(face, 1e-9);
  std::vector<gp_Pnt2d> points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const gp_Pnt2d uv(u0 + (u1 - u0) * (i + 0.5) / n, v0 + (v1 - v0) * (j + 0.5) / n);
      if (classifier.Perform(uv) != TopAbs_OUT) points.push_back(uv);
    }
  if (points.empty()) points.emplace_back((u0 + u1) / 2, (v0 + v1) / 2);
  return points;
}

/// Largest distance between a face that is sub-triangle `sub` of a triangle and the surface at the
/// same barycentric coordinates. It is an upper bound of the distance to the closest point.
double matched_deviation(const Handle(Geom_Surface) & face, const Surface& surface, int triangle,
                         int sub) {
  constexpr int n = 4;
  double worst = 0;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) {
      const double s = double(i) / n, t = double(j) / n;
      Vec3 L = Vec3::Constant(t / 3);
      L[(sub + 1) % 3] += 1 - s - t;
      L[(sub + 2) % 3] += s;
      const Vec3 x = from_occ(face->Value(s, t).XYZ());
      worst = std::max(worst, (x - surface.position({triangle, L})).norm());
    }
  return worst;
}

bool on_unit_square(const TopoDS_Face& face) {
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  return std::abs(u0) + std::abs(u1 - 1) + std::abs(v0) + std::abs(v1 - 1) < 1e-6;
}

/// The origin of a face of write_step(). The face of a trimmed model face has triangle -1.
struct SubTriangle {
  int region, triangle, sub;
};

/// The origin of each face, if write_step() wrote the file: faces keep their order. Empty if their
/// number differs.
std::vector<SubTriangle> as_written(const std::vector<const SkinnedRegion*>& regions, int faces) {
  std::vector<SubTriangle> expected;
  for (int r = 0; r < isize(regions); ++r) {
    const Surface& surface = regions[r]->surface;
    if (surface.trim()) {
      expected.push_back({r, -1, 0});
      continue;
    }
    for (int t = 0; t < surface.mesh().triangle_count(); ++t)
      for (int s = 0; s < 3; ++s) expected.push_back({r, t, s});
  }
  const bool any_exact = std::any_of(expected.begin(), expected.end(),
                                     [](const SubTriangle& sub) { return sub.triangle >= 0; });
  if (isize(expected) != faces || !any_exact) expected.clear();
  return expected;
}

/// The largest distance of exact faces from their surfaces. If faces and triangles match in order,
/// no closest-point search is needed.
double deviation(const TopoDS_Shape& shape, const std::vector<const SkinnedRegion*>& regions,
                 const std::vector<SubTriangle>& expected, double size) {
  double worst = 0;
  size_t f = 0;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next(), ++f) {
    if (f < expected.size() && expected[f].triangle < 0) continue;
    const TopoDS_Face& face = TopoDS::Face(it.Current());
    const Handle(Geom_Surface) geometry = BRep_Tool::Surface(face);
    double found = std::numeric_limits<double>::infinity();
    if (f < expected.size() && on_unit_square(face)) {
      const auto& [region, t, s] = expected[f];
      found = matched_deviation(geometry, regions[region]->surface, t, s);
    }
    if (found > 1e-4 * size) found = std::min(found, nearest_deviation(face, regions));
    worst = std::max(worst, found);
  }
  return worst;
}

int count(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
  TopTools_IndexedMapOfShape map;
  TopExp::MapShapes(shape, kind, map);
  return map.Extent();
}

}  // namespace

double nearest_deviation(const TopoDS_Face& face,
                         const std::vector<const SkinnedRegion*>& regions) {
  const Handle(Geom_Surface) geometry = BRep_Tool::Surface(face);
  double worst = 0;
  for (const gp_Pnt2d& uv : points_inside(face)) {
    const Vec3 p = from_occ(geometry->Value(uv.X(), uv.Y()).XYZ());
    double nearest = std::numeric_limits<double>::infinity();
    for (const SkinnedRegion* region : regions)
      nearest = std::min(nearest, region->surface.closest_point(p).distance);
    worst = std::max(worst, nearest);
  }
  return worst;
}

TopoDS_Shape read_step(const std::filesystem::path& path) {
  require_input_file(path, "a STEP file");
  STEPControl_Reader reader;
  TopoDS_Shape shape;
  if (reader.ReadFile(path.string().c_str()) == IFSelect_RetDone) {
    reader.TransferRoots();
    shape = reader.OneShape();
  }
  if (shape.IsNull())
    throw InputError(path.string() + ": OpenCASCADE finds no shape in it; expected a STEP file");
  return shape;
}

StepReport measure_shape(const TopoDS_Shape& shape, const std::vector<int>& region_of_face) {
  StepReport report;
  report.faces = count(shape, TopAbs_FACE);
  TopTools_IndexedMapOfShape edges;
  for (TopExp_Explorer f(shape, TopAbs_FACE); f.More(); f.Next())
    TopExp::MapShapes(f.Current(), TopAbs_EDGE, edges);
  report.edges = edges.Extent();
  report.curves = count(shape, TopAbs_EDGE) - report.edges;
  const auto sides = sides_of(edges, shape, region_of_face);
  Bnd_Box box;
  for (int e = 0; e < edges.Extent(); ++e)
    measure_edge(TopoDS::Edge(edges(e + 1)), sides[e], box, report);
  if (!box.IsVoid()) report.size = std::sqrt(box.SquareExtent());
  for (TopExp_Explorer it(shape, TopAbs_VERTEX); it.More(); it.Next())
    report.max_tolerance =
        std::max(report.max_tolerance, BRep_Tool::Tolerance(TopoDS::Vertex(it.Current())));
  measure_shells(shape, report);
  report.valid = BRepCheck_Analyzer(shape).IsValid();
  return report;
}

StepReport measured_file(const std::filesystem::path& path,
                         const std::vector<const SkinnedRegion*>& regions,
                         std::vector<TopoDS_Face>& fitted) {
  const TopoDS_Shape shape = read_step(path);
  const auto expected = as_written(regions, count(shape, TopAbs_FACE));
  std::vector<int> region_of_face;
  for (const SubTriangle& sub : expected) region_of_face.push_back(sub.region);
  StepReport report = measure_shape(shape, region_of_face);
  report.file = path;
  report.bytes = input_file_size(path);
  if (!regions.empty()) {
    report.max_deviation = deviation(shape, regions, expected, report.size);
    report.continuity = shape_continuity(shape, report.size);
    report.area = report.continuity->area;
  } else {
    for (const double area : face_areas(shape)) report.area += area;
  }
  fitted.clear();
  size_t f = 0;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next(), ++f)
    if (f < expected.size() && expected[f].triangle < 0)
      fitted.push_back(TopoDS::Face(it.Current()));
  return report;
}

namespace {

/// The pcurve of an edge on one of its faces.
struct FaceCurve {
  Handle(Geom_Surface) surface;
  Handle(Geom2d_BSplineCurve) line;
};

/// An edge whose curves are B-splines over one parameter range.
struct SplineEdge {
  Handle(Geom_BSplineCurve) curve;
  std::vector<FaceCurve> on_faces;
  double first = 0, last = 0;

  double gap(double fraction) const {
    const double t = first + fraction * (last - first);
    const gp_Pnt p = curve->Value(t);
    double largest = 0;
    for (const FaceCurve& face : on_faces) {
      const gp_Pnt2d uv = face.line->Value(t);
      largest = std::max(largest, p.SquareDistance(face.surface->Value(uv.X(), uv.Y())));
    }
    return std::sqrt(largest);
  }
};

BRep_ListOfCurveRepresentation& curves_of(const TopoDS_Shape& edge) {
  return Handle(BRep_TEdge)::DownCast(edge.TShape())->ChangeCurves();
}

/// Reads an edge. The result has no curve if the edge is closed, a seam, has a placement, or other
/// curve types.
SplineEdge spline_edge(const TopoDS_Shape& shape) {
  SplineEdge edge;
  for (const Handle(BRep_CurveRepresentation) & representation : curves_of(shape)) {
    const auto geometry = Handle(BRep_GCurve)::DownCast(representation);
    if (geometry.IsNull()) continue;
    if (geometry->IsCurveOnClosedSurface() || !geometry->Location().IsIdentity()) return {};
    if (geometry->IsCurve3D()) {
      edge.curve = Handle(Geom_BSplineCurve)::DownCast(geometry->Curve3D());
      geometry->Range(edge.first, edge.last);
    } else {
      edge.on_faces.push_back(
          {geometry->Surface(), Handle(Geom2d_BSplineCurve)::DownCast(geometry->PCurve())});
    }
  }
  const auto whole = [&](const auto& curve) {
    return !curve.IsNull() && !curve->IsPeriodic() && curve->FirstParameter() == edge.first &&
           curve->LastParameter() == edge.last;
  };
  const bool same = whole(edge.curve) && !edge.curve->IsClosed() &&
                    std::all_of(edge.on_faces.begin(), edge.on_faces.end(),
                                [&](const FaceCurve& face) { return whole(face.line); });
  return same ? edge : SplineEdge{};
}

/// Golden-section search: the fraction between a and b at which the gap is largest, if it has one
/// maximum there.
double largest_between(const SplineEdge& edge, double a, double b) {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double low = b - golden * (b - a), high = a + golden * (b - a);
  double of_low = edge.gap(low), of_high = edge.gap(high);
  for (int i = 0; i < 40; ++i) {
    if (of_low > of_high) {
      b = std::exchange(high, low);
      of_high = of_low;
      of_low = edge.gap(low = b - golden * (b - a));
    } else {
      a = std::exchange(low, high);
      of_low = of_high;
      of_high = edge.gap(high = a + golden * (b - a));
    }
  }
  return (a + b) / 2;
}

/// The position of the largest distance between an edge and its faces, and that distance. Only
/// approximate if it is below `least`.
struct Gap {
  double fraction = 0, size = 0;
};
Gap largest_gap(const SplineEdge& edge, double least) {
  int knots = edge.curve->NbKnots();
  for (const FaceCurve& face : edge.on_faces) knots += face.line->NbKnots();
  for (const FaceCurve& face : edge.on_faces)
    if (const auto spline = Handle(Geom_BSplineSurface)::DownCast(face.surface); !spline.IsNull())
      knots += spline->NbUKnots() + spline->NbVKnots();
  const int n = 8 * knots;
  std::vector<double> gaps(static_cast<size_t>(n) + 1);
  for (int i = 0; i <= n; ++i) gaps[i] = edge.gap(double(i) / n);
  const double highest = *std::max_element(gaps.begin(), gaps.end());
  if (highest < 0.5 * least) return {0, highest};
  Gap found;
  const auto take = [&](double fraction) {
    if (const double size = edge.gap(fraction); size > found.size) found = {fraction, size};
  };
  // A maximum between samples is slightly larger than they are.
  for (int i = 0; i <= n; ++i) {
    if (gaps[i] < 0.9 * highest || (i > 0 && gaps[i - 1] > gaps[i]) ||
        (i < n && gaps[i + 1] > gaps[i]))
      continue;
    take(double(i) / n);
    take(largest_between(edge, std::max(0.0, (i - 1.0) / n), std::min(1.0, (i + 1.0) / n)));
  }
  return found;
}

/// The weight w that moves this fraction to the reader's closest interior sample point.
double weight_for(double fraction) {
  constexpr int spans = 22;
  const double s = std::clamp(std::round(fraction * spans), 1.0, spans - 1.0) / spans;
  return s * (1 - fraction) / (fraction * (1 - s));
}

/// The same curve over the new parameter.
template <class Curve, class Poles>
opencascade::handle<Curve> over_new_parameter(const opencascade::handle<Curve>& curve, double first,
                                              double last, double w) {
  const int n = curve->NbPoles(), degree = curve->Degree();
  Poles poles(1, n);
  curve->Poles(poles);
  TColStd_Array1OfReal weights(1, n), knots(1, curve->NbKnots());
  TColStd_Array1OfInteger times(1, curve->NbKnots());
  curve->Knots(knots);
  curve->Multiplicities(times);
  curve->Weights(weights);
  TColStd_Array1OfReal of_poles(1, n + degree + 1);
  curve->KnotSequence(of_poles);
  const auto fraction = [&](double t) {
    return reparametrized_fraction((t - first) / (last - first), w);
  };
  for (int i = 1; i <= n; ++i)
    for (int k = 1; k <= degree; ++k) {
      const double s = fraction(of_poles(i + k));
      weights(i) *= s + w * (1 - s);
    }
  for (double& knot : knots) knot = first + (last - first) * fraction(knot);
  knots.ChangeLast() = last;
  return new Curve(poles, weights, knots, times, degree);
}

void change_parameter(const TopoDS_Shape& shape, const SplineEdge& edge, double w) {
  for (const Handle(BRep_CurveRepresentation) & representation : curves_of(shape)) {
    const auto geometry = Handle(BRep_GCurve)::DownCast(representation);
    if (geometry.IsNull()) continue;
    if (geometry->IsCurve3D())
      geometry->Curve3D(over_new_parameter<Geom_BSplineCurve, TColgp_Array1OfPnt>(
          edge.curve, edge.first, edge.last, w));
    else
      geometry->PCurve(over_new_parameter<Geom2d_BSplineCurve, TColgp_Array1OfPnt2d>(
          Handle(Geom2d_BSplineCurve)::DownCast(geometry->PCurve()), edge.first, edge.last, w));
  }
}

}  // namespace

void reparametrize_for_gap_check(const TopoDS_Shape& shape, double least) {
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  parallel_for(edges.Extent(), [&](int k) {
    const SplineEdge edge = spline_edge(edges(k + 1));
    if (edge.curve.IsNull() || edge.on_faces.empty()) return;
    const Gap gap = largest_gap(edge, least);
    // The reader samples the ends. A maximum very close to an end would need a very uneven
    // parametrisation.
    constexpr double near_end = 0.001;
    if (gap.size <= least || gap.fraction < near_end || gap.fraction > 1 - near_end) return;
    change_parameter(edges(k + 1), edge, weight_for(gap.fraction));
    constexpr double rounding = 1e-5;
    Handle(BRep_TEdge)::DownCast(edges(k + 1).TShape())->UpdateTolerance((1 + rounding) * gap.size);
  });
}

double parameter_weight(const Geom_Curve& curve) {
  const auto spline = dynamic_cast<const Geom_BSplineCurve*>(&curve);
  if (!spline || !spline->IsRational()) return 1;
  return std::pow(spline->Weight(1) / spline->Weight(spline->NbPoles()), 1.0 / spline->Degree());
}

}  // namespace batten
