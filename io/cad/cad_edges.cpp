// SPDX-License-Identifier: MPL-2.0
// Curves and names of the edges of CAD files, and shape healing.
#include <BRepAlgoAPI_Splitter.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_Surface.hxx>
#include <Precision.hxx>
#include <ShapeAnalysis_Edge.hxx>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeFix_Edge.hxx>
#include <ShapeUpgrade_ShapeDivideContinuity.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
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

/// Names of the faces after a change: the parts of face NAME are NAME.1, NAME.2, …
std::vector<std::string> face_names_after(
    const CadFile& cad, const TopTools_IndexedMapOfShape& faces,
    const std::function<TopoDS_Shape(const TopoDS_Shape&)>& became) {
  std::vector<std::string> names(static_cast<size_t>(faces.Extent()));
  for (int f = 1; f <= cad.faces.Extent(); ++f) {
    TopTools_IndexedMapOfShape parts;
    TopExp::MapShapes(became(cad.faces(f)), TopAbs_FACE, parts);
    for (int p = 1; p <= parts.Extent(); ++p)
      if (const int at = faces.FindIndex(parts(p)))
        names[at - 1] = cad.face_names[f - 1] + (parts.Extent() > 1 ? "." + std::to_string(p) : "");
  }
  int added = cad.faces.Extent();
  for (std::string& name : names)
    if (name.empty()) name = "face " + std::to_string(++added);
  return names;
}

/// Replaces the shape of `cad`. `became` maps an old edge or face to the new ones; the edges inherit
/// its label. Edges that come from no edge get the label `added`.
void replace(CadFile& cad, const TopoDS_Shape& shape,
             const std::function<TopoDS_Shape(const TopoDS_Shape&)>& became,
             const std::string& added = "") {
  TopoDS_Compound whole;
  BRep_Builder builder;
  builder.MakeCompound(whole);
  builder.Add(whole, shape);
  TopTools_IndexedMapOfShape edges, faces;
  TopExp::MapShapes(whole, TopAbs_EDGE, edges);
  TopExp::MapShapes(whole, TopAbs_FACE, faces);
  std::vector<std::string> labels(static_cast<size_t>(edges.Extent()), added);
  std::vector<char> known(labels.size(), 0);
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    TopTools_IndexedMapOfShape parts;
    TopExp::MapShapes(became(cad.edges(e)), TopAbs_EDGE, parts);
    for (int p = 1; p <= parts.Extent(); ++p)
      if (const int at = edges.FindIndex(parts(p));
          at && (!known[at - 1] || labels[at - 1].empty())) {
        labels[at - 1] = cad.labels[e - 1];
        known[at - 1] = 1;
      }
  }
  cad.face_names = face_names_after(cad, faces, became);
  cad.shape = whole;
  cad.edges = edges;
  cad.faces = faces;
  cad.labels = std::move(labels);
}

}  // namespace

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
  replace(cad, all, [&](const TopoDS_Shape& old) {
    return sewing.IsModifiedSubShape(old) ? sewing.ModifiedSubShape(old)
           : sewing.IsModified(old)       ? sewing.Modified(old)
                                          : old;
  });
}

namespace {

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
          [&](const TopoDS_Shape& old) { return divide.GetContext()->Apply(old); });
}

/// The closed chains of edges around a face, without seams and poles.
std::vector<std::vector<TopoDS_Edge>> boundary_chains(const TopoDS_Face& face) {
  TopTools_IndexedMapOfShape vertices;
  std::vector<TopoDS_Edge> edges;
  std::vector<int> ends;
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
    if (BRep_Tool::Degenerated(edge) || is_seam(edge, face)) continue;
    edges.push_back(edge);
    for (const TopoDS_Vertex& end : {TopExp::FirstVertex(edge), TopExp::LastVertex(edge)})
      ends.push_back(vertices.Add(end) - 1);
  }
  DisjointSets together(static_cast<size_t>(vertices.Extent()));
  for (size_t e = 0; e < edges.size(); ++e) together.unite(ends[2 * e], ends[2 * e + 1]);
  std::map<int, std::vector<TopoDS_Edge>> chains;
  for (size_t e = 0; e < edges.size(); ++e) chains[together.find(ends[2 * e])].push_back(edges[e]);
  std::vector<std::vector<TopoDS_Edge>> result;
  for (auto& [root, chain] : chains) result.push_back(std::move(chain));
  return result;
}

