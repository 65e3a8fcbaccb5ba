// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/prepared_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"

namespace batten {

// Decomposition of any triangles into manifold patches.

/// Manifold patches as defined by PreparedMesh: continued across or ending at non-manifold edges,
/// and oriented or cut open.
struct ManifoldPatches {
  std::vector<std::array<int, 3>> triangles;  ///< by vertices; neighbours are consistently oriented
  std::vector<int> duplicate_vertex_nodes;    ///< node of each vertex from the node count on
  std::vector<char> flipped;                  ///< per triangle: 1 if its orientation was reversed
  int count = 0;                              ///< number of patches
  int component_count = 0;  ///< number of connected components (parts that share no node)
  int cut_edges = 0;        ///< edges along which non-orientable patches were cut open
  std::vector<std::array<int, 2>> non_manifold_edges;  ///< edges with three or more triangles
  std::vector<int> non_manifold_nodes;  ///< where patches touch, except at ends of such edges

  /// A triangle as node indices.
  std::array<int, 3> nodes_of(std::array<int, 3> triangle) const;
  int vertex_count = 0;
};

/// Decomposes triangles, given as nodes without repeated corners. O(triangles · log triangles).
ManifoldPatches find_manifold_patches(const Points& points,
                                      std::vector<std::array<int, 3>> triangles);

namespace {

constexpr size_t kMaxListed = 8;
constexpr double kFlat = 1e-12;  // height over longest edge; below it a triangle counts as having
                                 // no area

std::string count_of(int count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// The corners of a face with consecutive repetitions removed.
std::vector<int> without_repeats(std::span<const int> corners) {
  std::vector<int> kept;
  for (const int v : corners)
    if (kept.empty() || kept.back() != v) kept.push_back(v);
  while (kept.size() > 1 && kept.front() == kept.back()) kept.pop_back();
  return kept;
}

bool has_distinct_corners(std::vector<int> corners) {
  std::sort(corners.begin(), corners.end());
  return corners.size() >= 3 && std::adjacent_find(corners.begin(), corners.end()) == corners.end();
}

/// Splits faces into triangles.
class Splitter {
 public:
  explicit Splitter(const Points& points) : points_(points) {}

  void split(std::span<const int> face, bool second_order, std::vector<std::array<int, 3>>& out) {
    if (second_order) {
      const size_t n = face.size() / 2;
      const auto middle = [&](size_t i) { return face[n + i % n]; };
      for (size_t i = 0; i < n; ++i) out.push_back({face[i], middle(i), middle(i + n - 1)});
      std::vector<int> inner;
      for (size_t i = 0; i < n; ++i) inner.push_back(middle(i));
      split_polygon(inner, out);
      return;
    }
    split_polygon(without_repeats(face), out);
  }

 private:
  double quality(int a, int b, int c) const {
    const Vec3 p = points_.row(a), q = points_.row(b), r = points_.row(c);
    const double longest =
        std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
    return longest > 0 ? (q - p).cross(r - p).norm() / longest : 0;
  }

  void split_polygon(const std::vector<int>& v, std::vector<std::array<int, 3>>& out) const {
    const size_t n = v.size();
    if (n == 3) {
      out.push_back({v[0], v[1], v[2]});
      return;
    }
    if (n == 4) {
      const auto length = [&](int i, int j) {
        return (points_.row(v[i]) - points_.row(v[j])).squaredNorm();
      };
      // Near a straight corner, one of the diagonals leaves a triangle without area.
      constexpr double kSliver = 0.1;
      const double first = std::min(quality(v[0], v[1], v[2]), quality(v[0], v[2], v[3])),
                   second = std::min(quality(v[0], v[1], v[3]), quality(v[1], v[2], v[3]));
      const bool shorter = length(0, 2) <= length(1, 3);
      if (shorter ? first >= kSliver * second : second < kSliver * first) {
        out.push_back({v[0], v[1], v[2]});
        out.push_back({v[0], v[2], v[3]});
      } else {
        out.push_back({v[0], v[1], v[3]});
        out.push_back({v[1], v[2], v[3]});
      }
      return;
    }
    constexpr size_t most_sides = 10'000;
    if (n > most_sides)
      throw InputError("found a face of " + std::to_string(n) + " corners, expected at most " +
                       std::to_string(most_sides));
    // Ear clipping: repeatedly cut off the ear of best quality, with respect to the normal of the
    // polygon. O(n²).
    Vec3 normal = Vec3::Zero();
    const Vec3 origin = points_.row(v[0]);
    for (size_t i = 1; i + 1 < n; ++i)
      normal += (points_.row(v[i]).transpose() - origin)
                    .cross(points_.row(v[i + 1]).transpose() - origin);
    std::vector<Ear> left(n);
    for (size_t i = 0; i < n; ++i) left[i].corner = v[i];
    for (size_t i = 0; i < n; ++i) measure(left, i, normal);
    while (left.size() > 3) {
      const size_t count = left.size();
      const size_t best = static_cast<size_t>(
          std::max_element(left.begin(), left.end(),
                           [](const Ear& x, const Ear& y) { return x.score < y.score; }) -
          left.begin());
      const int clipped = left[best].corner;
      out.push_back(
          {left[(best + count - 1) % count].corner, clipped, left[(best + 1) % count].corner});
      left.erase(left.begin() + static_cast<long>(best));
      const size_t next = best % left.size(), before = (next + left.size() - 1) % left.size();
      for (size_t i = 0; i < left.size(); ++i)
        if (i == next || i == before || left[i].contained == clipped) measure(left, i, normal);
    }
    out.push_back({left[0].corner, left[1].corner, left[2].corner});
  }

  // A corner of the remaining polygon as a candidate ear, the tip of a triangle that may be cut
  // off.
  struct Ear {
    int corner;
    double score = 0;
    int contained = -1;  // a corner inside the ear; the ear is measured again when that one is
                         // clipped
  };

  void measure(std::vector<Ear>& left, size_t i, const Vec3& normal) const {
    const size_t n = left.size();
    const int a = left[(i + n - 1) % n].corner, b = left[i].corner, c = left[(i + 1) % n].corner;
    const Vec3 p = points_.row(a), q = points_.row(b), r = points_.row(c);
    const bool outwards = (q - p).cross(r - p).dot(normal) <= 0;
    left[i].contained = outwards ? -1 : contained_corner(left, i, normal);
    left[i].score = quality(a, b, c) - (outwards || left[i].contained >= 0 ? 10 : 0);
  }

  int contained_corner(const std::vector<Ear>& left, size_t i, const Vec3& normal) const {
    const size_t n = left.size();
    const Vec3 corner[3] = {points_.row(left[(i + n - 1) % n].corner), points_.row(left[i].corner),
                            points_.row(left[(i + 1) % n].corner)};
    for (size_t k = 0; k < n; ++k) {
      if (k == i || k == (i + 1) % n || k == (i + n - 1) % n) continue;
      const Vec3 p = points_.row(left[k].corner);
      bool inside = true;
      for (int e = 0; e < 3; ++e)
        inside = inside && (corner[(e + 1) % 3] - corner[e]).cross(p - corner[e]).dot(normal) >= 0;
      if (inside) return left[k].corner;
    }
    return -1;
  }

  const Points& points_;
};

/// The triangles left after repairs, and the diagnosis.
struct MeshAnalysis {
  std::vector<int> face_of;
  ManifoldPatches manifold_patches;
  MeshDiagnosis found;
};

template <class T>
void append_limited(std::vector<T>& list, const T& item) {
  if (list.size() < kMaxListed) list.push_back(item);
}

/// Throws InputError for indices out of range. Counts unused and coincident nodes and lists nodes
/// that are not finite.
void check_nodes(const ShellMesh& shells, MeshDiagnosis& found) {
  const int n = shells.node_count();
  std::vector<char> used(n, 0);
  for (int f = 0; f < shells.face_count(); ++f)
    for (const int v : shells.face(f)) {
      if (v < 0 || v >= n)
        throw InputError("face " + std::to_string(f) + ": found node " + std::to_string(v) +
                         ", expected 0 to " + std::to_string(n - 1));
      used[v] = 1;
    }
  found.unused_nodes = static_cast<int>(std::count(used.begin(), used.end(), 0));
  for (int v = 0; v < n; ++v)
    if (used[v] && !shells.points.row(v).allFinite()) append_limited(found.non_finite_nodes, v);
  if (!found.non_finite_nodes.empty()) return;
  std::vector<std::array<double, 4>> places;
  for (int v = 0; v < n; ++v)
    if (used[v])
      places.push_back({shells.points(v, 0), shells.points(v, 1), shells.points(v, 2), 1.0 * v});
  std::sort(places.begin(), places.end());
  for (size_t i = 1; i < places.size(); ++i)
    found.coincident_nodes +=
        std::equal(places[i].begin(), places[i].begin() + 3, places[i - 1].begin());
}

/// Flags faces that are collapsed or duplicate an earlier face.
std::vector<char> faces_to_drop(const ShellMesh& shells, MeshDiagnosis& found) {
  std::vector<char> dropped(shells.face_count(), 0);
  std::vector<std::pair<std::vector<int>, int>> keys;
  for (int f = 0; f < shells.face_count(); ++f) {
    if (!has_distinct_corners(without_repeats(shells.corners(f)))) {
      dropped[f] = 1;
      ++found.collapsed_faces;
    }
    std::vector<int> key(shells.corners(f).begin(), shells.corners(f).end());
    std::sort(key.begin(), key.end());
    key.erase(std::unique(key.begin(), key.end()), key.end());
    keys.emplace_back(std::move(key), f);
  }
  std::sort(keys.begin(), keys.end());
  for (size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first && !dropped[keys[i].second]) {
      dropped[keys[i].second] = 1;
      ++found.duplicate_faces;
    }
  return dropped;
}

/// True if a triangle is too flat to have an area.
bool has_no_area(const Points& points, const std::array<int, 3>& t) {
  const Vec3 p = points.row(t[0]), q = points.row(t[1]), r = points.row(t[2]);
  const double longest =
      std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
  return !((q - p).cross(r - p).norm() > kFlat * longest);
}

void note_manifold_patches(MeshAnalysis& analysis) {
  const ManifoldPatches& manifold_patches = analysis.manifold_patches;
  MeshDiagnosis& found = analysis.found;
  found.components = manifold_patches.component_count;
  found.manifold_patches = manifold_patches.count;
  found.orientable = manifold_patches.cut_edges == 0;
  found.non_manifold_edge_count = isize(manifold_patches.non_manifold_edges);
  for (const auto& edge : manifold_patches.non_manifold_edges)
    append_limited(found.non_manifold_edges, edge);
  found.non_manifold_node_count = isize(manifold_patches.non_manifold_nodes);
  for (const int v : manifold_patches.non_manifold_nodes)
    append_limited(found.non_manifold_nodes, v);
  std::vector<int> faces;
  for (size_t t = 0; t < manifold_patches.flipped.size(); ++t)
    if (manifold_patches.flipped[t] && (faces.empty() || faces.back() != analysis.face_of[t]))
      faces.push_back(analysis.face_of[t]);
  found.flipped_faces = isize(faces);
}

MeshAnalysis examine(const ShellMesh& shells) {
  MeshAnalysis analysis;
  MeshDiagnosis& found = analysis.found;
  check_nodes(shells, found);
  if (!found.non_finite_nodes.empty()) return analysis;
  const std::vector<char> dropped = faces_to_drop(shells, found);
  Splitter splitter(shells.points);
  std::vector<std::array<int, 3>> triangles;
  for (int f = 0; f < shells.face_count(); ++f) {
    if (dropped[f]) continue;
    // A second-order element with a repeated corner or midside node is split by its corners only.
    const std::vector<int> all(shells.face(f).begin(), shells.face(f).end());
    const bool second = shells.second_order(f) && has_distinct_corners(all);
    splitter.split(second ? shells.face(f) : shells.corners(f), second, triangles);
    analysis.face_of.resize(triangles.size(), f);
  }
  for (const auto& t : triangles) found.zero_area_triangles += has_no_area(shells.points, t);
  analysis.manifold_patches = find_manifold_patches(shells.points, std::move(triangles));
  note_manifold_patches(analysis);
  return analysis;
}

}  // namespace

std::vector<std::vector<int>> polygons_of(const PreparedMesh& prepared) {
  const auto& triangles = prepared.mesh.triangles();
  std::vector<std::vector<int>> polygons;
  for (size_t first = 0, end = 0; first < triangles.size(); first = end) {
    std::map<int, int> after;  // next vertex along the outline; sides traversed in both directions
                               // are interior
    std::set<std::pair<int, int>> sides;
    for (; end < triangles.size() &&
           prepared.face_of_triangle[end] == prepared.face_of_triangle[first];
         ++end)
      for (int c = 0; c < 3; ++c) sides.insert({triangles[end][c], triangles[end][(c + 1) % 3]});
    for (const auto& [a, b] : sides)
      if (!sides.count({b, a})) after[a] = b;
    std::vector<int> polygon{after.begin()->first};
    while (after[polygon.back()] != polygon.front() && polygon.size() <= after.size())
      polygon.push_back(after[polygon.back()]);
    polygons.push_back(std::move(polygon));
  }
  return polygons;
}

MeshDiagnosis diagnose(const ShellMesh& shells) { return examine(shells).found; }

PreparedMesh prepare(const ShellMesh& shells, const std::function<std::string(int)>& node_name) {
  const auto name = [&](int v) { return node_name ? node_name(v) : std::to_string(v); };
  MeshAnalysis analysis = examine(shells);
  const MeshDiagnosis& d = analysis.found;
  if (shells.face_count() == 0) throw InputError("found no faces, expected a surface mesh");
  if (!d.non_finite_nodes.empty())
    throw InputError("node " + name(d.non_finite_nodes[0]) +
                     " has a coordinate that is not finite");
  if (analysis.face_of.empty())
    throw InputError("all " + count_of(shells.face_count(), "face") +
                     " have fewer than three distinct corners");
  if (d.zero_area_triangles > 0) {
    auto t =
        *std::find_if(analysis.manifold_patches.triangles.begin(),
                      analysis.manifold_patches.triangles.end(), [&](const auto& x) {
                        return has_no_area(shells.points, analysis.manifold_patches.nodes_of(x));
                      });
    t = analysis.manifold_patches.nodes_of(t);
    throw InputError("found " + count_of(d.zero_area_triangles, "triangle") +
                     " without area (the first has nodes " + name(t[0]) + ", " + name(t[1]) + ", " +
                     name(t[2]) + ")");
  }

  std::vector<std::string> notes;
  const auto add_note = [&](int count, const std::string& noun, const std::string& what) {
    if (count > 0) notes.push_back(count_of(count, noun) + " " + what);
  };
  add_note(d.collapsed_faces, "face", "with fewer than three distinct corners (ignored)");
  add_note(d.duplicate_faces, "face", "with the same nodes as another face (ignored)");
  add_note(d.flipped_faces, "face",
           "with reversed orientation (corrected in the computation only)");
  add_note(d.coincident_nodes, "node",
           "at the position of another node: the surface is open there");
  if (d.components > 1) notes.push_back("the mesh has " + std::to_string(d.components) + " parts");
  if (d.non_manifold_edge_count > 0)
    notes.push_back(count_of(d.non_manifold_edge_count, "edge") +
                    " with three or more faces (the first between nodes " +
                    name(d.non_manifold_edges[0][0]) + " and " + name(d.non_manifold_edges[0][1]) +
                    "): the parts of the surface stay connected there");
  if (d.non_manifold_node_count > 0)
    notes.push_back(count_of(d.non_manifold_node_count, "node") +
                    " where parts of the surface touch (the first is node " +
                    name(d.non_manifold_nodes[0]) + "): they stay connected there");
  if (!d.orientable)
    notes.push_back("the surface is not orientable (as a Möbius strip): it is cut along " +
                    count_of(analysis.manifold_patches.cut_edges, "edge") + " in the computation");
  TriangleMesh mesh(shells.points, std::move(analysis.manifold_patches.triangles),
                    std::move(analysis.manifold_patches.duplicate_vertex_nodes));
  return {std::move(mesh), std::move(analysis.face_of), d, std::move(notes)};
}

namespace {

/// One side of a triangle.
struct Side {
  std::array<int, 2> edge;  ///< low, high
  int triangle;
  bool forward;  ///< the triangle traverses low → high
};

/// True if two triangles, which have a common edge, have one that ends at v.
bool share_edge_at(int v, const std::array<int, 3>& x, const std::array<int, 3>& y) {
  const auto in_y = [&](int w) { return std::find(y.begin(), y.end(), w) != y.end(); };
  return in_y(v) && std::any_of(x.begin(), x.end(), [&](int w) { return w != v && in_y(w); });
}

class ManifoldPatchFinder {
 public:
  ManifoldPatchFinder(const Points& points, ManifoldPatches& manifold_patches)
      : points_(points),
        manifold_patches_(manifold_patches),
        nodes_(manifold_patches.triangles),
        links_(nodes_.size()),
        on_non_manifold_edge_(static_cast<size_t>(points.rows()), 0) {}

