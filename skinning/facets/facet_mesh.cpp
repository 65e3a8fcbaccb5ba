// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/facets/line_subdivision.h"

namespace batten {

// Delaunay mesh of a region in (u, v) that follows its lines.

/// The part of a line between two adjacent subdivision points, which becomes one edge of the mesh.
struct ConstrainedEdge {
  int line;
  double t0, t1;
  int a, b;
  bool curved;
  Vec2 from = Vec2::Zero(), to = Vec2::Zero();  ///< the line's points at t0 and t1
};

/// The mesh, and the edges of the lines in it.
struct FacetMesh {
  std::shared_ptr<const ParametricMesh> mesh;
  std::vector<FacetLine> lines;
  std::vector<ConstrainedEdge> constrained_edges;
  std::vector<int> constrained_edge_of;  ///< constrained edge of each mesh edge; -1: none
  /// Constrained edges of each line that lie in the region, in order.
  std::vector<std::vector<int>> edges_of_line;

  /// The image p(L) in (u, v) of a point of the mesh, with curved edges (formula in facets.h).
  Vec2 map_point(const Location& where) const;
};

/// Meshes a region that has a boundary. `edge_length` 0: that of mean_edge(). Edges on lines are
/// bisected until no triangle at a curved edge nearly folds. Throws as quadratic_elements().
FacetMesh facet_mesh(const SkinnedRegion& region, double edge_length,
                     const SubdivisionRequest& requested);

namespace {

/// True if a triangle at a curved edge is far from folding. It tests the Jacobian at the corners of
/// its six-node triangle, and the orientation of a lattice of its image.
bool is_unfolded(const FacetMesh& m, int t) {
  constexpr double least = 0.2;  // fraction of the straight triangle's area
  const TriangleShape shape = m.mesh->shape(t);
  Vec2 middle[3];  // midpoint of the edge opposite to each corner
  for (int i = 0; i < 3; ++i) middle[i] = m.map_point({t, (Vec3::Ones() - Vec3::Unit(i)) / 2});
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const Vec2 to_j = 4 * middle[k] - 3 * shape.vertex[i] - shape.vertex[j],
               to_k = 4 * middle[j] - 3 * shape.vertex[i] - shape.vertex[k];
    if (!(cross(to_j, to_k) > least * 2 * shape.area)) return false;
  }
  constexpr int n = 8;
  Vec2 x[n + 1][n + 1];
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) x[i][j] = m.map_point({t, Vec3(i, j, n - i - j) / n});
  const double limit = least * 2 * shape.area / (n * n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      if (!(cross(x[i + 1][j] - x[i][j], x[i][j + 1] - x[i][j]) > limit)) return false;
      if (i + j + 1 < n &&
          !(cross(x[i][j + 1] - x[i + 1][j + 1], x[i + 1][j] - x[i + 1][j + 1]) > limit))
        return false;
    }
  return true;
}

/// True if two segments without a common end intersect or touch.
bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const Vec2 low = a.cwiseMin(b), high = a.cwiseMax(b);
  if ((c.cwiseMax(d) - low).minCoeff() < 0 || (high - c.cwiseMin(d)).minCoeff() < 0) return false;
  const double ca = cross(d - c, a - c), cb = cross(d - c, b - c);
  const double ac = cross(b - a, c - a), ad = cross(b - a, d - a);
  return ca * cb <= 0 && ac * ad <= 0;
}

/// Meshes between the subdivision points; adds points and repeats if triangles fold or edges cross.
class FacetMesher {
 public:
  FacetMesher(const SkinnedRegion& region, double edge_length, const SubdivisionRequest& requested)
      : region_(region),
        may_split_(requested.may_split),
        requested_(!requested.at.empty()),
        s_(region, edge_length, requested) {}

