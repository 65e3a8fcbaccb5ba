// SPDX-License-Identifier: MPL-2.0
// Reads and writes STL, text and binary. Corners whose coordinates are equal, or differ by rounding,
// become one node.
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <ostream>
#include <unordered_map>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_source_text.h"

namespace batten {
namespace {

constexpr size_t kHeader = 84, kRecord = 50;

float load_float(const char* bytes) {
  std::uint32_t bits = 0;
  for (int i = 3; i >= 0; --i) bits = bits << 8 | static_cast<unsigned char>(bytes[i]);
  return std::bit_cast<float>(bits);
}

void store_float(char* bytes, float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (int i = 0; i < 4; ++i) bytes[i] = static_cast<char>(bits >> (8 * i) & 255);
}

size_t binary_count(const std::string& text) {
  size_t count = 0;
  for (size_t i = 4; i-- > 0;) count = count << 8 | static_cast<unsigned char>(text[80 + i]);
  return count;
}

/// Unit normal of a triangle; zero if the triangle has no area.
Vec3 normal_of(const Points& points, std::span<const int> face) {
  const Vec3 a = points.row(face[0]), b = points.row(face[1]), c = points.row(face[2]);
  const Vec3 area = (b - a).cross(c - a);
  return area.norm() > 0 ? area.normalized() : Vec3::Zero();
}

struct PositionHash {
  size_t operator()(const std::array<double, 3>& key) const {
    std::uint64_t hash = 0;
    for (const double c : key) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return hash;
  }
};

/// Numbers positions in the order of their first occurrence; equal positions share a number.
class Nodes {
 public:
  int operator()(const std::array<double, 3>& position) {
    std::array<double, 3> key;
    for (size_t c = 0; c < 3; ++c) key[c] = position[c] + 0.0;  // -0 becomes 0
    const auto [at, is_new] = index_.try_emplace(key, isize(index_));
    if (is_new) coordinates_.insert(coordinates_.end(), position.begin(), position.end());
    return at->second;
  }
  Points points() const {
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
        coordinates_.data(), static_cast<Eigen::Index>(index_.size()), 3);
  }

 private:
  std::unordered_map<std::array<double, 3>, int, PositionHash> index_;
  std::vector<double> coordinates_;
};

/// For each node, the node with which it is welded: the first one within `tolerance`, or itself.
std::vector<int> welded_nodes(const Points& points, double tolerance) {
  // Most points are farther than the tolerance from the sides of these cells, and have one cell.
  const double side = 16 * tolerance;
  std::unordered_map<std::array<double, 3>, std::vector<int>, PositionHash> cells;
  std::vector<int> first(static_cast<size_t>(points.rows()));
  for (int i = 0; i < isize(first); ++i) {
    const auto cell = [&](int c, double shift) {
      return std::floor((points(i, c) + shift) / side) + 0.0;
    };
    first[i] = i;
    for (double x = cell(0, -tolerance); x <= cell(0, tolerance); ++x)
      for (double y = cell(1, -tolerance); y <= cell(1, tolerance); ++y)
        for (double z = cell(2, -tolerance); z <= cell(2, tolerance); ++z) {
          const auto there = cells.find({x, y, z});
          if (there == cells.end()) continue;
          for (const int other : there->second)
            if ((points.row(i) - points.row(other)).norm() <= tolerance)
              first[i] = std::min(first[i], other);
        }
    if (first[i] == i) cells[{cell(0, 0), cell(1, 0), cell(2, 0)}].push_back(i);
  }
  return first;
}

class StlMesh : public MeshContent {
 public:
  explicit StlMesh(MeshSourceText text) : file_(std::move(text)) {
    const std::string& bytes = file_.text();
    // Some binary files also start with "solid"; their size identifies them.
    binary_ = bytes.size() >= kHeader && bytes.size() == kHeader + kRecord * binary_count(bytes);
    std::string_view first = std::string_view(bytes).substr(0, bytes.find('\n'));
    if (!binary_ && next_token(first) != "solid") {
      if (bytes.size() < kHeader)
        file_.fail(size_t{0},
                   "found " + quoted_excerpt(bytes) + ", expected 'solid' or a binary header");
      file_.fail_at_end("found " + std::to_string(bytes.size()) + " bytes, expected " +
                        std::to_string(kHeader + kRecord * binary_count(bytes)) + " for " +
                        std::to_string(binary_count(bytes)) + " triangles");
    }
    format = binary_ ? "binary STL" : "STL text";
    extensions = {".stl"};
    binary_ ? read_binary() : read_text();
    weld();
    node_labels = Labels::counted_from(0, shells.node_count());
    face_labels = Labels::counted_from(0, shells.face_count());
  }

