// SPDX-License-Identifier: MPL-2.0
// Trimmed mesh: classification of triangles by the loops that bound a region, and cut-cell
// quadrature.
//
// The mesh does not follow the loops. Integrals extend over the part of each triangle that is
// inside the region; they are computed by the divergence theorem. With any point P of a convex
// sub-triangle S,
//
//   ∫ f dA  =  Σ over the boundary of (S ∩ region)  ∫₀¹∫₀¹ f(P + r (c(t) - P)) r (c - P) × c' dr dt
//    S∩region
//
// the region is decomposed into cones from P over straight edge parts and over the cubic arcs
// themselves. There is no subdivision and no polygonal approximation: the rules are exact for
// polynomials f up to a given degree. Weights may be negative where an arc bends towards P; all
// points lie in S.
#pragma once

#include <memory>
#include <vector>

#include "batten/elements/quadrature.h"
#include "batten/fem/curves/domain_loops.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

/// Region of a parametric mesh that is bounded by loops of cubic curves.
class Trim {
 public:
  /// Position of a triangle relative to the trimmed region; `Cut`: boundary loops pass through it.
  enum class Side : char { Outside, Inside, Cut };

  /// Classifies and cuts the triangles of a mesh by the loops that bound a region. On a mesh that
  /// is periodic in u, each loop is given once, beginning with u in [0, period), and cuts on both
  /// sides of the seam. Cost: O(triangles + arcs · triangles that they cross).
  Trim(const ParametricMesh& mesh, DomainLoops domain_loops);

  /// Loops that bound the trimmed region. On a mesh that is periodic in u, their images one period
  /// to either side are included.
  const DomainLoops& loops() const { return loops_; }
  Side side(int triangle) const { return side_[triangle]; }
  /// Indices of the triangles that the boundary loops pass through, ascending.
  const std::vector<int>& cut_triangles() const { return cut_triangles_; }
  /// Fraction of the area of a triangle that is inside the trimmed region, 0 to 1.
  double area_fraction(int triangle) const { return area_fraction_[triangle]; }
  /// Area of the part of the mesh inside the trimmed region, in (u, v). If the mesh covers the
  /// region, this is the area of the whole region.
  double area() const { return area_; }

  /// Quadrature rule on the part of a triangle inside the trimmed region: barycentric points, and
  /// weights that sum to area_fraction(triangle). Multiply the weights by the area of the triangle.
  /// Exact for polynomials of `degree` on each sub-triangle (two vertices and the centroid). Points
  /// are ordered by sub-triangle.
  TriangleRule rule(int triangle, int degree) const;

  /// Points on the boundary loops inside a triangle, in barycentric coordinates: the ends and the
  /// middle of each arc between the sides of the sub-triangles. Empty unless the triangle is cut.
  std::vector<Vec3> boundary_points(int triangle) const;

  /// Trim of the concatenated `meshes` (ParametricMesh::concatenated()). `trims`: one per mesh;
  /// null for an untrimmed mesh. The result has no loops(), because loops belong to the (u, v)
  /// plane of a single mesh.
  static Trim concatenated(const std::vector<const Trim*>& trims,
                           const std::vector<const ParametricMesh*>& meshes);

  /// This trim, restricted to the mesh that consists of the given triangles in the given order.
  Trim restricted(const std::vector<int>& triangles) const;

 private:
  Trim() = default;
  // Index into cut_triangles_; -1 if the triangle is not cut.
  int find_cut(int triangle) const;
  struct Cone {
    int sub;
    Vec2 apex;
    bool straight;
    PlanarCubic side;
  };
  // Cuts a triangle by the cubic arcs of the loops near it.
  void cut_triangle(int triangle, const TriangleShape& shape,
                    const std::vector<PlanarCubic>& segments);

  DomainLoops loops_;
  std::vector<Side> side_;
  std::vector<double> area_fraction_;
  std::vector<int> cut_triangles_;
  std::vector<int> cones_of_;  // first cone of each cut triangle
  std::vector<Cone> cones_;
  std::vector<std::array<Vec2, 3>> corners_;  // of each cut triangle
  double area_ = 0;
};

}  // namespace batten
