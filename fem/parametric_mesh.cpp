#include "batten/fem/parametric_mesh.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

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
    throw MeshError("the period of a parametric mesh is " + format_number(period) +
                    "; expected a positive number, or 0 for none");
  const int n = vertex_count();
  for (int v = 0; v < n; ++v)
    if (!vertices_[v].allFinite())
      throw MeshError("parametric vertex " + std::to_string(v) + " is not finite");
  if (period_ > 0)
    for (int v = 0; v < n; ++v)
      if (!(vertices_[v].x() >= 0 && vertices_[v].x() < period_))
        throw MeshError("parametric vertex " + std::to_string(v) +
                        " has u = " + format_number(vertices_[v].x()) +
                        ", outside of one period, 0 to " + format_number(period_));
  if (triangles_.empty()) throw MeshError("a parametric mesh needs at least one triangle");
  edges_from_.resize(n);
  triangle_edges_.resize(triangles_.size());
  std::vector<char> used(n, 0);
  for (int t = 0; t < triangle_count(); ++t) {
    const Triangle& tri = triangles_[t];
    for (const int v : tri) {
      if (v < 0 || v >= n)
        throw MeshError("triangle " + std::to_string(t) + " names vertex " + std::to_string(v) +
                        " of " + std::to_string(n));
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
        // Three such edges could close around the tube.
        constexpr double margin = 1e-9;
        if (period_ > 0 && std::abs(edge_vector(e).x()) > (1 - margin) * period_ / 3)
          throw MeshError("edge " + std::to_string(low) + "-" + std::to_string(high) + " spans " +
                          format_number(std::abs(edge_vector(e).x())) +
                          " in u, a third of the period or more: a periodic mesh needs at least "
                          "four columns");
      } else {
        Edge& edge = edges_[e];
        const auto name = std::to_string(low) + "-" + std::to_string(high);
        if (!edge.boundary()) throw MeshError("edge " + name + " has more than two triangles");
        edge.triangle[1] = t;
        edge.local[1] = i;
        if (edge_sign(edge.triangle[0], edge.local[0]) == edge_sign(t, i))
          throw MeshError("the triangles at edge " + name + " are wound in opposite directions");
      }
      triangle_edges_[t][i] = e;
    }
    shape(t);  // throws unless counter-clockwise
  }
  for (int v = 0; v < n; ++v)
    if (!used[v]) throw MeshError("parametric vertex " + std::to_string(v) + " has no triangle");
}

ParametricMesh ParametricMesh::concatenated(const std::vector<const ParametricMesh*>& meshes) {
  ParametricMesh all;
  for (const ParametricMesh* mesh : meshes) {
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
  if (!(p.x() < period_)) p.x() = 0;  // a hair below zero
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
  if (n < 1) throw InputError("a square mesh needs at least one square a side");
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

}  // namespace batten