  FacetMesh make() {
    FacetMesh result;
    result.lines = s_.lines();
    constexpr int rounds = 12;
    // More rounds, because cusps are resolved step by step.
    const int untangling = requested_ ? 2 * rounds : rounds;
    for (int round = 0;; ++round) {
      list_constrained_edges();
      if (untangle(round < untangling)) continue;
      triangulate(result);
      std::set<int> folded;
      for (int t = 0; t < result.mesh->triangle_count(); ++t) {
        const auto& e = result.mesh->edges_of(t);
        std::vector<int> curved;
        for (const int edge : e)
          if (result.constrained_edge_of[edge] >= 0 &&
              constrained_edges_[result.constrained_edge_of[edge]].curved)
            curved.push_back(result.constrained_edge_of[edge]);
        if (!curved.empty() && !is_unfolded(result, t)) folded.insert(curved.begin(), curved.end());
      }
      if (folded.empty()) return result;
      // In a cusp bisection does not help: its last edges become straight.
      if (round >= rounds || !may_split_)
        for (const int p : folded) straight_.insert(key(constrained_edges_[p]));
      else
        for (const int p : folded) split(p);
      if (round > 2 * rounds)
        throw InputError(s_.message_prefix() + "its facets are folded where curves touch");
    }
  }

 private:
  using Key = std::pair<int, double>;
  static Key key(const ConstrainedEdge& piece) { return {piece.line, piece.t0}; }

  void list_constrained_edges() {
    constrained_edges_.clear();
    for (size_t l = 0; l < s_.lines().size(); ++l)
      for (size_t k = 0; k + 1 < s_.on(l).size(); ++k) {
        const SubdivisionPoint &a = s_.on(l)[k], &b = s_.on(l)[k + 1];
        ConstrainedEdge piece{
            static_cast<int>(l), a.t, b.t, a.node, b.node, s_.lines()[l].embedded() != nullptr};
        if (!s_.on_boundary(l) && !inside(s_.lines()[l].at(0.5 * (a.t + b.t)))) continue;
        if (straight_.count(key(piece))) piece.curved = false;
        piece.from = s_.near(s_.nodes()[a.node], s_.lines()[l].at(a.t));
        piece.to = s_.near(s_.nodes()[b.node], s_.lines()[l].at(b.t));
        constrained_edges_.push_back(piece);
      }
  }

  /// True if p is inside the region. In an annulus only the holes are tested.
  bool inside(const Vec2& p) {
    const Trim* trim = region_.surface.trim().get();
    if (trim) return trim->loops().contains(region_.surface.mesh().wrapped(p));
    if (s_.has_seam()) return true;
    if (!loops_) loops_ = boundary_loops(region_);
    return loops_->contains(p);
  }

  void split(int p) {
    const ConstrainedEdge& piece = constrained_edges_[p];
    s_.add(static_cast<size_t>(piece.line), 0.5 * (piece.t0 + piece.t1));
  }

  /// The parameter at which a constrained edge is split to separate it from another one. It is the
  /// middle or, if the neighbours prescribe points, the point next to an end of the other edge. In
  /// a cusp, subdivision must proceed in equal steps on both lines.
  double split_beside(const ConstrainedEdge& piece, const ConstrainedEdge& other) const {
    const double middle = 0.5 * (piece.t0 + piece.t1);
    if (!requested_) return middle;
    constexpr double within = 0.4;  // fraction of the edge, from its middle
    double best = middle, least = within * (piece.t1 - piece.t0);
    for (const Vec2& end : {other.from, other.to}) {
      const double t = s_.lines()[piece.line].closest(s_.near(end, piece.from)).u;
      if (std::abs(t - middle) >= least) continue;
      least = std::abs(t - middle);
      best = t;
    }
    return best;
  }

  /// True if two constrained edges meet other than in one common end. Edges that share both ends
  /// coincide.
  bool tangled(const ConstrainedEdge& a, const ConstrainedEdge& b) const {
    const int shared = (a.a == b.a) + (a.a == b.b) + (a.b == b.a) + (a.b == b.b);
    if (shared > 0) return shared > 1;
    const Vec2 move = s_.near(b.from, a.from) - b.from;
    return meet(a.from, a.to, b.from + move, b.to + move);
  }

