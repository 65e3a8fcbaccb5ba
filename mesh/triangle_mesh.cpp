// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

std::string named(int vertex) { return std::to_string(vertex); }

}  // namespace

MeshTopology::MeshTopology(int node_count, std::vector<std::array<int, 3>> triangles,
                           std::vector<int> duplicate_vertex_nodes)
    : vertex_count_(node_count + isize(duplicate_vertex_nodes)),
      triangles_(std::move(triangles)),
      duplicate_vertex_nodes_(std::move(duplicate_vertex_nodes)) {
  for (const int node : duplicate_vertex_nodes_)
    if (node < 0 || node >= node_count)
      throw InputError("found a vertex of node " + named(node) + ", but there are " +
                       std::to_string(node_count) + " nodes");
  for (size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [a, b, c] = triangles_[t];
    for (const int v : {a, b, c})
      if (v < 0 || v >= vertex_count_)
        throw InputError("triangle " + std::to_string(t) + " uses vertex " + named(v) +
                         ", but there are " + std::to_string(vertex_count_) + " vertices");
    if (a == b || b == c || c == a)
      throw InputError("triangle " + std::to_string(t) + " has vertex " +
                       named(node_of(a == b || a == c ? a : b)) + " twice");
  }
  find_coincident_vertices();
  find_edges();
  find_fans();
  find_loops();
  find_components();
}

