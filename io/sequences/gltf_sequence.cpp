// SPDX-License-Identifier: MPL-2.0
// Reads an animated glTF scene as a sequence of meshes.

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/sequences/gltf_animation.h"
#include "batten/io/sequences/sequence_files.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

// The triangles of a glTF scene, and their vertex positions at one time.

/// All triangles of the shown nodes, with one part per mesh primitive and node.
class GltfSurface {
 public:
  /// Keeps references to the arguments. Throws InputError if there are no triangles, data counts
  /// differ from the vertex count, an index or joint does not exist, or geometry requires an
  /// unsupported extension.
  GltfSurface(const GltfDocument& document, const GltfNodes& nodes);

  /// Number of vertices of all parts.
  int vertex_count() const { return vertex_count_; }
  /// Vertex indices of the triangles.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  /// Vertex positions for node states at one time: morph targets, then the skin or the node's
  /// transform. As specified by glTF, a skin ignores the transform of its own node.
  Points at(const std::vector<GltfNode>& moment) const;

 private:
  struct Part {
    int node = 0, skin = -1, first = 0;
    Points base;
    std::vector<long> targets;  // accessors
    VecX weights;               // of the targets, if the node has none
    MatX joints, joint_weights;
  };
  struct Skin {
    std::vector<int> joints;
    std::vector<Mat4> inverse;
  };
  void add(int node);
  void add_primitive(const GltfDocument::Json& primitive, Part part, const std::string& what);
  void count_elements(int mesh);
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
  double elements_ = 0;  // of the accessors, again for each use
};

namespace {

using GltfJson = GltfDocument::Json;

// Primitive modes of glTF.
constexpr long kTriangles = 4, kStrip = 5, kFan = 6;

const GltfJson& member(const GltfJson& object, const char* key) {
  static const GltfJson none = GltfJson::object();
  const auto found = object.find(key);
  return found != object.end() && found->is_object() ? *found : none;
}

Points points_of(const GltfDocument& document, long accessor, Eigen::Index count,
                 const std::string& what) {
  Points points = document.accessor(accessor, 3);
  if (count >= 0 && points.rows() != count)
    document.fail("found " + std::to_string(points.rows()) + " elements of accessor " +
                  std::to_string(accessor) + " in " + what + ", expected " + std::to_string(count) +
                  " as its vertices");
  if (!points.allFinite())
    document.fail("found a coordinate that is not finite in accessor " + std::to_string(accessor) +
                  " of " + what);
  return points;
}

}  // namespace

GltfSurface::GltfSurface(const GltfDocument& document, const GltfNodes& nodes)
    : document_(document), nodes_(nodes) {
  skins_.resize(static_cast<size_t>(document.count("skins")));
  const std::vector<int> shown = nodes.shown(document);
  for (const int node : shown)
    if (nodes.nodes[node].mesh >= 0) count_elements(nodes.nodes[node].mesh);
  for (const int node : shown)
    if (nodes.nodes[node].mesh >= 0) add(node);
  if (triangles_.empty()) document.fail("found no triangles in the scene, expected at least one");
}

const GltfSurface::Skin& GltfSurface::skin(int index) {
  const GltfJson& json = document_.item("skins", index);
  Skin& skin = skins_[static_cast<size_t>(index)];
  if (!skin.joints.empty()) return skin;
  const std::string what = "skin " + std::to_string(index);
  skin.joints = document_.indices(json, "joints");
  if (skin.joints.empty()) document_.fail("found no joints in " + what);
  for (const int joint : skin.joints) document_.item("nodes", joint);
  skin.inverse.assign(skin.joints.size(), Mat4::Identity());
  if (!json.contains("inverseBindMatrices")) return skin;
  const MatX matrices =
      document_.accessor(document_.integer(json, "inverseBindMatrices", what), 16);
  if (matrices.rows() < isize(skin.joints))
    document_.fail("found " + std::to_string(matrices.rows()) + " matrices in " + what +
                   ", expected " + std::to_string(skin.joints.size()) + " as it has joints");
  for (int j = 0; j < isize(skin.joints); ++j)
    skin.inverse[j] = matrices.row(j).transpose().reshaped(4, 4);
  return skin;
}

void GltfSurface::add(int node) {
  const int index = nodes_.nodes[node].mesh;
  const GltfJson& mesh = document_.item("meshes", index);
  if (!mesh.contains("primitives") || !mesh["primitives"].is_array())
    document_.fail("found no primitives in mesh " + std::to_string(index));
  Part part;
  part.node = node;
  part.skin = nodes_.nodes[node].skin;
  if (part.skin >= 0) skin(part.skin);
  if (mesh.contains("weights") && mesh["weights"].is_array())
    part.weights = document_.numbers(mesh, "weights", VecX::Zero(isize(mesh["weights"])));
  int number = 0;
  for (const GltfJson& primitive : mesh["primitives"])
    add_primitive(primitive, part,
                  "primitive " + std::to_string(number++) + " of mesh " + std::to_string(index));
}