  /// Constrained edges sorted for a sweep along u (axis 0) or v (axis 1), and the number of later
  /// edges that overlap each one in that direction.
  struct Sweep {
    std::vector<int> order, beside;
    long pairs = 0;
  };
  Sweep sweep(int axis) const {
    const auto low = [&](int p) {
      return std::min(constrained_edges_[p].from[axis], constrained_edges_[p].to[axis]);
    };
    Sweep result;
    result.order.resize(constrained_edges_.size());
    std::iota(result.order.begin(), result.order.end(), 0);
    std::sort(result.order.begin(), result.order.end(),
              [&](int p, int q) { return std::pair(low(p), p) < std::pair(low(q), q); });
    for (auto it = result.order.begin(); it != result.order.end(); ++it) {
      const double high =
          std::max(constrained_edges_[*it].from[axis], constrained_edges_[*it].to[axis]);
      const auto end = std::upper_bound(it, result.order.end(), high,
                                        [&](double at, int q) { return at < low(q); });
      result.beside.push_back(static_cast<int>(end - it) - 1);
      result.pairs += result.beside.back();
    }
    return result;
  }

  /// All tangled pairs, sorted, the lower index first.
  std::vector<std::pair<int, int>> tangled_pairs() const {
    Sweep best = sweep(1);
    // In an annulus u is only known up to the period, so the sweep is along v.
    if (!s_.has_seam())
      if (Sweep other = sweep(0); other.pairs < best.pairs) best = std::move(other);
    std::vector<std::pair<int, int>> pairs;
    for (size_t i = 0; i < best.order.size(); ++i)
      for (int k = 1; k <= best.beside[i]; ++k) {
        const auto [p, q] = std::minmax(best.order[i], best.order[i + static_cast<size_t>(k)]);
        if (tangled(constrained_edges_[p], constrained_edges_[q])) pairs.emplace_back(p, q);
      }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

  /// Splits the curved edges whose chords meet. Returns true if there were any.
  bool untangle(bool may_split) {
    std::map<int, double> cuts;
    for (const auto& [p, q] : tangled_pairs()) {
      const ConstrainedEdge &a = constrained_edges_[p], &b = constrained_edges_[q];
      if (!may_split || !(a.curved || b.curved))
        throw InputError(s_.message_prefix() + "curves '" + s_.lines()[a.line].name() + "' and '" +
                         s_.lines()[b.line].name() + "' intersect where they have no common point");
      if (a.curved) cuts.try_emplace(p, split_beside(a, b));
      if (b.curved) cuts.try_emplace(q, split_beside(b, a));
    }
    for (const auto& [p, t] : cuts) s_.add(static_cast<size_t>(constrained_edges_[p].line), t);
    return !cuts.empty();
  }

  /// Meshes between the constrained edges and finds their mesh edges.
  void triangulate(FacetMesh& result) const {
    PlanarMeshInput task;
    task.edge_length = s_.size();
    task.keep_segments = true;
    result.constrained_edges = constrained_edges_;
    std::vector<std::array<int, 2>> seams;
    const auto number = number_points(result.constrained_edges, task, seams);
    sort_by_loop(result.constrained_edges, task);
    task.outline.insert(task.outline.end(), seams.begin(), seams.end());
    try {
      result.mesh = std::make_shared<ParametricMesh>(delaunay_mesh(task));
    } catch (const InputError& error) {
      throw InputError(s_.message_prefix() + error.what());
    }
    if (s_.has_seam()) close(result, number);
    find_edges(result);
  }

  /// Numbers the end points of constrained edges, left and right of the seam, and lists the edges
  /// of the seam's right copy. Nodes used only by dropped edges are left out. Each edge is shifted
  /// between the two copies of the seam, so that a node on the seam has two positions, one per
  /// copy.
  std::vector<std::array<int, 2>> number_points(std::vector<ConstrainedEdge>& constrained_edges,
                                                PlanarMeshInput& task,
                                                std::vector<std::array<int, 2>>& seams) const {
    std::vector<std::array<int, 2>> number(s_.nodes().size(), {-1, -1});
    const auto point = [&](int node, const Vec2& p) {
      const bool right = s_.has_seam() && s_.beyond_seam(p) > 0.5 * s_.period() && s_.on_seam(node);
      int& index = number[node][right];
      if (index < 0) {
        index = isize(task.points);
        task.points.push_back(s_.has_seam() ? p : s_.nodes()[node]);
      }
      return index;
    };
    const auto move = [&](ConstrainedEdge& piece, bool right) {
      Vec2 shift = Vec2::Zero();
      if (s_.has_seam()) {
        const bool of_seam = piece.line == static_cast<int>(s_.seam());
        const double beyond = of_seam ? 0 : s_.beyond_seam(0.5 * (piece.from + piece.to));
        shift.x() = (right - std::floor(beyond / s_.period())) * s_.period();
      }
      piece.a = point(piece.a, piece.from + shift);
      piece.b = point(piece.b, piece.to + shift);
    };
    for (ConstrainedEdge& piece : constrained_edges) {
      if (s_.has_seam() && piece.line == static_cast<int>(s_.seam())) {
        ConstrainedEdge image = piece;
        move(image, true);
        seams.push_back({image.a, image.b});
      }
      move(piece, false);
    }
    return number;
  }

  /// Distributes the constrained edges to the outline, the holes and the inner segments.
  void sort_by_loop(const std::vector<ConstrainedEdge>& constrained_edges,
                    PlanarMeshInput& task) const {
    std::vector<int> loop_of(s_.lines().size(), -1);
    for (size_t i = 0; i < region_.boundary.size(); ++i)
      for (const BoundarySegment& piece : region_.boundary[i])
        loop_of[s_.line_of(piece)] = static_cast<int>(i);
    const int outlines = s_.has_seam() ? 2 : 1;
    if (s_.has_seam()) loop_of[s_.seam()] = 0;
    task.holes.resize(region_.boundary.size() - static_cast<size_t>(outlines));
    for (const ConstrainedEdge& piece : constrained_edges) {
      const int loop = loop_of[piece.line];
      (loop < 0          ? task.inner
       : loop < outlines ? task.outline
                         : task.holes[loop - outlines])
          .push_back({piece.a, piece.b});
    }
  }

  /// Finds the mesh edge of every constrained edge.
  void find_edges(FacetMesh& result) const {
    result.constrained_edge_of.assign(result.mesh->edge_count(), -1);
    result.edges_of_line.assign(s_.lines().size(), {});
    for (size_t p = 0; p < result.constrained_edges.size(); ++p) {
      const ConstrainedEdge& piece = result.constrained_edges[p];
      const int e = result.mesh->edge_between(piece.a, piece.b);
      if (e < 0)
        throw InputError(s_.message_prefix() + "curve '" + s_.lines()[piece.line].name() +
                         "' touches another one where they have no common point");
      result.constrained_edge_of[e] = static_cast<int>(p);
      result.edges_of_line[piece.line].push_back(static_cast<int>(p));
    }
  }

  /// Merges the two copies of the seam.
  void close(FacetMesh& result, const std::vector<std::array<int, 2>>& number) const {
    const ParametricMesh& open = *result.mesh;
    std::vector<int> becomes(static_cast<size_t>(open.vertex_count()), -1);
    for (const auto& [left, right] : number)
      if (left >= 0 && right >= 0) becomes[right] = left;
    std::vector<Vec2> vertices;
    std::vector<int> closed(becomes.size(), -1);
    const ParametricMesh& mesh = region_.surface.mesh();
    for (size_t v = 0; v < becomes.size(); ++v) {
      if (becomes[v] >= 0) continue;
      closed[v] = isize(vertices);
      vertices.push_back(mesh.wrapped(open.vertices()[v]));
    }
    for (size_t v = 0; v < becomes.size(); ++v)
      if (becomes[v] >= 0) closed[v] = closed[becomes[v]];
    std::vector<ParametricMesh::Triangle> triangles = open.triangles();
    for (auto& triangle : triangles)
      for (int& v : triangle) v = closed[v];
    for (ConstrainedEdge& piece : result.constrained_edges)
      for (int* node : {&piece.a, &piece.b}) *node = closed[*node];
    result.mesh =
        std::make_shared<ParametricMesh>(std::move(vertices), std::move(triangles), s_.period());
  }

  const SkinnedRegion& region_;
  bool may_split_, requested_;
  LineSubdivision s_;
  std::vector<ConstrainedEdge> constrained_edges_;
  std::set<Key> straight_;
  std::optional<DomainLoops> loops_;
};

}  // namespace

