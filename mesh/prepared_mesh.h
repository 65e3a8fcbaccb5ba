// SPDX-License-Identifier: MPL-2.0
// Converts shell elements to a clean, oriented triangle mesh, and reports defects of the input.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Counts of components, patches and defects of a shell mesh. The lists contain at most 8 items,
/// but the counts include all.
struct MeshDiagnosis {
  int components = 0;  ///< number of connected components, which share no nodes with each other
  /// Number of manifold patches: sets of faces that are connected by edges. At an edge with three
  /// or more faces, the rule of PreparedMesh decides which faces are connected.
  int manifold_patches = 0;
  int unused_nodes = 0;     ///< number of nodes that belong to no face
  int collapsed_faces = 0;  ///< number of faces with fewer than three distinct corners
  int duplicate_faces = 0;  ///< number of faces with the same nodes as an earlier face
  /// Number of faces whose orientation must be reversed to match the other faces of their patch.
  int flipped_faces = 0;
  /// Number of nodes of faces whose position equals that of another node of a face.
  int coincident_nodes = 0;
  /// Number of triangles whose height is below 1e-12 times their longest edge.
  int zero_area_triangles = 0;
  /// False if a patch of the mesh is non-orientable, like a Möbius strip.
  bool orientable = true;
  std::vector<std::array<int, 2>> non_manifold_edges;  ///< up to 8 edges with three or more faces
  int non_manifold_edge_count = 0;
  /// Up to 8 nodes at which patches touch without sharing an edge.
  std::vector<int> non_manifold_nodes;
  int non_manifold_node_count = 0;
  std::vector<int> non_finite_nodes;  ///< up to 8 nodes with non-finite coordinates
};

/// Triangle mesh derived from shell elements, used for all computations. Vertex i is node i of the
/// shell mesh; duplicates of nodes that belong to several patches follow (see MeshTopology). The
/// shell elements are not changed.
///
/// Every face is split into triangles: quads along their shorter diagonal (ties: 1-3), or along the
/// other one if a corner is nearly straight there, second-order elements through their midside nodes, polygons by clipping the ear of best quality.
///
/// Non-manifold edges (three or more faces) are resolved as follows. Two faces continue the same
/// patch if the angle between their normals is less than 45°, and if the cosine of this angle
/// exceeds that of each of the two faces with any other face at the edge by at least 0.05. All
/// other patches end at the edge. Therefore a skin continues past its ribs, while three walls that
/// meet at 120° all end there. Non-orientable patches are cut open.
struct PreparedMesh {
  TriangleMesh mesh;
  /// Index of the shell face from which each triangle was made.
  std::vector<int> face_of_triangle;
  MeshDiagnosis diagnosis;
  /// Messages for the user about repairs and unusual properties of the mesh, such as "12 faces with
  /// reversed orientation (corrected in the computation only)".
  std::vector<std::string> notes;
};

/// The shell faces of a prepared mesh as polygons of vertex indices. Each polygon has the
/// orientation of the triangles made from the face. The polygons of second-order faces include the
/// midside nodes. O(triangles).
std::vector<std::vector<int>> polygons_of(const PreparedMesh& prepared);

/// Counts the defects of a shell mesh without repairing them. Throws InputError only if a node
/// index is out of range or a face has more than 10,000 corners. O(faces · log faces), plus O(n²)
/// for a face with n corners.
MeshDiagnosis diagnose(const ShellMesh& shells);

/// Converts shell elements to a clean, oriented triangle mesh. The repairs affect the triangle mesh
/// only, not `shells`. Collapsed and duplicate faces are omitted, unused nodes are ignored, and
/// faces are reoriented to match the lowest-numbered face of their patch. Throws InputError if
/// there are no faces, a coordinate is not finite, or a triangle has zero area; the message states
/// the first location. `node_name`: converts a 0-based node index to the name used in messages;
/// empty: the index itself.
PreparedMesh prepare(const ShellMesh& shells,
                     const std::function<std::string(int)>& node_name = {});

}  // namespace batten
