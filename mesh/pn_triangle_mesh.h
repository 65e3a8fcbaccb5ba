// SPDX-License-Identifier: MPL-2.0
// Curved point-normal (PN) triangles, closest points on a mesh of PN triangles, and harmonic
// parametrization of such a mesh.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// One curved triangle.

/// Curved point-normal (PN) triangle: a cubic Bézier triangle that interpolates three points and
/// has a given normal at each of them. Its inner control point is chosen such that quadratic
/// patches are reproduced. With exact points and unit normals of a smooth surface, triangles of
/// size h have a distance of O(h³), usually O(h⁴), from the surface; flat triangles have a distance
/// of O(h²). If all three normals equal the normal of the flat triangle, the patch is the flat
/// triangle. Reference: [Vlachos2001], section 3.1.
class PnTriangle {
 public:
  using Corners = std::array<Vec3, 3>;
  PnTriangle(const Corners& points, const Corners& normals);

  /// Point x of a PN triangle, and its first and second derivatives with respect to u and v. The
  /// parameters u and v are the second and third barycentric coordinates.
  struct Jet {
    Vec3 x, u, v, uu, uv, vv;
  };
  /// Point and derivatives of the curved triangle at the barycentric coordinates `weights` (sum 1).
  Jet jet(const Vec3& weights) const;
  Vec3 at(const Vec3& weights) const { return jet(weights).x; }

 private:
  // Control points, named by the corners they are nearest to: 0, 1, 2, 001, 011, 112, 122, 220,
  // 200, 012.
  std::array<Vec3, 10> b_;
};

/// A mesh of PN triangles, defined by a triangle mesh and corner normals. If two triangles have
/// different normals at a common corner, their shared edge is a crease. Queries are thread-safe.
class PnTriangleMesh {
 public:
  /// Builds a mesh of curved triangles. `normals`: three unit vectors per triangle, one at each
  /// corner, on the side of the area vector of the triangle. If `normals` is empty, all triangles
  /// are flat. Throws InputError if `normals` is not empty and its size is not the number of
  /// triangles.
  explicit PnTriangleMesh(TriangleMesh mesh, std::vector<PnTriangle::Corners> normals = {});

  const TriangleMesh& mesh() const { return mesh_; }
  PnTriangle triangle(int t) const;
  /// True if triangle t is curved, that is, if one of its corner normals differs from the normal of
  /// the flat triangle.
  bool curved(int t) const { return !normals_.empty() && curved_[t] != 0; }

  /// Corner normals of triangle t. Call this function only if the mesh was built with normals.
  const PnTriangle::Corners& normals(int t) const { return normals_[t]; }

  struct ClosestPoint {
    int triangle = -1;
    Vec3 weights = Vec3::Zero();  ///< barycentric coordinates of the closest point in `triangle`
    Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();
    bool on_boundary = false;  ///< true: the closest point lies on an edge with only one triangle
  };
  /// The point of the mesh of PN triangles that is closest to p. Newton's method starts in the
  /// nearest flat triangle and continues in the adjacent triangle when it crosses an edge. If
  /// `side` is given, the iteration starts in the nearest triangle whose normal has a positive dot
  /// product with `side`; the result is empty if no triangle has such a normal. The result always
  /// lies on the surface, but its distance may be only a local minimum if the triangles are large
  /// compared with the distance. Costs some microseconds.
  std::optional<ClosestPoint> nearest(const Vec3& p, const std::optional<Vec3>& side = {}) const;

 private:
  struct FootPoint;
  FootPoint foot_point(int t, const Vec3& p, Vec3 weights) const;
  FootPoint foot_point_on_edge(int t, int corner, const Vec3& p, Vec3 weights) const;
  bool on_boundary(int t, const Vec3& weights) const;

  TriangleMesh mesh_;
  std::vector<PnTriangle::Corners> normals_;
  std::vector<char> curved_;
  TriangleTree search_;
};

// Parametrization over the plane.

/// Harmonic parametrization of a mesh with boundary over the plane. The parameters u_i (2D points)
/// of the vertices i minimise
///
///     Σ w_ij |u_i - u_j|²  over all edges ij, with given parameters of boundary vertices.
///
/// The weights w_ij are cotangent weights, clamped to [0.01, 100]. Since they are positive, no
/// triangle is inverted if the boundary parameters form a convex polygon; otherwise few triangles
/// are inverted. References: [Tutte1963]; [Floater1997]; [PinkallPolthier1993] (cotangent weights).
class HarmonicMap {
 public:
  /// Computes the parametrization. `boundary_parameter`: maps the position of a boundary vertex to
  /// its parameter (u, v). Throws InputError if the mesh has no boundary or several manifold
  /// patches. Costs one sparse factorization. This object keeps a reference to `mesh`, which must
  /// outlive it.
  HarmonicMap(const PnTriangleMesh& mesh,
              const std::function<Vec2(const Vec3&)>& boundary_parameter);

  /// Parameter (u, v) of a mesh vertex.
  Vec2 parameter(int vertex) const { return flat_.point(vertex).head<2>(); }
  /// The point of the mesh of PN triangles at a parameter (u, v). A parameter outside the domain is
  /// replaced by the nearest point of the domain. Costs about 1 µs.
  Vec3 surface_point(const Vec2& parameter) const;

 private:
  const PnTriangleMesh& mesh_;
  TriangleMesh flat_;
  TriangleTree search_;
};

}  // namespace batten