Vec2 FacetMesh::map_point(const Location& where) const {
  const auto& v = mesh->triangles()[where.triangle];
  const auto& e = mesh->edges_of(where.triangle);
  Vec2 p = mesh->shape(where.triangle).point(where.L);
  for (int i = 0; i < 3; ++i) {
    if (constrained_edge_of[e[i]] < 0 || where.L[i] == 1) continue;
    const ConstrainedEdge& piece = constrained_edges[constrained_edge_of[e[i]]];
    if (!piece.curved) continue;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const bool forward = v[j] == piece.a;
    const double Lj = where.L[forward ? j : k], Lk = where.L[forward ? k : j];
    if (Lj == 0 || Lk == 0) continue;
    const double s = where.L[i] == 0 ? Lk : 0.5 * (1 + Lk - Lj);
    const Vec2 on_line = lines[piece.line].at(piece.t0 + s * (piece.t1 - piece.t0));
    if (where.L[i] == 0) return mesh->image_near(on_line, p);
    const Vec2& from = mesh->vertices()[piece.a];
    const Vec2 chord = (1 - s) * from + s * mesh->image_near(mesh->vertices()[piece.b], from);
    p += Lj * Lk / (s * (1 - s)) * (mesh->image_near(on_line, chord) - chord);
  }
  return p;
}

