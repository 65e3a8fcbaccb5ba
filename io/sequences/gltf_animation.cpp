// SPDX-License-Identifier: MPL-2.0
#include "batten/io/sequences/gltf_animation.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/fem/curves/cubic.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

Eigen::Quaterniond quaternion(const VecX& xyzw) {
  const Eigen::Quaterniond q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  return q.norm() > 0 ? q.normalized() : Eigen::Quaterniond::Identity();
}

Mat4 local(const GltfNode& node) {
  if (node.uses_matrix) return node.matrix;
  Mat4 m = Mat4::Identity();
  m.topLeftCorner<3, 3>() = node.rotation.toRotationMatrix() * node.scale.asDiagonal();
  m.topRightCorner<3, 1>() = node.translation;
  return m;
}

GltfNode read_node(const GltfDocument& document, int n) {
  const auto& json = document.item("nodes", n);
  GltfNode node;
  node.mesh = document.index(json, "mesh");
  node.skin = document.index(json, "skin");
  node.uses_matrix = json.contains("matrix");
  const VecX matrix = document.numbers(json, "matrix", node.matrix.reshaped());
  node.matrix = matrix.reshaped(4, 4);
  node.translation = document.numbers(json, "translation", node.translation);
  node.scale = document.numbers(json, "scale", node.scale);
  node.rotation = quaternion(document.numbers(json, "rotation", node.rotation.coeffs()));
  if (json.contains("weights") && json["weights"].is_array())
    node.weights = document.numbers(json, "weights", VecX::Zero(isize(json["weights"])));
  return node;
}

}  // namespace

GltfNodes::GltfNodes(const GltfDocument& document) {
  const int count = document.count("nodes");
  for (int n = 0; n < count; ++n) nodes.push_back(read_node(document, n));
  std::vector<std::vector<int>> children(static_cast<size_t>(count));
  for (int n = 0; n < count; ++n)
    for (const int child : document.indices(document.item("nodes", n), "children")) {
      document.item("nodes", child);
      if (nodes[child].parent >= 0)
        document.fail("node " + std::to_string(child) + " has two parents, " +
                      std::to_string(nodes[child].parent) + " and " + std::to_string(n));
      nodes[child].parent = n;
      children[n].push_back(child);
    }
  for (int n = 0; n < count; ++n)
    if (nodes[n].parent < 0) order.push_back(n);
  for (size_t i = 0; i < order.size(); ++i)
    order.insert(order.end(), children[order[i]].begin(), children[order[i]].end());
  if (isize(order) < count) document.fail("found a cycle of nodes, expected a tree");
}

std::vector<int> GltfNodes::shown(const GltfDocument& document) const {
  std::vector<char> in(nodes.size(), document.count("scenes") == 0);
  if (document.count("scenes") > 0) {
    const long scene = document.integer(document.root(), "scene", 0L);
    for (const int n : document.indices(document.item("scenes", scene), "nodes")) {
      document.item("nodes", n);
      in[n] = 1;
    }
  }
  for (const int n : order)
    if (nodes[n].parent >= 0 && in[nodes[n].parent]) in[n] = 1;
  std::vector<int> result;
  for (int n = 0; n < isize(nodes); ++n)
    if (in[n]) result.push_back(n);
  return result;
}

std::vector<Mat4> GltfNodes::world_transforms(const std::vector<GltfNode>& at) const {
  std::vector<Mat4> result(at.size());
  for (const int n : order)
    result[n] = at[n].parent < 0 ? local(at[n]) : Mat4(result[at[n].parent] * local(at[n]));
  return result;
}

GltfAnimation::GltfAnimation(const GltfDocument& document, const std::string& name) {
  const int count = document.count("animations");
  int chosen = name.empty() ? 0 : -1;
  std::vector<std::string> known;
  for (int a = 0; a < count; ++a) {
    known.push_back(document.text(document.item("animations", a), "name", ""));
    if (chosen < 0 && known.back() == name) chosen = a;
    known.back() = std::to_string(a + 1) + " " + known.back();
  }
  int number = 0;
  const auto parsed = std::from_chars(name.data(), name.data() + name.size(), number);
  if (chosen < 0 && parsed.ec == std::errc() && parsed.ptr == name.data() + name.size() &&
      number >= 1 && number <= count)
    chosen = number - 1;
  if (chosen < 0)
    document.fail(
        "found no animation " + quoted_excerpt(name) + ", expected " +
        (count == 0 ? "none, as the file has none" : "one of: " + comma_separated(known)));
  if (count > 0) {
    const auto& animation = document.item("animations", chosen);
    const std::string what = "animation " + std::to_string(chosen + 1);
    if (animation.contains("channels"))
      for (const auto& channel : animation["channels"])
        add_channel(document, animation, channel, what);
  }
  for (const Channel& channel : channels_)
    keys_.insert(keys_.end(), channel.times.begin(), channel.times.end());
  std::sort(keys_.begin(), keys_.end());
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  if (keys_.empty()) keys_ = {0};
}