void GltfSurface::add_primitive(const GltfJson& primitive, Part part, const std::string& what) {
  if (!primitive.is_object()) document_.fail("found another kind of value as " + what);
  const long mode = document_.integer(primitive, "mode", kTriangles);
  if (mode < kTriangles || mode > kFan) return;  // points and lines
  const GltfJson& attributes = member(primitive, "attributes");
  const long position = document_.index(attributes, "POSITION");
  const GltfJson& extensions = member(primitive, "extensions");
  for (const auto& [name, data] : extensions.items())
    if (name == "KHR_draco_mesh_compression" &&
        (position < 0 || !document_.item("accessors", position).contains("bufferView")))
      document_.fail(what + " is compressed with " + name +
                     ", which is not supported: export it without");
  if (position < 0) document_.fail("found no POSITION in " + what);
  part.base = points_of(document_, position, -1, what);
  if (primitive.contains("targets"))
    for (const GltfJson& target : primitive["targets"]) {
      const long accessor = document_.index(target, "POSITION");
      // Read once to validate it.
      if (accessor >= 0) points_of(document_, accessor, part.base.rows(), what);
      part.targets.push_back(accessor);
    }
  if (part.skin >= 0) read_joints(attributes, part, what);
  part.first = vertex_count_;
  const auto vertices = static_cast<int>(part.base.rows());
  for (const auto& [a, b, c] : triangles_of(primitive, vertices, what))
    triangles_.push_back({part.first + a, part.first + b, part.first + c});
  if (vertex_count_ > 1000000000 - vertices) document_.fail("found too many vertices");
  vertex_count_ += vertices;
  parts_.push_back(std::move(part));
}