FacetMesh facet_mesh(const SkinnedRegion& region, double edge_length,
                     const SubdivisionRequest& requested) {
  return FacetMesher(region, edge_length, requested).make();
}

namespace {

bool has_own_mesh(const SkinnedRegion& region) {
  return region.surface.trim() || !region.embedded.empty();
}

/// True if a point is requested on an edge-aligned line where the element mesh has no vertex.
bool requests_more(const SkinnedRegion& region, const SubdivisionRequest& requested) {
  for (size_t r = 0; r < std::min(requested.at.size(), region.edge_aligned.size()); ++r) {
    const std::vector<double>& has = region.edge_aligned[r].parameters;
    const double same = kParameterTolerance * (has.back() - has.front());
    for (const double t : requested.at[r])
      if (std::none_of(has.begin(), has.end(), [&](double u) { return std::abs(u - t) <= same; }))
        return true;
  }
  return false;
}

/// Points of an n-fold subdivided mesh, the points on each edge from its lower to its higher
/// vertex, and lines as chains of directed edges.
struct SampledMesh {
  Tessellation tessellation;
  std::vector<Vec2> uv;
  std::vector<std::vector<int>> edge_points;
  struct Link {
    int edge, from, to;
    double t0, t1;
  };
  std::vector<std::vector<Link>> lines;
  std::shared_ptr<const ParametricMesh> mesh;
  bool is_element_mesh = true;
};

SampledMesh sample_mesh(const SkinnedRegion& region, int n, double edge_length,
                        const SubdivisionRequest& requested = {}) {
  SampledMesh result;
  const Surface& surface = region.surface;
  std::optional<FacetMesh> own;
  if (has_own_mesh(region) || requests_more(region, requested))
    own = facet_mesh(region, edge_length, requested);
  result.is_element_mesh = !own;
  result.mesh = own ? own->mesh : surface.shared_mesh();
  const ParametricMesh& mesh = *result.mesh;

  result.tessellation = tessellate(mesh, n);
  auto& points = result.tessellation.points;
  for (const auto& e : mesh.edges()) result.edge_points.push_back({e.low});
  // Vertices are followed by the points inside edges, from the lower end, and those inside
  // triangles.
  for (size_t p = static_cast<size_t>(mesh.vertex_count()); p < points.size(); ++p)
    for (int i = 0; i < 3; ++i)
      if (points[p].L[i] == 0)
        result.edge_points[mesh.edges_of(points[p].triangle)[i]].push_back(static_cast<int>(p));
  for (int e = 0; e < mesh.edge_count(); ++e) result.edge_points[e].push_back(mesh.edges()[e].high);

  if (!own) {
    for (const Location& where : points)
      result.uv.push_back(mesh.shape(where.triangle).point(where.L));
    for (const EdgeAlignedLine& aligned_line : region.edge_aligned) {
      result.lines.emplace_back();
      for (size_t k = 0; k < aligned_line.edges.size(); ++k)
        result.lines.back().push_back({aligned_line.edges[k], aligned_line.vertices[k],
                                       aligned_line.vertices[k + 1], aligned_line.parameters[k],
                                       aligned_line.parameters[k + 1]});
    }
    return result;
  }
  const size_t lines = region.edge_aligned.size() + region.embedded.size();
  for (size_t l = 0; l < lines; ++l) {
    const auto& list = own->edges_of_line[l];
    result.lines.emplace_back();
    for (const int p : list) {
      const ConstrainedEdge& piece = own->constrained_edges[p];
      result.lines.back().push_back(
          {mesh.edge_between(piece.a, piece.b), piece.a, piece.b, piece.t0, piece.t1});
    }
  }
  const TriangleLocator locator(surface.mesh());
  for (Location& where : points) {
    result.uv.push_back(own->map_point(where));
    where = locator.locate(result.uv.back());
  }
  for (size_t f = 0; f < result.tessellation.facets.size(); ++f) {
    const auto& [a, b, c] = result.tessellation.facets[f];
    const Vec2& first = result.uv[a];
    result.tessellation.facet_triangle[f] =
        locator
            .locate((first + mesh.image_near(result.uv[b], first) +
                     mesh.image_near(result.uv[c], first)) /
                    3)
            .triangle;
  }
  return result;
}

}  // namespace

