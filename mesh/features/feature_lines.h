// Feature lines of a mesh: its creases and boundaries, and the patches that they enclose.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of feature_lines().
struct FeatureLineOptions {
  /// An edge is a crease if the normals of its two triangles differ by more than this angle, in
  /// degrees; between 0 and 180.
  double crease_degrees = 30;
  /// A line ends at a vertex where its direction changes by more than this angle, in degrees;
  /// between 0 and 180.
  double corner_degrees = 45;
  /// Crease chains with a dangling end that are shorter than this are noise; relative to the size
  /// of the mesh.
  double min_length = 0.02;
};

/// A chain of crease edges, or of edges at the boundary.
struct FeatureLine {
  std::vector<int> vertices;  ///< in their order; closed lines do not repeat the first vertex
  std::vector<int> edges;     ///< mesh edges in their order
  bool closed = false;
  bool boundary = false;  ///< true: boundary line; false: crease
};

/// A patch of the mesh enclosed by feature lines.
struct FeaturePatch {
  std::vector<int> triangles;  ///< ascending
  std::vector<std::vector<int>>
      loops;  ///< lines around the patch, as indices; each loop in order, the longest loop first
  std::vector<int> inner;  ///< indices of lines that have this patch on both sides
  bool flat = false;       ///< all triangles lie in one plane
};

/// Result of feature_lines().
struct FeatureLines {
  std::vector<FeatureLine> lines;
  std::vector<FeaturePatch> patches;  ///< sorted by their lowest triangle
};

/// Finds the feature lines of a mesh and the patches that they enclose. Lines are split at corners
/// and at vertices where the number of crease and boundary edges is not two. They are sorted by
/// their lowest vertex. Creases rounded off by many small triangles are not detected. Throws
/// InputError for angles outside (0, 180). O(edges).
FeatureLines feature_lines(const TriangleMesh& mesh, const FeatureLineOptions& options = {});

/// Finds the shortest path along edges through some vertices, in their order (Dijkstra's algorithm).
/// The length of an edge with dihedral angle a is divided by 1 + (a / 10°)², so that the path follows
/// creases.
///
/// `closed`: the path returns to its first vertex, which is not repeated. The result lists nodes, see
/// MeshTopology::node_of(). Throws InputError if `through` is empty, a vertex is out of range, or two
/// of them are in parts of the mesh that are not connected. O(n log n) per vertex of `through`.
std::vector<int> crease_path(const TriangleMesh& mesh, std::vector<int> through,
                             bool closed = false);

}  // namespace batten
