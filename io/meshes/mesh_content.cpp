// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/mesh_content.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {

Labels Labels::counted_from(long first, int count) {
  Labels labels;
  labels.first_ = first;
  labels.count_ = count;
  return labels;
}

Labels::Labels(std::vector<long> labels) : count_(isize(labels)), labels_(std::move(labels)) {
  if (labels_.empty()) return;
  const auto [low, high] = std::minmax_element(labels_.begin(), labels_.end());
  first_ = *low;
  const auto range = static_cast<unsigned long>(*high) - static_cast<unsigned long>(*low);
  if (range < 4 * labels_.size() + 1024) {
    dense_.assign(range + 1, -1);
    for (int i = 0; i < count_; ++i) {
      int& there = dense_[labels_[i] - first_];
      if (there >= 0 && !duplicate_) duplicate_ = {there, i};
      there = i;
    }
    return;
  }
  for (int i = 0; i < count_; ++i) by_label_.push_back({labels_[i], i});
  std::sort(by_label_.begin(), by_label_.end());
  for (size_t i = 1; i < by_label_.size(); ++i)
    if (by_label_[i].first == by_label_[i - 1].first &&
        (!duplicate_ || by_label_[i].second < duplicate_->second))
      duplicate_ = {by_label_[i - 1].second, by_label_[i].second};
}

std::optional<int> Labels::find(long label) const {
  if (!by_label_.empty()) {
    const auto at = std::lower_bound(by_label_.begin(), by_label_.end(), std::pair(label, 0));
    if (at == by_label_.end() || at->first != label) return {};
    return at->second;
  }
  if (count_ == 0 || label < first_) return {};
  const auto index = static_cast<unsigned long>(label) - static_cast<unsigned long>(first_);
  if (labels_.empty())
    return index < static_cast<unsigned long>(count_) ? std::optional(static_cast<int>(index))
                                                      : std::nullopt;
  if (index >= dense_.size() || dense_[index] < 0) return {};
  return dense_[index];
}

int unused_nodes(const ShellMesh& mesh) {
  std::vector<char> used(static_cast<size_t>(mesh.node_count()));
  for (int f = 0; f < mesh.face_count(); ++f)
    for (const int node : mesh.face(f)) used[node] = 1;
  return static_cast<int>(std::count(used.begin(), used.end(), 0));
}

std::vector<int> outline_of(const ShellMesh& mesh, int face) {
  const auto nodes = mesh.face(face), corners = mesh.corners(face);
  if (!mesh.second_order(face)) return {nodes.begin(), nodes.end()};
  std::vector<int> outline;
  for (size_t i = 0; i < corners.size(); ++i) {
    outline.push_back(corners[i]);
    outline.push_back(nodes[corners.size() + i]);
  }
  return outline;
}

std::vector<std::array<int, 3>> triangles_of(const ShellMesh& mesh, int face) {
  const auto n = mesh.face(face);
  if (mesh.second_order(face) && n.size() == 6)
    return {{n[0], n[3], n[5]}, {n[3], n[1], n[4]}, {n[4], n[2], n[5]}, {n[3], n[4], n[5]}};
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> rest(n.begin(), n.end());
  if (mesh.second_order(face)) {
    for (size_t i = 0; i < 4; ++i) triangles.push_back({n[i], n[4 + i], n[4 + (i + 3) % 4]});
    rest.assign(n.begin() + 4, n.end());
  }
  const auto length = [&](int a, int b) {
    return (mesh.points.row(a) - mesh.points.row(b)).squaredNorm();
  };
  const auto area = [&](int a, int b, int c) {
    const Vec3 p = mesh.points.row(a), q = mesh.points.row(b), r = mesh.points.row(c);
    return (q - p).cross(r - p).norm();
  };
  const auto least = [&](size_t k) {
    return std::min(area(rest[k], rest[k + 1], rest[k + 2]),
                    area(rest[k], rest[k + 2], rest[(k + 3) % 4]));
  };
  // Near a straight corner, one of the diagonals leaves a triangle without area.
  constexpr double kSliver = 0.1;
  if (rest.size() == 4 &&
      (length(rest[1], rest[3]) < length(rest[0], rest[2]) ? least(1) >= kSliver * least(0)
                                                           : least(0) < kSliver * least(1)))
    std::rotate(rest.begin(), rest.begin() + 1, rest.end());
  for (size_t i = 2; i < rest.size(); ++i) triangles.push_back({rest[0], rest[i - 1], rest[i]});
  return triangles;
}

std::vector<int> set_of_faces(const ShellMesh& mesh, const std::vector<MeshSet>& sets) {
  std::vector<int> result(static_cast<size_t>(mesh.face_count()), -1);
  for (int s = 0; s < isize(sets); ++s)
    for (const int face : sets[static_cast<size_t>(s)].faces) {
      if (face < 0 || face >= mesh.face_count())
        throw InputError("the set '" + sets[static_cast<size_t>(s)].name + "' has face " +
                         std::to_string(face) + ", expected 0 to " +
                         std::to_string(mesh.face_count() - 1));
      result[static_cast<size_t>(face)] = s;
    }
  return result;
}

std::optional<std::array<int, 3>> mesh_colour(const std::string& hex) {
  if (hex.empty()) return std::nullopt;
  const auto digit = [](unsigned char c) { return std::isxdigit(c) != 0; };
  bool sound = hex.size() == 7 && hex[0] == '#';
  for (size_t i = 1; i < hex.size(); ++i)
    sound = sound && digit(static_cast<unsigned char>(hex[i]));
  if (!sound) throw InputError("found the colour '" + hex + "', expected one as '#ff8800'");
  std::array<int, 3> colour{};
  for (size_t c = 0; c < 3; ++c) colour[c] = std::stoi(hex.substr(1 + 2 * c, 2), nullptr, 16);
  return colour;
}

std::string hex_of(const std::array<int, 3>& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", colour[0] & 255, colour[1] & 255,
                colour[2] & 255);
  return text;
}

}  // namespace batten
