// What hangs on the shells of a deck while they are edited.
#pragma once

#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/io/report/deform_report.h"
#include "batten/mesh/attached/attachment.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// The elements of a deck that are no shells: which of them keep their shape while the shells
/// deform, and where the nodes go that no shell has.
class AttachedNodes {
 public:
  AttachedNodes(const MeshFile& file, const TriangleMesh& mesh, const AttachmentOptions& options);

  /// Rigid elements, bushes and bolts, as features of the deformation.
  const std::vector<FormFeature>& connections() const { return connections_; }
  /// A region of interest with the nodes of connections that begin in it, or in a handle.
  void extend_region(std::vector<int>& region, const std::vector<Handle>& handles) const;
  /// Moves the other nodes: `before` and `after` are places of all vertices. `features`: what moved
  /// rigidly.
  void propagate_to_attached(const Points& before, Points& after,
                             const std::vector<FormFeature>& features) const;
  /// What became of all that, between the first and the last shape.
  void measure_into(DeformReport& report, const Points& before, const Points& after) const;

 private:
  /// Rotations of the nodes that open nodes hang on.
  std::vector<Mat3> rotations(const Points& before, const Points& after,
                              const std::vector<FormFeature>& features) const;

  const MeshFile& file_;
  const TriangleMesh& mesh_;
  AttachmentOptions options_;
  std::vector<char> has_face_;  // of the file's nodes
  std::vector<FormFeature> connections_;
  std::vector<int> free_nodes_;  // nodes that elements have and neither shells nor connections
};

}  // namespace batten
