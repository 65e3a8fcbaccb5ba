// A mesh cut by the loops that bound a region: which part of which triangle counts.
//
// The grid ignores the loops. Integrals run over the part of each triangle that is inside, by the
// divergence theorem: with any point P of a convex sub-triangle S,
//
//   ∫ f dA  =  Σ over the boundary of (S ∩ region)  ∫₀¹∫₀¹ f(P + r (c(t) - P)) r (c - P) × c' dr dt
//    S∩region
//
// cones from P over straight edge parts and over the cubic arcs themselves. No subdivision, no
// chords: exact for polynomials f up to a stated degree. Weights may be negative where an arc bends
// towards P; all points lie in S.
#pragma once

#include <memory>
#include <vector>

#include "batten/elements/quadrature.h"
#include "batten/fem/curves/domain_loops.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

class Trim {
 public:
  enum class Side : char { Outside, Inside, Cut };

  /// Cuts a mesh by loops. On a mesh that is periodic in u a loop is given once, beginning with u
  /// in [0, period), and cuts on both sides of the seam. O(triangles + arcs · triangles that they
  /// cross).
  Trim(const ParametricMesh& mesh, DomainLoops domain_loops);

  /// The loops; on a mesh that is periodic in u also their images one period to either side.
  const DomainLoops& loops() const { return loops_; }
  Side side(int triangle) const { return side_[triangle]; }
  /// Triangles that the loops pass through, ascending.
  const std::vector<int>& cut_triangles() const { return cut_triangles_; }
  /// Share of the triangle's area that is inside, 0 to 1.
  double area_fraction(int triangle) const { return area_fraction_[triangle]; }
  /// Area inside, in (u, v). Equals that of the given loops where the mesh covers the region.
  double area() const { return area_; }

  /// Barycentric points and weights over the part inside, whose weights sum to share(triangle):
  /// multiply by the triangle's area. Exact for polynomials of `degree` on each sub-triangle
  /// (V_j, V_k, centroid). Points are ordered by sub-triangle.
  TriangleRule rule(int triangle, int degree) const;

  /// Trims of meshes side by side (ParametricMesh::side_by_side), null ones for meshes that are
  /// whole. It has no loops(): these belong to the (u, v) of each.
  static Trim concatenated(const std::vector<const Trim*>& trims,
                           const std::vector<const ParametricMesh*>& meshes);

  /// This trim for a mesh that holds only these triangles, in this order.
  Trim restricted(const std::vector<int>& triangles) const;

 private:
  Trim() = default;
  struct Cone {
    int sub;
    Vec2 apex;
    bool straight;
    PlanarCubic side;
  };
  // By the arcs that come near it.
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