/// True if the tangents of all edges that meet at a vertex of a chain agree.
bool is_smooth(const std::vector<TopoDS_Edge>& chain) {
  constexpr double corner_deg = 1;
  TopTools_IndexedMapOfShape vertices;
  std::vector<std::vector<Vec3>> leaving;
  for (const TopoDS_Edge& edge : chain) {
    double start, end;
    const Handle(Geom_Curve) curve = curve_of(edge, start, end);
    if (curve.IsNull()) return false;
    for (const bool last : {false, true}) {
      const TopoDS_Edge along = TopoDS::Edge(edge.Oriented(TopAbs_FORWARD));
      const int v = vertices.Add(last ? TopExp::LastVertex(along) : TopExp::FirstVertex(along));
      leaving.resize(static_cast<size_t>(vertices.Extent()));
      gp_Pnt at;
      gp_Vec slope;
      curve->D1(last ? end : start, at, slope);
      leaving[v - 1].push_back((last ? -1 : 1) * from_occ(slope.XYZ()));
    }
  }
  return std::all_of(leaving.begin(), leaving.end(), [](const std::vector<Vec3>& at) {
    return at.size() == 2 && degrees_between(at[0], -at[1]) <= corner_deg;
  });
}

/// The seams and poles of a face.
struct Closures {
  bool in_u = false, in_v = false;  // directions in which the face is closed
  int poles = 0;
};
Closures closures_of(const TopoDS_Face& face) {
  Closures found;
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
    if (BRep_Tool::Degenerated(edge)) {
      ++found.poles;
    } else if (is_seam(edge, face)) {
      double first, last;
      const Handle(Geom2d_Curve) line = BRep_Tool::CurveOnSurface(edge, face, first, last);
      const gp_Pnt2d a = line->Value(first), b = line->Value(last);
      (std::abs(a.X() - b.X()) < std::abs(a.Y() - b.Y()) ? found.in_u : found.in_v) = true;
    }
  }
  return found;
}

/// True if the isoparametric curves along a tube bend by more than the radius of its boundary: a
/// surface between the two boundary loops alone would leave the tube.
bool is_bent(const TopoDS_Face& face, bool closed_in_u,
             const std::vector<std::vector<TopoDS_Edge>>& chains) {
  double radius = std::numeric_limits<double>::infinity();
  for (const auto& chain : chains) {
    Bnd_Box box;
    for (const TopoDS_Edge& edge : chain) BRepBndLib::Add(edge, box, false);
    radius = std::min(radius, std::sqrt(box.SquareExtent() / 8));
  }
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  constexpr int curves = 8, samples = 16;
  for (int i = 0; i < curves; ++i) {
    const auto at = [&](double along) {
      const double s = closed_in_u ? double(i) / curves : along,
                   t = closed_in_u ? along : double(i) / curves;
      return from_occ(surface->Value(u0 + s * (u1 - u0), v0 + t * (v1 - v0)).XYZ());
    };
    const Vec3 start = at(0), chord = at(1) - start;
    for (int k = 1; k < samples; ++k) {
      const Vec3 off = at(double(k) / samples) - start;
      const double along = chord.squaredNorm() > 0 ? off.dot(chord) / chord.squaredNorm() : 0;
      if ((off - along * chord).norm() > radius) return true;
    }
  }
  return false;
}

