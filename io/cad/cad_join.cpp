// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_join.h"

#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRepTools_ReShape.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GCPnts_AbscissaPoint.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAPI_ProjectPointOnCurve.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <GeomProjLib.hxx>
#include <Geom_Curve.hxx>
#include <Geom_ElementarySurface.hxx>
#include <Geom_Surface.hxx>
#include <Precision.hxx>
#include <ShapeFix_Edge.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Pnt2d.hxx>
#include <gp_Vec2d.hxx>
#include <map>
#include <ostream>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace {

/// Replaces closed shells by solids with outward normals.
TopoDS_Shape with_solids(const TopoDS_Shape& sewn) {
  TopoDS_Compound result;
  BRep_Builder builder;
  builder.MakeCompound(result);
  int count = 0;
  TopoDS_Shape last;
  const auto add = [&](const TopoDS_Shape& shape) {
    last = shape;
    builder.Add(result, shape);
    ++count;
  };
  for (TopExp_Explorer s(sewn, TopAbs_SHELL); s.More(); s.Next()) {
    const TopoDS_Shell shell = TopoDS::Shell(s.Current());
    if (!free_edges_of(shell).IsEmpty()) {
      add(shell);
      continue;
    }
    TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(shell);
    BRepLib::OrientClosedSolid(solid);
    add(solid);
  }
  for (TopExp_Explorer f(sewn, TopAbs_FACE, TopAbs_SHELL); f.More(); f.Next()) add(f.Current());
  return count == 1 ? last : TopoDS_Shape(result);
}

/// The faces of `part` that the options select, as one CAD part.
CadPart selected_part(const CadFile& part, const CadJoinOptions& options) {
  CadPart all;
  for (const CadPart& one : tree_of(part.document).parts) {
    if (all.name.empty()) all.name = one.name;
    for (const CadFace& face : one.faces) {
      const std::string name = "face " + std::to_string(part.faces.FindIndex(face.face));
      const auto has = [&](const std::vector<std::string>& names) {
        return std::find(names.begin(), names.end(), name) != names.end();
      };
      if ((options.only.empty() || has(options.only)) && !has(options.without))
        all.faces.push_back(face);
    }
  }
  return all;
}

/// A point on an edge at a fraction of its parameter range.
gp_Pnt point_of(const TopoDS_Edge& edge, double fraction) {
  double start, end;
  const Handle(Geom_Curve) curve = curve_of(edge, start, end);
  return curve->Value(start + fraction * (end - start));
}

/// 1 if two edges coincide in the same direction of their curves, -1 if in opposite directions, 0 if
/// they do not. Their parametrisations may differ.
int direction_of(const TopoDS_Edge& edge, const TopoDS_Edge& other, double tolerance) {
  const auto near = [&](double s, double t) {
    return point_of(edge, s).Distance(point_of(other, t)) <= tolerance;
  };
  const bool same = near(0, 0) && near(1, 1), opposite = near(0, 1) && near(1, 0);
  if (!same && !opposite) return 0;
  double start, end;
  const Handle(Geom_Curve) curve = curve_of(other, start, end);
  GeomAPI_ProjectPointOnCurve foot;
  constexpr int samples = 8;
  double last = same ? 0 : 1;
  int direction = same ? 1 : -1;
  for (int i = 1; i < samples; ++i) {
    foot.Init(point_of(edge, static_cast<double>(i) / samples), curve, start, end);
    if (foot.NbPoints() == 0 || foot.LowerDistance() > tolerance) return 0;
    const double fraction = (foot.LowerDistanceParameter() - start) / (end - start);
    if (i == 1 && same && opposite) direction = fraction < 0.5 ? 1 : -1, last = fraction;
    if (direction * (fraction - last) < 0) return 0;
    last = fraction;
  }
  return direction;
}

