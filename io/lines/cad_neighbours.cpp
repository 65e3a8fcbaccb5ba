// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/cad_neighbours.h"

#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Standard_Failure.hxx>
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
#include <numbers>
#include <optional>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/lines/cad_curve.h"

namespace batten {
namespace {

using std::numbers::pi;

// A face beside an edge, with the curve of the edge in space and on the surface of the face.
class FaceAlongEdge {
 public:
  FaceAlongEdge(const TopoDS_Edge& edge, const TopoDS_Face& face)
      : surface_(BRep_Tool::Surface(face)),
        pcurve_(BRep_Tool::CurveOnSurface(edge, face, start_, end_)),
        reversed_(edge.Orientation() == TopAbs_REVERSED),
        flipped_(face.Orientation() == TopAbs_REVERSED) {
    double first, last;
    curve_ = BRep_Tool::Curve(edge, first, last);
  }
  bool is_valid() const { return !surface_.IsNull() && !pcurve_.IsNull() && !curve_.IsNull(); }

  // The sample at a fraction of the edge, in the direction of its curve; lengths in millimetres.
  std::optional<NeighbourSample> at(double fraction) const {
    const double t = start_ + fraction * (end_ - start_);
    const gp_Pnt2d uv = pcurve_->Value(t);
    gp_Pnt p;
    gp_Vec du, dv, duu, dvv, duv;
    surface_->D2(uv.X(), uv.Y(), p, du, dv, duu, dvv, duv);
    const Vec3 xu = from_occ(du.XYZ()), xv = from_occ(dv.XYZ());
    const Vec3 area = xu.cross(xv);
    const Vec3 along = tangent(fraction);
    if (!(area.norm() > 1e-9 * (xu.squaredNorm() + xv.squaredNorm())) || along.isZero())
      return std::nullopt;
    // The face lies to the left of its oriented edge, seen from the tip of its oriented normal.
    const Vec3 n = area.normalized() * (flipped_ ? -1 : 1);
    const Vec3 into = n.cross(along * (reversed_ ? -1 : 1)).normalized();
    Eigen::Matrix<double, 3, 2> X;
    X << xu, xv;
    const Vec2 c = (X.transpose() * X).inverse() * (X.transpose() * into);
    const Vec3 second = c[0] * c[0] * from_occ(duu.XYZ()) + 2 * c[0] * c[1] * from_occ(duv.XYZ()) +
                        c[1] * c[1] * from_occ(dvv.XYZ());
    return NeighbourSample{from_occ(curve_->Value(t).XYZ()), into, n.dot(second) * n};
  }
  // Unit tangent in the direction of the curve; zero where the curve is singular.
  Vec3 tangent(double fraction) const {
    gp_Pnt p;
    gp_Vec d;
    curve_->D1(start_ + fraction * (end_ - start_), p, d);
    return d.Magnitude() > 0 ? Vec3(from_occ(d.XYZ()) / d.Magnitude()) : Vec3(Vec3::Zero());
  }
  Vec3 oriented_tangent(bool at_end) const {
    return tangent(at_end != reversed_ ? 1 : 0) * (reversed_ ? -1 : 1);
  }
  Vec3 oriented_normal(bool at_end) const {
    for (const double nudge : {0.0, 1e-6, 1e-4, 1e-2}) {
      const double fraction = at_end != reversed_ ? 1 - nudge : nudge;
      if (const auto sample = at(fraction))
        return (tangent(fraction) * (reversed_ ? -1 : 1)).cross(sample->into).normalized();
    }
    return Vec3::Zero();
  }