  void find() {
    link_all();
    orient();
    split_fans();
    count_components();
  }

 private:
  /// Adjacency across an edge within a patch.
  struct Link {
    int other;
    bool flipped;  ///< both triangles traverse the edge in the same direction
  };

  void link_all() {
    std::vector<Side> sides;
    for (int t = 0; t < isize(nodes_); ++t)
      for (int c = 0; c < 3; ++c) {
        const int a = nodes_[t][c], b = nodes_[t][(c + 1) % 3];
        sides.push_back({{std::min(a, b), std::max(a, b)}, t, a < b});
      }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
      return std::pair(x.edge, x.triangle) < std::pair(y.edge, y.triangle);
    });
    for (auto first = sides.begin(); first != sides.end();) {
      auto last = first + 1;
      while (last != sides.end() && last->edge == first->edge) ++last;
      if (last - first == 2) link(*first, *(first + 1));
      if (last - first > 2) link_non_manifold_edge({first, last});
      first = last;
    }
  }

  void link(const Side& x, const Side& y) {
    const bool flipped = x.forward == y.forward;
    links_[x.triangle].push_back({y.triangle, flipped});
    links_[y.triangle].push_back({x.triangle, flipped});
  }

  void link_non_manifold_edge(std::vector<Side> sides) {
    manifold_patches_.non_manifold_edges.push_back(sides[0].edge);
    for (const int v : sides[0].edge) on_non_manifold_edge_[v] = 1;
    while (sides.size() >= 2) {
      const auto [i, j] = continuing_pair(sides);
      if (i < 0) return;
      link(sides[i], sides[j]);
      sides.erase(sides.begin() + j);
      sides.erase(sides.begin() + i);
    }
  }

