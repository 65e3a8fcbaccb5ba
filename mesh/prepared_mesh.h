// Converts shell elements to a clean, oriented triangle mesh, and reports defects of the input.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Counts of features and defects of a shell mesh. Lists hold at most the first 8 entries.
struct MeshDiagnosis {
  int components = 0;  ///< connected components: parts that share no node
  /// Parts connected by manifold edges, or across non-manifold edges by the rule of PreparedMesh.
  int manifold_patches = 0;
  int unused_nodes = 0;         ///< nodes that belong to no face
  int collapsed_faces = 0;      ///< faces with fewer than three distinct corners
  int duplicate_faces = 0;      ///< faces with the same nodes as an earlier face
  int flipped_faces = 0;        ///< faces whose orientation must be reversed to match their patch
  int coincident_nodes = 0;     ///< used nodes at exactly the position of another used node
  int zero_area_triangles = 0;  ///< triangles with a height below 1e-12 of the longest edge
  /// False if a patch is non-orientable, such as a Möbius strip.
  bool orientable = true;
  std::vector<std::array<int, 2>> non_manifold_edges;  ///< edges with three or more faces
  int non_manifold_edge_count = 0;
  /// Nodes at which patches touch without sharing an edge there.
  std::vector<int> non_manifold_nodes;
  int non_manifold_node_count = 0;
  std::vector<int> non_finite_nodes;  ///< nodes with a coordinate that is not finite
};

/// Triangle mesh derived from shell elements, used for all computations. Vertex numbers are the
/// node numbers. The shell elements themselves are unchanged, so a file can be written back as it
/// was.
///
/// Every face is split into triangles: quads along their shorter diagonal (ties: 1-3), second-order
/// elements through their midside nodes, polygons by clipping the ear of best quality.
///
/// Non-manifold edges (three or more faces) are resolved as follows. Two faces continue the same
/// patch if the bend between them is less than 45° and is smaller, by 0.05 in the cosine, than that
/// of either with any other face. All other patches end at the edge. So a skin continues past its
/// ribs, while three walls that meet at 120° all end. Non-orientable patches are cut open.
struct PreparedMesh {
  TriangleMesh mesh;
  /// The face that each triangle comes from.
  std::vector<int> face_of_triangle;
  MeshDiagnosis diagnosis;
  /// Repairs and observations in plain sentences, such as "12 faces turned to run as the neighbours
  /// do (in the computation only)".
  std::vector<std::string> notes;
};

/// The faces as polygons of mesh vertices, oriented like their triangles. For second-order faces
/// the polygon includes the midside nodes. O(triangles).
std::vector<std::vector<int>> polygons_of(const PreparedMesh& prepared);

/// Counts defects without repairing anything. Throws InputError only for indices out of range and
/// faces with more than 10,000 corners. O(faces · log faces), plus O(n²) for a face of n corners.
MeshDiagnosis diagnose(const ShellMesh& shells);

/// Converts shell elements to a triangle mesh with safe repairs, which affect the computation only.
/// Collapsed and duplicate faces are omitted, unused nodes ignored, and faces reoriented to match
/// their neighbours (the lowest face of each patch decides). Throws InputError with the reason and
/// the first location: no faces, a coordinate that is not finite, triangles without area. Messages
/// name nodes by their 0-based index or by `node_name`, if given.
PreparedMesh prepare(const ShellMesh& shells,
                     const std::function<std::string(int)>& node_name = {});

}  // namespace batten
