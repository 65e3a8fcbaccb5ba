// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/parametric_mesh.h"

#include <algorithm>
#include <cmath>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

Vec2 nearest_image(const Vec2& p, const Vec2& anchor, double period) {
  if (period == 0) return p;
  return {p.x() + period * std::round((anchor.x() - p.x()) / period), p.y()};
}

}  // namespace

ParametricMesh::ParametricMesh(std::vector<Vec2> vertices, std::vector<Triangle> triangles,
                               double period)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)), period_(period) {
  if (!(period >= 0) || !std::isfinite(period))
    throw MeshError("found a parametric mesh with the period " + format_number(period) +
                    ", expected a positive number, or 0 for none");
  const int n = vertex_count();
  for (int v = 0; v < n; ++v)
    if (!vertices_[v].allFinite())
      throw MeshError("parametric vertex " + std::to_string(v) + " is not finite");
  if (period_ > 0)
    for (int v = 0; v < n; ++v)
      if (!(vertices_[v].x() >= 0 && vertices_[v].x() < period_))
        throw MeshError("parametric vertex " + std::to_string(v) +
                        " has u = " + format_number(vertices_[v].x()) +
                        ", expected a value in one period, 0 to " + format_number(period_));
  if (triangles_.empty()) throw MeshError("a parametric mesh needs at least one triangle");
  edges_from_.resize(n);
  triangle_edges_.resize(triangles_.size());
  std::vector<char> used(n, 0);
  for (int t = 0; t < triangle_count(); ++t) {
    poll_every<8192>(t);
    const Triangle& tri = triangles_[t];
    for (const int v : tri) {
      if (v < 0 || v >= n)
        throw MeshError("triangle " + std::to_string(t) + " uses vertex " + std::to_string(v) +
                        ", expected 0 to " + std::to_string(n - 1));
      used[v] = 1;
    }
    for (int i = 0; i < 3; ++i) {
      const int a = tri[(i + 1) % 3], b = tri[(i + 2) % 3];
      const int low = std::min(a, b), high = std::max(a, b);
      int e = edge_between(low, high);
      if (e < 0) {
        e = edge_count();
        edges_.push_back({low, high, {t, -1}, {i, -1}});
        edges_from_[low].push_back(e);
        // Three longer edges could form a closed loop around the tube.
        constexpr double margin = 1e-9;
        if (period_ > 0 && std::abs(edge_vector(e).x()) > (1 - margin) * period_ / 3)
          throw MeshError("edge " + std::to_string(low) + "-" + std::to_string(high) + " spans " +
                          format_number(std::abs(edge_vector(e).x())) +
                          " in u, a third of the period or more; a periodic mesh needs at least "
                          "four columns");
      } else {
        Edge& edge = edges_[e];
        const auto name = std::to_string(low) + "-" + std::to_string(high);
        if (!edge.boundary()) throw MeshError("edge " + name + " has more than two triangles");
        edge.triangle[1] = t;
        edge.local[1] = i;
        if (edge_sign(edge.triangle[0], edge.local[0]) == edge_sign(t, i))
          throw MeshError("the triangles at edge " + name + " have opposite orientations");
      }
      triangle_edges_[t][i] = e;
    }
    shape(t);  // throws unless counter-clockwise
  }
  for (int v = 0; v < n; ++v)
    if (!used[v])
      throw MeshError("parametric vertex " + std::to_string(v) + " belongs to no triangle");
}

ParametricMesh ParametricMesh::concatenated(const std::vector<const ParametricMesh*>& meshes) {
  ParametricMesh all;
  for (const ParametricMesh* mesh : meshes) {
    throw_if_cancelled();
    const int v0 = all.vertex_count(), e0 = all.edge_count(), t0 = all.triangle_count();
    if (mesh->components_.empty()) all.components_.push_back({v0, mesh->period_});
    for (const Component& component : mesh->components_)
      all.components_.push_back({v0 + component.first_vertex, component.period});
    all.vertices_.insert(all.vertices_.end(), mesh->vertices_.begin(), mesh->vertices_.end());
    for (const Triangle& t : mesh->triangles_)
      all.triangles_.push_back({v0 + t[0], v0 + t[1], v0 + t[2]});
    for (const Triangle& t : mesh->triangle_edges_)
      all.triangle_edges_.push_back({e0 + t[0], e0 + t[1], e0 + t[2]});
    for (Edge e : mesh->edges_) {
      e.low += v0;
      e.high += v0;
      for (int& t : e.triangle)
        if (t >= 0) t += t0;
      all.edges_.push_back(e);
    }
    for (std::vector<int> edges : mesh->edges_from_) {
      for (int& e : edges) e += e0;
      all.edges_from_.push_back(std::move(edges));
    }
  }
  return all;
}

