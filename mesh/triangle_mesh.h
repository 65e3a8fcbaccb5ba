// SPDX-License-Identifier: MPL-2.0
// Triangle meshes and their connectivity (non-manifold meshes as joined manifold patches), and
// closest points on a mesh.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "batten/core/box_tree.h"
#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/geometry.h"

namespace batten {

/// Connectivity of a triangle mesh: vertices, edges, triangles and their neighbours. Computed once
/// and shared by all shapes (point sets) of the mesh.
///
/// Each manifold patch is oriented. Every edge has one or two triangles, which traverse it in
/// opposite directions, and the triangles around a vertex form one fan. Vertices without triangles
/// are allowed and have no neighbours.
///
/// Non-manifold meshes (built-up structures) are represented as several manifold patches. If a
/// patch ends at another one (a T-joint) or touches it at a point, each patch has its own vertices
/// there. Coincident vertices of several patches belong to one node: they have the same position
/// and move together. Vertices 0 … node_count() - 1 are the nodes themselves; each further vertex
/// is a duplicate of one of them.
class MeshTopology {
 public:
  struct Edge {
    int low, high;  ///< vertex indices of both ends of the edge, low < high
    /// `left`: triangle that traverses the edge from vertex `low` to vertex `high`; `right`:
    /// triangle that traverses it from `high` to `low`. -1: there is no such triangle.
    int left, right;
  };

  /// Builds the connectivity from triangles, given as vertex triples in counter-clockwise order.
  /// `duplicate_vertex_nodes`: the node of each duplicate vertex, that is, of the vertices from
  /// `node_count` on. Throws InputError if a vertex index is out of range, a triangle repeats a
  /// corner, an edge has more than two triangles or two that traverse it in the same direction, or
  /// the triangles of a vertex form several fans. The message names the nodes. O(triangles · log
  /// triangles).
  MeshTopology(int node_count, std::vector<std::array<int, 3>> triangles,
               std::vector<int> duplicate_vertex_nodes = {});

  int vertex_count() const { return vertex_count_; }
  /// Number of nodes. Coincident vertices of several manifold patches count as one node.
  int node_count() const { return vertex_count_ - isize(duplicate_vertex_nodes_); }
  /// The node to which a vertex belongs. It differs from the vertex only for a duplicate vertex
  /// where several manifold patches meet.
  int node_of(int vertex) const {
    return vertex < node_count() ? vertex : duplicate_vertex_nodes_[vertex - node_count()];
  }
  /// All vertices of the node to which `vertex` belongs, ascending. On manifold meshes the result
  /// contains only `vertex`.
  std::span<const int> coincident_vertices(int vertex) const {
    return part(coincident_vertices_, coincident_start_, node_of(vertex));
  }
  /// The given vertices and all vertices that belong to the same nodes as these vertices,
  /// ascending, without repetition.
  std::vector<int> expand_to_nodes(std::vector<int> vertices) const;
  /// The nodes to which the given vertices belong, ascending, without repetition.
  std::vector<int> nodes_of(std::vector<int> vertices) const;
  int triangle_count() const { return isize(triangles_); }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  /// The edges, sorted by Edge::low; edges with equal `low` are sorted by Edge::high.
  const std::vector<Edge>& edges() const { return edges_; }
  /// Indices of the edges opposite to the three corners of a triangle.
  const std::array<int, 3>& edges_of(int triangle) const { return edges_of_[triangle]; }
  /// The one-ring of a vertex: the vertices connected to it by an edge, ascending.
  std::span<const int> neighbours(int vertex) const {
    return part(neighbours_, neighbour_start_, vertex);
  }
  /// Indices of the triangles around a vertex, ascending.
  std::span<const int> triangles_of(int vertex) const {
    return part(triangles_of_, triangle_start_, vertex);
  }
  /// The triangle that shares the edge opposite to `corner` (0, 1 or 2) with the given triangle; -1
  /// if the edge has only one triangle.
  int across(int triangle, int corner) const;