  MeshRounding write(const std::filesystem::path& path, const Points& points,
                     const MeshWriteOptions&) const override {
    MeshRounding rounding;
    const std::string out = binary_ ? patched_binary(points, rounding) : patched_text(points);
    write_file_atomically(path, [&](std::ostream& stream) {
      stream.write(out.data(), static_cast<std::streamsize>(out.size()));
    });
    return rounding;
  }

 private:
  void read_binary() {
    const std::string& bytes = file_.text();
    Nodes nodes;
    for (size_t at = kHeader; at < bytes.size(); at += kRecord) {
      std::array<int, 3> face;
      for (size_t k = 0; k < 3; ++k) {
        std::array<double, 3> position;
        for (size_t c = 0; c < 3; ++c) {
          position[c] = load_float(&bytes[at + 12 + 12 * k + 4 * c]);
          if (!std::isfinite(position[c]))
            throw InputError(file_.path().string() + ": a coordinate of triangle " +
                             std::to_string((at - kHeader) / kRecord) + " is not finite");
        }
        face[k] = nodes(position);
      }
      shells.add_face(face);
    }
    shells.points = nodes.points();
  }

  /// Calls `normal` with the part of a line that holds a facet normal, and `corner` with the three
  /// coordinates of each corner.
  template <class Solid, class Normal, class Corner>
  void walk(MeshSourceText& file, const Solid& solid, const Normal& normal,
            const Corner& corner) const {
    std::string_view line;
    int corners = 0;
    bool open = false;
    while (file.next(line)) {
      std::string_view rest = line;
      const std::string_view token = next_token(rest);
      if (token.empty()) continue;
      const auto misplaced = [&] {
        file.fail(token, "found " + quoted_excerpt(token) + " after " +
                             format_count(corners, "corner") + ", expected facets of three");
      };
      if (token == "facet") {
        if (open) misplaced();
        open = true;
        corners = 0;
        next_token(rest);
        normal(trimmed(rest));
      } else if (token == "vertex") {
        if (!open || ++corners > 3) misplaced();
        for (int c = 0; c < 3; ++c) {
          const std::string_view number = next_token(rest);
          corner(c, number.empty() ? line.substr(line.size()) : number);
        }
      } else if (token == "endfacet") {
        if (!open || corners != 3) misplaced();
        open = false;
      } else if (token == "solid") {
        solid(trimmed(rest));
      } else if (token != "outer" && token != "endloop" && token != "endsolid") {
        file.fail(token, "found " + quoted_excerpt(token) + ", expected a line of STL text");
      }
    }
    if (open) file.fail_at_end("found the end of the file in a facet, expected 'endfacet'");
  }

  void read_text() {
    Nodes nodes;
    std::array<double, 3> position;
    std::vector<int> face;
    walk(
        file_,
        [&](std::string_view name) {
          sets.push_back({std::string(name), {}, {}, {}});
        },
        [](std::string_view) {},
        [&](int c, std::string_view number) {
          position[c] = file_.real(number);
          if (c < 2) return;
          face.push_back(nodes(position));
          if (face.size() < 3) return;
          if (!sets.empty()) sets.back().faces.push_back(shells.face_count());
          shells.add_face(face);
          face.clear();
        });
    std::erase_if(sets, [](const MeshSet& set) { return set.faces.empty() || set.name.empty(); });
    shells.points = nodes.points();
  }

  /// Welds corners that differ by rounding. The tolerance is two units in the last place of the
  /// largest coordinate in single precision, and at most a tenth of the shortest edge.
  void weld() {
    double shortest = std::numeric_limits<double>::infinity();
    for (int f = 0; f < shells.face_count(); ++f)
      for (int k = 0; k < 3; ++k) {
        const double length =
            (shells.points.row(shells.face(f)[k]) - shells.points.row(shells.face(f)[(k + 1) % 3]))
                .norm();
        if (length > 0) shortest = std::min(shortest, length);
      }
    const double largest = shells.points.size() > 0 ? shells.points.cwiseAbs().maxCoeff() : 0,
                 tolerance = std::min(2.4e-7 * largest, 0.1 * shortest);
    constexpr double kMostCells = 1e15;  // integers in double precision
    if (!(tolerance > 0) || largest / tolerance > kMostCells) return;
    const std::vector<int> first = welded_nodes(shells.points, tolerance);
    std::vector<int> number(first.size());
    int count = 0;
    for (int i = 0; i < isize(first); ++i) number[i] = first[i] == i ? count++ : number[first[i]];
    if (count == isize(first)) return;
    warnings.push_back(format_count(isize(first) - count, "node") + " within " +
                       format_number(tolerance) + " of another one, welded with it");
    ShellMesh welded;
    welded.points.resize(count, 3);
    for (int i = 0; i < isize(first); ++i)
      if (first[i] == i) welded.points.row(number[i]) = shells.points.row(i);
    for (int f = 0; f < shells.face_count(); ++f) {
      const auto face = shells.face(f);
      welded.add_face(std::array{number[face[0]], number[face[1]], number[face[2]]});
    }
    shells = std::move(welded);
  }

