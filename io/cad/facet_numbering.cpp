#include "batten/io/cad/facet_numbering.h"

#include <BRep_Tool.hxx>
#include <Geom_Curve.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>

#include "batten/core/disjoint_sets.h"
#include "batten/core/isize.h"
#include "batten/io/cad/cad_free_edges.h"
#include "batten/io/cad/facet_deviation.h"
#include "batten/io/cad/occ_values.h"

namespace batten {
namespace {

/// An edge of the mesh, by its nodes.
using Link = std::pair<int, int>;
struct LinkHash {
  size_t operator()(const Link& l) const {
    return static_cast<size_t>(l.first) * 0x9e3779b97f4a7c15ULL + static_cast<size_t>(l.second);
  }
};
Link link(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

class Numbering {
 public:
  Numbering(const TopoDS_Shape& shape, bool curved) : curved_(curved) {
    TopExp::MapShapes(shape, TopAbs_EDGE, edges_);
    TopExp::MapShapes(shape, TopAbs_VERTEX, vertices_);
    of_edge_.resize(static_cast<size_t>(edges_.Extent()));
    of_vertex_.assign(static_cast<size_t>(vertices_.Extent()), -1);
  }

  /// Adds the triangles of a face; false where it has none.
  bool add(const TopoDS_Face& face) {
    TopLoc_Location location;
    const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, location);
    if (mesh.IsNull() || mesh->NbTriangles() == 0) return false;
    const gp_Trsf move = location.Transformation();
    std::vector<int> ids(static_cast<size_t>(mesh->NbNodes()), -1);
    std::vector<Vec3> at(ids.size());
    for (size_t i = 0; i < ids.size(); ++i)
      at[i] = from_occ(mesh->Node(static_cast<int>(i) + 1).Transformed(move));
    for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next())
      assign_edge_nodes(TopoDS::Edge(e.Current()), mesh, location, ids, at);
    for (size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] < 0) ids[i] = new_node(at[i]);
      const Vec3& node_position = points_[static_cast<size_t>(ids[i])];
      if (at[i] == node_position) continue;
      // Where faces differ by their tolerances, the first one says where the common node is.
      at[i] = node_position;
      mesh->SetNode(static_cast<int>(i) + 1,
                    gp_Pnt(at[i].x(), at[i].y(), at[i].z()).Transformed(move.Inverted()));
    }
    std::vector<PnTriangle::Corners> normals;
    if (curved_) normals = corner_normals(face, *mesh, at);
    const bool flip = (face.Orientation() == TopAbs_REVERSED) != move.IsNegative();
    for (int t = 1; t <= mesh->NbTriangles(); ++t) {
      std::array<int, 3> corner{};
      mesh->Triangle(t).Get(corner[0], corner[1], corner[2]);
      for (int& c : corner) c = ids[static_cast<size_t>(c) - 1];
      if (flip) std::swap(corner[1], corner[2]);
      if (curved_) {
        const auto& [a, b, c] = normals[static_cast<size_t>(t) - 1];
        normals_.push_back(flip ? PnTriangle::Corners{-a, -c, -b} : PnTriangle::Corners{a, b, c});
      }
      triangles_.push_back(corner);
      faces_.push_back(face_count_);
    }
    deviation_ = std::max(deviation_, surface_deviation(face, *mesh, at, normals));
    ++face_count_;
    return true;
  }

  int face_count() const { return face_count_; }

  /// The mesh, without triangles of equal nodes and nodes without a triangle; the face of each
  /// triangle comes into `faces`.
  CadFacets finish(std::vector<int>& faces) {
    DisjointSets same(points_.size());
    for (const auto& [a, b] : equal_) same.unite(a, b);
    CadFacets facets;
    std::vector<int> number(points_.size(), -1);
    std::vector<Vec3> used;
    const auto numbered = [&](int node) {
      int& n = number[static_cast<size_t>(same.find(node))];
      if (n < 0) {
        n = isize(used);
        used.push_back(points_[static_cast<size_t>(same.find(node))]);
      }
      return n;
    };
    for (size_t t = 0; t < triangles_.size(); ++t) {
      std::array<int, 3> corner = triangles_[t];
      for (int& c : corner) c = same.find(c);
      if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
      for (int& c : corner) c = numbered(c);
      facets.mesh.add_face(corner);
      if (curved_) facets.normals.push_back(normals_[t]);
      faces.push_back(faces_[t]);
    }
    facets.mesh.points.resize(isize(used), 3);
    for (int i = 0; i < isize(used); ++i) facets.mesh.points.row(i) = used[i];
    count_free(facets, same, number);
    facets.deviation = deviation_;
    return facets;
  }

  /// Chords along these edges may be free: beside them lies one face.
  void set_free_edges(const TopTools_IndexedMapOfShape& free_edges) {
    for (int r = 1; r <= free_edges.Extent(); ++r)
      free_edges_.push_back(edges_.FindIndex(free_edges(r)) - 1);
  }

 private:
  int new_node(const Vec3& p) {
    points_.push_back(p);
    return isize(points_) - 1;
  }

  int vertex_node(const TopoDS_Vertex& vertex, const Vec3& p) {
    const int at = vertices_.FindIndex(vertex);
    if (at == 0) return new_node(p);
    int& node = of_vertex_[static_cast<size_t>(at) - 1];
    if (node < 0) node = new_node(p);
    return node;
  }

  /// Nodes along an edge of a face get the edge's numbers; at its ends its vertices'.
  void assign_edge_nodes(const TopoDS_Edge& edge, const Handle(Poly_Triangulation) & mesh,
                         const TopLoc_Location& location, std::vector<int>& ids,
                         const std::vector<Vec3>& at) {
    const Handle(Poly_PolygonOnTriangulation) chain =
        BRep_Tool::PolygonOnTriangulation(edge, mesh, location);
    if (chain.IsNull()) return;
    const int number = edges_.FindIndex(edge), count = chain->NbNodes();
    if (number == 0) return;
    const auto local = [&](int k) { return static_cast<size_t>(chain->Node(k + 1)) - 1; };
    std::vector<int>& nodes = of_edge_[static_cast<size_t>(number) - 1];
    if (nodes.empty()) {
      TopoDS_Vertex first, last;
      TopExp::Vertices(TopoDS::Edge(edge.Oriented(TopAbs_FORWARD)), first, last);
      const bool point = BRep_Tool::Degenerated(edge);
      for (int k = 0; k < count; ++k)
        nodes.push_back(k == 0 || point  ? vertex_node(first, at[local(k)])
                        : k == count - 1 ? vertex_node(last, at[local(k)])
                                         : new_node(at[local(k)]));
      if (!point) deviation_ = std::max(deviation_, chord_deviation(edge, *chain, at));
    }
    if (isize(nodes) != count) return;  // a crack, which is counted
    for (int k = 0; k < count; ++k) {
      int& id = ids[local(k)];
      if (id < 0)
        id = nodes[static_cast<size_t>(k)];
      else if (id != nodes[static_cast<size_t>(k)])
        equal_.emplace_back(id, nodes[static_cast<size_t>(k)]);
    }
  }

  void count_free(CadFacets& facets, DisjointSets& same, const std::vector<int>& number) const {
    std::unordered_map<Link, int, LinkHash> uses;
    uses.reserve(static_cast<size_t>(facets.mesh.face_count()) * 2);
    for (int f = 0; f < facets.mesh.face_count(); ++f) {
      const auto corner = facets.mesh.face(f);
      for (size_t k = 0; k < 3; ++k) ++uses[link(corner[k], corner[(k + 1) % 3])];
    }
    const auto of = [&](int node) { return number[static_cast<size_t>(same.find(node))]; };
    std::unordered_map<Link, char, LinkHash> rim;
    for (const int e : free_edges_) {
      const auto& nodes = of_edge_[static_cast<size_t>(e)];
      for (size_t k = 0; k + 1 < nodes.size(); ++k) rim[link(of(nodes[k]), of(nodes[k + 1]))] = 1;
    }
    for (const auto& [ends, count] : uses) {
      if (count != 1) continue;
      ++facets.free_edges;
      if (!rim.contains(ends)) ++facets.cracks;
    }
  }

  TopTools_IndexedMapOfShape edges_, vertices_;
  std::vector<std::vector<int>> of_edge_;  // nodes along each edge
  std::vector<int> of_vertex_;
  std::vector<Vec3> points_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<PnTriangle::Corners> normals_;
  std::vector<int> faces_, free_edges_;
  std::vector<std::pair<int, int>> equal_;  // nodes in one place
  bool curved_;
  int face_count_ = 0;
  double deviation_ = 0;
};

}  // namespace