  /// Free boundary loops of the mesh: closed chains of vertices, with the surface on their left.
  /// Each loop starts at its lowest-numbered vertex, and the loops are sorted by their first
  /// vertices. Loops that share an edge with another patch (a non-manifold edge) are not free
  /// boundaries; they are in non_manifold_loops().
  const std::vector<std::vector<int>>& boundary_loops() const { return loops_; }
  const std::vector<std::vector<int>>& non_manifold_loops() const { return non_manifold_loops_; }
  /// True if the vertex lies on the boundary of its manifold patch, that is, on an edge with only
  /// one triangle of the patch.
  bool on_boundary(int vertex) const { return on_boundary_[vertex] != 0; }
  /// Index of the manifold patch (edge-connected component) of each vertex; -1 for vertices without
  /// triangles. Patches are numbered in the order of their lowest-numbered vertices.
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
  /// Flag of each edge: 1 if another edge joins the same two nodes. Empty for meshes without
  /// duplicate vertices.
  std::vector<char> non_manifold_edges() const;

  int vertex_count_, component_count_ = 0;
  std::vector<std::array<int, 3>> triangles_, edges_of_;
  std::vector<Edge> edges_;
  std::vector<int> neighbours_, neighbour_start_, triangles_of_, triangle_start_, component_;
  std::vector<int> duplicate_vertex_nodes_, coincident_vertices_, coincident_start_;
  std::vector<std::vector<int>> loops_, non_manifold_loops_;
  std::vector<char> on_boundary_;
};

/// A triangle mesh: connectivity and one position per vertex. It has value semantics: a copy has
/// its own points, but shares the connectivity.
class TriangleMesh {
 public:
  /// Builds a mesh. `points`: one per node (n×3). `triangles`, `duplicate_vertex_nodes`: see the
  /// constructor of MeshTopology. Throws InputError like the constructor of MeshTopology, or if a
  /// coordinate is not finite.
  TriangleMesh(Points points, std::vector<std::array<int, 3>> triangles,
               std::vector<int> duplicate_vertex_nodes = {});
  /// A mesh with the connectivity of this mesh and the vertex positions `points` (n×3). Throws
  /// InputError if the number of points differs from the number of vertices or a coordinate is not
  /// finite.
  TriangleMesh with_points(Points points) const;

  const Points& points() const { return points_; }
  const MeshTopology& topology() const { return *topology_; }
  Vec3 point(int vertex) const { return points_.row(vertex).transpose(); }
  int vertex_count() const { return topology_->vertex_count(); }
  int triangle_count() const { return topology_->triangle_count(); }
  const std::vector<std::array<int, 3>>& triangles() const { return topology_->triangles(); }
  /// Twice the area of a triangle times its unit normal.
  Vec3 area_vector(int triangle) const;
  /// Bounding box of all vertices that belong to triangles.
  Box3 box() const;
  /// Mesh size: the diagonal of the bounding box, which is the reference length for relative
  /// tolerances; 0 for a mesh without triangles.
  double size() const;
  /// Length of the closed polygon through the given vertices. Do not repeat the first vertex at the
  /// end.
  double length(const std::vector<int>& closed_loop) const;

 private:
  TriangleMesh(std::shared_ptr<const MeshTopology> topology, Points points);
  Points points_;
  std::shared_ptr<const MeshTopology> topology_;
};

// Closest points on a triangle mesh.

/// Search tree for closest points on a triangle mesh: a BoxTree over the triangles, split by their
/// centroids. Construction costs O(triangles · log triangles). A query visits some dozens of boxes
/// and takes about 1 µs for points near the surface. Queries are thread-safe.
class TriangleTree {
 public:
  explicit TriangleTree(const TriangleMesh& mesh);

  struct ClosestPoint {
    int triangle = -1;
    Vec3 at = Vec3::Zero(), weights = Vec3::Zero();  ///< position; barycentric coordinates
    double distance = 0;
  };
  /// The point of the mesh that is closest to p (ties: triangle with the lowest index). If `normal`
  /// is given, only triangles whose normal has a positive dot product with `normal` are considered.
  /// Empty if there is no such triangle.
  std::optional<ClosestPoint> nearest(const Vec3& p, const std::optional<Vec3>& normal = {}) const;
  /// The closest point of the triangles for which `accepts` is true; empty if there is none.
  std::optional<ClosestPoint> nearest_among(const Vec3& p,
                                            const std::function<bool(int triangle)>& accepts) const;

 private:
  using Corners = std::array<Vec3, 3>;
  static std::vector<Corners> corners_of(const TriangleMesh& mesh);
  static BoxTree<3> boxes_of(const std::vector<Corners>& triangles);
  template <class Accepts>
  std::optional<ClosestPoint> search(const Vec3& p, const Accepts& accepts) const;

  std::vector<Corners> corners_;  // per triangle, contiguous: queries read many of them
  BoxTree<3> tree_;
};

}  // namespace batten