 private:
  Handle(Geom_Surface) surface_;
  double start_ = 0, end_ = 0;
  Handle(Geom2d_Curve) pcurve_;
  Handle(Geom_Curve) curve_;
  bool reversed_, flipped_;
};

// Adds the angles of a face at its vertices.
void add_corner_angles(const TopoDS_Face& face, const TopTools_IndexedMapOfShape& vertices,
                       std::vector<double>& angles) {
  for (TopExp_Explorer w(face, TopAbs_WIRE); w.More(); w.Next()) {
    std::vector<TopoDS_Edge> edges;
    for (BRepTools_WireExplorer e(TopoDS::Wire(w.Current()), face); e.More(); e.Next())
      if (!BRep_Tool::Degenerated(e.Current())) edges.push_back(e.Current());
    for (size_t i = 0; i < edges.size(); ++i) {
      const TopoDS_Edge &before = edges[i], &after = edges[(i + 1) % edges.size()];
      const int vertex = vertices.FindIndex(TopExp::LastVertex(before, true));
      const FaceAlongEdge in(before, face), out(after, face);
      if (vertex == 0 || !in.is_valid() || !out.is_valid()) continue;
      const Vec3 a = in.oriented_tangent(true), b = out.oriented_tangent(false);
      const double turning = std::atan2(in.oriented_normal(true).dot(a.cross(b)), a.dot(b));
      angles[vertex - 1] += pi - turning;
    }
  }
}

struct FreeEdge {
  TopoDS_Edge edge;
  TopoDS_Face face;
  std::string name, face_name;
  std::array<int, 2> vertices;  // indices, from 0
  NeighbourCurve neighbour;
  int component = 0;
  double length = 0;
  double turning = 0;  // ∫ geodesic curvature ds, radians
  // Vertices at the ends of the oriented edge.
  int first_vertex() const { return vertices[edge.Orientation() == TopAbs_REVERSED ? 1 : 0]; }
  int last_vertex() const { return vertices[edge.Orientation() == TopAbs_REVERSED ? 0 : 1]; }
};

// Samples the face along an edge. Returns false if that is impossible.
bool sample(FreeEdge& free, double scale) {
  const FaceAlongEdge along(free.edge, free.face);
  if (!along.is_valid()) return false;
  const bool closed = free.vertices[0] == free.vertices[1];
  const int count = closed ? 1600 : 400;
  free.neighbour.name = free.face_name;
  Vec3 before = Vec3::Zero();
  for (int i = 0; i <= count; ++i) {
    auto sample = along.at(static_cast<double>(i) / count);
    if (!sample) continue;  // a pole or an apex
    const Vec3 tangent = along.tangent(static_cast<double>(i) / count);
    if (!free.neighbour.samples.empty()) {
      const NeighbourSample& last = free.neighbour.samples.back();
      free.turning += (tangent - before).dot((last.into + sample->into) / 2);
      free.length += scale * (sample->point - last.point / scale).norm();
    }
    before = tangent;
    sample->point *= scale;
    sample->curvature /= scale;
    free.neighbour.samples.push_back(*sample);
  }
  return free.neighbour.samples.size() > 1;
}

// Chains free edges to closed loops; each is a list of indices.
std::vector<std::vector<size_t>> closed_loops(const std::vector<FreeEdge>& edges,
                                              std::vector<char>& used) {
  std::multimap<int, size_t> at_vertex;
  for (size_t e = 0; e < edges.size(); ++e)
    for (const int v : edges[e].vertices) at_vertex.emplace(v, e);
  std::vector<std::vector<size_t>> loops;
  for (size_t e = 0; e < edges.size(); ++e) {
    if (used[e]) continue;
    std::vector<size_t> loop{e};
    std::vector<char> visited = used;
    visited[e] = 1;
    int v = edges[e].vertices[1];
    while (v != edges[e].vertices[0]) {
      const auto [first, last] = at_vertex.equal_range(v);
      // Edges of the same face come first, where two loops touch at a vertex.
      auto next = last;
      for (auto it = first; it != last; ++it)
        if (!visited[it->second] &&
            (next == last || edges[it->second].face.IsSame(edges[loop.back()].face)))
          next = it;
      if (next == last) break;
      loop.push_back(next->second);
      visited[next->second] = 1;
      const auto& ends = edges[next->second].vertices;
      v = ends[0] == v ? ends[1] : ends[0];
    }
    if (v != edges[e].vertices[0]) continue;
    used = visited;
    loops.push_back(std::move(loop));
  }
  return loops;
}

// Change of direction, radians, from one edge of a face to the next at their common vertex,
// positive to the left, where the face lies.
double turning_in_face(const FreeEdge& a, const FreeEdge& b, int vertex) {
  const bool a_first = a.last_vertex() == vertex && b.first_vertex() == vertex;
  const FaceAlongEdge in(a_first ? a.edge : b.edge, a.face), out(a_first ? b.edge : a.edge, a.face);
  const Vec3 before = in.oriented_tangent(true), after = out.oriented_tangent(false);
  return std::atan2(in.oriented_normal(true).dot(before.cross(after)), before.dot(after));
}

NeighbourOpening opening_of(const std::vector<FreeEdge>& edges, const std::vector<size_t>& loop,
                            const std::vector<double>& corner_angles) {
  NeighbourOpening opening;
  opening.component = edges[loop.front()].component;
  double turning = 0, points = 0;
  for (const size_t e : loop) {
    const FreeEdge& edge = edges[e];
    opening.lines.push_back(edge.name);
    if (std::find(opening.faces.begin(), opening.faces.end(), edge.face_name) ==
        opening.faces.end())
      opening.faces.push_back(edge.face_name);
    opening.length += edge.length;
    turning += edge.turning;
    for (const NeighbourSample& sample : edge.neighbour.samples) opening.centre += sample.point;
    points += isize(edge.neighbour.samples);
  }
  std::map<int, std::vector<const FreeEdge*>> corners;
  for (const size_t e : loop)
    for (const int v : edges[e].vertices) corners[v].push_back(&edges[e]);
  for (const auto& [v, two] : corners)
    turning += two[0]->face.IsSame(two[1]->face) ? turning_in_face(*two[0], *two[1], v)
                                                 : pi - corner_angles[v];
  opening.centre /= points;
  opening.turning_deg = turning * 180 / pi;
  return opening;
}

}  // namespace

bool CadFaceSelection::includes(const std::string& face) const {
  const auto has = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), face) != names.end();
  };
  return (only.empty() || has(only)) && !has(without);
}

