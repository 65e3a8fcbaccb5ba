#include "batten/io/cad/edge_reparametrization.h"

#include <BRep_CurveOnSurface.hxx>
#include <BRep_GCurve.hxx>
#include <BRep_TEdge.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "batten/core/isize.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

/// A curve of the faces of an edge.
struct FaceCurve {
  Handle(Geom_Surface) surface;
  Handle(Geom2d_BSplineCurve) line;
};

/// An edge of B-splines over one range.
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

/// Reads an edge; without a curve if it is closed, a seam, moved, or has another form.
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

/// The share between a and b at which the gap is largest, if it has one maximum there.
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

/// Where an edge is farthest from its faces, and how far; roughly where that is below `least`.
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
  // A maximum between samples is a little higher than they are.
  for (int i = 0; i <= n; ++i) {
    if (gaps[i] < 0.9 * highest || (i > 0 && gaps[i - 1] > gaps[i]) ||
        (i < n && gaps[i + 1] > gaps[i]))
      continue;
    take(double(i) / n);
    take(largest_between(edge, std::max(0.0, (i - 1.0) / n), std::min(1.0, (i + 1.0) / n)));
  }
  return found;
}

/// w such that the reader's nearest inner place comes to be at this share.
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
    // A gap at an end is seen; one very near to an end would take a very uneven parameter.
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
