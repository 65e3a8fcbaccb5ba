// A C1 surface in space over a parametric mesh.
#pragma once

#include <memory>
#include <vector>

#include "batten/fem/parametric_mesh.h"
#include "batten/fem/trim.h"

namespace batten {

/// Position and derivatives with respect to (u, v) at one point.
struct SurfaceJet {
  Vec3 x, x_u, x_v, x_uu, x_uv, x_vv;

  /// Area vector x_u × x_v; its length is the Jacobian of the surface.
  Vec3 area_vector() const;
  /// Unit normal, right-handed with (u, v). Zero where the surface is singular.
  Vec3 normal() const;
};

/// Curvatures of a surface at a point, positive where the surface bends towards its normal (a
/// sphere with outward normals of radius R has mean -1/R). Units: 1/length, Gauss 1/length².
struct Curvatures {
  double mean = 0, gauss = 0, k1 = 0, k2 = 0;  ///< k1 ≥ k2
};
Curvatures curvatures(const SurfaceJet& jet);

/// The surface X(u, v) = Σ N_m(u, v) q_m; q is dofs × 3. C1 everywhere: second derivatives jump at
/// element edges. With a trim, the surface is only the part inside of its loops. Copies share mesh
/// and trim.
class Surface {
 public:
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
  /// The trim, or null when the surface is the whole mesh.
  const std::shared_ptr<const Trim>& trim() const { return trim_; }
  /// The 12 dofs of one triangle, columns x, y, z.
  Eigen::Matrix<double, 12, 3> triangle_dofs(int triangle) const;

  Vec3 position(const Location& where) const;
  SurfaceJet jet(const Location& where) const;
  /// x_u × x_v, in a third of the time of a jet.
  Vec3 area_vector(const Location& where) const;

  /// The triangle that holds (u, v), or the nearest one with L clamped into it when (u, v) is
  /// outside the domain. O(triangles).
  Location locate(const Vec2& uv) const;

  /// The nearest point of the surface: 15 samples of each triangle, then Newton's method from every
  /// sample that its neighbours do not beat. Finds it unless the surface folds between two samples.
  /// With a trim, of the points inside and those of the loops x(c(t)), which are sampled likewise.
  /// O(triangles).
  ClosestPoint closest_point(const Vec3& p) const;

  /// Area of the surface; with a trim, of the part inside.
  double area() const;

 private:
  // The nearest point of the trim's loops.
  ClosestPoint closest_on_loops(const Vec3& p) const;

  std::shared_ptr<const ParametricMesh> mesh_;
  TriangleElement kind_;
  DofMap dof_map_;
  Points dofs_;
  std::shared_ptr<const Trim> trim_;
};

/// The rows N(where) over the dofs: positions of many fixed points are one sparse product, E q.
/// `derivative`: kW for positions, kU … kVV for derivatives. Points × dofs.
SparseMatrix evaluation_operator(const ParametricMesh& mesh, TriangleElement kind,
                                 const std::vector<Location>& points, Derivative derivative = kW);

/// Display points and facets: the pattern only, shared along element edges so that the facets are
/// watertight.
struct Tessellation {
  std::vector<Location> points;  ///< the mesh's vertices come first, in their order
  std::vector<std::array<int, 3>> facets;
  std::vector<int> facet_triangle;  ///< element that holds each facet
};
/// Display points of a mesh with each triangle cut into n² facets, n ≥ 1.
Tessellation tessellate(const ParametricMesh& mesh, int n);

/// Curvatures at the points of a tessellation. They are taken at the centroids of the elements'
/// sub-triangles, where they are most accurate, and averaged to the vertices (weights: area), then
/// interpolated linearly. O(h²). With a trim, only the share of an element that is inside counts;
/// vertices with less than a fifth of an element around them take the mean of their neighbours.
std::vector<Curvatures> recovered_curvatures(const Surface& surface, const Tessellation& points);

}  // namespace batten
