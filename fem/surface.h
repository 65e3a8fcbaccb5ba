// SPDX-License-Identifier: MPL-2.0
// C1 finite-element surface in space over a parametric mesh.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "batten/fem/parametric_mesh.h"
#include "batten/fem/trim.h"

namespace batten {

/// Position and derivatives with respect to (u, v) at one point.
struct SurfaceJet {
  Vec3 x, x_u, x_v, x_uu, x_uv, x_vv;

  /// Area vector x_u × x_v, whose length is the Jacobian of the surface.
  Vec3 area_vector() const;
  /// Unit normal x_u × x_v / |x_u × x_v|; zero if x_u × x_v = 0.
  Vec3 normal() const;
};

/// Curvatures of a surface at a point, positive where the surface bends towards its normal: a
/// sphere of radius R with outward normals has mean curvature -1/R. Units: 1/length; Gaussian
/// curvature 1/length².
struct Curvatures {
  double mean = 0, gauss = 0, k1 = 0, k2 = 0;  ///< mean, Gaussian and principal curvatures; k1 ≥ k2
};
/// Computes the curvatures of a surface at a point from its derivatives there.
Curvatures curvatures(const SurfaceJet& jet);

/// The surface X(u, v) = Σ N_m(u, v) q_m with dofs q (n×3). It is C1; second derivatives jump at
/// element edges. With a trim, only the part inside the trim's loops belongs to the surface. Copies
/// share mesh and trim.
class Surface {
 public:
  /// Result of closest_point().
  struct ClosestPoint {
    Location where;
    double distance = 0;
  };

  Surface(std::shared_ptr<const ParametricMesh> mesh, TriangleElement kind, Points dofs,
          std::shared_ptr<const Trim> trim = nullptr);

  const ParametricMesh& mesh() const { return *mesh_; }
  const std::shared_ptr<const ParametricMesh>& shared_mesh() const { return mesh_; }
  TriangleElement kind() const { return kind_; }
  const DofMap& dof_map() const { return dof_map_; }
  const Points& dofs() const { return dofs_; }
  /// The trim, or null if the surface covers the whole mesh.
  const std::shared_ptr<const Trim>& trim() const { return trim_; }
  /// The 12 dofs of one triangle: three per vertex, then one per edge; columns x, y, z.
  Eigen::Matrix<double, 12, 3> triangle_dofs(int triangle) const;

  Vec3 position(const Location& where) const;
  SurfaceJet jet(const Location& where) const;
  /// Area vector x_u × x_v; takes a third of the time of jet().
  Vec3 area_vector(const Location& where) const;

  /// Triangle that contains (u, v), and barycentric coordinates. For points outside of the domain,
  /// it is the nearest triangle, with coordinates clamped to it. Cost: O(triangles);
  /// TriangleLocator is faster for many points.
  Location locate(const Vec2& uv) const;

  /// Point of the surface nearest to p. Evaluates 15 samples per triangle, and starts Newton's
  /// method from every sample that is nearer than its neighbours. The nearest point is found unless
  /// the surface folds between two samples. With a trim, the candidates are the points inside and
  /// the points of its loops, which are sampled in the same way. Cost: O(triangles).
  ClosestPoint closest_point(const Vec3& p) const;

  /// Area of the surface in space; with a trim, area of the part inside.
  double area() const;

 private:
  // Point on the trim's loops nearest to p.
  ClosestPoint closest_on_loops(const Vec3& p) const;

  std::shared_ptr<const ParametricMesh> mesh_;
  TriangleElement kind_;
  DofMap dof_map_;
  Points dofs_;
  std::shared_ptr<const Trim> trim_;
};

/// Sparse evaluation matrix E (points × dofs), whose rows are the shape functions at the given
/// points: E q evaluates a surface with dofs q at many fixed points. `derivative`: kW for
/// positions, kU … kVV for derivatives.
SparseMatrix evaluation_operator(const ParametricMesh& mesh, TriangleElement kind,
                                 const std::vector<Location>& points, Derivative derivative = kW);

/// Display mesh of a surface: locations in its parametric mesh, and the flat facets between them.
/// Points on element edges are shared, so that the facets are watertight.
struct Tessellation {
  /// Locations of the display points; those at mesh vertices come first, in mesh order.
  std::vector<Location> points;
  std::vector<std::array<int, 3>> facets;
  std::vector<int> facet_triangle;  ///< index of the element triangle that contains each facet
};
/// Creates a display mesh with n² facets per element triangle, n ≥ 1.
Tessellation tessellate(const ParametricMesh& mesh, int n);

/// Curvatures of a surface at the points of a tessellation. They are evaluated at the centroids of
/// the three sub-triangles of each element, where they are most accurate, averaged to the vertices
/// with area weights, and interpolated linearly. Error: O(h²). With a trim, an element counts by
/// the fraction of its area that is inside; vertices with less than a fifth of an element around
/// them get the mean of their neighbours.
std::vector<Curvatures> recovered_curvatures(const Surface& surface, const Tessellation& points);

// Dofs that interpolate a given surface.

/// Position x of a surface at a point (u, v), and its derivatives with respect to u and v (the
/// columns of `gradient`).
struct FirstOrderJet {
  Vec3 x = Vec3::Zero();
  Eigen::Matrix<double, 3, 2> gradient = Eigen::Matrix<double, 3, 2>::Zero();
};

/// Computes the dofs (n×3) that interpolate a given surface over (u, v) on a mesh: positions and
/// slopes at vertices, and normal slopes at edge midpoints. If `edge_midpoints` is not null, it
/// receives the positions of `surface` at edge midpoints, one row per edge; compare them with the
/// interpolant to see how well the mesh resolves the surface. Calls `surface` once per vertex and
/// per edge, in parallel.
Points interpolate_surface(const ParametricMesh& mesh,
                           const std::function<FirstOrderJet(const Vec2& uv)>& surface,
                           Points* edge_midpoints = nullptr);

}  // namespace batten