void MeshTopology::find_edges() {
  struct Side {
    int low, high, triangle, corner;  // the edge is opposite to the corner
    bool forward;                     // the triangle traverses low → high
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles_.size());
  // Bucket the sides by their lower vertex, so that only short lists remain to be sorted.
  std::vector<int> start(vertex_count_ + 1, 0);
  for (const auto& t : triangles_)
    for (int c = 0; c < 3; ++c) ++start[std::min(t[(c + 1) % 3], t[(c + 2) % 3]) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  sides.resize(3 * triangles_.size());
  std::vector<int> next(start.begin(), start.end() - 1);
  for (int t = 0; t < triangle_count(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int a = triangles_[t][(c + 1) % 3], b = triangles_[t][(c + 2) % 3];
      sides[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), t, c, a < b};
    }
  edges_of_.resize(triangles_.size());
  edges_.reserve(triangles_.size() * 3 / 2 + 16);
  for (int v = 0; v < vertex_count_; ++v) {
    std::sort(sides.begin() + start[v], sides.begin() + start[v + 1],
              [](const Side& x, const Side& y) {
                return std::pair(x.high, x.triangle) < std::pair(y.high, y.triangle);
              });
    for (int i = start[v]; i < start[v + 1];) {
      int end = i + 1;
      while (end < start[v + 1] && sides[end].high == sides[i].high) ++end;
      const std::string where = "the edge between vertices " + named(node_of(sides[i].low)) +
                                " and " + named(node_of(sides[i].high));
      if (end - i > 2)
        throw InputError(where + " has " + std::to_string(end - i) +
                         " triangles, expected one or two");
      if (end - i == 2 && sides[i].forward == sides[i + 1].forward)
        throw InputError("the two triangles at " + where +
                         " have opposite orientations, expected equal ones");
      Edge edge{sides[i].low, sides[i].high, -1, -1};
      for (; i < end; ++i) {
        (sides[i].forward ? edge.left : edge.right) = sides[i].triangle;
        edges_of_[sides[i].triangle][sides[i].corner] = isize(edges_);
      }
      edges_.push_back(edge);
    }
  }

  neighbour_start_.assign(vertex_count_ + 1, 0);
  for (const Edge& e : edges_) {
    ++neighbour_start_[e.low + 1];
    ++neighbour_start_[e.high + 1];
  }
  std::partial_sum(neighbour_start_.begin(), neighbour_start_.end(), neighbour_start_.begin());
  neighbours_.resize(2 * edges_.size());
  next.assign(neighbour_start_.begin(), neighbour_start_.end() - 1);
  // Edges are sorted by (low, high): so the lower neighbours of a vertex ascend, then the higher
  // ones.
  for (const Edge& e : edges_) neighbours_[next[e.high]++] = e.low;
  for (const Edge& e : edges_) neighbours_[next[e.low]++] = e.high;
}

int MeshTopology::across(int triangle, int corner) const {
  const Edge& e = edges_[edges_of_[triangle][corner]];
  return e.left == triangle ? e.right : e.left;
}

void MeshTopology::find_fans() {
  triangle_start_.assign(vertex_count_ + 1, 0);
  for (const auto& t : triangles_)
    for (const int v : t) ++triangle_start_[v + 1];
  std::partial_sum(triangle_start_.begin(), triangle_start_.end(), triangle_start_.begin());
  triangles_of_.resize(3 * triangles_.size());
  std::vector<int> next(triangle_start_.begin(), triangle_start_.end() - 1);
  for (int t = 0; t < triangle_count(); ++t)
    for (const int v : triangles_[t]) triangles_of_[next[v]++] = t;

  // A closed fan has as many edges as triangles, an open fan one more.
  on_boundary_.assign(vertex_count_, 0);
  std::vector<int> open_ends(vertex_count_, 0);
  for (const Edge& e : edges_)
    if (e.left < 0 || e.right < 0)
      for (const int v : {e.low, e.high}) {
        on_boundary_[v] = 1;
        ++open_ends[v];
      }
  for (int v = 0; v < vertex_count_; ++v) {
    const auto own = triangles_of(v);
    if (own.empty()) continue;
    // Walk the fan from its open end, or from any triangle if it is closed.
    const auto corner_in = [&](int t) {
      return triangles_[t][0] == v ? 0 : triangles_[t][1] == v ? 1 : 2;
    };
    int first = own[0];
    if (open_ends[v] > 0)
      for (const int t : own)
        if (across(t, (corner_in(t) + 2) % 3) < 0) first = t;
    size_t seen = 0;
    int t = first;
    do {
      ++seen;
      t = across(t, (corner_in(t) + 1) % 3);
    } while (t >= 0 && t != first);
    if (seen != own.size())
      throw InputError("vertex " + named(node_of(v)) +
                       " is non-manifold, expected one fan of triangles around every vertex");
  }
}

void MeshTopology::find_coincident_vertices() {
  const int n = node_count();
  coincident_start_.assign(n + 1, 0);
  for (int v = 0; v < vertex_count_; ++v) ++coincident_start_[node_of(v) + 1];
  std::partial_sum(coincident_start_.begin(), coincident_start_.end(), coincident_start_.begin());
  coincident_vertices_.resize(vertex_count_);
  std::vector<int> next(coincident_start_.begin(), coincident_start_.end() - 1);
  for (int v = 0; v < vertex_count_; ++v) coincident_vertices_[next[node_of(v)]++] = v;
}

std::vector<int> MeshTopology::expand_to_nodes(std::vector<int> vertices) const {
  for (size_t i = 0, given = vertices.size(); i < given; ++i)
    for (const int v : coincident_vertices(vertices[i]))
      if (v != vertices[i]) vertices.push_back(v);
  return sorted_unique(std::move(vertices));
}

std::vector<int> MeshTopology::nodes_of(std::vector<int> vertices) const {
  for (int& v : vertices) v = node_of(v);
  return sorted_unique(std::move(vertices));
}

std::vector<char> MeshTopology::non_manifold_edges() const {
  if (duplicate_vertex_nodes_.empty()) return {};
  std::vector<std::pair<std::pair<int, int>, int>> ends(edges_.size());
  for (size_t e = 0; e < edges_.size(); ++e)
    ends[e] = {std::minmax({node_of(edges_[e].low), node_of(edges_[e].high)}), static_cast<int>(e)};
  std::sort(ends.begin(), ends.end());
  std::vector<char> joint(edges_.size(), 0);
  for (size_t i = 1; i < ends.size(); ++i)
    if (ends[i].first == ends[i - 1].first) joint[ends[i].second] = joint[ends[i - 1].second] = 1;
  return joint;
}

void MeshTopology::find_loops() {
  // The surface is on the left of the boundary, so a boundary edge runs like its only triangle.
  std::vector<int> after(vertex_count_, -1);
  std::vector<char> into_joint(vertex_count_, 0);
  const std::vector<char> joint = non_manifold_edges();
  for (size_t i = 0; i < edges_.size(); ++i) {
    const Edge& e = edges_[i];
    if (e.left >= 0 && e.right >= 0) continue;
    const int from = e.right < 0 ? e.low : e.high;
    after[from] = e.right < 0 ? e.high : e.low;
    into_joint[from] = !joint.empty() && joint[i];
  }
  for (int v = 0; v < vertex_count_; ++v) {
    if (after[v] < 0) continue;
    std::vector<int> loop;
    bool along_joint = false;
    for (int w = v; after[w] >= 0;) {
      loop.push_back(w);
      along_joint |= into_joint[w] != 0;
      w = std::exchange(after[w], -1);
    }
    (along_joint ? non_manifold_loops_ : loops_).push_back(std::move(loop));
  }
}

void MeshTopology::find_components() {
  component_.assign(vertex_count_, -1);
  std::vector<int> stack;
  for (int v = 0; v < vertex_count_; ++v) {
    if (component_[v] >= 0 || neighbours(v).empty()) continue;
    component_[v] = component_count_;
    stack.push_back(v);
    while (!stack.empty()) {
      const int w = stack.back();
      stack.pop_back();
      for (const int u : neighbours(w))
        if (component_[u] < 0) {
          component_[u] = component_count_;
          stack.push_back(u);
        }
    }
    ++component_count_;
  }
}

TriangleMesh::TriangleMesh(Points points, std::vector<std::array<int, 3>> triangles,
                           std::vector<int> duplicate_vertex_nodes)
    : TriangleMesh(nullptr, std::move(points)) {
  const auto nodes = static_cast<int>(points_.rows());
  topology_ = std::make_shared<const MeshTopology>(nodes, std::move(triangles),
                                                   std::move(duplicate_vertex_nodes));
  points_.conservativeResize(vertex_count(), 3);
  for (int v = nodes; v < vertex_count(); ++v) points_.row(v) = points_.row(topology_->node_of(v));
}

TriangleMesh::TriangleMesh(std::shared_ptr<const MeshTopology> topology, Points points)
    : points_(std::move(points)), topology_(std::move(topology)) {
  for (long v = 0; v < points_.rows(); ++v)
    if (!points_.row(v).allFinite())
      throw InputError("vertex " + named(static_cast<int>(v)) +
                       " has a coordinate that is not finite");
}

TriangleMesh TriangleMesh::with_points(Points points) const {
  if (points.rows() != points_.rows())
    throw InputError("found " + std::to_string(points.rows()) + " points, expected " +
                     std::to_string(points_.rows()));
  return TriangleMesh(topology_, std::move(points));
}

Vec3 TriangleMesh::area_vector(int triangle) const {
  const auto& [a, b, c] = triangles()[triangle];
  return (point(b) - point(a)).cross(point(c) - point(a));
}

Box3 TriangleMesh::box() const {
  Box3 box;
  for (int v = 0; v < vertex_count(); ++v)
    if (!topology_->neighbours(v).empty()) box.extend(point(v));
  return box;
}

double TriangleMesh::size() const { return triangle_count() == 0 ? 0 : box().diagonal().norm(); }

double TriangleMesh::length(const std::vector<int>& closed_loop) const {
  double sum = 0;
  for (size_t i = 0; i < closed_loop.size(); ++i)
    sum += (point(closed_loop[i]) - point(closed_loop[(i + 1) % closed_loop.size()])).norm();
  return sum;
}

namespace {

/// Barycentric coordinates of the point of a triangle closest to p. Source: [Ericson2005], 5.1.5.
Vec3 nearest_in_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

}  // namespace

std::vector<TriangleTree::Corners> TriangleTree::corners_of(const TriangleMesh& mesh) {
  std::vector<Corners> corners;
  corners.reserve(mesh.triangles().size());
  for (const auto& [a, b, c] : mesh.triangles())
    corners.push_back({mesh.point(a), mesh.point(b), mesh.point(c)});
  return corners;
}

BoxTree<3> TriangleTree::boxes_of(const std::vector<Corners>& triangles) {
  std::vector<Box3> boxes;
  std::vector<Vec3> centroids;
  for (const Corners& corners : triangles) {
    boxes.push_back(bounding_box(corners));
    centroids.push_back((corners[0] + corners[1] + corners[2]) / 3);
  }
  return BoxTree<3>(boxes, centroids);
}

TriangleTree::TriangleTree(const TriangleMesh& mesh)
    : corners_(corners_of(mesh)), tree_(boxes_of(corners_)) {}

std::optional<TriangleTree::ClosestPoint> TriangleTree::nearest(
    const Vec3& p, const std::optional<Vec3>& normal) const {
  if (!normal) return search(p, [](int) { return true; });
  return search(p, [&](int t) {
    const auto& [a, b, c] = corners_[t];
    return (b - a).cross(c - a).dot(*normal) > 0;
  });
}

std::optional<TriangleTree::ClosestPoint> TriangleTree::nearest_among(
    const Vec3& p, const std::function<bool(int triangle)>& accepts) const {
  return search(p, accepts);
}

template <class Accepts>
std::optional<TriangleTree::ClosestPoint> TriangleTree::search(const Vec3& p,
                                                               const Accepts& accepts) const {
  Vec3 at, weights;
  const auto distance2_of = [&](int t) {
    const auto& [a, b, c] = corners_[t];
    weights = nearest_in_triangle(p, a, b, c);
    at = weights[0] * a + weights[1] * b + weights[2] * c;
    return (at - p).squaredNorm();
  };
  double best = kInfinity;  // of the accepted triangles: most of them are farther, which is cheaper
  const auto [triangle, distance2] = tree_.nearest(p, [&](int t) {
    const double found = distance2_of(t);
    if (!(found <= best) || !accepts(t)) return kInfinity;
    best = found;
    return found;
  });
  if (triangle < 0) return {};
  distance2_of(triangle);
  return ClosestPoint{triangle, at, weights, std::sqrt(distance2)};
}

}  // namespace batten
