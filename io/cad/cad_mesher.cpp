// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_mesher.h"

#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <IMeshTools_Parameters.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_map>

#include "batten/core/containers.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/cad/occ_settings.h"

namespace batten {
namespace {

TopoDS_Compound together(const std::vector<CadPart>& parts) {
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  for (const CadPart& part : parts)
    if (!part.faces.empty()) builder.Add(all, part.shape);
  return all;
}

double size_of(const TopoDS_Shape& shape) {
  Bnd_Box box;
  BRepBndLib::AddOptimal(shape, box, false, false);
  return box.IsVoid() ? 0 : std::sqrt(box.SquareExtent());
}

/// Merges all parts into one; unnamed faces get the name of their part. (Each face of an IGES file
/// is a part of its own.)
void make_one(std::vector<CadPart>& parts) {
  CadPart all;
  all.shape = together(parts);
  for (CadPart& part : parts) {
    for (CadFace& face : part.faces) {
      if (face.name.empty()) face.name = part.name;
      all.faces.push_back(face);
    }
    all.curves.insert(all.curves.end(), part.curves.begin(), part.curves.end());
  }
  parts = {all};
}

/// Largest distance of chords from edges, and of flat triangles from faces, mm.
struct Deflection {
  double edges, faces;
};

void mesh_faces(const TopoDS_Shape& shape, const Deflection& deflection) {
  BRepTools::Clean(shape);
  IMeshTools_Parameters how;
  how.Deflection = deflection.edges;
  how.DeflectionInterior = deflection.faces;
  how.Angle = 0.5;
  BRepMesh_IncrementalMesh(shape, how);
}

/// Sort key of a mesh, smaller is better: holes are worse than a large deviation.
std::tuple<int, int, double> defect_key(const CadFacets& f) {
  return {f.unmeshed, f.cracks, f.deviation};
}

}  // namespace

JoinedParts joined_parts(const CadFile& cad) {
  JoinedParts result{tree_of(cad.document).parts, false, size_of(cad.shape)};
  if (cad.header.format == CadFormat::Iges && result.parts.size() > 1) {
    make_one(result.parts);
    result.sewn = true;
  }
  for (CadPart& part : result.parts) {
    const int free_edges = free_edges_of(part.shape).Extent();
    if (free_edges == 0) continue;
    std::vector<CadFace> faces = part.faces;
    const TopoDS_Shape shape = sewn(part.shape, ContinuityOptions{}.sewing * result.size, &faces);
    if (free_edges_of(shape).Extent() >= free_edges) continue;  // sewing joined nothing
    part.shape = shape;
    part.faces = std::move(faces);
    result.sewn = true;
  }
  return result;
}

CadFacets mesh_parts(const std::vector<CadPart>& parts, double size, double chord, bool curved) {
  const TopoDS_Compound all = together(parts);
  if (!(chord > 0)) chord = 1e-3 * size;
  CadFacets facets;
  // The error of flat triangles is O(h²), that of curved ones O(h⁴).
  Deflection deflection = {chord, curved ? std::max(chord, 0.1 * std::sqrt(chord * size)) : chord};
  Deflection last = deflection, best = deflection;
  for (int round = 0; round < 5; ++round) {
    mesh_faces(all, last = deflection);
    CadFacets made = number_facets(parts, all, curved);
    const bool whole = made.unmeshed == 0 && made.cracks == 0;
    const bool better = round == 0 || defect_key(made) < defect_key(facets);
    const double deviation = made.deviation;
    if (better) {
      facets = std::move(made);
      best = deflection;
    }
    if (whole && deviation <= chord) break;
    if (whole && !better && round > 1) break;
    // If the discretised boundary of a face intersects itself in the parameter plane, a finer one
    // may not.
    const double finer = whole ? std::clamp(0.9 * chord / deviation, 0.1, 0.7) : 0.7;
    deflection.edges *= std::max(finer, curved ? 0.7 : 0.1);
    deflection.faces *= curved ? std::sqrt(finer) : finer;
  }
  if (best.faces != last.faces) mesh_faces(all, best);
  facets.size = size;
  facets.chord = chord;
  return facets;
}

namespace {

/// An edge of the mesh, as a pair of nodes.
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

