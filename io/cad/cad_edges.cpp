// SPDX-License-Identifier: MPL-2.0
// Curves and names of the edges of CAD files, and shape healing.
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_Surface.hxx>
#include <Precision.hxx>
#include <ShapeAnalysis_Edge.hxx>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeFix_Edge.hxx>
#include <ShapeUpgrade_ShapeDivideContinuity.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/cad/occ_settings.h"

namespace batten {

Handle(Geom_Curve) curve_of(const TopoDS_Edge& edge, double& start, double& end) {
  if (BRep_Tool::Degenerated(edge)) return {};
  Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, start, end);
  if (curve.IsNull()) {
    // An edge that has only a pcurve.
    if (!BRepLib::BuildCurve3d(edge)) return {};
    curve = BRep_Tool::Curve(edge, start, end);
  }
  if (curve.IsNull() || !(end > start)) return {};
  constexpr int samples = 16;
  const gp_Pnt first = curve->Value(start);
  double reach = 0;
  for (int i = 1; i <= samples; ++i)
    reach = std::max(reach, first.Distance(curve->Value(start + (end - start) * i / samples)));
  if (reach <= 1e-12 * (1 + first.XYZ().Modulus())) return {};
  return curve;
}

std::vector<std::string> edge_names(const CadFile& cad) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  int count = 0;
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    double start, end;
    std::string& name = names.emplace_back();
    if (curve_of(TopoDS::Edge(cad.edges(e)), start, end).IsNull()) continue;
    const std::string& label = cad.labels[e - 1];
    ++count;
    name = label.empty() ? "edge" + std::to_string(count) : label;
    for (int n = 2; !taken.insert(name).second; ++n) name = label + "_" + std::to_string(n);
  }
  return names;
}

namespace {

bool has_crease(const TopoDS_Face& face) {
  Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (const auto part = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface); !part.IsNull())
    surface = part->BasisSurface();
  return !surface.IsNull() && surface->Continuity() == GeomAbs_C0;
}

/// Splitting uses the pcurves of the edges. Replaces inaccurate pcurves by projections of the 3D
/// curves.
void project_edges(const TopoDS_Face& face) {
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge edge = TopoDS::Edge(e.Current());
    if (BRep_Tool::Degenerated(edge) || BRep_Tool::IsClosed(edge, face)) continue;
    double off = 0;
    ShapeAnalysis_Edge().CheckSameParameter(edge, face, off);
    if (off <= 10 * Precision::Confusion()) continue;
    double start, end;
    const Handle(Geom2d_Curve) rough = BRep_Tool::CurveOnSurface(edge, face, start, end);
    BRep_Builder builder;
    builder.UpdateEdge(edge, Handle(Geom2d_Curve)(), face, 0);
    if (!ShapeFix_Edge().FixAddPCurve(edge, face, false))
      builder.UpdateEdge(edge, rough, face, off);
  }
}

/// Replaces the shape of `cad`. `became` maps an old edge to the new edges, which inherit its
/// label.
void replace(CadFile& cad, const TopoDS_Shape& shape,
             const std::function<TopoDS_Shape(const TopoDS_Shape&)>& became) {
  TopoDS_Compound whole;
  BRep_Builder builder;
  builder.MakeCompound(whole);
  builder.Add(whole, shape);
  TopTools_IndexedMapOfShape edges, faces;
  TopExp::MapShapes(whole, TopAbs_EDGE, edges);
  TopExp::MapShapes(whole, TopAbs_FACE, faces);
  std::vector<std::string> labels(static_cast<size_t>(edges.Extent()));
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    TopTools_IndexedMapOfShape parts;
    TopExp::MapShapes(became(cad.edges(e)), TopAbs_EDGE, parts);
    for (int p = 1; p <= parts.Extent(); ++p)
      if (const int at = edges.FindIndex(parts(p)))
        if (std::string& label = labels[at - 1]; label.empty()) label = cad.labels[e - 1];
  }
  cad.shape = whole;
  cad.edges = edges;
  cad.faces = faces;
  cad.labels = std::move(labels);
}

void merge_coincident_edges(CadFile& cad) {
  const int free_edges = free_edges_of(cad.shape).Extent();
  if (cad.faces.Extent() < 2 || free_edges == 0) return;
  Bnd_Box box;
  BRepBndLib::Add(cad.shape, box, false);
  BRepBuilderAPI_Sewing sewing(ContinuityOptions{}.sewing * std::sqrt(box.SquareExtent()));
  for (int f = 1; f <= cad.faces.Extent(); ++f) sewing.Add(cad.faces(f));
  sewing.Perform();
  const TopoDS_Shape sewn = sewing.SewedShape();
  if (sewn.IsNull() || free_edges_of(sewn).Extent() >= free_edges) return;
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  builder.Add(all, sewn);
  TopTools_IndexedMapOfShape of_faces;
  for (int f = 1; f <= cad.faces.Extent(); ++f)
    TopExp::MapShapes(cad.faces(f), TopAbs_EDGE, of_faces);
  for (int e = 1; e <= cad.edges.Extent(); ++e)
    if (!of_faces.Contains(cad.edges(e))) builder.Add(all, cad.edges(e));
  replace(cad, all, [&](const TopoDS_Shape& edge) {
    return sewing.IsModifiedSubShape(edge) ? sewing.ModifiedSubShape(edge) : edge;
  });
}

void divide_at_creases(CadFile& cad) {
  bool any = false;
  for (int f = 1; f <= cad.faces.Extent(); ++f) any = any || has_crease(TopoDS::Face(cad.faces(f)));
  if (!any) return;
  for (int f = 1; f <= cad.faces.Extent(); ++f)
    if (has_crease(TopoDS::Face(cad.faces(f)))) project_edges(TopoDS::Face(cad.faces(f)));
  BRepLib::SameParameter(cad.shape, Precision::Confusion(), true);
  ShapeUpgrade_ShapeDivideContinuity divide(cad.shape);
  divide.SetSurfaceCriterion(GeomAbs_C1);
  divide.SetBoundaryCriterion(GeomAbs_C0);
  divide.SetPCurveCriterion(GeomAbs_C0);
  divide.SetTolerance(Precision::Confusion());
  if (!divide.Perform() || divide.Result().IsNull()) return;
  replace(cad, divide.Result(),
          [&](const TopoDS_Shape& edge) { return divide.GetContext()->Apply(edge); });
}

}  // namespace

void heal_shape(CadFile& cad) {
  const OccSettings occ;
  merge_coincident_edges(cad);
  divide_at_creases(cad);
}

}  // namespace batten