  /// The two triangles at a non-manifold edge that continue the same patch; {-1, -1} if there are
  /// none or the choice is ambiguous.
  std::array<int, 2> continuing_pair(const std::vector<Side>& sides) const {
    const Vec3 from = points_.row(sides[0].edge[0]), to = points_.row(sides[0].edge[1]);
    const Vec3 along = (to - from).normalized();
    std::vector<Vec3> away;
    for (const Side& side : sides)
      for (const int v : nodes_[side.triangle])
        if (v != side.edge[0] && v != side.edge[1]) {
          const Vec3 d = points_.row(v).transpose() - from;
          away.push_back((d - along.dot(d) * along).normalized());
        }
    constexpr double bends_by_45_degrees = -0.70710678, clear = 0.05;
    std::array<int, 2> best{-1, -1};
    double straightest = bends_by_45_degrees;
    for (int j = 0; j < isize(sides); ++j)
      for (int i = 0; i < j; ++i)
        if (const double cosine = away[i].dot(away[j]); cosine < straightest) {
          straightest = cosine;
          best = {i, j};
        }
    for (const int kept : best)
      for (int other = 0; kept >= 0 && other < isize(sides); ++other)
        if (other != best[0] && other != best[1] &&
            away[kept].dot(away[other]) < straightest + clear)
          return {-1, -1};
    return best;
  }

