// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/catmull_clark.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

using Key = std::pair<int, int>;
Key key(int a, int b) { return std::minmax(a, b); }

constexpr double kPermanent = std::numeric_limits<double>::infinity();

double sharpness_of(double given) { return given >= kInfinitelySharp ? kPermanent : given; }
/// Sharpness at the next level.
double remaining_sharpness(double sharpness) { return std::max(sharpness - 1, 0.0); }

/// Smooth rule: new position of a node with n edges. `sum`: the far ends of the edges plus the
/// centroids of the faces.
Vec3 smooth_moved(const Vec3& at, double n, const Vec3& sum) {
  return at * (n - 2) / n + sum / (n * n);
}
/// Smooth limit position in a quad mesh. `ends`: sum of the far ends of the edges; `across`: sum of
/// the diagonally opposite corners.
Vec3 smooth_limit(const Vec3& at, double n, const Vec3& ends, const Vec3& across) {
  return (n * n * at + 4 * ends + across) / (n * (n + 5));
}

/// An edge at a node: its far end and its sharpness.
struct RingEdge {
  Vec3 end;
  double sharp = 0;
};

/// A node and its edges: all that its subdivision rule depends on.
struct CentreVertex {
  Vec3 at;
  double corner = 0;  // sharpness of the node itself
  std::vector<RingEdge> ring_edges;

  enum class Rule { Smooth, Crease, Corner };
  Rule rule() const {
    const auto sharp = std::count_if(ring_edges.begin(), ring_edges.end(),
                                     [](const RingEdge& s) { return s.sharp > 0; });
    return corner > 0 || sharp > 2 ? Rule::Corner : sharp == 2 ? Rule::Crease : Rule::Smooth;
  }
  CentreVertex after_one_level() const {
    CentreVertex next = *this;
    next.corner = remaining_sharpness(corner);
    for (RingEdge& ring_edge : next.ring_edges)
      ring_edge.sharp = remaining_sharpness(ring_edge.sharp);
    return next;
  }
  /// Applies the rule of the node: its position (corner), (a + m v + b)/(m + 2) along its crease,
  /// or `smooth`.
  Vec3 apply_rule(double m, const Vec3& smooth) const {
    if (rule() != Rule::Crease) return rule() == Rule::Corner ? at : smooth;
    Vec3 ends = Vec3::Zero();
    for (const RingEdge& ring_edge : ring_edges)
      if (ring_edge.sharp > 0) ends += ring_edge.end;
    return (ends + m * at) / (m + 2);
  }
  /// Blending factor: mean of all sharpnesses at this node that end at this level, at most 1.
  double blend_fraction() const {
    double sum = 0;
    int count = 0;
    const auto add = [&](double sharp) {
      if (!(sharp > 0) || remaining_sharpness(sharp) > 0) return;
      sum += sharp;
      ++count;
    };
    add(corner);
    for (const RingEdge& ring_edge : ring_edges) add(ring_edge.sharp);
    return count == 0 ? 1 : std::min(sum / count, 1.0);
  }
  /// Position after one level; `centres`: sum of the centroids of its faces.
  Vec3 moved(const Vec3& centres) const {
    const double n = static_cast<double>(ring_edges.size());
    Vec3 sum = centres;
    for (const RingEdge& ring_edge : ring_edges) sum += ring_edge.end;
    const Vec3 smooth = smooth_moved(at, n, sum);
    const CentreVertex next = after_one_level();
    if (next.rule() == rule()) return apply_rule(6, smooth);
    return blend_fraction() * apply_rule(6, smooth) +
           (1 - blend_fraction()) * next.apply_rule(6, smooth);
  }
};

/// The new node on an edge; `smooth`: the edge point without sharpness.
Vec3 edge_point(const Vec3& a, const Vec3& b, double sharp, const Vec3& smooth) {
  const double weight = std::min(sharp, 1.0);
  return weight * (a + b) / 2 + (1 - weight) * smooth;
}

/// A node with the quads around it, which determine its limit position.
struct OneRing {
  struct RingFace {
    std::array<int, 2> ring_edges;
    Vec3 across;
  };
  CentreVertex centre_vertex;
  std::vector<RingFace> ring_faces;