/// Limits what many uses of the same data add up to.
void GltfSurface::count_elements(int mesh) {
  constexpr double most_repeated = 1 << 22;
  const auto count = [&](const GltfJson& object, const std::string& key) {
    if (const long accessor = document_.index(object, key.c_str()); accessor >= 0)
      elements_ += static_cast<double>(document_.element_count(accessor));
  };
  static const GltfJson none = GltfJson::array();
  const auto list = [](const GltfJson& object, const char* key) -> const GltfJson& {
    const auto found = object.find(key);
    return found != object.end() && found->is_array() ? *found : none;
  };
  for (const GltfJson& primitive : list(document_.item("meshes", mesh), "primitives")) {
    if (!primitive.is_object()) continue;  // reported when it is read
    elements_ += 1 + static_cast<double>(list(primitive, "targets").size());
    const GltfJson& attributes = member(primitive, "attributes");
    for (const auto& [name, data] : attributes.items())
      if (name == "POSITION" || name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_"))
        count(attributes, name);
    count(primitive, "indices");
    for (const GltfJson& target : list(primitive, "targets"))
      if (target.is_object()) count(target, "POSITION");
  }
  if (elements_ > most_repeated + static_cast<double>(document_.buffer_bytes()))
    document_.fail("found " + format_number(elements_) + " vertices and indices up to mesh " +
                   std::to_string(mesh) + ", counted for each node that uses them, expected " +
                   format_number(most_repeated) + " at most, or one per byte of the buffers");
}

void GltfSurface::read_joints(const GltfJson& attributes, Part& part,
                              const std::string& what) const {
  for (int set = 0;; ++set) {
    const std::string j = "JOINTS_" + std::to_string(set), w = "WEIGHTS_" + std::to_string(set);
    if (!attributes.contains(j) || !attributes.contains(w)) break;
    const MatX joints = document_.accessor(document_.integer(attributes, j.c_str(), what), 4),
               weights = document_.accessor(document_.integer(attributes, w.c_str(), what), 4);
    if (joints.rows() != part.base.rows() || weights.rows() != part.base.rows())
      document_.fail("found " + std::to_string(joints.rows()) + " joints and " +
                     std::to_string(weights.rows()) + " weights in " + what + ", expected " +
                     std::to_string(part.base.rows()) + " as its vertices");
    part.joints.conservativeResize(part.base.rows(), 4 * set + 4);
    part.joint_weights.conservativeResize(part.base.rows(), 4 * set + 4);
    part.joints.rightCols(4) = joints;
    part.joint_weights.rightCols(4) = weights;
  }
  if (part.joints.cols() == 0) {
    part.skin = -1;
    return;
  }
  const auto count = static_cast<double>(skins_[static_cast<size_t>(part.skin)].joints.size());
  for (Eigen::Index i = 0; i < part.joints.rows(); ++i) {
    // Some programs omit the weights of vertices that are bound to the first joint only.
    const double sum = part.joint_weights.row(i).sum();
    if (!std::isfinite(sum)) document_.fail("found a weight that is not finite in " + what);
    if (sum > 0)
      part.joint_weights.row(i) /= sum;
    else
      part.joint_weights(i, 0) = 1;
    for (Eigen::Index k = 0; k < part.joints.cols(); ++k)
      if (part.joint_weights(i, k) != 0 && !(part.joints(i, k) >= 0 && part.joints(i, k) < count))
        document_.fail("found the joint " + std::to_string(static_cast<long>(part.joints(i, k))) +
                       " of vertex " + std::to_string(i) + " in " + what + ", expected 0 to " +
                       std::to_string(static_cast<long>(count) - 1));
  }
}

std::vector<std::array<int, 3>> GltfSurface::triangles_of(const GltfJson& primitive, int vertices,
                                                          const std::string& what) const {
  std::vector<int> corners;
  if (primitive.contains("indices")) {
    const long accessor = document_.integer(primitive, "indices", what);
    const MatX indices = document_.accessor(accessor, 1);
    for (Eigen::Index i = 0; i < indices.rows(); ++i) {
      if (!(indices(i, 0) >= 0 && indices(i, 0) < vertices))
        document_.fail("found the vertex " + std::to_string(static_cast<long>(indices(i, 0))) +
                       " in accessor " + std::to_string(accessor) + " of " + what +
                       ", expected 0 to " + std::to_string(vertices - 1));
      corners.push_back(static_cast<int>(indices(i, 0)));
    }
  } else {
    for (int i = 0; i < vertices; ++i) corners.push_back(i);
  }
  const long mode = document_.integer(primitive, "mode", kTriangles);
  std::vector<std::array<int, 3>> triangles;
  for (size_t i = 2; i < corners.size(); i += mode == kTriangles ? 3 : 1) {
    if (mode == kFan)
      triangles.push_back({corners[0], corners[i - 1], corners[i]});
    else if (mode == kStrip && i % 2 == 1)
      triangles.push_back({corners[i - 1], corners[i - 2], corners[i]});
    else
      triangles.push_back({corners[i - 2], corners[i - 1], corners[i]});
  }
  return triangles;
}

Points GltfSurface::at(const std::vector<GltfNode>& moment) const {
  const std::vector<Mat4> world_transforms = nodes_.world_transforms(moment);
  Points result(vertex_count_, 3);
  for (const Part& part : parts_) {
    Points points = part.base;
    const VecX& weights =
        moment[part.node].weights.size() > 0 ? moment[part.node].weights : part.weights;
    for (Eigen::Index t = 0; t < std::min<Eigen::Index>(weights.size(), isize(part.targets)); ++t)
      if (const long accessor = part.targets[t]; weights[t] != 0 && accessor >= 0)
        points += weights[t] * document_.accessor(accessor, 3);
    auto rows = result.middleRows(part.first, points.rows());
    if (part.skin < 0) {
      const Mat4& m = world_transforms[part.node];
      rows = (points * m.topLeftCorner<3, 3>().transpose()).rowwise() +
             m.topRightCorner<3, 1>().transpose();
      continue;
    }
    const Skin& skin = skins_[static_cast<size_t>(part.skin)];
    std::vector<Mat4> joints;
    for (size_t j = 0; j < skin.joints.size(); ++j)
      joints.push_back(world_transforms[skin.joints[j]] * skin.inverse[j]);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      Mat4 sum = Mat4::Zero();
      for (Eigen::Index k = 0; k < part.joints.cols(); ++k)
        if (part.joint_weights(i, k) != 0)
          sum += part.joint_weights(i, k) * joints[static_cast<size_t>(part.joints(i, k))];
      const Vec3 p = points.row(i).transpose();
      rows.row(i) = (sum.topLeftCorner<3, 3>() * p + sum.topRightCorner<3, 1>()).transpose();
    }
  }
  return result;
}

