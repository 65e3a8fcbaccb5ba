// From shell elements to a triangle mesh that mathematics can stand on.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// What a mesh is like, by counting. Lists hold at most the first 8 of their kind.
struct MeshDiagnosis {
  int components = 0;        ///< parts of the mesh that have no node in common
  int manifold_patches = 0;  ///< parts that edges of two faces, or two of more that go on, connect
  int unused_nodes = 0;      ///< nodes of no face
  int collapsed_faces = 0;   ///< faces with fewer than three different corners
  int duplicate_faces = 0;   ///< faces with the same nodes as an earlier one
  int flipped_faces = 0;     ///< faces that have to be turned to run as their component does
  int coincident_nodes = 0;  ///< used nodes at exactly the place of an earlier one
  int zero_area_triangles = 0;  ///< triangles with a height below 1e-12 of the longest edge
  bool orientable = true;
  std::vector<std::array<int, 2>> non_manifold_edges;  ///< edges of three faces or more
  int non_manifold_edge_count = 0;
  /// Nodes where sheets meet that share no edge of theirs there.
  std::vector<int> non_manifold_nodes;
  int non_manifold_node_count = 0;
  std::vector<int> non_finite_nodes;  ///< nodes with a coordinate that is not finite
};

/// The mathematics' view of shell elements: every face as triangles (quads along their shorter
/// diagonal, ties along 13; second-order elements along their middle nodes; polygons so that their
/// worst triangle is best), the same vertex numbers. The elements themselves stay as they are, so
/// a file can be written back as it was.
///
/// Where three faces or more share an edge, two of them are one sheet that goes on when they bend by
/// less than 45° from one to the other and less than all other two by 0.05 in the cosine; all others
/// end there. A skin goes on past its ribs; three walls that meet at 120° all end. Sheets with one
/// side only are cut open.
struct PreparedMesh {
  TriangleMesh mesh;
  std::vector<int> face_of_triangle;
  MeshDiagnosis diagnosis;
  /// What was done or noticed, in sentences: "12 faces turned to run the same way as their
  /// neighbours".
  std::vector<std::string> notes;
};

/// The faces as polygons of the mesh's vertices, wound as their triangles; of second-order faces the
/// outline with the middle nodes. O(triangles).
std::vector<std::vector<int>> polygons_of(const PreparedMesh& prepared);

/// Throws InputError only for indices out of range and faces of more than 10,000 corners. O(faces ·
/// log faces), for a face of n corners O(n²).
MeshDiagnosis diagnose(const ShellMesh& shells);

/// Safe repairs, for the mathematics only: collapsed and duplicate faces are left out, faces turned
/// to agree with their neighbours (the lowest face of each sheet leads), unused nodes ignored.
/// Throws InputError with the reason and the first places (nodes by their numbers from 0, or as
/// `node_name` calls them): no faces, a coordinate that is not finite, triangles of no area.
PreparedMesh prepare(const ShellMesh& shells,
                     const std::function<std::string(int)>& node_name = {});

}  // namespace batten
