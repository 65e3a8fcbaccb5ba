// SPDX-License-Identifier: MPL-2.0
// Nodes of non-shell elements, which follow the shells during an edit.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "batten/mesh/attached/attachment.h"
#include "batten/mesh/attached/surface_ties.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Measures of the motion of attached elements between two shapes. Lengths are in model units.
struct AttachedMotion {
  int connections = 0;  ///< number of connections; see AttachedNodes::connections()
  /// Largest distance of a node of a connection from its position under the best-fitting rigid-body
  /// motion of the connection.
  double max_rigid_error = 0;
  std::string worst_connection;  ///< connection with `max_rigid_error`; empty: all errors are 0
  int moved_nodes = 0;           ///< number of moved nodes that belong to no shell or connection
  std::vector<int> inverted_solids;  ///< indices of solid elements that the motion inverted
  int tied_nodes = 0;                ///< number of nodes that are tied to surfaces
  double max_gap_change = 0;         ///< largest change of the distance of a tied node
  std::string worst_tie;             ///< tie with `max_gap_change`
};

/// The nodes of non-shell elements of a mesh. The class determines which elements stay rigid while
/// the shells deform, and moves the nodes that belong to no shell.
class AttachedNodes {
 public:
  /// Finds the connections of a mesh. Keeps references to `elements` and `mesh`. The node numbers
  /// of the elements and ties must be the vertex numbers of the mesh, as in the result of prepare().
  /// `face_of_triangle`: see PreparedMesh; required if there are ties. O(elements).
  AttachedNodes(std::span<const NonShellElement> elements, const TriangleMesh& mesh,
                const AttachmentOptions& options = {}, std::span<const SurfaceTie> ties = {},
                std::span<const int> face_of_triangle = {});

  /// The connections (rigid elements, bushes and bolts) as form features of the deformation; see
  /// the free function connections().
  const std::vector<FormFeature>& connections() const { return connections_; }
  /// Sentences about tied nodes that are too far from their surfaces.
  const std::vector<std::string>& notes() const { return ties_.notes(); }
  /// Appends the connections (rigid elements, bushes, bolts and spot welds) to the features of a
  /// problem, and the constraints of ties to its linear constraints. If the problem has a region of
  /// interest, the nodes of connections and ties that have a node in the region or in a handle are
  /// added to it. `points`: positions of all vertices before the edit (n×3).
  void add_to(DeformProblem& problem, const Points& points) const;
  /// The same for the undeformed mesh.
  void add_to(DeformProblem& problem) const { add_to(problem, mesh_.points()); }
  /// Moves tied nodes to their exact distances from their surfaces, and the nodes that belong
  /// neither to shells nor to connections by propagate_to_attached(). `before`: positions of all
  /// vertices before the deformation (n×3). `after`: deformed positions, in which these nodes are
  /// updated. `problem`: the problem to which add_to() has added. Nodes of its features, handles,
  /// fixed vertices and other constraints keep their positions. Throws NoSolutionError if a
  /// factorization fails.
  void propagate(const Points& before, Points& after, const DeformProblem& problem) const;
  /// Measures the motion of the attached elements between two shapes (n×3 each).
  AttachedMotion motion(const Points& before, const Points& after) const;

 private:
  void extend_region(std::vector<int>& region, const std::vector<Handle>& handles) const;
  /// Rotation of the ring of faces around a node.
  Mat3 ring_rotation(int node, const Points& before, const Points& after) const;
  /// Rotations of the nodes to which free nodes are attached.
  std::vector<Mat3> rotations(const Points& before, const Points& after,
                              const std::vector<FormFeature>& features) const;
  void place_tied_nodes(const Points& before, Points& after, const DeformProblem& problem,
                        std::vector<char>& placed, std::vector<Mat3>& rotations) const;

  std::span<const NonShellElement> elements_;
  const TriangleMesh& mesh_;
  AttachmentOptions options_;
  SurfaceTies ties_;
  std::vector<char> has_face_;  // per node
  std::vector<FormFeature> connections_;
  std::vector<int> free_nodes_;  // nodes of elements that belong neither to shells nor to
                                 // connections
};

}  // namespace batten