double facet_length(const SkinnedRegion& region) { return mean_edge(region.surface).space; }

double mean_facet_length(const std::vector<const SkinnedRegion*>& regions) {
  double sum = 0;
  for (const auto* region : regions) sum += facet_length(*region);
  return sum / static_cast<double>(regions.size());
}

int display_facets_per_edge(const std::vector<const SkinnedRegion*>& regions) {
  constexpr double max_facets = 400'000;
  double triangles = 0;
  for (const auto* region : regions) triangles += region->surface.mesh().triangle_count();
  return std::clamp(static_cast<int>(std::sqrt(max_facets / triangles)), 1, 4);
}

QuadraticElements quadratic_elements(const SkinnedRegion& region, double edge_length,
                                     const SubdivisionRequest& requested) {
  SampledMesh halves = sample_mesh(region, 2, edge_length, requested);
  const ParametricMesh& mesh = *halves.mesh;
  const auto middle = [&](int edge) { return halves.edge_points[edge][1]; };
  QuadraticElements result;
  result.is_element_mesh = halves.is_element_mesh;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto &v = mesh.triangles()[t], &e = mesh.edges_of(t);
    result.triangles.push_back({v[0], v[1], v[2], middle(e[2]), middle(e[0]), middle(e[1])});
    // Of the four facets of a triangle, the central one has no corner of the triangle.
    for (int f = 4 * t; f < 4 * t + 4; ++f) {
      const auto& corners = halves.tessellation.facets[f];
      if (*std::min_element(corners.begin(), corners.end()) >= mesh.vertex_count())
        result.element.push_back(halves.tessellation.facet_triangle[f]);
    }
  }
  for (const auto& links : halves.lines) {
    result.lines.emplace_back();
    result.parameters.emplace_back();
    for (const auto& link : links) {
      result.lines.back().push_back({link.from, link.to, middle(link.edge)});
      result.parameters.back().push_back({link.t0, link.t1});
    }
  }
  result.nodes = std::move(halves.tessellation.points);
  result.uv = std::move(halves.uv);
  return result;
}

DisplayFacets facets(const SkinnedRegion& region, int n, double edge_length,
                     const SubdivisionRequest& requested) {
  SampledMesh all = sample_mesh(region, n, edge_length, requested);
  DisplayFacets result;
  for (const auto& links : all.lines) {
    auto& chains = result.lines.emplace_back();
    for (const auto& link : links) {
      std::vector<int> piece = all.edge_points[link.edge];
      if (piece.front() != link.from) std::reverse(piece.begin(), piece.end());
      if (chains.empty() || chains.back().back() != link.from)
        chains.push_back(piece);
      else
        chains.back().insert(chains.back().end(), piece.begin() + 1, piece.end());
    }
  }
  result.tessellation = std::move(all.tessellation);
  return result;
}

std::string facet_error(const SkinnedRegion& region) {
  if (region.embedded.empty()) return "";
  try {
    quadratic_elements(region);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

}  // namespace batten