/// Gives an edge a pcurve on a face. On analytic surfaces, it is the projection within 1e-9 of the
/// edge's length, in the period of the surface that is nearest to `middle`.
void add_pcurve(const TopoDS_Edge& edge, const TopoDS_Face& face, const gp_Pnt2d& middle) {
  double start, end;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, start, end);
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (surface->IsKind(STANDARD_TYPE(Geom_ElementarySurface))) {
    double tolerance = 1e-9 * GCPnts_AbscissaPoint::Length(GeomAdaptor_Curve(curve), start, end);
    const Handle(Geom2d_Curve) projected =
        GeomProjLib::Curve2d(curve, start, end, surface, tolerance);
    if (!projected.IsNull()) {
      const gp_Pnt2d at = projected->Value((start + end) / 2);
      const double shift[2] = {
          surface->IsUPeriodic()
              ? surface->UPeriod() * std::round((middle.X() - at.X()) / surface->UPeriod())
              : 0,
          surface->IsVPeriodic()
              ? surface->VPeriod() * std::round((middle.Y() - at.Y()) / surface->VPeriod())
              : 0};
      projected->Translate(gp_Vec2d(shift[0], shift[1]));
      BRep_Builder().UpdateEdge(edge, projected, face, Precision::Confusion());
      return;
    }
  }
  ShapeFix_Edge().FixAddPCurve(edge, face, false);
}

bool has_seam(const TopoDS_Face& face) {
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next())
    if (is_seam(TopoDS::Edge(e.Current()), face)) return true;
  return false;
}

/// Replaces free edges of `added` by the edges of `given` with which they coincide, so that the
/// result has the curves and vertices of `given`. Other edges, and all edges if a face would become
/// invalid, are left to sewing.
void adopt_edges(const std::vector<CadFace>& given, std::vector<CadFace>& added, double tolerance) {
  BRep_Builder builder;
  const auto compound = [&](const std::vector<CadFace>& faces) {
    TopoDS_Compound all;
    builder.MakeCompound(all);
    for (const CadFace& face : faces) builder.Add(all, face.face);
    return all;
  };
  const TopoDS_Compound whole = compound(added);
  const TopTools_IndexedMapOfShape free = free_edges_of(whole),
                                   wanted = free_edges_of(compound(given));
  BRepTools_ReShape change;
  TopTools_IndexedDataMapOfShapeListOfShape faces_of;
  TopExp::MapShapesAndAncestors(whole, TopAbs_EDGE, TopAbs_FACE, faces_of);
  std::map<int, gp_Pnt2d> middles;  // by the number of the edge in `taken`
  TopTools_IndexedMapOfShape taken, moved;
  const auto replace_vertex = [&](const TopoDS_Vertex& from, const TopoDS_Vertex& to) {
    if (!from.IsSame(to) && moved.Add(from) == moved.Extent()) change.Replace(from, to);
  };
  for (int e = 1; e <= free.Extent(); ++e) {
    const TopoDS_Edge edge = TopoDS::Edge(free(e).Oriented(TopAbs_FORWARD));
    // The seam of a periodic face ends at vertices that have no counterpart.
    if (has_seam(TopoDS::Face(faces_of.FindFromKey(edge).First()))) continue;
    for (int k = 1; k <= wanted.Extent(); ++k) {
      if (taken.Contains(wanted(k))) continue;
      const TopoDS_Edge other = TopoDS::Edge(wanted(k).Oriented(TopAbs_FORWARD));
      const int direction = direction_of(edge, other, tolerance);
      if (direction == 0) continue;
      const int number = taken.Add(wanted(k));
      double start, end;
      const Handle(Geom2d_Curve) pcurve = BRep_Tool::CurveOnSurface(
          edge, TopoDS::Face(faces_of.FindFromKey(edge).First()), start, end);
      if (!pcurve.IsNull()) middles[number] = pcurve->Value((start + end) / 2);
      const TopoDS_Vertex first = TopExp::FirstVertex(other), last = TopExp::LastVertex(other);
      change.Replace(edge, other.Oriented(direction > 0 ? TopAbs_FORWARD : TopAbs_REVERSED));
      replace_vertex(TopExp::FirstVertex(edge), direction > 0 ? first : last);
      replace_vertex(TopExp::LastVertex(edge), direction > 0 ? last : first);
      break;
    }
  }
  if (taken.IsEmpty()) return;
  std::vector<CadFace> adopted = added;
  for (CadFace& face : adopted) {
    const TopoDS_Shape changed = change.Apply(face.face);
    if (changed.IsNull() || changed.ShapeType() != TopAbs_FACE) return;
    face.face = TopoDS::Face(changed);
    for (TopExp_Explorer e(face.face, TopAbs_EDGE); e.More(); e.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(e.Current());
      if (const int number = taken.FindIndex(edge)) add_pcurve(edge, face.face, middles[number]);
    }
    BRepLib::SameParameter(face.face, Precision::Confusion(), true);
    BRepLib::UpdateTolerances(face.face);
    if (!BRepCheck_Analyzer(face.face).IsValid()) return;
  }
  added = std::move(adopted);
}

