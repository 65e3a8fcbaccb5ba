// SPDX-License-Identifier: MPL-2.0
// Feature lines of a mesh (creases and boundaries), and the patches that they enclose.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of feature_lines().
struct FeatureLineOptions {
  /// An edge is a crease if the normals of its two triangles differ by more than this angle, in
  /// degrees; between 0 and 180.
  double crease_degrees = 30;
  /// A feature line ends at a vertex (a corner) if its direction changes there by more than this
  /// angle, in degrees; between 0 and 180.
  double corner_degrees = 45;
  /// Minimum length of crease lines with a dangling end, relative to the mesh size. Shorter lines
  /// are regarded as noise and omitted.
  double min_length = 0.02;
  /// Edges that are feature lines whatever their angle; indices into MeshTopology::edges().
  std::vector<int> given_edges = {};
};

/// A feature line of a mesh: a chain of boundary edges, of crease edges, or of other given edges.
struct FeatureLine {
  enum class Kind { Boundary, Crease, Given };
  std::vector<int> vertices;  ///< in order; the first vertex of a closed line is not repeated
  std::vector<int> edges;     ///< indices into MeshTopology::edges(), in order along the line
  bool closed = false;
  Kind kind = Kind::Crease;
};

/// A patch of the mesh enclosed by feature lines.
struct FeaturePatch {
  std::vector<int> triangles;  ///< triangle indices, ascending
  /// Boundary loops of the patch, the longest one first. Each loop is a sequence of indices into
  /// FeatureLines::lines.
  std::vector<std::vector<int>> loops;
  std::vector<int> inner;  ///< indices of the feature lines with this patch on both sides
  bool flat = false;       ///< true if all triangles lie in one plane
};

/// Result of feature_lines().
struct FeatureLines {
  std::vector<FeatureLine> lines;
  std::vector<FeaturePatch> patches;  ///< sorted by their lowest-numbered triangles
};

/// Finds the feature lines of a mesh and the patches that they enclose. Lines are split at corners
/// (see FeatureLineOptions::corner_degrees), where their kind changes, and at vertices whose number
/// of feature edges is not two. The lines are sorted by their lowest-numbered vertices. Creases rounded off by
/// many small triangles are not detected. Throws InputError if an angle is not between 0 and 180,
/// or a given edge is out of range. O(edges).
FeatureLines feature_lines(const TriangleMesh& mesh, const FeatureLineOptions& options = {});

/// Finds the shortest path along edges through the vertices `through`, in the given order
/// (Dijkstra's algorithm). The length of an edge is divided by 1 + (a / 10°)², where a is the angle
/// between the normals of its triangles, so that the path follows creases.
///
/// `closed`: the path returns to its first vertex, which is not repeated in the result. The result
/// contains nodes, see MeshTopology::node_of(). Throws InputError if `through` is empty, a vertex
/// is out of range, or two vertices lie in different connected components of the mesh. O(n log n)
/// per vertex of `through`.
std::vector<int> crease_path(const TriangleMesh& mesh, std::vector<int> through,
                             bool closed = false);

}  // namespace batten
