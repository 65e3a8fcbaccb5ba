// Triangle meshes that deformers work on: oriented sheets, with or without boundary, that may meet.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>
#include <optional>

#include "batten/core/geometry.h"
#include "batten/core/eigen.h"
#include "batten/core/containers.h"

namespace batten {

/// The neighbours of vertices, edges and triangles: found once, shared by all shapes of a mesh.
///
/// Every edge has one or two triangles, which run through it in opposite directions; the triangles
/// around a vertex form one fan. Vertices without triangles are allowed and have no neighbours.
///
/// Built-up structures are several such sheets: where a sheet ends at another one (a T-joint) or
/// touches it at a point, each has a vertex of its own there. These vertices are one node: they have
/// one place and go together. Vertices 0 … node_count() - 1 are the nodes themselves, the others
/// stand for one of them.
class MeshTopology {
 public:
  struct Edge {
    int low, high;    ///< vertices, low < high
    int left, right;  ///< triangle that runs low → high, and the other one; -1 where there is none
  };

  /// `duplicate_vertex_nodes`: the node of each vertex from node_count on. Throws InputError that names the
  /// nodes: an index out of range, a corner twice in a triangle, an edge of more than two triangles
  /// or of two that run the same way, a vertex whose triangles form several fans.
  /// O(triangles · log triangles).
  MeshTopology(int node_count, std::vector<std::array<int, 3>> triangles,
               std::vector<int> duplicate_vertex_nodes = {});

  int vertex_count() const { return vertex_count_; }
  int node_count() const { return vertex_count_ - isize(duplicate_vertex_nodes_); }
  int node_of(int vertex) const {
    return vertex < node_count() ? vertex : duplicate_vertex_nodes_[vertex - node_count()];
  }
  /// All vertices of the node that a vertex is one of, ascending: itself alone in most places.
  std::span<const int> coincident_vertices(int vertex) const {
    return part(coincident_vertices_, coincident_start_, node_of(vertex));
  }
  /// The vertices with all that go together with them; the nodes of vertices. Ascending, each once.
  std::vector<int> expand_to_nodes(std::vector<int> vertices) const;
  std::vector<int> nodes_of(std::vector<int> vertices) const;
  int triangle_count() const { return isize(triangles_); }
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
  /// vertex, the loops are sorted by it. Those that run along another sheet somewhere are no rims
  /// and come apart, in non_manifold_loops().
  const std::vector<std::vector<int>>& boundary_loops() const { return loops_; }
  const std::vector<std::vector<int>>& non_manifold_loops() const { return non_manifold_loops_; }
  bool on_boundary(int vertex) const { return on_boundary_[vertex] != 0; }
  /// Number of the sheet of each vertex, which its edges connect; -1 for vertices without triangles.
  /// Sheets are numbered in the order of their lowest vertices.
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

  void find_coincident_vertices();
  /// Whether each edge joins the same nodes as another one; empty where none does.
  std::vector<char> non_manifold_edges() const;

  int vertex_count_, component_count_ = 0;
  std::vector<std::array<int, 3>> triangles_, edges_of_;
  std::vector<Edge> edges_;
  std::vector<int> neighbours_, neighbour_start_, triangles_of_, triangle_start_, component_;
  std::vector<int> duplicate_vertex_nodes_, coincident_vertices_, coincident_start_;
  std::vector<std::vector<int>> loops_, non_manifold_loops_;
  std::vector<char> on_boundary_;
};

/// A topology and a position for each vertex: a value, cheap to copy but for the points.
class TriangleMesh {
 public:
  /// One point for each node. Throws InputError: what MeshTopology throws, a coordinate that is not
  /// finite.
  TriangleMesh(Points points, std::vector<std::array<int, 3>> triangles,
               std::vector<int> duplicate_vertex_nodes = {});
  /// The same mesh in another shape: one point for each vertex. Throws InputError on another number
  /// of points.
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


// The nearest point of a triangle mesh. Internal.

/// A tree of boxes around triangles, halved at the median of their middles. O(triangles log triangles) once;
/// a search looks at some dozens of boxes, about a microsecond near the surface. It may be asked from several
/// threads.
class AabbTree {
 public:
  explicit AabbTree(const TriangleMesh& mesh);

  struct ClosestPoint {
    int triangle = -1;
    Vec3 at = Vec3::Zero(), weights = Vec3::Zero();  ///< barycentric
    double distance = 0;
  };
  /// Of triangles whose normal has a positive share of `normal`, where it is given; none: no such
  /// triangle. Of several at the same distance the lowest.
  std::optional<ClosestPoint> nearest(const Vec3& p, const std::optional<Vec3>& normal = {}) const;

 private:
  struct Node {
    Vec3 low, high;
    int first = 0, last = 0;  // of order_
    int right = -1;           // the left half is the next node; none: a leaf
    double distance2(const Vec3& p) const {
      return (low - p).cwiseMax(p - high).cwiseMax(0).squaredNorm();
    }
  };
  int build(int first, int last, const std::vector<Vec3>& centroids);

  TriangleMesh mesh_;
  std::vector<int> order_;  // triangles, those of a node side by side
  std::vector<Node> nodes_;
};

}  // namespace batten
