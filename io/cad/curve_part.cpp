#include "batten/io/cad/curve_part.h"

#include <BRep_Builder.hxx>
#include <Geom_BSplineCurve.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>

#include "batten/core/isize.h"
#include "batten/io/cad/occ_values.h"

namespace batten {
namespace {

TopoDS_Edge edge_of(const CubicSpline& spline, double tolerance) {
  const int knots = isize(spline.knots);
  TColgp_Array1OfPnt poles(1, isize(spline.poles));
  TColStd_Array1OfReal values(1, knots);
  TColStd_Array1OfInteger times(1, knots);
  for (int i = 1; i <= poles.Length(); ++i) poles(i) = to_occ(spline.poles[i - 1]);
  for (int i = 1; i <= knots; ++i) {
    values(i) = spline.knots[i - 1];
    times(i) = spline.multiplicities[i - 1];
  }
  BRep_Builder builder;
  TopoDS_Vertex first, last;
  builder.MakeVertex(first, to_occ(spline.poles.front()), tolerance);
  if (spline.closed)
    last = first;
  else
    builder.MakeVertex(last, to_occ(spline.poles.back()), tolerance);
  TopoDS_Edge edge;
  builder.MakeEdge(edge, new Geom_BSplineCurve(poles, values, times, 3), tolerance);
  builder.Add(edge, first.Oriented(TopAbs_FORWARD));
  builder.Add(edge, last.Oriented(TopAbs_REVERSED));
  builder.Range(edge, spline.knots.front(), spline.knots.back());
  return edge;
}

}  // namespace

CadPart part_of_curves(const std::string& name, const std::vector<CubicSpline>& splines) {
  double size = 0;
  for (const CubicSpline& spline : splines) size = std::max(size, spline.size);
  CadPart part;
  part.name = name;
  TopoDS_Compound compound;
  BRep_Builder builder;
  builder.MakeCompound(compound);
  for (const CubicSpline& spline : splines) {
    part.curves.push_back({edge_of(spline, 1e-9 * size), spline.name, ""});
    builder.Add(compound, part.curves.back().edge);
  }
  part.shape = compound;
  return part;
}

}  // namespace batten