  /// Orients the triangles so that neighbours traverse their common edge in opposite directions.
  /// Cuts the patch open where that is impossible.
  void orient() {
    std::vector<int> flip(nodes_.size(), -1), stack;
    for (size_t seed = 0; seed < flip.size(); ++seed) {
      if (flip[seed] >= 0) continue;
      ++manifold_patches_.count;
      flip[seed] = 0;
      stack.push_back(static_cast<int>(seed));
      while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (const Link& link : links_[t]) {
          if (flip[link.other] >= 0) continue;
          flip[link.other] = flip[t] ^ static_cast<int>(link.flipped);
          stack.push_back(link.other);
        }
      }
    }
    for (int t = 0; t < isize(flip); ++t) cut_inconsistent_edges(t, flip);
    manifold_patches_.flipped.assign(flip.begin(), flip.end());
    for (size_t t = 0; t < flip.size(); ++t)
      if (flip[t] == 1) {
        std::swap(nodes_[t][1], nodes_[t][2]);
        std::swap(manifold_patches_.triangles[t][1], manifold_patches_.triangles[t][2]);
      }
  }

  void cut_inconsistent_edges(int t, const std::vector<int>& flip) {
    std::erase_if(links_[t], [&](const Link& link) {
      if (flip[link.other] == (flip[t] ^ static_cast<int>(link.flipped))) return false;
      manifold_patches_.cut_edges += t < link.other;
      for (const int v : nodes_[t])
        if (std::find(nodes_[link.other].begin(), nodes_[link.other].end(), v) !=
            nodes_[link.other].end())
          on_non_manifold_edge_[v] = 1;
      return true;
    });
  }