  bool has_stable_rule() const {
    const auto is_permanent = [](double sharp) { return sharp == 0 || sharp == kPermanent; };
    const auto sharp =
        std::count_if(centre_vertex.ring_edges.begin(), centre_vertex.ring_edges.end(),
                      [](const RingEdge& s) { return s.sharp > 0; });
    return is_permanent(centre_vertex.corner) && (sharp != 1 || centre_vertex.corner > 0) &&
           std::all_of(centre_vertex.ring_edges.begin(), centre_vertex.ring_edges.end(),
                       [&](const RingEdge& s) { return is_permanent(s.sharp); });
  }

  void subdivide() {
    std::vector<Vec3> beside(centre_vertex.ring_edges.size(),
                             Vec3::Zero());  // per edge: sum of the centroids of the two faces
    Vec3 all = Vec3::Zero();
    for (RingFace& ring_face : ring_faces) {
      const auto& [a, b] = ring_face.ring_edges;
      ring_face.across = Vec3((centre_vertex.at + centre_vertex.ring_edges[a].end +
                               centre_vertex.ring_edges[b].end + ring_face.across) /
                              4);
      for (const int s : ring_face.ring_edges) beside[s] += ring_face.across;
      all += ring_face.across;
    }
    CentreVertex next = centre_vertex.after_one_level();
    next.at = centre_vertex.moved(all);
    for (size_t s = 0; s < centre_vertex.ring_edges.size(); ++s) {
      const RingEdge& ring_edge = centre_vertex.ring_edges[s];
      next.ring_edges[s].end = edge_point(centre_vertex.at, ring_edge.end, ring_edge.sharp,
                                          (centre_vertex.at + ring_edge.end + beside[s]) / 4);
    }
    centre_vertex = std::move(next);
  }

  Vec3 limit() {
    constexpr int most = 60;  // levels; each one halves the ring
    for (int level = 0; level < most && !has_stable_rule(); ++level) subdivide();
    Vec3 ends = Vec3::Zero(), across = Vec3::Zero();
    for (const RingEdge& ring_edge : centre_vertex.ring_edges) ends += ring_edge.end;
    for (const RingFace& ring_face : ring_faces) across += ring_face.across;
    return centre_vertex.apply_rule(
        4, smooth_limit(centre_vertex.at, static_cast<double>(centre_vertex.ring_edges.size()),
                        ends, across));
  }
};

/// A polygon mesh with its edges, and sharpnesses of edges and nodes.
class Cage {
 public:
  Cage(Points points, std::vector<std::vector<int>> faces, const CageTags& tags)
      : points_(std::move(points)), faces_(std::move(faces)), edges_at_(points_.rows()) {
    for (int f = 0; f < isize(faces_); ++f)
      for (size_t i = 0; i < faces_[f].size(); ++i) edge_of(f, i).faces.push_back(f);
    faces_at_.resize(points_.rows());
    for (int f = 0; f < isize(faces_); ++f)
      for (const int v : faces_[f]) faces_at_[v].push_back(f);
    corners_.resize(points_.rows(), 0.0);
    apply_tags(tags);
  }

  Cage subdivided() const {
    const long v0 = points_.rows(), e0 = v0 + isize(faces_);
    Points points(e0 + isize(edges_), 3);
    for (int f = 0; f < isize(faces_); ++f) points.row(v0 + f) = centre(f).transpose();
    CageTags tags;
    for (int e = 0; e < isize(edges_); ++e) {
      const Edge& edge = edges_[e];
      const int own = static_cast<int>(e0) + e;
      Vec3 smooth = at(edge.low) + at(edge.high);
      for (const int f : edge.faces) smooth += centre(f);
      points.row(own) = edge_point(at(edge.low), at(edge.high), edge.sharp, smooth / 4).transpose();
      if (const double sharp = remaining_sharpness(edge.sharp); sharp > 0)
        for (const int end : {edge.low, edge.high}) tags.creases.push_back({end, own, sharp});
    }
    for (int v = 0; v < v0; ++v) {
      points.row(v) = moved(v).transpose();
      if (const double sharp = remaining_sharpness(corners_[v]); sharp > 0)
        tags.corners.push_back({v, sharp});
    }
    std::vector<std::vector<int>> quads;
    for (int f = 0; f < isize(faces_); ++f) {
      const auto& face = faces_[f];
      const size_t n = face.size();
      for (size_t i = 0; i < n; ++i)
        quads.push_back({face[i], static_cast<int>(e0) + number(face[i], face[(i + 1) % n]),
                         static_cast<int>(v0) + f,
                         static_cast<int>(e0) + number(face[(i + n - 1) % n], face[i])});
    }
    return Cage(std::move(points), std::move(quads), tags);
  }