double ParametricMesh::period_at(int vertex) const {
  if (components_.empty()) return period_;
  const auto after = std::upper_bound(
      components_.begin(), components_.end(), vertex,
      [](int v, const Component& component) { return v < component.first_vertex; });
  return std::prev(after)->period;
}

int ParametricMesh::edge_between(int a, int b) const {
  const int low = std::min(a, b), high = std::max(a, b);
  for (const int e : edges_from_[low])
    if (edges_[e].high == high) return e;
  return -1;
}

TriangleShape ParametricMesh::shape(int t) const {
  const Triangle& tri = triangles_[t];
  const Vec2& first = vertices_[tri[0]];
  const double period = period_at(tri[0]);
  return {first,
          nearest_image(vertices_[tri[1]], first, period),
          nearest_image(vertices_[tri[2]], first, period),
          {edge_sign(t, 0), edge_sign(t, 1), edge_sign(t, 2)}};
}

Vec2 ParametricMesh::image_near(const Vec2& p, const Vec2& anchor) const {
  return nearest_image(p, anchor, period_);
}

Vec2 ParametricMesh::wrapped(Vec2 p) const {
  if (period_ == 0) return p;
  p.x() -= period_ * std::floor(p.x() / period_);
  if (!(p.x() < period_)) p.x() = 0;  // can result from rounding slightly below zero
  return p;
}

Vec2 ParametricMesh::chain_vector(const std::vector<int>& chain) const {
  if (period_ == 0) return vertices_[chain.back()] - vertices_[chain.front()];
  Vec2 sum = Vec2::Zero();
  for (size_t i = 0; i + 1 < chain.size(); ++i) {
    const Vec2& from = vertices_[chain[i]];
    sum += image_near(vertices_[chain[i + 1]], from) - from;
  }
  return sum;
}

Vec2 ParametricMesh::edge_vector(int e) const {
  const Vec2& low = vertices_[edges_[e].low];
  return nearest_image(vertices_[edges_[e].high], low, period_at(edges_[e].low)) - low;
}

Vec2 ParametricMesh::edge_tangent(int e) const { return edge_vector(e).normalized(); }

Vec2 ParametricMesh::edge_normal(int e) const {
  const Vec2 t = edge_tangent(e);
  return {-t.y(), t.x()};
}

double ParametricMesh::edge_length(int e) const { return edge_vector(e).norm(); }