  /// Finds the fans: triangles around a node that are linked by edges at it. The first fan keeps
  /// the node as its vertex, each further fan gets a new vertex.
  void split_fans() {
    const auto node_count = static_cast<int>(points_.rows());
    std::vector<std::vector<int>> around(node_count);
    for (int t = 0; t < isize(nodes_); ++t)
      for (const int v : nodes_[t]) around[v].push_back(t);
    std::vector<int> fan;
    std::vector<char> seen(nodes_.size(), 0);
    for (int v = 0; v < node_count; ++v) {
      int fans = 0;
      for (const int seed : around[v]) {
        if (seen[seed]) continue;
        const int own =
            ++fans == 1 ? v : node_count + isize(manifold_patches_.duplicate_vertex_nodes);
        if (own != v) manifold_patches_.duplicate_vertex_nodes.push_back(v);
        seen[seed] = 1;
        fan = {seed};
        for (size_t i = 0; i < fan.size(); ++i) {
          const int t = fan[i];
          for (int c = 0; c < 3; ++c)
            if (nodes_[t][c] == v) manifold_patches_.triangles[t][c] = own;
          for (const Link& link : links_[t]) {
            if (seen[link.other] || !share_edge_at(v, nodes_[t], nodes_[link.other])) continue;
            seen[link.other] = 1;
            fan.push_back(link.other);
          }
        }
      }
      if (fans > 1 && !on_non_manifold_edge_[v]) manifold_patches_.non_manifold_nodes.push_back(v);
      for (const int t : around[v]) seen[t] = 0;
    }
  }

