// SPDX-License-Identifier: MPL-2.0
// Writes a mesh as binary glTF 2.0 (GLB): one glTF mesh per set, in metres, y up.
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/glb_file.h"
#include "batten/io/meshes/corner_normals.h"
#include "batten/io/meshes/mesh_content.h"

namespace batten {
namespace {

using Json = nlohmann::ordered_json;

/// Converts from z up to glTF's y up. `0 - y` avoids a negative zero.
std::array<float, 3> turned(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.z()), static_cast<float>(0 - p.y())};
}

class GlbMesh {
 public:
  explicit GlbMesh(const MeshOutput& output)
      : path_(output.path), mesh_(output.mesh), sets_(output.sets), metres_(output.unit_in_metres) {
    root_["asset"] = {{"version", "2.0"}, {"generator", "Batten"}};
    root_["scene"] = 0;
    std::vector<std::vector<std::array<int, 3>>> parts(sets_.size() + 1);
    const std::vector<int> set = set_of_faces(mesh_, sets_);
    for (int f = 0; f < mesh_.face_count(); ++f)
      for (const auto& triangle : triangles_of(mesh_, f))
        parts[set[f] < 0 ? sets_.size() : static_cast<size_t>(set[f])].push_back(triangle);
    for (size_t s = 0; s < parts.size(); ++s)
      if (!parts[s].empty()) add(parts[s], s);
  }

  void write() {
    root_["buffers"][0]["byteLength"] = binary_.size();
    const std::string json = root_.dump();
    if (glb_header_size(json.size()) + binary_.size() > std::numeric_limits<std::uint32_t>::max())
      throw InputError(path_.string() + ": this file would have " +
                       std::to_string(binary_.size() >> 20) +
                       " MB, expected less than the 4096 MB of GLB");
    write_file_atomically(
        path_, [&](std::ostream& out) { out << glb_header(json, binary_.size()) << binary_; });
  }

 private:
  /// Adds the triangles of a set as a glTF mesh with its node. The last part holds the faces
  /// without a set.
  void add(const std::vector<std::array<int, 3>>& triangles, size_t set) {
    const CornerNormals corners = corner_normals(mesh_.points, triangles);
    const auto vertices = isize(corners.normals);
    Json primitive, mesh;
    primitive["attributes"]["POSITION"] = add_view(kVertexBuffer, vertices, "VEC3", kFloat);
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::max());
    high.fill(-std::numeric_limits<float>::max());
    for (const int node : corners.nodes) {
      const auto p = turned(metres_ * Vec3(mesh_.points.row(node).transpose()));
      for (size_t c = 0; c < 3; ++c) {
        if (!std::isfinite(p[c]))
          throw InputError(path_.string() + ": a coordinate of node " + std::to_string(node) +
                           " is too large for single precision");
        low[c] = std::min(low[c], p[c]);
        high[c] = std::max(high[c], p[c]);
        append_float32(binary_, p[c]);
      }
    }
    root_["accessors"].back()["min"] = low;
    root_["accessors"].back()["max"] = high;
    primitive["attributes"]["NORMAL"] = add_view(kVertexBuffer, vertices, "VEC3", kFloat);
    for (const Vec3& n : corners.normals)
      for (const float c : turned(n)) append_float32(binary_, c);
    primitive["indices"] = add_view(kIndexBuffer, 3 * isize(corners.of), "SCALAR", kUnsignedInt);
    for (const auto& triangle : corners.of)
      for (const int vertex : triangle) append_uint32(binary_, static_cast<std::uint32_t>(vertex));
    primitive["mode"] = 4;
    Json node;
    node["mesh"] = root_.contains("meshes") ? root_["meshes"].size() : 0;
    if (set < sets_.size()) {
      if (const auto colour = mesh_colour(sets_[set].colour))
        primitive["material"] = material(sets_[set].colour, *colour);
      if (!sets_[set].name.empty()) mesh["name"] = node["name"] = sets_[set].name;
    }
    mesh["primitives"] = Json::array({primitive});
    root_["scenes"][0]["nodes"].push_back(node["mesh"]);
    root_["nodes"].push_back(node);
    root_["meshes"].push_back(mesh);
  }

  /// Adds an accessor, with its own buffer view, for the data that is appended next.
  size_t add_view(int target, int count, const char* type, int component) {
    const size_t bytes = 4 * static_cast<size_t>(count) * (type[0] == 'V' ? 3 : 1);
    root_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes}, {"target", target}});
    root_["accessors"].push_back({{"bufferView", root_["bufferViews"].size() - 1},
                                  {"componentType", component},
                                  {"count", count},
                                  {"type", type}});
    return root_["accessors"].size() - 1;
  }

  /// Finds or adds a material of this colour. glTF expects linear components; colours in files are
  /// sRGB.
  size_t material(const std::string& name, const std::array<int, 3>& colour) {
    Json& all = root_["materials"];
    for (size_t m = 0; m < all.size(); ++m)
      if (all[m]["name"] == name) return m;
    std::array<double, 4> linear{0, 0, 0, 1};
    for (size_t c = 0; c < 3; ++c) {
      const double channel = colour[c] / 255.0;
      linear[c] = channel <= 0.04045 ? channel / 12.92 : std::pow((channel + 0.055) / 1.055, 2.4);
    }
    Json look;
    look["name"] = name;
    look["pbrMetallicRoughness"] = {
        {"baseColorFactor", linear}, {"metallicFactor", 0}, {"roughnessFactor", 0.6}};
    look["doubleSided"] = true;
    all.push_back(look);
    return all.size() - 1;
  }

  const std::filesystem::path& path_;
  const ShellMesh& mesh_;
  const std::vector<MeshSet>& sets_;
  double metres_;
  Json root_;
  std::string binary_;
};

}  // namespace

void write_glb_mesh(const MeshOutput& output) { GlbMesh(output).write(); }

}  // namespace batten
