#include "batten/io/lines/cad_face_topology.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp_Face.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Geom2d_Curve.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "batten/core/containers.h"
#include "batten/io/cad/shape_continuity.h"
#include "batten/io/lines/cad_edges.h"

namespace batten {
namespace {

/// Groups the edges of a wire into connected chains. Degenerate edges are skipped; seams are added
/// to `seams`.
std::vector<std::vector<int>> chains_of(const TopoDS_Wire& wire, const TopoDS_Face& face,
                                        const CadFile& cad, const std::vector<std::string>& names,
                                        std::set<int>& seams) {
  std::vector<int> edges;
  TopTools_IndexedMapOfShape vertices;
  std::vector<std::pair<int, int>> ends;
  for (TopExp_Explorer e(wire, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge edge = TopoDS::Edge(e.Current());
    const int index = cad.edges.FindIndex(edge) - 1;
    if (index < 0 || names[index].empty()) continue;
    if (BRep_Tool::IsClosed(edge, face)) {
      seams.insert(index);
      continue;
    }
    edges.push_back(index);
    ends.emplace_back(vertices.Add(TopExp::FirstVertex(edge)) - 1,
                      vertices.Add(TopExp::LastVertex(edge)) - 1);
  }
  DisjointSets together(static_cast<size_t>(vertices.Extent()));
  for (const auto& [a, b] : ends) together.unite(a, b);
  std::map<int, std::vector<int>> chains;
  for (size_t i = 0; i < edges.size(); ++i)
    chains[together.find(ends[i].first)].push_back(edges[i]);
  std::vector<std::vector<int>> result;
  for (auto& [group, chain] : chains) result.push_back(std::move(chain));
  return result;
}

/// Turning angle from one edge to the next, as seen against the face normal, radians.
double turning_angle(const BRepAdaptor_Curve& from, bool from_reversed, const BRepAdaptor_Curve& to,
                     bool to_reversed, const gp_Vec& normal) {
  gp_Pnt at;
  gp_Vec in, out;
  from.D1(from_reversed ? from.FirstParameter() : from.LastParameter(), at, in);
  to.D1(to_reversed ? to.LastParameter() : to.FirstParameter(), at, out);
  if (from_reversed) in.Reverse();
  if (to_reversed) out.Reverse();
  return std::atan2(normal.Dot(in.Crossed(out)), in.Dot(out));
}

/// The normal of the face near the end of an edge. It is not evaluated at the end, because it is
/// undefined at poles.
gp_Vec normal_near_end(const TopoDS_Edge& edge, const TopoDS_Face& face) {
  constexpr double back = 0.01;  // fraction of the edge
  double start, end;
  const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, start, end);
  if (curve.IsNull()) return {0, 0, 0};
  const bool reversed = edge.Orientation() == TopAbs_REVERSED;
  const gp_Pnt2d uv =
      curve->Value(reversed ? start + back * (end - start) : end - back * (end - start));
  gp_Pnt at;
  gp_Vec normal;
  BRepGProp_Face(face).Normal(uv.X(), uv.Y(), at, normal);
  return normal;
}

bool is_convex(const TopoDS_Face& any_face) {
  const TopoDS_Face face = TopoDS::Face(any_face.Oriented(TopAbs_FORWARD));
  std::vector<TopoDS_Edge> edges;
  for (BRepTools_WireExplorer e(BRepTools::OuterWire(face), face); e.More(); e.Next())
    if (!BRep_Tool::Degenerated(e.Current())) edges.push_back(e.Current());
  constexpr double straight_angle = 0.1;  // radians
  for (size_t i = 0; i < edges.size(); ++i) {
    const TopoDS_Edge &from = edges[i], &to = edges[(i + 1) % edges.size()];
    const double corner_angle = turning_angle(
        BRepAdaptor_Curve(from), from.Orientation() == TopAbs_REVERSED, BRepAdaptor_Curve(to),
        to.Orientation() == TopAbs_REVERSED, normal_near_end(from, face));
    if (!(corner_angle > -straight_angle)) return false;
  }
  return !edges.empty();
}

CadFaceBoundary loops_of(const TopoDS_Face& face, const CadFile& cad,
                         const std::vector<std::string>& names) {
  CadFaceBoundary result;
  const TopoDS_Wire outer = BRepTools::OuterWire(face);
  std::set<int> seams;
  for (TopExp_Explorer w(face, TopAbs_WIRE); w.More(); w.Next()) {
    const TopoDS_Wire wire = TopoDS::Wire(w.Current());
    for (const auto& chain : chains_of(wire, face, cad, names, seams)) {
      std::vector<std::string> loop;
      for (const int e : chain) loop.push_back(names[e]);
      result.loops.insert(wire.IsSame(outer) ? result.loops.begin() : result.loops.end(),
                          std::move(loop));
    }
  }
  for (const int e : seams) result.inner.push_back(names[e]);
  result.convex = result.loops.size() == 1 && seams.empty() && is_convex(face);
  return result;
}

/// The largest distance between curve ends at a common vertex.
double largest_gap(const CadFile& cad) {
  TopTools_IndexedMapOfShape vertices;
  TopExp::MapShapes(cad.shape, TopAbs_VERTEX, vertices);
  std::vector<std::vector<gp_Pnt>> ends(static_cast<size_t>(vertices.Extent()) + 1);
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    const TopoDS_Edge edge = TopoDS::Edge(cad.edges(e).Oriented(TopAbs_FORWARD));
    double start, end;
    const Handle(Geom_Curve) curve = curve_of(edge, start, end);
    if (curve.IsNull()) continue;
    ends[static_cast<size_t>(vertices.FindIndex(TopExp::FirstVertex(edge)))].push_back(
        curve->Value(start));
    ends[static_cast<size_t>(vertices.FindIndex(TopExp::LastVertex(edge)))].push_back(
        curve->Value(end));
  }
  double gap = 0;
  for (size_t v = 1; v < ends.size(); ++v)
    for (const gp_Pnt& p : ends[v])
      for (const gp_Pnt& q : ends[v]) gap = std::max(gap, p.Distance(q));
  return gap;
}

}  // namespace

CadFaceTopology read_cad_loops(const std::filesystem::path& file, double model_unit_in_metres) {
  CadFile cad = read_cad(file);
  heal_shape(cad);
  const std::vector<std::string> names = edge_names(cad);
  CadFaceTopology result;
  Bnd_Box box;
  for (int f = 1; f <= cad.faces.Extent(); ++f) {
    result.faces.push_back(loops_of(TopoDS::Face(cad.faces(f)), cad, names));
    result.faces.back().name = "face " + std::to_string(f);
  }
  for (int e = 1; e <= cad.edges.Extent(); ++e) BRepBndLib::Add(cad.edges(e), box, false);
  const double scale = 1e-3 / model_unit_in_metres;
  if (!box.IsVoid()) result.size = scale * std::sqrt(box.SquareExtent());
  for (const EdgeContinuity& edge : shape_continuity(cad.shape, result.size / scale).inner)
    if (const std::string& name = names[edge.edge - 1];
        !name.empty() && edge.faces[0] != edge.faces[1])
      result.joins.push_back({name, edge.angle_deg});
  result.gap = scale * largest_gap(cad);
  return result;
}

}  // namespace batten