  /// The limit surface. All faces must be quads.
  ShellMesh limit() const {
    ShellMesh mesh;
    mesh.points.resize(points_.rows(), 3);
    for (int v = 0; v < points_.rows(); ++v) mesh.points.row(v) = limit_of(v).transpose();
    for (const auto& face : faces_) mesh.add_face(face);
    return mesh;
  }

 private:
  struct Edge {
    int low, high;
    std::vector<int> faces;
    double sharp = 0;
  };

  void apply_tags(const CageTags& tags) {
    for (const auto& [a, b, sharp] : tags.creases) {
      const auto found = number_.find(key(a, b));
      if (found == number_.end())
        throw InputError("the crease from node " + std::to_string(a + 1) + " to " +
                         std::to_string(b + 1) + " is not an edge of the cage");
      edges_[found->second].sharp = sharpness_of(sharp);
    }
    for (const auto& [node, sharp] : tags.corners) {
      if (node < 0 || node >= points_.rows())
        throw InputError("the corner " + std::to_string(node + 1) + " is not a node of the cage");
      corners_[node] = sharpness_of(sharp);
    }
    for (Edge& edge : edges_)
      if (edge.faces.size() != 2) edge.sharp = kPermanent;
    for (size_t v = 0; v < corners_.size(); ++v)
      if (faces_at_[v].size() == 1 || ends_joint(v)) corners_[v] = kPermanent;
  }
  /// True if exactly one edge with a face count other than two ends at the node.
  bool ends_joint(size_t v) const {
    return std::count_if(edges_at_[v].begin(), edges_at_[v].end(),
                         [&](int e) { return edges_[e].faces.size() != 2; }) == 1;
  }

  Edge& edge_of(int f, size_t i) {
    const Key k = key(faces_[f][i], faces_[f][(i + 1) % faces_[f].size()]);
    const auto [found, is_new] = number_.emplace(k, isize(edges_));
    if (is_new) {
      edges_.push_back({k.first, k.second, {}, 0});
      edges_at_[k.first].push_back(found->second);
      edges_at_[k.second].push_back(found->second);
    }
    return edges_[found->second];
  }
  int number(int a, int b) const { return number_.at(key(a, b)); }
  Vec3 at(int v) const { return points_.row(v).transpose(); }
  Vec3 centre(int f) const {
    Vec3 sum = Vec3::Zero();
    for (const int v : faces_[f]) sum += at(v);
    return sum / static_cast<double>(faces_[f].size());
  }

  bool sharp_at(int v) const {
    return corners_[v] > 0 || std::any_of(edges_at_[v].begin(), edges_at_[v].end(),
                                          [&](int e) { return edges_[e].sharp > 0; });
  }
  Vec3 far_end(int e, int v) const {
    return at(edges_[e].low == v ? edges_[e].high : edges_[e].low);
  }
  Vec3 far_ends(int v) const {
    Vec3 sum = Vec3::Zero();
    for (const int e : edges_at_[v]) sum += far_end(e, v);
    return sum;
  }
  /// Index of the node among the corners of face f.
  long corner_index(int f, int v) const {
    return std::find(faces_[f].begin(), faces_[f].end(), v) - faces_[f].begin();
  }

