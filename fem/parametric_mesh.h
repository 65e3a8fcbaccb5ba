// SPDX-License-Identifier: MPL-2.0
// Triangle meshes in the (u, v) plane, with numbered edges and dofs.
#pragma once

#include <array>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/elements/c1_triangle.h"

namespace batten {

/// Conforming mesh of counter-clockwise triangles in the (u, v) plane. Immutable.
///
///            V_i              Edge i of a triangle is opposite its vertex i and runs V_j → V_k,
///            /\               (i, j, k) cyclic. In the mesh, an edge runs from its lower vertex
///    edge k /  \ edge j       index to the higher one, which fixes the sign of its normal
///          /____\             (c1_triangle.h). Edges are numbered in the order in which they
///       V_j edge i V_k        first occur in the triangles.
///
/// A mesh may be periodic in u, as on a tube: (u + period, v) is the same point as (u, v). Vertices
/// have u in [0, period). Triangles and edges that cross the seam are unwrapped: their vertices are
/// shifted to within half a period of the first vertex of the triangle, or of the lower-numbered
/// vertex of the edge.
class ParametricMesh {
 public:
  using Triangle = std::array<int, 3>;
  struct Edge {
    int low, high;    ///< indices of the end vertices, low < high
    int triangle[2];  ///< adjacent triangles; triangle[1] is -1 on the boundary
    int local[2];     ///< local index 0 … 2 of the edge in each adjacent triangle
    bool boundary() const { return triangle[1] < 0; }
  };

  /// Throws MeshError if a vertex index is out of range, a triangle is not counter-clockwise, an
  /// edge has more than two triangles or occurs twice in the same direction, or a vertex belongs to
  /// no triangle. For a periodic mesh, it also throws if the u of a vertex is outside of [0,
  /// period), or if an edge spans a third of the period or more, because its direction around the
  /// tube would be ambiguous. `period`: 0 for a mesh that is not periodic.
  ParametricMesh(std::vector<Vec2> vertices, std::vector<Triangle> triangles, double period = 0);

  /// Disjoint union of meshes: vertices, edges and triangles of each mesh follow those of the
  /// previous ones, in their original order. Cost: O(size of all meshes).
  static ParametricMesh concatenated(const std::vector<const ParametricMesh*>& meshes);

  int vertex_count() const { return isize(vertices_); }
  int edge_count() const { return isize(edges_); }
  int triangle_count() const { return isize(triangles_); }
  /// Period in u; 0 for a mesh that is not periodic and for concatenated() meshes.
  double period() const { return period_; }

  const std::vector<Vec2>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<Edge>& edges() const { return edges_; }
  /// Indices of the three edges of a triangle; edge i is opposite vertex i.
  const Triangle& edges_of(int triangle) const { return triangle_edges_[triangle]; }
  /// Index of the edge between vertices a and b; -1 if there is no such edge.
  int edge_between(int a, int b) const;

  /// +1 if edge `local` of the triangle, taken from its lower to its higher vertex index, runs
  /// counter-clockwise around the triangle; otherwise -1.
  double edge_sign(int triangle, int local) const {
    const auto& t = triangles_[triangle];
    return t[(local + 1) % 3] < t[(local + 2) % 3] ? 1 : -1;
  }
  /// Shape of a triangle, unwrapped across the seam of a periodic mesh.
  TriangleShape shape(int triangle) const;
  /// Unit vector in (u, v) from the lower-numbered to the higher-numbered vertex of an edge.
  /// edge_normal(): edge_tangent() rotated by +90°.
  Vec2 edge_tangent(int edge) const;
  Vec2 edge_normal(int edge) const;
  double edge_length(int edge) const;
  /// The point p, shifted in u by the multiple of the period that brings it nearest to the u of
  /// `anchor`; p itself if the mesh is not periodic.
  Vec2 image_near(const Vec2& p, const Vec2& anchor) const;
  /// The point p, shifted in u by a multiple of the period into [0, period); p itself if the mesh
  /// is not periodic.
  Vec2 wrapped(Vec2 p) const;
  /// Vector from the first to the last vertex of a chain of vertices, summed over its edges. For a
  /// closed chain once around a periodic mesh, it is (period, 0) or (-period, 0).
  Vec2 chain_vector(const std::vector<int>& chain) const;

  /// Mesh of n×n squares on [0,1]², each divided by its (0,0)-(1,1) diagonal. Used by benchmarks
  /// and tests.
  static ParametricMesh unit_square(int n);
  /// Uniform refinement: each triangle is divided into four by its edge midpoints.
  ParametricMesh refined() const;

 private:
  struct Component {
    int first_vertex;
    double period;
  };
  ParametricMesh() = default;
  // Vector in (u, v) from the lower-numbered to the higher-numbered end of an edge.
  Vec2 edge_vector(int edge) const;
  double period_at(int vertex) const;

  std::vector<Vec2> vertices_;
  std::vector<Triangle> triangles_;
  double period_ = 0;
  std::vector<Component> components_;  // of a concatenated mesh, ascending; else empty
  std::vector<Triangle> triangle_edges_;
  std::vector<Edge> edges_;
  std::vector<std::vector<int>> edges_from_;  // by lower vertex
};

/// Numbering of the dofs of one coordinate: 3v + {0: w, 1: w_u, 2: w_v} at vertex v, and 3·vertices
/// + e for the normal derivative w_n at edge e.
class DofMap {
 public:
  explicit DofMap(const ParametricMesh& mesh)
      : edge_start_(3 * mesh.vertex_count()), count_(edge_start_ + mesh.edge_count()) {}

  int count() const { return count_; }
  /// Index of a dof at vertex v. `derivative`: 0 for the value w, 1 for w_u, 2 for w_v.
  int vertex(int v, int derivative = 0) const { return 3 * v + derivative; }
  int edge(int e) const { return edge_start_ + e; }
  /// Indices of the 12 dofs of triangle t: three per vertex, then one per edge.
  std::array<int, 12> triangle(const ParametricMesh& mesh, int t) const;

 private:
  int edge_start_, count_;
};

// Points on a mesh.

/// A point of a surface mesh: triangle and barycentric coordinates.
struct Location {
  int triangle = 0;
  Vec3 L = Vec3::Constant(1.0 / 3);
};

// Fill-reducing elimination orders of the dofs of a surface.

/// Elimination order of the dofs of one coordinate by nested dissection of the mesh, for a sparse
/// Cholesky factorization; the dof eliminated first comes first.
///
/// The triangles are bisected recursively by their centroids, across the longer side of their
/// bounding box. Dofs that touch both halves form the separator and come last, after those of the
/// halves, which are ordered in the same way. Cost: O(triangles · log triangles). This is much
/// cheaper than ordering the matrix graph and gives less fill on large meshes.
std::vector<int> nested_dissection_order(const ParametricMesh& mesh);

/// Vertices to which each dof belongs, as input of vertex_ordering(): for a vertex dof, its vertex
/// twice; for an edge dof, the two ends of its edge.
std::vector<std::array<int, 2>> dof_vertices(const ParametricMesh& mesh);

}  // namespace batten
