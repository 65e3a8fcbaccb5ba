// SPDX-License-Identifier: MPL-2.0
// Sequences for tests of readers and writers.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "batten/core/errors.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/sequences/sequence_files.h"
#include "batten/io/sequences/sequence_writer.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

namespace batten_test {
using namespace batten;

/// The error message of reading a file, or "".
inline std::string reading(const std::filesystem::path& path, const SequenceOptions& options = {}) {
  return error_message([&] { read_frames(path, options); });
}

/// A waving strip of quads; its last faces are a triangle and a pentagon.
inline MeshSequence wave(int frames, double step = 0.25) {
  constexpr int length = 5;
  MeshSequence s;
  s.shells.points = Points::Zero(2 * length + 1, 3);
  for (int i = 0; i < length; ++i)
    for (int side = 0; side < 2; ++side) s.shells.points.row(2 * i + side) << i, 1.5 * side, 0;
  s.shells.points.row(2 * length) << length, 0.75, 0;
  for (int i = 0; i + 2 < length; ++i)
    s.shells.add_face(std::array{2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1});
  const int e = 2 * (length - 2);
  s.shells.add_face(std::array{e, e + 2, e + 4, e + 3, e + 1});
  s.shells.add_face(std::array{0, 1, 4});
  for (int k = 0; k < frames; ++k) {
    Points p = s.shells.points;
    for (int i = 0; i < p.rows(); ++i) {
      p(i, 2) = std::sin(0.7 * k + 0.9 * p(i, 0)) / 3;
      p(i, 0) += 0.1 * k;
    }
    s.frames.push_back(p);
    s.times.push_back(step * k);
  }
  s.shells.points = s.frames.front();
  return s;
}

inline void write_sequence(const std::filesystem::path& path, const MeshSequence& s) {
  SequenceWriter writer(path, s.shells, s.times);
  for (int k = 0; k < s.frame_count(); ++k) writer.write(k, s.frames[k]);
  writer.finish();
}

/// Largest distance of a node from its position in the other sequence.
inline double apart(const MeshSequence& a, const MeshSequence& b) {
  REQUIRE(a.frame_count() == b.frame_count());
  REQUIRE(a.node_count() == b.node_count());
  double largest = 0;
  for (int k = 0; k < a.frame_count(); ++k)
    largest = std::max(largest, (a.frames[k] - b.frames[k]).rowwise().norm().maxCoeff());
  return largest;
}

inline std::vector<std::vector<int>> faces_of(const ShellMesh& mesh) {
  std::vector<std::vector<int>> faces;
  for (int f = 0; f < mesh.face_count(); ++f)
    faces.emplace_back(mesh.face(f).begin(), mesh.face(f).end());
  return faces;
}

inline std::string bytes_in(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void put_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Names of all files in a folder, including hidden ones.
inline std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}

/// A number in a buffer, little-endian.
template <class T>
T number_in(const std::string& bytes, size_t at, bool big = false) {
  std::array<char, sizeof(T)> part;
  for (size_t i = 0; i < sizeof(T); ++i) part[i] = bytes.at(at + (big ? sizeof(T) - 1 - i : i));
  T value;
  std::memcpy(&value, part.data(), sizeof value);
  return value;
}

}  // namespace batten_test
