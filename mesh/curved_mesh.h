// The nearest point of a mesh of curved triangles.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/curved_triangle.h"
#include "batten/mesh/surface_search.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A triangle mesh whose triangles bulge as the normals at their corners say. Two triangles may have two
/// normals at a common corner: there is an edge. May be asked from several threads.
class CurvedMesh {
 public:
  /// `normals`: unit vectors, one a corner, on the side of the triangle's area vector; none at all: all
  /// triangles are flat. Throws InputError on another number of them.
  explicit CurvedMesh(TriangleMesh mesh, std::vector<CurvedTriangle::Corners> normals = {});

  const TriangleMesh& mesh() const { return mesh_; }
  CurvedTriangle triangle(int t) const;
  /// Whether a triangle bulges.
  bool curved(int t) const { return !normals_.empty() && curved_[t] != 0; }

  const CurvedTriangle::Corners& normals(int t) const { return normals_[t]; }  ///< where curved

  struct Found {
    int triangle = -1;
    Vec3 weights = Vec3::Zero();  ///< barycentric
    Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();
    bool at_rim = false;  ///< on an edge without a triangle beyond
  };
  /// The nearest point, of those whose normal has a positive share of `side` where it is given. Newton's
  /// method begins in the nearest flat triangle and goes on in the next one where it leaves that. What it
  /// finds is a point of the surface in any case; where the mesh is coarse beside the distance a nearer one
  /// may exist. Some microseconds.
  std::optional<Found> nearest(const Vec3& p, const std::optional<Vec3>& side = {}) const;

 private:
  struct Foot;
  Foot foot(int t, const Vec3& p, Vec3 weights) const;
  Foot foot_on_edge(int t, int corner, const Vec3& p, Vec3 weights) const;
  bool at_rim(int t, const Vec3& weights) const;

  TriangleMesh mesh_;
  std::vector<CurvedTriangle::Corners> normals_;
  std::vector<char> curved_;
  SurfaceSearch search_;
};

}  // namespace batten
