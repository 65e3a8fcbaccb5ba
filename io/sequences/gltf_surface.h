// The triangles of a glTF scene, and where they are at one moment. Internal.
#pragma once

#include "batten/io/sequences/gltf_animation.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// All triangles of the nodes that are shown, one part for each mesh and node, side by side.
class GltfSurface {
 public:
  /// Keeps references. Throws InputError: no triangles, other counts of data than of vertices, an
  /// index or joint that is not there, geometry that only an extension can read.
  GltfSurface(const GltfDocument& document, const GltfNodes& nodes);

  int vertex_count() const { return vertex_count_; }
  /// Three vertices each.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  /// The vertices with the nodes at one moment: morph targets, then skins (of which the node's own
  /// place is no part, as glTF has it), or the node's place.
  Points at(const std::vector<GltfNode>& moment) const;

 private:
  struct Part {
    int node = 0, skin = -1, first = 0;
    Points base;
    std::vector<long> targets;  // accessors
    VecX weights;               // of targets, where the node has none
    MatX joints, joint_weights;
  };
  struct Skin {
    std::vector<int> joints;
    std::vector<Mat4> inverse;
  };
  void add(int node);
  void add_primitive(const GltfDocument::Json& primitive, Part part, const std::string& what);
  void read_joints(const GltfDocument::Json& attributes, Part& part, const std::string& what) const;
  std::vector<std::array<int, 3>> triangles_of(const GltfDocument::Json& primitive, int vertices,
                                               const std::string& what) const;
  const Skin& skin(int index);

  const GltfDocument& document_;
  const GltfNodes& nodes_;
  std::vector<Part> parts_;
  std::vector<Skin> skins_;
  std::vector<std::array<int, 3>> triangles_;
  int vertex_count_ = 0;
};

}  // namespace batten