ParametricMesh ParametricMesh::unit_square(int n) {
  if (n < 1) throw InputError("a square mesh needs at least one square per side");
  std::vector<Vec2> vertices;
  std::vector<Triangle> triangles;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      vertices.emplace_back(static_cast<double>(i) / n, static_cast<double>(j) / n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  return {std::move(vertices), std::move(triangles)};
}

ParametricMesh ParametricMesh::refined() const {
  std::vector<Vec2> vertices = vertices_;
  for (const Edge& e : edges_) {
    const Vec2& low = vertices_[e.low];
    vertices.push_back(wrapped(0.5 * (low + image_near(vertices_[e.high], low))));
  }
  std::vector<Triangle> triangles;
  for (int t = 0; t < triangle_count(); ++t) {
    const Triangle &v = triangles_[t], &e = triangle_edges_[t];
    const int m[3] = {vertex_count() + e[0], vertex_count() + e[1], vertex_count() + e[2]};
    triangles.push_back({v[0], m[2], m[1]});
    triangles.push_back({v[1], m[0], m[2]});
    triangles.push_back({v[2], m[1], m[0]});
    triangles.push_back({m[0], m[1], m[2]});
  }
  return {std::move(vertices), std::move(triangles), period_};
}

std::array<int, 12> DofMap::triangle(const ParametricMesh& mesh, int t) const {
  const auto &v = mesh.triangles()[t], &e = mesh.edges_of(t);
  return {3 * v[0], 3 * v[0] + 1, 3 * v[0] + 2, 3 * v[1],   3 * v[1] + 1, 3 * v[1] + 2,
          3 * v[2], 3 * v[2] + 1, 3 * v[2] + 2, edge(e[0]), edge(e[1]),   edge(e[2])};
}

namespace {

class Dissection {
 public:
  explicit Dissection(const ParametricMesh& mesh)
      : mesh_(mesh),
        dofs_(mesh),
        triangles_(mesh.triangle_count()),
        centre_(mesh.triangle_count()),
        seen_(mesh.vertex_count() + mesh.edge_count(), 0),
        side_(seen_.size(), 0),
        half_(mesh.triangle_count(), 0) {
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      triangles_[t] = t;
      const auto& corner = mesh.shape(t).vertex;
      centre_[t] = corner[0] + corner[1] + corner[2];
    }
    order_.resize(dofs_.count());
    next_ = dofs_.count();
  }

  std::vector<int> order() {
    split(0, isize(triangles_));
    return std::move(order_);
  }

 private:
  static constexpr int kLeaf = 6;              // triangles
  static constexpr int kPollTriangles = 1000;  // 1 ms

  // Visits vertices and edges in one numbering: edges follow all vertices.
  template <class Visit>
  void for_each_entity(int triangle, const Visit& visit) const {
    for (const int v : mesh_.triangles()[triangle]) visit(v);
    for (const int e : mesh_.edges_of(triangle)) visit(mesh_.vertex_count() + e);
  }

  // Filled from the end: separators are placed first, so that they are eliminated last.
  void place(int entity) {
    if (seen_[entity]) return;
    seen_[entity] = 1;
    if (entity >= mesh_.vertex_count()) {
      order_[--next_] = dofs_.edge(entity - mesh_.vertex_count());
    } else {
      for (int d = 2; d >= 0; --d) order_[--next_] = dofs_.vertex(entity, d);
    }
  }

  void split(int begin, int end) {
    if (end - begin <= kLeaf) {
      for (int i = begin; i < end; ++i)
        for_each_entity(triangles_[i], [&](int entity) { place(entity); });
      return;
    }
    Box2 box;
    for (int i = begin; i < end; ++i) box.extend(centre_[triangles_[i]]);
    const int axis = box.sizes().x() >= box.sizes().y() ? 0 : 1;
    const int middle = (begin + end) / 2;
    if (end - begin > kPollTriangles) throw_if_cancelled();
    std::nth_element(triangles_.begin() + begin, triangles_.begin() + middle,
                     triangles_.begin() + end, [&](int a, int b) {
                       const double x = centre_[a][axis], y = centre_[b][axis];
                       return x != y ? x < y : a < b;
                     });
    const int cut = straightened(begin, middle, end);
    ++stamp_;
    for (int i = begin; i < cut; ++i)
      for_each_entity(triangles_[i], [&](int entity) { side_[entity] = stamp_; });
    for (int i = cut; i < end; ++i)
      for_each_entity(triangles_[i], [&](int entity) {
        if (side_[entity] == stamp_) place(entity);
      });
    split(begin, cut);
    split(cut, end);
  }

  // Splitting by centroids leaves a ragged boundary. A triangle with two neighbours in the other
  // half changes sides, until there is none. On unstructured meshes this reduces the separator by a
  // third. Returns where the second half begins.
  int straightened(int begin, int middle, int end) {
    half_stamp_ += 2;
    for (int i = begin; i < end; ++i) half_[triangles_[i]] = half_stamp_ + (i >= middle);
    int count = middle - begin;
    bool any = true;
    while (any) {
      any = false;
      for (int i = begin; i < end; ++i) {
        const int t = triangles_[i], own = half_[t], other = 2 * half_stamp_ + 1 - own;
        int across = 0, beside = 0;
        for (const int e : mesh_.edges_of(t))
          for (const int neighbour : mesh_.edges()[e].triangle) {
            if (neighbour < 0 || neighbour == t) continue;
            across += half_[neighbour] == other;
            beside += half_[neighbour] == own;
          }
        const int left = own == half_stamp_ ? count - 1 : end - begin - count - 1;
        if (across <= beside || left < 1) continue;
        half_[t] = other;
        count += own == half_stamp_ ? -1 : 1;
        any = true;
      }
    }
    std::stable_partition(triangles_.begin() + begin, triangles_.begin() + end,
                          [&](int t) { return half_[t] == half_stamp_; });
    return begin + count;
  }

  const ParametricMesh& mesh_;
  DofMap dofs_;
  std::vector<int> triangles_;
  std::vector<Vec2> centre_;
  std::vector<char> seen_;  // vertices, then edges
  std::vector<int> side_;
  std::vector<int> half_;  // half of each triangle
  std::vector<int> order_;
  int next_ = 0, stamp_ = 0, half_stamp_ = 0;
};

}  // namespace

std::vector<int> nested_dissection_order(const ParametricMesh& mesh) {
  return Dissection(mesh).order();
}

std::vector<std::array<int, 2>> dof_vertices(const ParametricMesh& mesh) {
  const DofMap dofs(mesh);
  std::vector<std::array<int, 2>> vertices(dofs.count());
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int d = 0; d < 3; ++d) vertices[dofs.vertex(v, d)] = {v, v};
  for (int e = 0; e < mesh.edge_count(); ++e)
    vertices[dofs.edge(e)] = {mesh.edges()[e].low, mesh.edges()[e].high};
  return vertices;
}

}  // namespace batten
