// Nodes of a glTF scene and how an animation moves them. Internal.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "batten/io/sequences/gltf_document.h"

namespace batten {

using Mat4 = Eigen::Matrix4d;

/// A node as the file has it, or at one moment of an animation.
struct GltfNode {
  int parent = -1, mesh = -1, skin = -1;
  bool uses_matrix = false;
  Mat4 matrix = Mat4::Identity();
  Vec3 translation = Vec3::Zero(), scale = Vec3::Ones();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  VecX weights;  ///< of morph targets; empty: those of the mesh
};

/// All nodes. Throws InputError: a node with two parents, nodes that are their own ancestors.
struct GltfNodes {
  explicit GltfNodes(const GltfDocument& document);
  /// The nodes of the scene that is shown first, ascending; all, where the file has no scene.
  std::vector<int> shown(const GltfDocument& document) const;
  /// The place of each node, for nodes at one moment.
  std::vector<Mat4> world_transforms(const std::vector<GltfNode>& at) const;

  std::vector<GltfNode> nodes;
  std::vector<int> order;  ///< parents before children
};

/// An animation: channels that move properties of nodes between keys.
class GltfAnimation {
 public:
  /// `name`: a name or a number counted from 1; empty: the first. Throws InputError: no such
  /// animation, keys that are not ascending or finite, other numbers of values than of keys.
  GltfAnimation(const GltfDocument& document, const std::string& name);

  /// The times of all keys, ascending, each once; one time where nothing moves.
  const std::vector<double>& keys() const { return keys_; }
  /// Moves nodes to a time; before the first key and after the last one they stand still.
  void apply(double time, std::vector<GltfNode>& nodes) const;

 private:
  enum class Path { Translation, Rotation, Scale, Weights };
  enum class Interpolation { Linear, Step, Cubic };
  struct Channel {
    int node = 0;
    Path path = Path::Translation;
    Interpolation interpolation = Interpolation::Linear;
    std::vector<double> times;
    MatX values;  // a row for each key; cubic: three, in-tangent, value, out-tangent
  };
  void add_channel(const GltfDocument& document, const GltfDocument::Json& animation,
                   const GltfDocument::Json& channel, const std::string& what);
  static VecX value_at(const Channel& channel, double time);

  std::vector<Channel> channels_;
  std::vector<double> keys_;
};

}  // namespace batten