void GltfAnimation::add_channel(const GltfDocument& document, const GltfDocument::Json& animation,
                                const GltfDocument::Json& json, const std::string& what) {
  if (!json.is_object() || !json.contains("target") || !animation.contains("samplers"))
    document.fail("found a channel without target or sampler in " + what);
  const std::string path = document.text(json["target"], "path", "");
  Channel channel;
  channel.node = document.index(json["target"], "node");
  if (channel.node < 0) return;  // defined by an extension
  document.item("nodes", channel.node);
  const long which = document.integer(json, "sampler", what);
  const auto& samplers = animation["samplers"];
  if (!samplers.is_array() || which < 0 || which >= isize(samplers) ||
      !samplers[static_cast<size_t>(which)].is_object())
    document.fail("found the sampler " + std::to_string(which) + " of " +
                  std::to_string(samplers.size()) + " in " + what);
  const auto& sampler = samplers[static_cast<size_t>(which)];
  const std::string interpolation = document.text(sampler, "interpolation", "LINEAR");
  channel.interpolation = interpolation == "STEP"          ? Interpolation::Step
                          : interpolation == "CUBICSPLINE" ? Interpolation::Cubic
                                                           : Interpolation::Linear;
  const VecX times = document.accessor(document.integer(sampler, "input", what), 1).reshaped();
  channel.times.assign(times.begin(), times.end());
  for (size_t k = 0; k < channel.times.size(); ++k)
    if (!std::isfinite(times[static_cast<long>(k)]) ||
        (k > 0 && !(channel.times[k] > channel.times[k - 1])))
      document.fail("found the time " + format_number(channel.times[k]) + " of key " +
                    std::to_string(k + 1) + " in " + what + ", expected ascending ones");
  if (channel.times.empty()) document.fail("found a sampler without keys in " + what);
  if (path == "translation")
    channel.path = Path::Translation;
  else if (path == "rotation")
    channel.path = Path::Rotation;
  else if (path == "scale")
    channel.path = Path::Scale;
  else if (path == "weights")
    channel.path = Path::Weights;
  else
    return;  // defined by an extension
  const int components = channel.path == Path::Rotation ? 4 : channel.path == Path::Weights ? 1 : 3;
  channel.values = document.accessor(document.integer(sampler, "output", what), components);
  const long rows =
      isize(channel.times) * (channel.interpolation == Interpolation::Cubic ? 3L : 1L);
  if (channel.path == Path::Weights) {
    // The weights of all targets are stored consecutively per key.
    if (channel.values.rows() == 0 || channel.values.rows() % rows != 0)
      document.fail("found " + std::to_string(channel.values.rows()) + " weights for " +
                    std::to_string(channel.times.size()) + " keys in " + what);
    channel.values = MatX(channel.values.reshaped(channel.values.rows() / rows, rows).transpose());
  } else if (channel.values.rows() != rows) {
    document.fail("found " + std::to_string(channel.values.rows()) + " values for " +
                  std::to_string(channel.times.size()) + " keys in " + what + ", expected " +
                  std::to_string(rows));
  }
  if (!channel.values.allFinite()) document.fail("found a value that is not finite in " + what);
  channels_.push_back(std::move(channel));
}

VecX GltfAnimation::value_at(const Channel& channel, double time) {
  const auto& times = channel.times;
  const bool cubic = channel.interpolation == Interpolation::Cubic;
  const auto row = [&](long key, int which) -> VecX {
    return channel.values.row(cubic ? 3 * key + which : key).transpose();
  };
  const long last = isize(times) - 1;
  const long after = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  if (after == 0) return row(0, 1);
  if (after > last) return row(last, 1);
  const long k = after - 1;
  if (channel.interpolation == Interpolation::Step) return row(k, 1);
  const double length = times[static_cast<size_t>(after)] - times[static_cast<size_t>(k)],
               s = (time - times[static_cast<size_t>(k)]) / length;
  if (cubic) return hermite_value(row(k, 1), row(k, 2), row(k + 1, 1), row(k + 1, 0), length, s);
  if (channel.path != Path::Rotation) return (1 - s) * row(k, 1) + s * row(k + 1, 1);
  return quaternion(row(k, 1)).slerp(s, quaternion(row(k + 1, 1))).coeffs();
}

void GltfAnimation::apply(double time, std::vector<GltfNode>& nodes) const {
  for (const Channel& channel : channels_) {
    GltfNode& node = nodes[channel.node];
    const VecX value = value_at(channel, time);
    if (channel.path != Path::Weights) node.uses_matrix = false;
    if (channel.path == Path::Translation) node.translation = value;
    if (channel.path == Path::Rotation) node.rotation = quaternion(value);
    if (channel.path == Path::Scale) node.scale = value;
    if (channel.path == Path::Weights) node.weights = value;
  }
}

}  // namespace batten
