// SPDX-License-Identifier: MPL-2.0
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/op_counter.h"
#include "batten/skinning/domains/mesher.h"

#if BATTEN_HAVE_CGAL
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <queue>
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

constexpr int kPollInterval = 1024;  // refinement steps between two polls for cancellation
// Longest edge over the target length. Meshes come out with a mean edge of about three quarters of
// the longest.
constexpr double kMaxEdgeRatio = 1.3;

// Orders points along a Z-order (Morton) curve, so that neighbours are close in memory.
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

// Shape quality, approximately the sine of the smallest angle: 4 √3 area over the sum of squared
// sides, 1 for an equilateral triangle.
double quality(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 ab = b - a, ac = c - a, bc = c - b;
  const double area2 = ab.x() * ac.y() - ab.y() * ac.x();
  return 2 * std::sqrt(3.0) * area2 / (ab.squaredNorm() + ac.squaredNorm() + bc.squaredNorm());
}

// Laplacian-type smoothing: moves each free vertex in turn to the area centroid of its triangles. A
// move is accepted if the worst of these triangles improves or stays good (0.8). CGAL's own
// optimizers are not used: they sum in the order of addresses, so that the last bits change from
// run to run.
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
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (size_t v = 0; v < vertices.size(); ++v) {
      poll_every<4096>(static_cast<long>(v));
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
}

// A point inside a simple polygon. On horizontal lines midway between consecutive heights of its
// points, it is the middle of the widest interval inside.
Point inside_of(const std::vector<Vec2>& points, const std::vector<std::array<int, 2>>& polygon) {
  std::vector<double> heights;
  for (const auto& segment : polygon) heights.push_back(points[segment[0]].y());
  std::sort(heights.begin(), heights.end());
  double widest = 0;
  Point best(points[polygon[0][0]].x(), points[polygon[0][0]].y());
  for (size_t i = 0; i + 1 < heights.size(); ++i) {
    const double step = heights[i + 1] - heights[i], y = heights[i] + step / 2;
    if (step <= widest) continue;
    std::vector<double> crossings;
    for (const auto& [a, b] : polygon) {
      const Vec2 &p = points[a], &q = points[b];
      if ((p.y() > y) != (q.y() > y))
        crossings.push_back(p.x() + (q.x() - p.x()) * ((y - p.y()) / (q.y() - p.y())));
    }
    std::sort(crossings.begin(), crossings.end());
    for (size_t k = 0; k + 1 < crossings.size(); k += 2) {
      const double width = std::min(step, crossings[k + 1] - crossings[k]);
      if (width <= widest) continue;
      widest = width;
      best = Point((crossings[k] + crossings[k + 1]) / 2, y);
    }
  }
  return best;
}

// Marks as outside every face that can be reached from `start` without crossing a segment.
void exclude(Triangulation& triangulation, Triangulation::Face_handle start) {
  std::vector<Triangulation::Face_handle> stack{start};
  start->set_in_domain(false);
  while (!stack.empty()) {
    const auto face = stack.back();
    stack.pop_back();
    for (int i = 0; i < 3; ++i) {
      const auto next = face->neighbor(i);
      if (triangulation.is_constrained({face, i}) || !next->is_in_domain()) continue;
      next->set_in_domain(false);
      stack.push_back(next);
    }
  }
}

// Ruppert's Delaunay refinement [Ruppert1995], but without splitting segments. Triangles whose
// circumcircle is too large for the target length or for their shortest edge get its centre as a
// new vertex. The centre is skipped if it is not visible from the triangle or encroaches on a
// segment. The largest circumcircles come first. Every new vertex keeps a distance of √2 times the
// shortest edge that caused it, so that the refinement terminates.
class Refinement {
 public:
  Refinement(Triangulation& triangulation, const PlanarMeshInput& task, double min_sine_squared)
      : triangulation_(triangulation), task_(task), min_sine_squared_(min_sine_squared) {}