  /// Adds the triangles of a face; false if it has none.
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
      // Faces differ by their tolerances; the first one determines the common node position.
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

  /// Builds the mesh without degenerate triangles and unused nodes. `faces` gets the face of each
  /// triangle.
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

  /// Declares the edges with one adjacent face; mesh edges along them are not cracks.
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

  /// Assigns the shared node numbers along an edge of a face; at its ends, those of its vertices.
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
    if (isize(nodes) != count) return;  // a crack, counted later
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
  std::vector<std::pair<int, int>> equal_;  // pairs of coincident nodes
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

namespace {

/// A surface restricted to its parameter range.
struct BoundedSurface {
  Handle(Geom_Surface) surface;
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;

  explicit BoundedSurface(const TopoDS_Face& face) : surface(BRep_Tool::Surface(face)) {
    if (!surface.IsNull()) surface->Bounds(u0, u1, v0, v1);
  }

  /// Unit normal; zero if the surface is singular there.
  Vec3 normal(const Vec2& uv) const {
    gp_Pnt at;
    gp_Vec du, dv;
    surface->D1(uv[0], uv[1], at, du, dv);
    return from_occ(du.XYZ()).cross(from_occ(dv.XYZ())).normalized();
  }

  /// Distance from `p` to the surface, with Gauss-Newton steps from (u, v). Steps that increase the
  /// distance are damped (Levenberg-Marquardt), because many CAD surfaces are parametrised very
  /// unevenly.
  double distance(Vec2 uv, const Vec3& p) const {
    gp_Pnt at;
    gp_Vec du, dv;
    surface->D1(uv[0], uv[1], at, du, dv);
    double best = (p - from_occ(at.XYZ())).norm(), damping = 0;
    for (int step = 0; step < 30; ++step) {
      const Vec3 miss = p - from_occ(at.XYZ()), a = from_occ(du.XYZ()), b = from_occ(dv.XYZ());
      Mat2 I;
      I << a.dot(a), a.dot(b), a.dot(b), b.dot(b);
      I.diagonal() *= 1 + damping;
      if (!(I.determinant() > 1e-20 * I.trace() * I.trace()))
        I.diagonal().array() += 1e-8 * I.trace();
      if (!(I.determinant() > 0)) return best;
      const Vec2 move = I.inverse() * Vec2(a.dot(miss), b.dot(miss));
      const Vec2 next(std::clamp(uv[0] + move[0], u0, u1), std::clamp(uv[1] + move[1], v0, v1));
      gp_Pnt there;
      gp_Vec there_u, there_v;
      surface->D1(next[0], next[1], there, there_u, there_v);
      const double distance = (p - from_occ(there.XYZ())).norm();
      if (distance < best) {
        const bool settled = distance > best * (1 - 1e-3);
        best = distance;
        uv = next;
        at = there;
        du = there_u;
        dv = there_v;
        damping /= 10;
        if (settled) return best;
      } else if (damping < 1e4 && next != uv) {
        damping = std::max(10 * damping, 1e-2);
      } else {
        return best;
      }
    }
    return best;
  }
};

/// The corners of a triangle, in space and in parameters.
struct Facet {
  std::array<Vec3, 3> point;
  std::array<Vec2, 3> uv;

