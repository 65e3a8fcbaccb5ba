#include "batten/io/sequences/glb_writer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "batten/core/errors.h"
#include "batten/io/files/byte_order.h"
#include "batten/io/files/glb_file.h"

namespace batten {

GlbWriter::GlbWriter(const std::filesystem::path& path, std::vector<std::array<int, 3>> triangles,
                     int points, std::vector<double> times)
    : file_(path),
      triangles_(triangles.size()),
      points_(points),
      times_(std::move(times)),
      out_(file_.temporary(), std::ios::binary) {
  // The longest numbers that can be in it.
  Bounds longest;
  longest.low.fill(-std::numeric_limits<float>::denorm_min());
  longest.high = longest.low;
  const size_t frames = times_.size();
  json_room_ = 0;
  binary_size_ = 12 * (triangles_ + frames * static_cast<size_t>(points_)) +
                 (frames > 1 ? 4 * frames + 4 * frames * (frames - 1) : 0);
  const std::string longest_json = json(std::vector<Bounds>(frames, longest));
  json_room_ = longest_json.size() + 16 * frames * 6;
  if (glb_header_size(json_room_) + binary_size_ > std::numeric_limits<std::uint32_t>::max())
    throw InputError(path.string() + ": this file would have " +
                     std::to_string((json_room_ + binary_size_) >> 20) +
                     " MB, expected less than the 4096 MB of GLB: choose fewer frames");
  std::string begin(glb_header_size(json_room_), ' ');
  for (const auto& triangle : triangles)
    for (const int node : triangle) append_uint32(begin, static_cast<std::uint32_t>(node));
  put(begin);
}

void GlbWriter::write(const Points& points) {
  const bool first = bounds_.empty();
  Bounds bounds;
  bounds.low.fill(std::numeric_limits<float>::max());
  bounds.high.fill(-std::numeric_limits<float>::max());
  if (first) first_.resize(points.rows(), 3);
  std::string bytes;
  bytes.reserve(static_cast<size_t>(points.rows()) * 12);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto value = static_cast<float>(first ? points(i, c) : points(i, c) - first_(i, c));
      if (!std::isfinite(value))
        throw InputError(file_.path().string() + ": a coordinate of node " + std::to_string(i) +
                         " is too large for single precision");
      if (first) first_(i, c) = value;
      const auto axis = static_cast<size_t>(c);
      bounds.low[axis] = std::min(bounds.low[axis], value);
      bounds.high[axis] = std::max(bounds.high[axis], value);
      append_float32(bytes, value);
    }
  bounds_.push_back(bounds);
  put(bytes);
}

void GlbWriter::finish() {
  std::string bytes;
  if (times_.size() > 1) {
    for (const double time : times_) append_float32(bytes, static_cast<float>(time));
    for (size_t k = 0; k < times_.size(); ++k)
      for (size_t target = 1; target < times_.size(); ++target)
        append_float32(bytes, target == k ? 1.f : 0.f);
  }
  put(bytes);
  std::string text = json(bounds_);
  text.resize(json_room_, ' ');
  out_.seekp(0);
  put(glb_header(std::move(text), binary_size_));
  out_.close();
  if (!out_) throw FileError(file_.path().string() + ": cannot write this file: writing failed");
  file_.commit();
}

void GlbWriter::put(const std::string& bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out_) throw FileError(file_.path().string() + ": cannot write this file: writing failed");
}

std::string GlbWriter::json(const std::vector<Bounds>& bounds) const {
  using Json = nlohmann::ordered_json;
  const size_t frames = times_.size(), index_bytes = 12 * triangles_,
               frame_bytes = 12 * static_cast<size_t>(points_),
               key_begin = index_bytes + frames * frame_bytes;
  Json accessors = Json::array();
  accessors.push_back({{"bufferView", 0},
                       {"componentType", kUnsignedInt},
                       {"count", 3 * triangles_},
                       {"type", "SCALAR"}});
  for (size_t k = 0; k < frames; ++k)
    accessors.push_back({{"bufferView", 1},
                         {"byteOffset", k * frame_bytes},
                         {"componentType", kFloat},
                         {"count", points_},
                         {"type", "VEC3"},
                         {"min", bounds[k].low},
                         {"max", bounds[k].high}});
  Json views = Json::array();
  views.push_back({{"buffer", 0}, {"byteLength", index_bytes}, {"target", kIndexBuffer}});
  views.push_back({{"buffer", 0},
                   {"byteOffset", index_bytes},
                   {"byteLength", frames * frame_bytes},
                   {"byteStride", 12},
                   {"target", kVertexBuffer}});
  Json primitive, mesh, root;
  primitive["attributes"]["POSITION"] = 1;
  primitive["indices"] = 0;
  primitive["mode"] = 4;
  root["asset"] = {{"version", "2.0"}, {"generator", "Batten"}};
  root["scene"] = 0;
  root["scenes"][0]["nodes"] = std::vector<int>{0};
  root["nodes"][0]["mesh"] = 0;
  root["buffers"][0]["byteLength"] = binary_size_;
  if (frames > 1) {
    for (size_t k = 1; k < frames; ++k) primitive["targets"][k - 1]["POSITION"] = 1 + k;
    mesh["weights"] = std::vector<int>(frames - 1, 0);
    views.push_back(
        {{"buffer", 0}, {"byteOffset", key_begin}, {"byteLength", 4 * frames * frames}});
    accessors.push_back({{"bufferView", 2},
                         {"componentType", kFloat},
                         {"count", frames},
                         {"type", "SCALAR"},
                         {"min", std::vector<float>{static_cast<float>(times_.front())}},
                         {"max", std::vector<float>{static_cast<float>(times_.back())}}});
    accessors.push_back({{"bufferView", 2},
                         {"byteOffset", 4 * frames},
                         {"componentType", kFloat},
                         {"count", frames * (frames - 1)},
                         {"type", "SCALAR"}});
    Json& animation = root["animations"][0];
    animation["samplers"][0] = {
        {"input", frames + 1}, {"interpolation", "LINEAR"}, {"output", frames + 2}};
    animation["channels"][0]["sampler"] = 0;
    animation["channels"][0]["target"] = {{"node", 0}, {"path", "weights"}};
  }
  mesh["primitives"][0] = std::move(primitive);
  root["meshes"][0] = std::move(mesh);
  root["accessors"] = std::move(accessors);
  root["bufferViews"] = std::move(views);
  return root.dump();
}

}  // namespace batten