/// Adds isoparametric curves that divide a closed face. See heal_shape().
/// `keep_tube`: a tube stays whole.
void add_divisions(const TopoDS_Face& face, bool keep_tube, TopTools_ListOfShape& divisions) {
  const Closures closed = closures_of(face);
  if (!(closed.in_u || closed.in_v) || (keep_tube && is_tube(face))) return;
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  const auto parts = [&](bool is_closed, bool other_closed) {
    if (is_closed) return closed.poles > 0 ? 4 : 2;
    return other_closed && closed.poles > 1 ? 2 : 1;
  };
  const auto add = [&](const Handle(Geom_Curve) & curve, double first, double last) {
    BRepBuilderAPI_MakeEdge edge(curve, first, last);
    if (edge.IsDone()) divisions.Append(edge.Edge());
  };
  const int columns = parts(closed.in_u, closed.in_v), rows = parts(closed.in_v, closed.in_u);
  for (int i = 1; i < columns; ++i) add(surface->UIso(u0 + (u1 - u0) * i / columns), v0, v1);
  for (int i = 1; i < rows; ++i) add(surface->VIso(v0 + (v1 - v0) * i / rows), u0, u1);
}

double area_of(const TopoDS_Shape& shape) {
  // The default number of Gauss points gives surfaces of revolution only to about 3e-3.
  constexpr double accuracy = 1e-4;
  GProp_GProps found;
  BRepGProp::SurfaceProperties(shape, found, accuracy);
  return found.Mass();
}

void divide_closed_faces(CadFile& cad) {
  TopTools_ListOfShape divisions, whole;
  // Of two tubes between the same loops (a bored sphere), the second one is divided.
  std::set<std::set<int>> bounds;
  for (int f = 1; f <= cad.faces.Extent(); ++f) {
    const TopoDS_Face& face = TopoDS::Face(cad.faces(f));
    std::set<int> edges;
    for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next())
      if (!is_seam(TopoDS::Edge(e.Current()), face)) edges.insert(cad.edges.FindIndex(e.Current()));
    add_divisions(face, bounds.insert(edges).second, divisions);
  }
  if (divisions.IsEmpty()) return;
  whole.Append(cad.shape);
  try {
    BRepAlgoAPI_Splitter splitter;
    splitter.SetArguments(whole);
    splitter.SetTools(divisions);
    splitter.SetNonDestructive(true);
    splitter.Build();
    constexpr double same_area = 1e-3;
    if (!splitter.IsDone() || !BRepCheck_Analyzer(splitter.Shape()).IsValid() ||
        !(std::abs(area_of(splitter.Shape()) / area_of(cad.shape) - 1) < same_area))
      return;
    const auto became = [&](const TopoDS_Shape& old) {
      const TopTools_ListOfShape& parts = splitter.Modified(old);
      if (parts.IsEmpty()) return old;
      TopoDS_Compound all;
      BRep_Builder builder;
      builder.MakeCompound(all);
      for (const TopoDS_Shape& part : parts) builder.Add(all, part);
      return TopoDS_Shape(all);
    };
    replace(cad, splitter.Shape(), became, "division");
  } catch (const Standard_Failure&) {
    return;  // the faces stay whole
  }
}

}  // namespace

bool is_seam(const TopoDS_Edge& edge, const TopoDS_Face& face) {
  if (BRep_Tool::Degenerated(edge) || !BRep_Tool::IsClosed(edge, face)) return false;
  int uses = 0;
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) uses += e.Current().IsSame(edge);
  return uses > 1;
}

bool is_tube(const TopoDS_Face& face) {
  const Closures closed = closures_of(face);
  if (closed.in_u == closed.in_v || closed.poles > 0) return false;
  const auto chains = boundary_chains(face);
  return chains.size() == 2 && std::all_of(chains.begin(), chains.end(), is_smooth) &&
         !is_bent(face, closed.in_u, chains);
}

void heal_shape(CadFile& cad) {
  const OccSettings occ;
  cad.face_names.clear();
  for (int f = 1; f <= cad.faces.Extent(); ++f)
    cad.face_names.push_back("face " + std::to_string(f));
  merge_coincident_edges(cad);
  divide_at_creases(cad);
  divide_closed_faces(cad);
}

}  // namespace batten