  void run() {
    auto& t = triangulation_;
    for (auto f = t.finite_faces_begin(); f != t.finite_faces_end(); ++f)
      if (f->is_in_domain()) enqueue_if_bad(f);
    for (long round = 0; !queue_.empty(); ++round) {
      poll_every<kPollInterval>(round);
      const BadTriangle bad = queue_.top();
      queue_.pop();
      if (!still_exists(bad)) continue;
      const Point centre = t.circumcenter(bad.face);
      FaceHandle there;
      if (find(centre, bad.face, there) && fits(centre, bad.face, there)) insert(centre, there);
    }
  }

 private:
  using FaceHandle = Triangulation::Face_handle;
  struct BadTriangle {
    double radius2;
    long number;  // insertion order, breaks ties
    FaceHandle face;
    std::array<Triangulation::Vertex_handle, 3> corners;
    bool operator<(const BadTriangle& other) const {
      return radius2 != other.radius2 ? radius2 < other.radius2 : number > other.number;
    }
  };

  // Adds a triangle to the queue if it is bad.
  void enqueue_if_bad(FaceHandle face) {
    const auto triangle = triangulation_.triangle(face);
    double shortest2 = std::numeric_limits<double>::infinity(), product = 1;
    for (int i = 0; i < 3; ++i) {
      const double side2 = CGAL::squared_distance(triangle[i], triangle[(i + 1) % 3]);
      shortest2 = std::min(shortest2, side2);
      product *= side2;
    }
    const double area = triangle.area(), radius2 = product / (16 * area * area);
    double edge = task_.edge_length;
    if (task_.size_field) {
      const Point centre = CGAL::centroid(triangle);
      edge = std::min(edge, task_.size_field->at({centre.x(), centre.y()}));
    }
    // Circumradius of an equilateral triangle.
    const double largest = kMaxEdgeRatio * edge / std::sqrt(3.0);
    if (radius2 > largest * largest || shortest2 < 4 * min_sine_squared_ * radius2)
      queue_.push({radius2, number_++, face, {face->vertex(0), face->vertex(1), face->vertex(2)}});
  }

  // True if the triangle has not changed since it was queued.
  bool still_exists(const BadTriangle& bad) const {
    return bad.face->vertex(0) == bad.corners[0] && bad.face->vertex(1) == bad.corners[1] &&
           bad.face->vertex(2) == bad.corners[2];
  }

  // Finds the face that contains the centre. Returns false if the centre is outside of the domain,
  // at a vertex, or on a segment.
  bool find(const Point& centre, FaceHandle from, FaceHandle& there) const {
    Triangulation::Locate_type type;
    int at;
    there = triangulation_.locate(centre, type, at, from);
    return !(triangulation_.is_infinite(there) || !there->is_in_domain() ||
             type == Triangulation::VERTEX ||
             (type == Triangulation::EDGE && triangulation_.is_constrained({there, at})));
  }

  // True if the centre is visible from its triangle and encroaches on no segment (lies in no
  // segment's diametral circle).
  bool fits(const Point& centre, FaceHandle face, FaceHandle there) const {
    std::vector<FaceHandle> zone;
    std::vector<Triangulation::Edge> around;
    triangulation_.get_conflicts_and_boundary(centre, std::back_inserter(zone),
                                              std::back_inserter(around), there);
    bool good = std::find(zone.begin(), zone.end(), face) != zone.end();
    for (const auto& edge : around) {
      if (!triangulation_.is_constrained(edge)) continue;
      const auto ends = triangulation_.segment(edge);
      good = good && CGAL::angle(ends.source(), centre, ends.target()) == CGAL::ACUTE;
    }
    return good;
  }

  void insert(const Point& centre, FaceHandle there) {
    const auto vertex = triangulation_.insert(centre, there);
    auto f = triangulation_.incident_faces(vertex);
    const auto first = f;
    do {
      f->set_in_domain(true);
      enqueue_if_bad(f);
    } while (++f != first);
  }

  Triangulation& triangulation_;
  const PlanarMeshInput& task_;
  double min_sine_squared_;
  std::priority_queue<BadTriangle> queue_;
  long number_ = 0;
};

void refine_between(Triangulation& triangulation, const std::vector<Point>& hole_seeds,
                    const PlanarMeshInput& task, double min_sine_squared) {
  for (auto f = triangulation.all_faces_begin(); f != triangulation.all_faces_end(); ++f)
    f->set_in_domain(true);
  exclude(triangulation, triangulation.infinite_face());
  for (const Point& seed : hole_seeds) exclude(triangulation, triangulation.locate(seed));
  Refinement(triangulation, task, min_sine_squared).run();
}