  void count_components() {
    DisjointSets groups(on_non_manifold_edge_.size());
    for (const auto& t : nodes_)
      for (const int v : t) groups.unite(t[0], v);
    std::vector<int> roots;
    for (const auto& t : nodes_) roots.push_back(groups.find(t[0]));
    std::sort(roots.begin(), roots.end());
    manifold_patches_.component_count =
        static_cast<int>(std::unique(roots.begin(), roots.end()) - roots.begin());
  }

  const Points& points_;
  ManifoldPatches& manifold_patches_;
  std::vector<std::array<int, 3>> nodes_;   // of each triangle
  std::vector<std::vector<Link>> links_;    // of each triangle
  std::vector<char> on_non_manifold_edge_;  // per node: 1 if it lies on an edge where a patch ends
};

}  // namespace

std::array<int, 3> ManifoldPatches::nodes_of(std::array<int, 3> triangle) const {
  const int node_count = vertex_count - isize(duplicate_vertex_nodes);
  for (int& v : triangle)
    if (v >= node_count) v = duplicate_vertex_nodes[v - node_count];
  return triangle;
}

ManifoldPatches find_manifold_patches(const Points& points,
                                      std::vector<std::array<int, 3>> triangles) {
  ManifoldPatches manifold_patches;
  manifold_patches.triangles = std::move(triangles);
  ManifoldPatchFinder(points, manifold_patches).find();
  manifold_patches.vertex_count =
      static_cast<int>(points.rows()) + isize(manifold_patches.duplicate_vertex_nodes);
  return manifold_patches;
}

}  // namespace batten
