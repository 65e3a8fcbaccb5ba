// Triangle meshes that deformers work on: oriented manifolds with or without boundary.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "batten/core/box.h"
#include "batten/core/eigen.h"
#include "batten/core/index.h"

namespace batten {

/// The neighbours of vertices, edges and triangles: found once, shared by all shapes of a mesh.
///
/// Every edge has one or two triangles, which run through it in opposite directions; the triangles
/// around a vertex form one fan. Vertices without triangles are allowed and have no neighbours.
class MeshTopology {
 public:
  struct Edge {
    int low, high;    ///< vertices, low < high
    int left, right;  ///< triangle that runs low → high, and the other one; -1 where there is none
  };

  /// Throws InputError that names the vertices: an index out of range, a corner twice in a
  /// triangle, an edge of more than two triangles or of two that run the same way, a vertex whose
  /// triangles form several fans. O(triangles · log triangles).
  MeshTopology(int vertex_count, std::vector<std::array<int, 3>> triangles);

  int vertex_count() const { return vertex_count_; }
  int triangle_count() const { return count_of(triangles_); }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  /// The edges, sorted by (low, high).
  const std::vector<Edge>& edges() const { return edges_; }
  /// Edges opposite to the three corners of a triangle.
  const std::array<int, 3>& edges_of(int triangle) const { return edges_of_[triangle]; }
  /// The one-ring N(i), ascending.
  std::span<const int> neighbours(int vertex) const {
    return part(neighbours_, neighbour_start_, vertex);
  }
  std::span<const int> triangles_of(int vertex) const {
    return part(triangles_of_, triangle_start_, vertex);
  }
  /// Triangle on the other side of the edge opposite to `corner`, or -1.
  int across(int triangle, int corner) const;

  /// Closed chains of boundary vertices, the surface on their left; each starts at its lowest
  /// vertex, the loops are sorted by it.
  const std::vector<std::vector<int>>& boundary_loops() const { return loops_; }
  bool on_boundary(int vertex) const { return on_boundary_[vertex] != 0; }
  /// Number of the connected part of each vertex, -1 for vertices without triangles; parts are
  /// numbered in the order of their lowest vertices.
  const std::vector<int>& component() const { return component_; }
  int component_count() const { return component_count_; }

 private:
  static std::span<const int> part(const std::vector<int>& all, const std::vector<int>& start,
                                   int i) {
    return {all.data() + start[i], static_cast<size_t>(start[i + 1] - start[i])};
  }
  void find_edges();
  void find_fans();
  void find_loops();
  void find_components();

  int vertex_count_, component_count_ = 0;
  std::vector<std::array<int, 3>> triangles_, edges_of_;
  std::vector<Edge> edges_;
  std::vector<int> neighbours_, neighbour_start_, triangles_of_, triangle_start_, component_;
  std::vector<std::vector<int>> loops_;
  std::vector<char> on_boundary_;
};

/// A topology and a position for each vertex: a value, cheap to copy but for the points.
class TriangleMesh {
 public:
  /// Throws InputError: what MeshTopology throws, a coordinate that is not finite.
  TriangleMesh(Points points, std::vector<std::array<int, 3>> triangles);
  /// The same mesh in another shape. Throws InputError on another number of points.
  TriangleMesh with_points(Points points) const;

  const Points& points() const { return points_; }
  const MeshTopology& topology() const { return *topology_; }
  Vec3 point(int vertex) const { return points_.row(vertex).transpose(); }
  int vertex_count() const { return topology_->vertex_count(); }
  int triangle_count() const { return topology_->triangle_count(); }
  const std::vector<std::array<int, 3>>& triangles() const { return topology_->triangles(); }
  /// Area vector of a triangle: twice its area times its unit normal.
  Vec3 area_vector(int triangle) const;
  /// The box around all vertices that have triangles, and its diagonal.
  Box3 box() const;
  double size() const;
  double length(const std::vector<int>& closed_loop) const;

 private:
  TriangleMesh(std::shared_ptr<const MeshTopology> topology, Points points);
  Points points_;
  std::shared_ptr<const MeshTopology> topology_;
};

}  // namespace batten
