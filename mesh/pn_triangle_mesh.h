// Curved PN triangles, closest points on a mesh of them, and harmonic parametrization of such a
// mesh.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// One curved triangle.

/// Curved PN triangle: a cubic Bézier triangle that interpolates three points and is tangent to the
/// plane normal to the given vector at each of them. Its inner control point is chosen such that
/// quadratic patches are reproduced. For triangles of size h on a smooth surface, exact points and
/// unit normals at the corners give an error of O(h³), usually O(h⁴). Flat triangles give O(h²). If
/// all three normals equal the normal of the flat triangle, the patch is that triangle. Source:
/// [Vlachos2001], section 3.1.
class PnTriangle {
 public:
  using Corners = std::array<Vec3, 3>;
  PnTriangle(const Corners& points, const Corners& normals);

  /// Position, and first and second derivatives with respect to the second and third barycentric
  /// coordinates (u and v).
  struct Jet {
    Vec3 x, u, v, uu, uv, vv;
  };
  /// Position and derivatives at barycentric coordinates `weights`, which sum to 1.
  Jet jet(const Vec3& weights) const;
  Vec3 at(const Vec3& weights) const { return jet(weights).x; }

 private:
  // Control points, named by the corners they are nearest to: 0, 1, 2, 001, 011, 112, 122, 220,
  // 200, 012.
  std::array<Vec3, 10> b_;
};

/// A triangle mesh whose triangles are PN triangles defined by corner normals. Different normals of
/// two triangles at a common corner represent a crease. Queries are thread-safe.
class PnTriangleMesh {
 public:
  /// `normals`: one unit vector per triangle corner, on the side of the triangle's area vector. If
  /// empty, all triangles are flat. Throws InputError if their number differs from the number of
  /// triangles.
  explicit PnTriangleMesh(TriangleMesh mesh, std::vector<PnTriangle::Corners> normals = {});

  const TriangleMesh& mesh() const { return mesh_; }
  PnTriangle triangle(int t) const;
  /// True if the triangle is curved, that is, a corner normal differs from the flat normal.
  bool curved(int t) const { return !normals_.empty() && curved_[t] != 0; }

  /// Corner normals of a triangle. Undefined if the mesh was built without normals.
  const PnTriangle::Corners& normals(int t) const { return normals_[t]; }

  struct ClosestPoint {
    int triangle = -1;
    Vec3 weights = Vec3::Zero();  ///< barycentric
    Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();
    bool on_boundary = false;  ///< on an edge that has only one triangle
  };
  /// The point of the curved surface that is closest to p. If `side` is given, the search starts
  /// from the nearest triangle whose normal has a positive dot product with `side`; empty if there
  /// is none. Newton's method starts in the nearest flat triangle and continues in the adjacent
  /// triangle when it leaves one. The result always lies on the surface. It may be only a local
  /// minimum if the mesh is coarse compared with the distance. Costs some microseconds.
  std::optional<ClosestPoint> nearest(const Vec3& p, const std::optional<Vec3>& side = {}) const;

 private:
  struct FootPoint;
  FootPoint foot_point(int t, const Vec3& p, Vec3 weights) const;
  FootPoint foot_point_on_edge(int t, int corner, const Vec3& p, Vec3 weights) const;
  bool on_boundary(int t, const Vec3& weights) const;

  TriangleMesh mesh_;
  std::vector<PnTriangle::Corners> normals_;
  std::vector<char> curved_;
  AabbTree search_;
};

// Parametrization over the plane.

/// Harmonic parametrization of a mesh with boundary over the plane. The parameters u_i of the
/// vertices minimise
///
///     Σ w_ij |u_i - u_j|²  over all edges, with the u_i of boundary vertices given.
///
/// w_ij are the cotangent weights, clamped to [0.01, 100]. With positive weights no triangle is
/// inverted if the boundary parameters form a convex polygon; otherwise few triangles are. Sources:
/// [Tutte1963]; [Floater1997]; [PinkallPolthier1993] (cotangent weights).
class HarmonicMap {
 public:
  /// `boundary_parameter`: maps the position of a boundary vertex to its parameter. Throws
  /// InputError if the mesh has no boundary or several manifold patches. Costs one sparse
  /// factorization. The map keeps a reference to `mesh`, which must outlive it.
  HarmonicMap(const PnTriangleMesh& mesh,
              const std::function<Vec2(const Vec3&)>& boundary_parameter);

  /// Parameter of a vertex.
  Vec2 parameter(int vertex) const { return flat_.point(vertex).head<2>(); }
  /// The point of the curved surface at a parameter; outside the parameter domain, at its nearest
  /// point. Costs about 1 µs.
  Vec3 surface_point(const Vec2& parameter) const;

 private:
  const PnTriangleMesh& mesh_;
  TriangleMesh flat_;
  AabbTree search_;
};

}  // namespace batten
