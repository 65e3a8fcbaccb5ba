// Non-shell elements of a mesh that follow the shells during an edit.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "batten/mesh/attached/attachment.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// How the attached elements moved between two shapes. Lengths are in model units.
struct AttachedMotion {
  int connections = 0;               ///< connections(): rigid elements, bushes and bolts
  double max_rigid_error = 0;        ///< largest distance of their nodes from a rigid-body motion
  std::string worst_connection;      ///< the connection with that error; empty: all errors are 0
  int moved_nodes = 0;               ///< nodes outside shells and connections that moved
  std::vector<int> inverted_solids;  ///< indices of solid elements that the motion inverted
};

/// The non-shell elements of a mesh: determines which of them stay rigid while the shells deform,
/// and moves the nodes that belong to no shell.
class AttachedNodes {
 public:
  /// Keeps references to `elements` and `mesh`. Vertex numbers of the mesh are node numbers of the
  /// elements, as prepare() creates them. O(elements).
  AttachedNodes(std::span<const NonShellElement> elements, const TriangleMesh& mesh,
                const AttachmentOptions& options = {});

  /// Rigid elements, bushes and bolts, as rigid features of the deformation; see the free function
  /// connections().
  const std::vector<FormFeature>& connections() const { return connections_; }
  /// Adds the connections to a problem: appends them to its features, and extends its region of
  /// interest, if it has one, by the nodes of connections that start in the region or in a handle.
  void add_to(DeformProblem& problem) const;
  /// Moves the nodes that belong neither to shells nor to connections, by propagate_to_attached().
  /// `before`, `after`: positions of all vertices (n×3). `features`: parts that moved rigidly,
  /// connections included. Throws NoSolutionError.
  void propagate(const Points& before, Points& after,
                 const std::vector<FormFeature>& features) const;
  /// Measures how the attached elements moved between two shapes (n×3 each).
  AttachedMotion motion(const Points& before, const Points& after) const;

 private:
  void extend_region(std::vector<int>& region, const std::vector<Handle>& handles) const;
  /// Rotations of the nodes to which free nodes are attached.
  std::vector<Mat3> rotations(const Points& before, const Points& after,
                              const std::vector<FormFeature>& features) const;

  std::span<const NonShellElement> elements_;
  const TriangleMesh& mesh_;
  AttachmentOptions options_;
  std::vector<char> has_face_;  // per node
  std::vector<FormFeature> connections_;
  std::vector<int> free_nodes_;  // nodes of elements that belong neither to shells nor to
                                 // connections
};

}  // namespace batten
