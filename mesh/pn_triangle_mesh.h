// The nearest point of a mesh of curved triangles.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/aabb_tree.h"
#include "batten/mesh/pn_triangle.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

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

}  // namespace batten
