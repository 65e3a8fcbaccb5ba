// SPDX-License-Identifier: MPL-2.0
// Meshes as given faces ([[neighbour]] with a mesh file): curves fitted to their boundary loops,
// with the tangent planes and curvatures of the mesh along them, and joined meshes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/features/mesh_boundary.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/skinning/facets/welded_mesh.h"
#include "batten/skinning/model/neighbour_faces.h"

namespace batten {

/// The faces of a mesh file that are given, and their boundary loops.
struct MeshNeighbour {
  ShellMesh shells;
  std::vector<MeshSet> sets;  ///< sets and properties of the file
  PreparedMesh prepared;
  std::vector<MeshBoundary> boundaries;  ///< in the order of NeighbourFaces::openings
};

/// Reads a mesh. `only`: names of the sets, properties or parts of the file whose faces are given;
/// empty: all faces. `without`: names of those that are left out. Throws InputError as
/// MeshFile::read() and prepare() do, for a name that does not exist, and if no face is left.
MeshNeighbour read_mesh_neighbour(const std::filesystem::path& file,
                                  const std::vector<std::string>& only,
                                  const std::vector<std::string>& without);

/// Fits curves to the boundary loops of a mesh, "edge1", "edge2" …, which end at corners of the
/// loops (find_corners(), 50 degrees). They pass the vertices within 1 % of the mean edge length or, if
/// the vertices are noisy, 1.5 times their median fourth difference, at most 10 %.
///
/// A loop that zigzags, as the rim of a hole in a scan, is smoothed first: if four rounds of a
/// low-pass filter reduce the sum of its turning angles by more than 720 degrees. It has no corners
/// then, and its curve lies in the surface that is fitted to the mesh beside it.
NeighbourFaces mesh_neighbour_faces(const MeshNeighbour& mesh);

/// A mesh of given faces and new faces.
struct JoinedMesh {
  ShellMesh mesh;              ///< the given faces, unchanged and first, then the new triangles
  std::vector<MeshSet> sets;   ///< those of the given meshes, and the triangles of each new face
  int new_loops = 0;           ///< number of boundary loops of the new faces
  int joined_loops = 0;        ///< of them, those that were joined to a given mesh
  int open_edges = 0;          ///< edges on boundary loops of the given faces that were not joined
  int free_edges = 0;          ///< edges of one face in the result
  int non_manifold_edges = 0;  ///< edges of more than two faces, at least one of which is new
};

/// Joins new faces to given meshes, without a gap, where a boundary loop of the new faces lies on a
/// boundary loop of a given mesh, within `tolerance` plus three times its longest edge. All new
/// triangles have the orientation of the given mesh.
///
/// - Each vertex of the new faces on the loop moves to the next vertex of the given mesh. Triangles
///   that collapse are removed, and triangles beside several given vertices are split.
/// - If the given loop zigzags, its distance from the new faces exceeding 10 % of its edge length, its
///   narrow notches are filled with triangles of its own vertices. New triangles within 0.7 edge lengths
///   of it or beyond it are replaced by a strip of triangles between both meshes, the one with the
///   shortest edges that is not folded (Fuchs, Kedem, Uselton 1977).
///
/// `names`: names of the new faces, one for each index in WeldedMesh::region. O(product of the numbers
/// of vertices of the two loops).
JoinedMesh join_meshes(const std::vector<MeshNeighbour>& given, const WeldedMesh& added,
                       const std::vector<std::string>& names, double tolerance);

}  // namespace batten
