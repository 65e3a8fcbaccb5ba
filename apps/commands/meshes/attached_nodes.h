// Non-shell elements of a deck that follow the shells during an edit.
#pragma once

#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/io/report/deform_report.h"
#include "batten/mesh/attached/attachment.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// The non-shell elements of a deck: determines which of them stay rigid while the shells deform,
/// and moves the nodes that belong to no shell.
class AttachedNodes {
 public:
  AttachedNodes(const MeshFile& file, const TriangleMesh& mesh, const AttachmentOptions& options);

  /// Rigid elements, bushes and bolts, as rigid features of the deformation.
  const std::vector<FormFeature>& connections() const { return connections_; }
  /// Extends a region of interest by the nodes of connections that start in it or in a handle.
  void extend_region(std::vector<int>& region, const std::vector<Handle>& handles) const;
  /// Moves the remaining nodes. `before` and `after`: positions of all vertices. `features`: parts
  /// that moved rigidly.
  void propagate_to_attached(const Points& before, Points& after,
                             const std::vector<FormFeature>& features) const;
  /// Reports how the attached elements moved between the first and the last shape.
  void measure_into(DeformReport& report, const Points& before, const Points& after) const;

 private:
  /// Rotations of the nodes to which open nodes are attached.
  std::vector<Mat3> rotations(const Points& before, const Points& after,
                              const std::vector<FormFeature>& features) const;

  const MeshFile& file_;
  const TriangleMesh& mesh_;
  AttachmentOptions options_;
  std::vector<char> has_face_;  // per node of the file
  std::vector<FormFeature> connections_;
  std::vector<int> free_nodes_;  // nodes of elements that belong neither to shells nor to
                                 // connections
};

}  // namespace batten
