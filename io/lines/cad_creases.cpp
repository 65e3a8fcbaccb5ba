#include "batten/io/lines/cad_creases.h"

#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
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
#include <map>

#include "batten/io/cad/occ_settings.h"

namespace batten {
namespace {

bool has_crease(const TopoDS_Face& face) {
  Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (const auto part = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface); !part.IsNull())
    surface = part->BasisSurface();
  return !surface.IsNull() && surface->Continuity() == GeomAbs_C0;
}

/// Edges are cut where their curves in the parameter plane are: rough ones are made anew from the curves in space.
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

}  // namespace

void divide_at_creases(CadFile& cad) {
  bool any = false;
  for (int f = 1; f <= cad.faces.Extent(); ++f) any = any || has_crease(TopoDS::Face(cad.faces(f)));
  if (!any) return;
  const OccSettings occ;
  for (int f = 1; f <= cad.faces.Extent(); ++f)
    if (has_crease(TopoDS::Face(cad.faces(f)))) project_edges(TopoDS::Face(cad.faces(f)));
  BRepLib::SameParameter(cad.shape, Precision::Confusion(), true);
  ShapeUpgrade_ShapeDivideContinuity divide(cad.shape);
  divide.SetSurfaceCriterion(GeomAbs_C1);
  divide.SetBoundaryCriterion(GeomAbs_C0);
  divide.SetPCurveCriterion(GeomAbs_C0);
  divide.SetTolerance(Precision::Confusion());
  if (!divide.Perform() || divide.Result().IsNull()) return;

  std::map<int, std::string> label_of;  // by the numbers of new edges
  TopoDS_Compound whole;
  BRep_Builder builder;
  builder.MakeCompound(whole);
  builder.Add(whole, divide.Result());
  TopTools_IndexedMapOfShape edges, faces;
  TopExp::MapShapes(whole, TopAbs_EDGE, edges);
  TopExp::MapShapes(whole, TopAbs_FACE, faces);
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    TopTools_IndexedMapOfShape parts;
    TopExp::MapShapes(divide.GetContext()->Apply(cad.edges(e)), TopAbs_EDGE, parts);
    for (int p = 1; p <= parts.Extent(); ++p)
      if (const int at = edges.FindIndex(parts(p))) label_of[at] = cad.labels[e - 1];
  }
  cad.shape = whole;
  cad.edges = edges;
  cad.faces = faces;
  cad.labels.assign(static_cast<size_t>(edges.Extent()), "");
  for (const auto& [edge, label] : label_of) cad.labels[edge - 1] = label;
}

}  // namespace batten
