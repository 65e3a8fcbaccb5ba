// SPDX-License-Identifier: MPL-2.0
// Node hierarchy of a glTF scene, and its animation by keys.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "batten/io/sequences/gltf_document.h"

namespace batten {

using Mat4 = Eigen::Matrix4d;

/// A node as stored in the file, or at one time of an animation.
struct GltfNode {
  int parent = -1, mesh = -1, skin = -1;
  /// True: `matrix` is the transform; false: translation, rotation and scale are.
  bool uses_matrix = false;
  Mat4 matrix = Mat4::Identity();
  Vec3 translation = Vec3::Zero(), scale = Vec3::Ones();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  VecX weights;  ///< weights of morph targets; empty: those of the mesh
};

/// All nodes of a file. Throws InputError if a node has two parents or is its own ancestor.
struct GltfNodes {
  explicit GltfNodes(const GltfDocument& document);
  /// Ascending indices of the nodes of the default scene; all nodes if the file has no scene.
  std::vector<int> shown(const GltfDocument& document) const;
  /// World transform of each node, for node states at one time.
  std::vector<Mat4> world_transforms(const std::vector<GltfNode>& at) const;

  std::vector<GltfNode> nodes;
  std::vector<int> order;  ///< topological order: parents before children
};

/// An animation: channels that interpolate properties of nodes between keys.
class GltfAnimation {
 public:
  /// `name`: name of the animation, or its 1-based number; empty: the first one. Throws InputError
  /// for an unknown animation, keys that are not finite and ascending, or a number of values that
  /// does not match the keys.
  GltfAnimation(const GltfDocument& document, const std::string& name);

  /// The times of all keys in seconds, ascending and unique; a single time if nothing moves.
  const std::vector<double>& keys() const { return keys_; }
  /// Sets the animated properties of nodes at a time. Times are clamped to the first and last key.
  void apply(double time, std::vector<GltfNode>& nodes) const;

 private:
  enum class Path { Translation, Rotation, Scale, Weights };
  enum class Interpolation { Linear, Step, Cubic };
  struct Channel {
    int node = 0;
    Path path = Path::Translation;
    Interpolation interpolation = Interpolation::Linear;
    std::vector<double> times;
    MatX values;  // a row per key; cubic: three rows per key: in-tangent, value, out-tangent
  };
  void add_channel(const GltfDocument& document, const GltfDocument::Json& animation,
                   const GltfDocument::Json& channel, const std::string& what);
  static VecX value_at(const Channel& channel, double time);

  std::vector<Channel> channels_;
  std::vector<double> keys_;
};

}  // namespace batten
