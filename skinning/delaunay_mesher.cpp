#include "batten/core/errors.h"
#include "batten/skinning/mesher.h"

#if BATTEN_HAVE_CGAL
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cstdint>
#include <map>
#endif

namespace batten {

#if BATTEN_HAVE_CGAL

bool have_delaunay_mesher() { return true; }

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_2<Kernel>;
using Face = CGAL::Delaunay_mesh_face_base_2<Kernel>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel,
                                               CGAL::Triangulation_data_structure_2<Vertex, Face>>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Triangulation>;
using Point = Triangulation::Point;

// Along the Z-shaped curve, so that neighbours lie near each other in memory.
std::vector<int> spatial_order(const std::vector<Point>& points) {
  double low_x = 0, low_y = 0, extent = 0;
  if (!points.empty()) low_x = points[0].x(), low_y = points[0].y();
  for (const Point& p : points) low_x = std::min(low_x, p.x()), low_y = std::min(low_y, p.y());
  for (const Point& p : points) extent = std::max({extent, p.x() - low_x, p.y() - low_y});
  constexpr int bits = 16;
  const auto spread = [](std::uint64_t x) {
    std::uint64_t result = 0;
    for (int b = 0; b < bits; ++b) result |= (x >> b & 1) << (2 * b);
    return result;
  };
  std::vector<std::pair<std::uint64_t, int>> keys;
  for (size_t i = 0; i < points.size(); ++i) {
    const double scale = ((1 << bits) - 1) / (extent > 0 ? extent : 1);
    const auto x = static_cast<std::uint64_t>((points[i].x() - low_x) * scale),
               y = static_cast<std::uint64_t>((points[i].y() - low_y) * scale);
    keys.emplace_back(spread(x) | spread(y) << 1, static_cast<int>(i));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<int> order;
  for (const auto& key : keys) order.push_back(key.second);
  return order;
}

// Sine of the smallest angle, about: 4 √3 area over the sum of squared sides, 1 when equilateral.
double quality(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 ab = b - a, ac = c - a, bc = c - b;
  const double area2 = ab.x() * ac.y() - ab.y() * ac.x();
  return 2 * std::sqrt(3.0) * area2 / (ab.squaredNorm() + ac.squaredNorm() + bc.squaredNorm());
}

// Moves free vertices to the centre of area of their triangles, one after the other, where the
// worst of these triangles becomes better or stays good (0.8). CGAL's own optimizers add up in the
// order of addresses, so that their last bits change from run to run.
void smooth(std::vector<Vec2>& vertices, const std::vector<ParametricMesh::Triangle>& triangles,
            const std::vector<char>& fixed, int sweeps) {
  std::vector<std::vector<int>> around(vertices.size());
  for (size_t t = 0; t < triangles.size(); ++t)
    for (const int v : triangles[t]) around[v].push_back(static_cast<int>(t));
  const auto worst = [&](int v) {
    double q = 1;
    for (const int t : around[v]) {
      const auto& [a, b, c] = triangles[t];
      q = std::min(q, quality(vertices[a], vertices[b], vertices[c]));
    }
    return q;
  };
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (size_t v = 0; v < vertices.size(); ++v) {
      if (fixed[v]) continue;
      Vec2 moment = Vec2::Zero();
      double total = 0;
      for (const int t : around[v]) {
        const auto& [a, b, c] = triangles[t];
        const Vec2 ab = vertices[b] - vertices[a], ac = vertices[c] - vertices[a];
        const double area2 = ab.x() * ac.y() - ab.y() * ac.x();
        moment += area2 / 3 * (vertices[a] + vertices[b] + vertices[c]);
        total += area2;
      }
      const Vec2 before = vertices[v];
      const double quality_before = worst(static_cast<int>(v));
      vertices[v] = moment / total;
      if (worst(static_cast<int>(v)) < std::min(quality_before, 0.8)) vertices[v] = before;
    }
}

}  // namespace

ParametricMesh delaunay_mesh(const MeshTask& task) {
  Triangulation triangulation;
  std::vector<Triangulation::Vertex_handle> handle;
  for (const Vec2& p : task.points) handle.push_back(triangulation.insert(Point(p.x(), p.y())));
  for (const auto* segments : {&task.outline, &task.inner})
    for (const auto& [a, b] : *segments) triangulation.insert_constraint(handle[a], handle[b]);

  // Sizes ask for the longest edge; meshes come out with a mean of about three quarters of it.
  constexpr double least_angle = 0.125;  // sin² of 20.7 degrees
  constexpr double longest = 1.3;
  CGAL::Delaunay_mesher_2<Triangulation, Criteria> mesher(
      triangulation, Criteria(least_angle, longest * task.edge_length));
  mesher.refine_mesh();

  // The task's points keep their numbers; the others follow along a space-filling curve.
  std::map<Triangulation::Vertex_handle, int> index;
  std::vector<Vec2> vertices = task.points;
  for (size_t i = 0; i < handle.size(); ++i) index[handle[i]] = static_cast<int>(i);
  std::vector<Triangulation::Vertex_handle> added;
  std::vector<Point> places;
  for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end();
       ++v)
    if (!index.count(v)) {
      added.push_back(v);
      places.push_back(v->point());
    }
  for (const int i : spatial_order(places)) {
    index[added[i]] = static_cast<int>(vertices.size());
    vertices.emplace_back(places[i].x(), places[i].y());
  }
  std::vector<char> fixed(vertices.size(), 0);
  for (auto e = triangulation.finite_edges_begin(); e != triangulation.finite_edges_end(); ++e)
    if (triangulation.is_constrained(*e))
      for (const int side : {1, 2}) fixed[index[e->first->vertex((e->second + side) % 3)]] = 1;
  std::vector<ParametricMesh::Triangle> found, triangles;
  std::vector<Point> centres;
  for (auto f = triangulation.finite_faces_begin(); f != triangulation.finite_faces_end(); ++f) {
    if (!f->is_in_domain()) continue;
    found.push_back({index[f->vertex(0)], index[f->vertex(1)], index[f->vertex(2)]});
    centres.push_back(CGAL::centroid(triangulation.triangle(f)));
  }
  for (const int i : spatial_order(centres)) triangles.push_back(found[i]);
  constexpr int sweeps = 6;
  smooth(vertices, triangles, fixed, sweeps);
  return {std::move(vertices), std::move(triangles)};
}

#else

bool have_delaunay_mesher() { return false; }

ParametricMesh delaunay_mesh(const MeshTask&) {
  throw InputError(
      "this build of Batten has no Delaunay mesher (it was built without CGAL): use "
      "mesher = \"fan\"");
}

#endif

}  // namespace batten
