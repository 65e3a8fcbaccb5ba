#include "batten/core/errors.h"
#include "batten/skinning/mesher.h"

#if BATTEN_HAVE_CGAL
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesh_vertex_base_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/lloyd_optimize_mesh_2.h>

#include <algorithm>
#include <cstdint>
#include <map>
#endif

namespace batten {

#if BATTEN_HAVE_CGAL

bool have_delaunay_mesher() { return true; }

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Delaunay_mesh_vertex_base_2<Kernel>;
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
  constexpr int smoothings = 8;
  CGAL::lloyd_optimize_mesh_2(triangulation, CGAL::parameters::max_iteration_number = smoothings);

  // The task's points keep their numbers; the others follow along a space-filling curve.
  std::map<Triangulation::Vertex_handle, int> index;
  std::vector<Vec2> vertices = task.points;
  for (size_t i = 0; i < handle.size(); ++i) index[handle[i]] = static_cast<int>(i);
  std::vector<Triangulation::Vertex_handle> added;
  std::vector<Point> places;
  for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v)
    if (!index.count(v)) {
      added.push_back(v);
      places.push_back(v->point());
    }
  for (const int i : spatial_order(places)) {
    index[added[i]] = static_cast<int>(vertices.size());
    vertices.emplace_back(places[i].x(), places[i].y());
  }
  std::vector<ParametricMesh::Triangle> found, triangles;
  std::vector<Point> centres;
  for (auto f = triangulation.finite_faces_begin(); f != triangulation.finite_faces_end(); ++f) {
    if (!f->is_in_domain()) continue;
    found.push_back({index[f->vertex(0)], index[f->vertex(1)], index[f->vertex(2)]});
    centres.push_back(CGAL::centroid(triangulation.triangle(f)));
  }
  for (const int i : spatial_order(centres)) triangles.push_back(found[i]);
  return {std::move(vertices), std::move(triangles)};
}

#else

bool have_delaunay_mesher() { return false; }

ParametricMesh delaunay_mesh(const MeshTask&) {
  throw InputError("this build of Batten has no Delaunay mesher (it was built without CGAL): use "
                   "mesher = \"fan\"");
}

#endif

}  // namespace batten
