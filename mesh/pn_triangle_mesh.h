// The nearest point of a mesh of curved triangles.
#pragma once

#include <optional>
#include <vector>
#include <array>
#include <functional>

#include "batten/mesh/triangle_mesh.h"
#include "batten/core/eigen.h"

namespace batten {

// A triangle that bulges as its corners' normals say.

/// The cubic Bézier triangle that begins at each corner in the corner's tangent plane, and whose inner
/// control point gives back quadratics. A surface's points and unit normals at the corners of triangles of
/// size h are met to O(h³), mostly O(h⁴); flat triangles to O(h²). With three equal normals across its plane
/// it is the flat triangle. Source: Vlachos et al. 2001, "Curved PN triangles", section 3.1.
class PnTriangle {
 public:
  using Corners = std::array<Vec3, 3>;
  PnTriangle(const Corners& points, const Corners& normals);

  /// Position and derivatives by the second and third barycentric coordinate.
  struct Jet {
    Vec3 x, u, v, uu, uv, vv;
  };
  Jet jet(const Vec3& weights) const;
  Vec3 at(const Vec3& weights) const { return jet(weights).x; }

 private:
  // Control points by the corners that they are nearest to: 0, 1, 2, 001, 011, 112, 122, 220, 200, 012.
  std::array<Vec3, 10> b_;
};


/// A triangle mesh whose triangles bulge as the normals at their corners say. Two triangles may have two
/// normals at a common corner: there is an edge. May be asked from several threads.
class PnTriangleMesh {
 public:
  /// `normals`: unit vectors, one a corner, on the side of the triangle's area vector; none at all: all
  /// triangles are flat. Throws InputError on another number of them.
  explicit PnTriangleMesh(TriangleMesh mesh, std::vector<PnTriangle::Corners> normals = {});

  const TriangleMesh& mesh() const { return mesh_; }
  PnTriangle triangle(int t) const;
  /// Whether a triangle bulges.
  bool curved(int t) const { return !normals_.empty() && curved_[t] != 0; }

  const PnTriangle::Corners& normals(int t) const { return normals_[t]; }  ///< where curved

  struct ClosestPoint {
    int triangle = -1;
    Vec3 weights = Vec3::Zero();  ///< barycentric
    Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();
    bool on_boundary = false;  ///< on an edge without a triangle beyond
  };
  /// The nearest point, of those whose normal has a positive share of `side` where it is given. Newton's
  /// method begins in the nearest flat triangle and goes on in the next one where it leaves that. What it
  /// finds is a point of the surface in any case; where the mesh is coarse beside the distance a nearer one
  /// may exist. Some microseconds.
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


// A piece of a surface laid out in a plane.

/// A harmonic map of a mesh with a rim into the plane: places u_i of the vertices for which
///
///     Σ w_ij |u_i - u_j|²  over all edges is least, those on the rim are given;
///
/// w the cotangent weights, of 0.01 at least and 100 at most. Such weights turn no triangle over where the rim's
/// places are convex; elsewhere few. Sources: Tutte 1963; Floater 1997, "Parametrization and smooth approximation
/// of surface triangulations"; Pinkall and Polthier 1993 (the cotangents).
class HarmonicMap {
 public:
  /// `boundary_parameter`: the place of each vertex on the rim, from its point. Throws InputError: a mesh without rim
  /// or of several sheets. Costs one factor. The mesh has to outlive the map.
  HarmonicMap(const PnTriangleMesh& mesh,
              const std::function<Vec2(const Vec3&)>& boundary_parameter);

  Vec2 parameter(int vertex) const { return flat_.point(vertex).head<2>(); }
  /// The surface's point over a place, or over the nearest one that has any. A microsecond.
  Vec3 surface_point(const Vec2& parameter) const;

 private:
  const PnTriangleMesh& mesh_;
  TriangleMesh flat_;
  AabbTree search_;
};

}  // namespace batten