CadFacets number_facets(const std::vector<CadPart>& parts, const TopoDS_Shape& shape, bool curved) {
  Numbering numbering(shape, curved);
  std::map<std::pair<std::string, std::string>, int> known;
  std::vector<FacetGroup> groups;
  std::vector<int> group_of_face;
  int unmeshed = 0, shells = 0;
  for (size_t p = 0; p < parts.size(); ++p) {
    const CadPart& part = parts[p];
    for (TopExp_Explorer s(part.shape, TopAbs_SHELL); s.More(); s.Next()) ++shells;
    const std::string plain = part.name.empty() ? "part " + std::to_string(p + 1) : part.name;
    for (const CadFace& face : part.faces) {
      if (!numbering.add(face.face)) {
        ++unmeshed;
        continue;
      }
      const std::string name = !face.name.empty()    ? face.name
                               : !face.solid.empty() ? face.solid
                                                     : plain;
      const auto [at, added] = known.try_emplace({name, face.colour}, isize(groups));
      if (added) groups.push_back({name, face.colour, {}});
      group_of_face.push_back(at->second);
    }
  }
  numbering.set_free_edges(free_edges_of(shape));
  std::vector<int> face_of_triangle;
  CadFacets facets = numbering.finish(face_of_triangle);
  for (int t = 0; t < isize(face_of_triangle); ++t)
    groups[static_cast<size_t>(group_of_face[static_cast<size_t>(face_of_triangle[t])])]
        .triangles.push_back(t);
  facets.faces = std::move(face_of_triangle);
  facets.groups = std::move(groups);
  facets.unmeshed = unmeshed;
  facets.shells = shells;
  return facets;
}

}  // namespace batten