  bool moved(const Points& points, int face) const {
    for (const int node : shells.face(face))
      if (points.row(node) != shells.points.row(node)) return true;
    return false;
  }

  std::string patched_binary(const Points& points, MeshRounding& rounding) const {
    std::string out = file_.text();
    for (int f = 0; f < shells.face_count(); ++f) {
      if (!moved(points, f)) continue;
      char* const record = &out[kHeader + kRecord * static_cast<size_t>(f)];
      const Vec3 normal = normal_of(points, shells.face(f));
      for (int c = 0; c < 3; ++c) store_float(record + 4 * c, static_cast<float>(normal[c]));
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c) {
          const int node = shells.face(f)[k];
          if (points(node, c) == shells.points(node, c)) continue;
          const auto value = static_cast<float>(points(node, c));
          if (!std::isfinite(value))
            throw InputError(file_.path().string() + ": the coordinate " +
                             format_number(points(node, c)) + " of node " + std::to_string(node) +
                             " is too large for single precision");
          store_float(record + 12 + 12 * k + 4 * c, value);
          const double error = std::abs(static_cast<double>(value) - points(node, c));
          if (error > rounding.largest) rounding = {error, node, {}};
        }
    }
    return out;
  }

  std::string patched_text(const Points& points) const {
    const std::string& text = file_.text();
    std::string out;
    out.reserve(text.size() + text.size() / 8);
    size_t done = 0;
    int face = -1, corner = 0;
    bool changed = false;
    const auto put = [&](auto value) {
      char digits[32];
      out.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    };
    const auto up_to = [&](size_t begin, size_t length) {
      out.append(text, done, begin - done);
      done = begin + length;
    };
    MeshSourceText walked = file_;
    walked.seek(0);
    const auto begin_of = [&](std::string_view part) { return walked.offset(part); };
    walk(
        walked, [](std::string_view) {},
        [&](std::string_view old) {
          corner = 0;
          changed = moved(points, ++face);
          if (!changed || old.empty()) return;
          up_to(begin_of(old), old.size());
          const Vec3 normal = normal_of(points, shells.face(face));
          for (int c = 0; c < 3; ++c) {
            if (c > 0) out += ' ';
            put(static_cast<float>(normal[c]));
          }
        },
        [&](int c, std::string_view old) {
          const int node = shells.face(face)[corner];
          corner += c == 2;
          if (points(node, c) == shells.points(node, c)) return;
          up_to(begin_of(old), old.size());
          put(points(node, c));
        });
    out.append(text, done, text.npos);
    return out;
  }

  MeshSourceText file_;
  bool binary_ = false;
};

}  // namespace

std::unique_ptr<MeshContent> read_stl_mesh(const std::filesystem::path& path) {
  return std::make_unique<StlMesh>(MeshSourceText(path, true));
}

void write_stl_mesh(const MeshOutput& output) {
  const ShellMesh& mesh = output.mesh;
  std::string body;
  std::uint32_t count = 0;
  const auto triangle = [&](int a, int b, int c) {
    const std::array<int, 3> nodes{a, b, c};
    char record[kRecord] = {};
    const Vec3 normal = normal_of(mesh.points, nodes);
    for (int i = 0; i < 3; ++i) store_float(record + 4 * i, static_cast<float>(normal[i]));
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) {
        const auto value = static_cast<float>(mesh.points(nodes[k], i));
        if (!std::isfinite(value))
          throw InputError(output.path.string() + ": a coordinate of node " +
                           std::to_string(nodes[k]) + " is too large for single precision");
        store_float(record + 12 + 12 * k + 4 * i, value);
      }
    body.append(record, kRecord);
    ++count;
  };
  for (int f = 0; f < mesh.face_count(); ++f)
    for (const auto& [a, b, c] : triangles_of(mesh, f)) triangle(a, b, c);
  write_file_atomically(output.path, [&](std::ostream& out) {
    char header[kHeader] = "Batten";
    for (int i = 0; i < 4; ++i) header[80 + i] = static_cast<char>(count >> (8 * i) & 255);
    out.write(header, kHeader);
    out << body;
  });
}

}  // namespace batten