  Facet(const Poly_Triangulation& mesh, int t, const std::vector<Vec3>& at) {
    std::array<int, 3> n{};
    mesh.Triangle(t).Get(n[0], n[1], n[2]);
    for (size_t c = 0; c < 3; ++c) {
      point[c] = at[static_cast<size_t>(n[c]) - 1];
      uv[c].setZero();
      if (mesh.HasUVNodes()) uv[c] = {mesh.UVNode(n[c]).X(), mesh.UVNode(n[c]).Y()};
    }
  }
};

/// Barycentric coordinates of the sample points of a triangle.
constexpr std::array<std::array<double, 3>, 7> kPoints = {{{1 / 3.0, 1 / 3.0, 1 / 3.0},
                                                           {0.5, 0.5, 0},
                                                           {0, 0.5, 0.5},
                                                           {0.5, 0, 0.5},
                                                           {2 / 3.0, 1 / 6.0, 1 / 6.0},
                                                           {1 / 6.0, 2 / 3.0, 1 / 6.0},
                                                           {1 / 6.0, 1 / 6.0, 2 / 3.0}}};

}  // namespace

std::vector<PnTriangle::Corners> corner_normals(const TopoDS_Face& face,
                                                const Poly_Triangulation& mesh,
                                                const std::vector<Vec3>& at) {
  constexpr double inwards = 1e-6;  // fraction of the path to the triangle's centroid
  const BoundedSurface sheet(face);
  const bool known = !sheet.surface.IsNull() && mesh.HasUVNodes();
  std::vector<PnTriangle::Corners> normals;
  for (int t = 1; t <= mesh.NbTriangles(); ++t) {
    const Facet facet(mesh, t, at);
    const Vec3 flat =
        (facet.point[1] - facet.point[0]).cross(facet.point[2] - facet.point[0]).normalized();
    PnTriangle::Corners& corners = normals.emplace_back();
    for (size_t c = 0; c < 3; ++c) {
      Vec3 n = flat;
      if (known) {
        const Vec2 middle = (facet.uv[0] + facet.uv[1] + facet.uv[2]) / 3;
        n = sheet.normal(facet.uv[c] + inwards * (middle - facet.uv[c]));
        if (n.dot(flat) < 0) n = -n;
        if (!(n.squaredNorm() > 0.5)) n = flat;
      }
      corners[c] = n;
    }
  }
  return normals;
}

double surface_deviation(const TopoDS_Face& face, const Poly_Triangulation& mesh,
                         const std::vector<Vec3>& at,
                         const std::vector<PnTriangle::Corners>& normals) {
  const BoundedSurface sheet(face);
  if (sheet.surface.IsNull() || !mesh.HasUVNodes()) return 0;
  if (GeomAdaptor_Surface(sheet.surface).GetType() == GeomAbs_Plane) return 0;
  double largest = 0;
  for (int t = 1; t <= mesh.NbTriangles(); ++t) {
    const Facet facet(mesh, t, at);
    std::optional<PnTriangle> curved;
    if (!normals.empty()) curved.emplace(facet.point, normals[static_cast<size_t>(t) - 1]);
    for (const auto& w : kPoints) {
      Vec3 p = Vec3::Zero();
      Vec2 uv = Vec2::Zero();
      for (size_t c = 0; c < 3; ++c) {
        p += w[c] * facet.point[c];
        uv += w[c] * facet.uv[c];
      }
      if (curved) p = curved->at({w[0], w[1], w[2]});
      double distance = sheet.distance(uv, p);
      // The search may end in a local minimum; starts at the corners may find a nearer one.
      for (size_t c = 0; c < 3 && distance > largest; ++c)
        distance = std::min(distance, sheet.distance(facet.uv[c], p));
      largest = std::max(largest, distance);
    }
  }
  return largest;
}

double chord_deviation(const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& chain,
                       const std::vector<Vec3>& at) {
  double first = 0, last = 0, largest = 0;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
  if (curve.IsNull() || !chain.HasParameters()) return 0;
  for (int k = 1; k < chain.NbNodes(); ++k) {
    const Vec3 &a = at[static_cast<size_t>(chain.Node(k)) - 1],
               &b = at[static_cast<size_t>(chain.Node(k + 1)) - 1];
    const double from = chain.Parameter(k), to = chain.Parameter(k + 1);
    const double length = (b - a).squaredNorm();
    for (int i = 1; i <= 3; ++i) {
      const Vec3 p = from_occ(curve->Value(from + (to - from) * i / 4).XYZ());
      const double fraction = length > 0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0;
      largest = std::max(largest, (a + fraction * (b - a) - p).norm());
    }
  }
  return largest;
}

}  // namespace batten