NeighbourFaces read_cad_neighbours(const std::filesystem::path& file, double model_unit_in_metres,
                                   const CadFaceSelection& selection) {
  const double scale = millimetres_in(model_unit_in_metres);
  CadFile cad = read_cad(file);
  const OccSettings occ;  // only now: read_cad() may have forked a child process
  try {
    const int face_count = cad.faces.Extent();
    if (face_count == 0)
      throw InputError(file.string() + ": found " + cad.found +
                       " and no face; expected the faces beside an opening");
    for (const auto* names : {&selection.only, &selection.without})
      for (const std::string& name : *names) {
        bool found = false;
        for (int f = 1; f <= face_count; ++f) found = found || name == "face " + std::to_string(f);
        if (!found)
          throw InputError(file.string() + ": found no face '" + name +
                           "', expected 'face 1' to 'face " + std::to_string(face_count) + "'");
      }
    cad.face_names.clear();
    for (int f = 1; f <= face_count; ++f) cad.face_names.push_back("face " + std::to_string(f));
    merge_coincident_edges(cad);
    NeighbourFaces result;
    TopTools_IndexedMapOfShape vertices;
    TopExp::MapShapes(cad.shape, TopAbs_VERTEX, vertices);
    std::vector<double> corner_angles(static_cast<size_t>(vertices.Extent()), 0.0);
    struct Use {
      TopoDS_Edge edge;
      TopoDS_Face face;
      int face_index;
      int count = 0;
    };
    std::map<int, Use> uses;  // by edge
    DisjointSets connected(static_cast<size_t>(face_count));
    for (TopExp_Explorer f(cad.shape, TopAbs_FACE); f.More(); f.Next()) {
      const TopoDS_Face face = TopoDS::Face(f.Current());
      const int index = cad.faces.FindIndex(face) - 1;
      if (!selection.includes(cad.face_names[index])) continue;
      ++result.faces;
      add_corner_angles(face, vertices, corner_angles);
      for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
        const TopoDS_Edge edge = TopoDS::Edge(e.Current());
        if (BRep_Tool::Degenerated(edge)) continue;
        Use& use = uses[cad.edges.FindIndex(edge)];
        if (use.count++ == 0)
          use = {edge, face, index, 1};
        else
          connected.unite(use.face_index, index);
      }
    }
    const std::vector<std::string> names = edge_names(cad);
    std::vector<FreeEdge> edges;
    for (const auto& [e, use] : uses) {
      if (use.count != 1 || names[e - 1].empty()) continue;
      FreeEdge free;
      free.edge = use.edge;
      free.face = use.face;
      free.name = names[e - 1];
      free.face_name = cad.face_names[use.face_index];
      free.component = connected.find(use.face_index);
      free.vertices = {vertices.FindIndex(TopExp::FirstVertex(use.edge)) - 1,
                       vertices.FindIndex(TopExp::LastVertex(use.edge)) - 1};
      if (!sample(free, scale)) continue;
      edges.push_back(std::move(free));
    }
    std::vector<char> used(edges.size(), 0);
    for (const std::vector<size_t>& loop : closed_loops(edges, used))
      result.openings.push_back(opening_of(edges, loop, corner_angles));
    std::stable_sort(
        result.openings.begin(), result.openings.end(),
        [](const NeighbourOpening& a, const NeighbourOpening& b) { return a.length > b.length; });
    find_outer_boundaries(result.openings);
    Box3 box;
    for (size_t e = 0; e < edges.size(); ++e) {
      if (!used[e]) result.open_lines.push_back(edges[e].name);
      double start, end;
      const Handle(Geom_Curve) curve = curve_of(edges[e].edge, start, end);
      result.lines.push_back(
          {edges[e].name, cad_curve(curve, start, end, scale), CharacterLine::Role::Outline});
      result.neighbours.push_back(std::move(edges[e].neighbour));
    }
    for (int v = 1; v <= vertices.Extent(); ++v)
      box.extend(scale * from_occ(BRep_Tool::Pnt(TopoDS::Vertex(vertices(v))).XYZ()));
    for (const NeighbourCurve& neighbour : result.neighbours)
      for (const NeighbourSample& sample : neighbour.samples) box.extend(sample.point);
    result.size = box.isEmpty() ? 0 : box.diagonal().norm();
    return result;
  } catch (const Standard_Failure& e) {
    throw InputError(file.string() + ": OpenCASCADE cannot evaluate its faces: " +
                     (e.GetMessageString() ? e.GetMessageString() : "no reason given"));
  }
}

}  // namespace batten