  CentreVertex centre_vertex(int v) const {
    CentreVertex centre_vertex{at(v), corners_[v], {}};
    for (const int e : edges_at_[v])
      centre_vertex.ring_edges.push_back({far_end(e, v), edges_[e].sharp});
    return centre_vertex;
  }
  Vec3 moved(int v) const {
    if (edges_at_[v].empty()) return at(v);
    Vec3 centres = Vec3::Zero();
    for (const int f : faces_at_[v]) centres += centre(f);
    if (sharp_at(v)) return centre_vertex(v).moved(centres);
    return smooth_moved(at(v), static_cast<double>(edges_at_[v].size()), far_ends(v) + centres);
  }
  Vec3 limit_of(int v) const {
    if (edges_at_[v].empty()) return at(v);
    if (sharp_at(v)) return ring(v).limit();
    Vec3 across = Vec3::Zero();
    for (const int f : faces_at_[v]) across += at(faces_[f][(corner_index(f, v) + 2) % 4]);
    return smooth_limit(at(v), static_cast<double>(edges_at_[v].size()), far_ends(v), across);
  }
  OneRing ring(int v) const {
    OneRing ring{centre_vertex(v), {}};
    const auto ring_edge = [&](int other) {
      const auto& edges = edges_at_[v];
      return static_cast<int>(std::find(edges.begin(), edges.end(), number(v, other)) -
                              edges.begin());
    };
    for (const int f : faces_at_[v]) {
      const auto& quad = faces_[f];
      const long i = corner_index(f, v);
      ring.ring_faces.push_back(
          {{ring_edge(quad[(i + 1) % 4]), ring_edge(quad[(i + 3) % 4])}, at(quad[(i + 2) % 4])});
    }
    return ring;
  }

  Points points_;
  std::vector<std::vector<int>> faces_;
  std::vector<Edge> edges_;
  std::map<Key, int> number_;
  std::vector<std::vector<int>> edges_at_, faces_at_;
  std::vector<double> corners_;  // sharpness per node
};

void check_sharpness(double sharpness) {
  if (!(sharpness >= 0))
    throw InputError("found a sharpness of " + batten::format_number(sharpness) +
                     ", expected 0 or more");
}

void check(const ShellMesh& cage, const CatmullClarkOptions& options) {
  constexpr double most = 4e6;
  if (options.levels < 1)
    throw InputError("found " + std::to_string(options.levels) +
                     " levels of subdivision, expected 1 or more");
  for (const CageCrease& crease : options.tags.creases) check_sharpness(crease.sharpness);
  for (const CageCorner& corner : options.tags.corners) check_sharpness(corner.sharpness);
  double quads = 0;
  for (int f = 0; f < cage.face_count(); ++f) quads += static_cast<double>(cage.corners(f).size());
  for (int k = 1; k < options.levels && quads <= most; ++k) quads *= 4;
  if (quads > most)
    throw InputError("found " + std::to_string(options.levels) + " levels of subdivision of " +
                     std::to_string(cage.face_count()) +
                     " faces, expected fewer: they make more than 4,000,000 quads");
}

}  // namespace

ShellMesh catmull_clark(const ShellMesh& cage, const CatmullClarkOptions& options) {
  check(cage, options);
  std::vector<std::vector<int>> faces;
  for (int f = 0; f < cage.face_count(); ++f)
    faces.emplace_back(cage.corners(f).begin(), cage.corners(f).end());
  Cage fine = Cage(cage.points, std::move(faces), options.tags).subdivided();
  for (int level = 1; level < options.levels; ++level) fine = fine.subdivided();
  return fine.limit();
}

ShellMesh catmull_clark_limit(const ShellMesh& cage, const CageTags& tags, double chord) {
  constexpr int max_rounds = 8;
  constexpr double most = 2e5;
  ShellMesh fine = catmull_clark(cage, {1, tags});
  for (int rounds = 2; rounds <= max_rounds && 4.0 * fine.face_count() <= most; ++rounds) {
    ShellMesh next = catmull_clark(cage, {rounds, tags});
    // Face centres are appended in order after the existing nodes.
    double off = 0;
    for (int f = 0; f < fine.face_count(); ++f) {
      Vec3 middle = Vec3::Zero();
      for (const int v : fine.corners(f)) middle += fine.points.row(v).transpose() / 4;
      off = std::max(off, (middle - next.points.row(fine.node_count() + f).transpose()).norm());
    }
    fine = std::move(next);
    if (off < 4 * chord) break;  // one more round quarters it
  }
  return fine;
}

}  // namespace batten
