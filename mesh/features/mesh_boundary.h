// SPDX-License-Identifier: MPL-2.0
// Boundary loops of a triangle mesh, with tangent planes and curvatures of the surface that the mesh
// approximates.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A free boundary loop of a mesh (MeshTopology::boundary_loops()), with the mesh on its left.
struct MeshBoundary {
  std::vector<int> vertices;
  std::vector<Vec3> points;   ///< point of the fitted surface closest to each vertex
  std::vector<Vec3> normals;  ///< unit normal at each vertex, on the side of the triangles' normals
  /// Second fundamental form at each vertex as a symmetric tensor in space, positive where the
  /// surface bends towards its normal: the normal curvature in a unit tangent direction d is dᵀ II d,
  /// 1/length.
  std::vector<Mat3> curvatures;
  /// Median over the vertices of the weighted root mean square distance of the mesh's vertices from
  /// the fitted surface.
  double noise = 0;
  double length = 0;           ///< length of the polygon
  Vec3 centre = Vec3::Zero();  ///< mean of the vertices
  /// Total geodesic curvature of the polygon on the mesh, Σ (π - sum of the angles of the triangles
  /// at the vertex), degrees: 360 around a flat sheet, -360 around a hole in it.
  double turning_deg = 0;
  int component = 0;  ///< manifold patch of the mesh (MeshTopology::component())
};

/// Computes all boundary loops of a mesh, longest first.
///
/// Normal and curvature at a vertex are those of the quadratic height function
///
///     z(x, y) = c + gᵀ(x, y) + ½ (x, y) H (x, y)ᵀ
///
/// fitted by weighted least squares to the vertices of its manifold patch that are connected to it by
/// at most three edges (more, if these are fewer than twelve; six or twelve edges, if the root mean
/// square residual is not more than twice as large then, as in noise), over the plane of the mean of the
/// triangles' normals there. Edges at which the triangles' normals differ by more than `crease_deg`
/// separate the vertices. On a smooth surface and with edge length h, the error of the normal is
/// O(h²). If there are fewer than six vertices, the surface is taken as flat. Source: Cazals, Pouget
/// 2005, jets of degree 2. O(boundary vertices).
std::vector<MeshBoundary> mesh_boundaries(const TriangleMesh& mesh, double crease_deg = 40);

}  // namespace batten