using VertexHandle = Triangulation::Vertex_handle;

// Inserts the points and segments of the input; returns the vertices of its points.
std::vector<VertexHandle> insert(const PlanarMeshInput& task, Triangulation& triangulation) {
  std::vector<VertexHandle> handle;
  for (const Vec2& p : task.points) {
    poll_every<kPollInterval>(isize(handle));
    handle.push_back(triangulation.insert(Point(p.x(), p.y())));
  }
  const auto constrain = [&](const std::vector<std::array<int, 2>>& segments) {
    for (const auto& [a, b] : segments) triangulation.insert_constraint(handle[a], handle[b]);
  };
  try {
    constrain(task.outline);
    constrain(task.inner);
    for (const auto& hole : task.holes) constrain(hole);
  } catch (const Triangulation::Intersection_of_constraints_exception&) {
    throw InputError("curves intersect in the parameter domain where they have no common point");
  }
  return handle;
}

// Ruppert's Delaunay refinement, which may split segments.
void refine_everywhere(Triangulation& triangulation, const std::vector<Point>& hole_seeds,
                       const PlanarMeshInput& task, double min_sine_squared) {
  CGAL::Delaunay_mesher_2<Triangulation, Criteria> mesher(
      triangulation, Criteria(min_sine_squared, kMaxEdgeRatio * task.edge_length));
  if (!hole_seeds.empty()) mesher.set_seeds(hole_seeds.begin(), hole_seeds.end());
  // Next to angles of a few degrees, Ruppert's refinement may not terminate.
  constexpr double many = 20;  // multiple of the vertices of a uniform mesh of the bounding box
  const double most =
      many * (bounding_box(task.points).sizes().prod() / (task.edge_length * task.edge_length) +
              static_cast<double>(task.points.size()) + 1000);
  mesher.init();
  for (long round = 0; !mesher.is_refinement_done(); ++round) {
    poll_every<kPollInterval>(round);
    mesher.step_by_step_refine_mesh();
    if (static_cast<double>(triangulation.number_of_vertices()) > most)
      throw InputError(
          "the parameter domain cannot be meshed with edges of " + format_number(task.edge_length) +
          " of its size: its curves are too close to each other, or meet at too small angles");
  }
}

// Extracts the vertices and triangles of the domain; smooths all vertices that are not on segments.
ParametricMesh smoothed_mesh(const Triangulation& triangulation,
                             const std::vector<VertexHandle>& handle, const PlanarMeshInput& task) {
  // The input points keep their numbers; the others follow along a space-filling curve.
  std::map<VertexHandle, int> index;
  std::vector<Vec2> vertices = task.points;
  for (size_t i = 0; i < handle.size(); ++i) index[handle[i]] = static_cast<int>(i);
  std::vector<VertexHandle> added;
  std::vector<Point> places;
  for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end();
       ++v)
    if (!index.count(v)) {
      added.push_back(v);
      places.push_back(v->point());
    }
  for (const int i : spatial_order(places)) {
    index[added[i]] = isize(vertices);
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

}  // namespace

ParametricMesh delaunay_mesh(const PlanarMeshInput& task) {
  count(OpCounter::Triangulation);
  Triangulation triangulation;
  const std::vector<VertexHandle> handle = insert(task, triangulation);
  std::vector<Point> seeds;
  for (const auto& hole : task.holes) seeds.push_back(inside_of(task.points, hole));
  constexpr double min_sine_squared = 0.125;  // sin² of 20.7 degrees
  if (task.keep_segments)
    refine_between(triangulation, seeds, task, min_sine_squared);
  else
    refine_everywhere(triangulation, seeds, task, min_sine_squared);
  return smoothed_mesh(triangulation, handle, task);
}

#else

bool have_delaunay_mesher() { return false; }

ParametricMesh delaunay_mesh(const PlanarMeshInput&) {
  throw InputError(
      "Batten was built without CGAL and has no Delaunay mesher; use mesher = \"fan\"");
}

#endif

}  // namespace batten
