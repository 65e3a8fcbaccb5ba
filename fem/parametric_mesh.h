// Triangle meshes of the (u, v) plane, with the edges that carry dofs.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/containers.h"
#include "batten/elements/c1_triangle.h"

namespace batten {

/// A conforming mesh of counter-clockwise triangles. Immutable.
///
///            V_i              Edge i of a triangle is opposite its vertex i and runs V_j → V_k,
///            /\               (i, j, k) cyclic. In the mesh an edge runs from its lower vertex
///    edge k /  \ edge j       number to its higher one, which fixes the sign of its normal
///          /____\             (c1_triangle.h). Edges are numbered in the order in which the
///       V_j edge i V_k        triangles name them first.
///
/// A mesh may be periodic in u: (u + period, v) is the same point as (u, v), as on a tube. Vertices
/// keep u in [0, period), triangles and edges that cross the seam are placed as if it were not
/// there: within half a period of their first vertex (edges: of the lower one).
class ParametricMesh {
 public:
  using Triangle = std::array<int, 3>;
  struct Edge {
    int low, high;    ///< vertices, low < high
    int triangle[2];  ///< the triangles beside it; triangle[1] is -1 on the boundary
    int local[2];     ///< its number 0..2 in each
    bool boundary() const { return triangle[1] < 0; }
  };

  /// Throws MeshError: a vertex index out of range, a triangle that is not counter-clockwise, an
  /// edge with more than two triangles or twice in the same direction, a vertex in no triangle.
  /// With a period: a u outside of [0, period), an edge that spans a third of the period or more
  /// (which way around it runs would be a guess).
  ParametricMesh(std::vector<Vec2> vertices, std::vector<Triangle> triangles, double period = 0);

  /// The components of all meshes, one after the other: vertices, edges and triangles of each
  /// follow those before it, in their order. O(all).
  static ParametricMesh concatenated(const std::vector<const ParametricMesh*>& meshes);

  int vertex_count() const { return isize(vertices_); }
  int edge_count() const { return isize(edges_); }
  int triangle_count() const { return isize(triangles_); }
  /// The period in u of a mesh of one component; 0: the mesh is not periodic.
  double period() const { return period_; }

  const std::vector<Vec2>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<Edge>& edges() const { return edges_; }
  const Triangle& edges_of(int triangle) const { return triangle_edges_[triangle]; }
  /// Edge between two vertices, or -1.
  int edge_between(int a, int b) const;

  /// +1 where the edge runs along the triangle's own direction, -1 where it runs against it.
  double edge_sign(int triangle, int local) const {
    const auto& t = triangles_[triangle];
    return t[(local + 1) % 3] < t[(local + 2) % 3] ? 1 : -1;
  }
  TriangleShape shape(int triangle) const;
  /// Unit vector from the lower to the higher end, and that vector turned by +90°.
  Vec2 edge_tangent(int edge) const;
  Vec2 edge_normal(int edge) const;
  double edge_length(int edge) const;
  /// The image of p that is nearest to `anchor` in u; p itself without a period.
  Vec2 image_near(const Vec2& p, const Vec2& anchor) const;
  /// The image of p with u in [0, period); p itself without a period.
  Vec2 wrapped(Vec2 p) const;
  /// Way from the first vertex of a chain of edges to the last: (period, 0) once around.
  Vec2 chain_vector(const std::vector<int>& chain) const;

  /// n×n squares over [0,1]², each cut along its (0,0)-(1,1) diagonal: the mesh of the benchmarks.
  static ParametricMesh unit_square(int n);
  /// The mesh with each triangle cut into four by the midpoints of its edges.
  ParametricMesh refined() const;

 private:
  struct Component {
    int first_vertex;
    double period;
  };
  ParametricMesh() = default;
  // From the lower end to the higher.
  Vec2 edge_vector(int edge) const;
  double period_at(int vertex) const;

  std::vector<Vec2> vertices_;
  std::vector<Triangle> triangles_;
  double period_ = 0;
  std::vector<Component> components_;  // of several, ascending; empty for one
  std::vector<Triangle> triangle_edges_;
  std::vector<Edge> edges_;
  std::vector<std::vector<int>> edges_from_;  // by lower vertex
};

/// Numbers of the unknowns of one coordinate: 3v + {0: w, 1: w_u, 2: w_v} at vertex v, and
/// 3·vertices + e for w_n at edge e.
class DofMap {
 public:
  explicit DofMap(const ParametricMesh& mesh)
      : edge_start_(3 * mesh.vertex_count()), count_(edge_start_ + mesh.edge_count()) {}

  int count() const { return count_; }
  int vertex(int v, int derivative = 0) const { return 3 * v + derivative; }
  int edge(int e) const { return edge_start_ + e; }
  /// Dofs of a triangle in the order of the element's dofs.
  std::array<int, 12> triangle(const ParametricMesh& mesh, int t) const;

 private:
  int edge_start_, count_;
};


// A point on the triangles of a mesh.

/// A point of a surface mesh: triangle and barycentric coordinates in it.
struct Location {
  int triangle = 0;
  Vec3 L = Vec3::Constant(1.0 / 3);
};


// Fill-reducing orders of a surface's dofs: one from its geometry, and what another needs.

/// Nested dissection: the triangles are halved by their centres across the longer side of their
/// box, again and again; the dofs that both halves touch come last, those of the halves before
/// them, each ordered the same way. O(triangles · log triangles), far cheaper than finding an order
/// from the matrix, and with less fill on large meshes. Result: all dofs, the first to eliminate
/// first.
std::vector<int> nested_dissection_order(const ParametricMesh& mesh);

/// Of each dof its vertex, twice, or the two ends of its edge: what vertex_ordering needs.
std::vector<std::array<int, 2>> dof_vertices(const ParametricMesh& mesh);

}  // namespace batten