namespace {

constexpr double kMostFrames = 1e6;

/// Classes of vertices that coincide in all frames seen so far.
class Seams {
 public:
  explicit Seams(const Points& first) {
    const double size = (first.colwise().maxCoeff() - first.colwise().minCoeff()).norm();
    within_ = kWeldTolerance * size;
    leader_.resize(static_cast<size_t>(first.rows()));
    std::unordered_multimap<std::size_t, int> cells;
    for (int v = 0; v < first.rows(); ++v) {
      leader_[v] = v;
      const Vec3 p = first.row(v).transpose();
      // Any neighbour within reach lies in one of the eight cells at the nearest cell corner.
      for (int corner = 0; corner < 8 && leader_[v] == v; ++corner) {
        const auto [begin, end] = cells.equal_range(
            key(p + within_ * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
        for (auto at = begin; at != end; ++at)
          if ((first.row(at->second) - first.row(v)).norm() <= within_) {
            leader_[v] = at->second;
            break;
          }
      }
      if (leader_[v] == v) cells.emplace(key(p), v);
    }
  }

  /// Splits classes whose vertices lie apart in this frame.
  void see(const Points& frame) {
    std::unordered_map<int, std::vector<int>> parted;  // new leaders by old leader
    for (int v = 0; v < frame.rows(); ++v) {
      const int leader = leader_[v];
      const auto near = [&](int other) {
        return (frame.row(v) - frame.row(other)).norm() <= within_;
      };
      if (leader == v || near(leader)) continue;
      std::vector<int>& others = parted[leader];
      const auto found = std::find_if(others.begin(), others.end(), near);
      leader_[v] = found == others.end() ? v : *found;
      if (found == others.end()) others.push_back(v);
    }
  }

  const std::vector<int>& leader() const { return leader_; }

 private:
  /// Hash of a cell four times as wide as the merge distance.
  std::size_t key(const Vec3& p) const {
    std::size_t hash = 0;
    for (int c = 0; c < 3; ++c) {
      const double cell = within_ > 0 ? std::floor(p[c] / (4 * within_)) : p[c];
      hash = hash * 0x9E3779B97F4A7C15u + std::hash<double>()(cell + 0.0);
      hash ^= hash >> 31;
    }
    return hash;
  }

  double within_ = 0;
  std::vector<int> leader_;
};

std::vector<double> sample_times(const std::vector<double>& keys, double rate,
                                 const GltfDocument& document) {
  if (rate == 0) return keys;
  if (!(rate > 0) || !std::isfinite(rate))
    document.fail("found " + format_number(rate) + " frames per second, expected a rate above 0");
  // Times are stored in single precision: tolerate its rounding, so that the last frame is not
  // lost.
  const double begin = keys.front(), end = keys.back(),
               count = std::floor((end - begin) * rate * (1 + 1e-6) + 1e-4) + 1;
  if (!(count <= kMostFrames))
    document.fail("found an animation of " + format_number(end - begin) + " s, which has " +
                  format_number(count) + " frames, expected " + format_number(kMostFrames) +
                  " at most");
  std::vector<double> times;
  for (int k = 0; k < static_cast<int>(count); ++k) times.push_back(begin + k / rate);
  return times;
}

}  // namespace

MeshSequence read_gltf_sequence(const std::filesystem::path& path, const SequenceOptions& options,
                                const Progress& progress) {
  progress.update("reading the scene", 0);
  const GltfDocument document(path);
  const GltfNodes nodes(document);
  const GltfSurface surface(document, nodes);
  const GltfAnimation animation(document, options.animation);
  const std::vector<double> times =
      sample_times(animation.keys(), options.frames_per_second, document);
  const FrameRange range = frame_range(options, isize(times), path.string());
  const auto frame = [&](int k) {
    std::vector<GltfNode> moment = nodes.nodes;
    animation.apply(times[static_cast<size_t>(k)], moment);
    Points points = surface.at(moment);
    if (!points.allFinite())
      document.fail("frame " + std::to_string(k + 1) + " has coordinates that are not finite");
    return points;
  };

  // Nodes of the sequence, in the order of their first vertex in the file.
  std::vector<int> vertices, node_of(static_cast<size_t>(surface.vertex_count()));
  if (options.weld_seams) {
    Seams seams(frame(0));
    for (int k = 1; k < isize(times); ++k) {
      progress.update("finding seams", static_cast<double>(k) / isize(times));
      seams.see(frame(k));
    }
    for (int v = 0; v < surface.vertex_count(); ++v) {
      const int leader = seams.leader()[v];
      if (leader == v) vertices.push_back(v);
      node_of[v] = leader == v ? isize(vertices) - 1 : node_of[leader];
    }
  } else {
    for (int v = 0; v < surface.vertex_count(); ++v) {
      vertices.push_back(v);
      node_of[v] = v;
    }
  }

  require_frame_memory(path, range.count, isize(vertices));
  MeshSequence sequence;
  sequence.shells.points.resize(isize(vertices), 3);
  for (const auto& [a, b, c] : surface.triangles())
    sequence.shells.add_face(std::array<int, 3>{node_of[a], node_of[b], node_of[c]});
  for (int k = range.first; k < range.first + range.count; ++k) {
    progress.update("reading frames", static_cast<double>(k - range.first) / range.count);
    sequence.frames.push_back(frame(k)(vertices, Eigen::all));
    sequence.times.push_back(times[static_cast<size_t>(k)]);
  }
  return sequence;
}

}  // namespace batten