std::string joined_text(const CadFile& part, const CadFile& added, const std::string& name,
                        const CadJoinOptions& options) {
  const double unit = options.model_unit_in_metres / 1e-3;  // one model unit in millimetres
  CadPart joined = selected_part(part, options);
  if (joined.faces.empty()) throw InputError("found no face of the part, expected at least one");
  std::vector<CadFace> more;
  for (const CadPart& one : tree_of(added.document).parts)
    more.insert(more.end(), one.faces.begin(), one.faces.end());
  adopt_edges(joined.faces, more, options.tolerance * unit);
  joined.faces.insert(joined.faces.end(), more.begin(), more.end());
  TopoDS_Compound faces;
  BRep_Builder builder;
  builder.MakeCompound(faces);
  for (const CadFace& face : joined.faces) builder.Add(faces, face.face);
  joined.shape = with_solids(sewn(faces, options.tolerance * unit, &joined.faces));
  // The faces of a solid may be turned.
  TopTools_IndexedMapOfShape placed;
  TopExp::MapShapes(joined.shape, TopAbs_FACE, placed);
  for (CadFace& face : joined.faces)
    if (const int at = placed.FindIndex(face.face)) face.face = TopoDS::Face(placed(at));
  CadWriteOptions how{CadFormat::Step, options.ap242, part.header.unit_in_metres, name};
  return cad_text(document_of({joined}), joined.shape, how);
}

CadJoinReport measured(const std::filesystem::path& file, const CadJoinOptions& options) {
  CadJoinReport report;
  ContinuityOptions as_read;
  as_read.sewing = 0;
  report.continuity = measure_continuity(file, options.model_unit_in_metres, as_read);
  const CadFile cad = read_cad(file);
  const OccSettings occ;  // only now: read_cad() may have forked a child process
  const double unit = 1e-3 / options.model_unit_in_metres;  // one millimetre in model units
  report.faces = cad.faces.Extent();
  for (TopExp_Explorer s(cad.shape, TopAbs_SOLID); s.More(); s.Next()) ++report.solids;
  for (TopExp_Explorer s(cad.shape, TopAbs_SHELL); s.More(); s.Next()) {
    ++report.shells;
    report.closed_shells += free_edges_of(s.Current()).IsEmpty();
  }
  report.valid = BRepCheck_Analyzer(cad.shape).IsValid();
  if (report.solids > 0) {
    GProp_GProps volume;
    BRepGProp::VolumeProperties(cad.shape, volume);
    report.volume = volume.Mass() * unit * unit * unit;
  }
  for (int e = 1; e <= cad.edges.Extent(); ++e)
    report.max_tolerance =
        std::max(report.max_tolerance, unit * BRep_Tool::Tolerance(TopoDS::Edge(cad.edges(e))));
  return report;
}

}  // namespace

CadJoinReport join_cad_files(const std::filesystem::path& part, const std::filesystem::path& added,
                             const std::filesystem::path& to, const CadJoinOptions& options) {
  if (!(options.tolerance > 0))
    throw InputError(to.string() + ": found the tolerance " + format_number(options.tolerance) +
                     " for joining faces, expected more than 0");
  const std::string text = sandboxed_read(
      part, "OpenCASCADE",
      [&] {
        const CadFile given = read_cad_here(part), more = read_cad_here(added);
        OccSettings occ;
        try {
          return joined_text(given, more, to.stem().string(), options);
        } catch (const Standard_Failure& failure) {
          throw InputError(part.string() +
                           ": OpenCASCADE cannot join faces to it: " + failure.GetMessageString());
        }
      },
      20);
  AtomicFile file(to);
  file.write([&](std::ostream& out) { out << text; });
  CadJoinReport report = measured(file.temporary(), options);
  report.added = read_cad(added).faces.Extent();
  file.commit();
  return report;
}

}  // namespace batten
