// SPDX-License-Identifier: MPL-2.0
// Reads and writes Stanford PLY, text and binary. Unknown properties are preserved.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <ostream>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/text_mesh_content.h"

namespace batten {
namespace {

enum class Scalar { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

size_t size_of(Scalar type) {
  static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<int>(type)];
}

struct Property {
  std::string name;
  Scalar type = Scalar::Int32;
  std::optional<Scalar> count;  // type of the list length, for list properties
};

struct Element {
  std::string name;
  long count = 0;
  std::vector<Property> properties;
};

class PlyReader {
 public:
  explicit PlyReader(TextMeshContent& mesh) : mesh_(mesh), file_(mesh.file) {}

  void read() {
    header();
    bool nodes = false, faces = false;
    for (const Element& element : elements_) {
      if (element.properties.empty()) continue;
      if (element.name == "vertex" && !nodes) {
        nodes = true;
        vertices(element);
      } else if (element.name == "face" && !faces) {
        if (!nodes) file_.fail(at(), "found faces before nodes, expected them after");
        faces = true;
        polygons(element);
      } else {
        mesh_.warnings.push_back(format_count(element.count, "element") + " '" + element.name +
                                 "' of the file remain unchanged");
        for (long i = 0; i < element.count; ++i)
          for (const Property& property : element.properties) skip(property);
      }
    }
    if (!nodes) file_.fail(at(), "found no nodes, expected an element 'vertex'");
    mesh_.node_labels = Labels::counted_from(0, mesh_.shells.node_count());
    mesh_.face_labels = Labels::counted_from(0, mesh_.shells.face_count());
    if (const int unused = unused_nodes(mesh_.shells))
      mesh_.warnings.push_back(format_count(unused, "node") + " without a face");
  }

 private:
  void header() {
    std::string_view line;
    if (!file_.next(line) || trimmed(line) != "ply")
      file_.fail(size_t{0}, "found " + quoted_excerpt(line) + ", expected 'ply'");
    bool format = false;
    while (file_.next(line)) {
      std::string_view rest = line;
      const std::string_view token = next_token(rest);
      if (token == "format") {
        format = true;
        read_format(next_token(rest), line);
      } else if (token == "element") {
        Element element{std::string(next_token(rest)), 0, {}};
        element.count = file_.integer(next_token(rest), "a number of elements");
        if (element.count < 0 || element.count > std::numeric_limits<int>::max())
          file_.fail(line, "found " + quoted_excerpt(line) + ", expected a number of elements");
        elements_.push_back(std::move(element));
      } else if (token == "property") {
        if (elements_.empty()) file_.fail(token, "found a property before any element");
        Property property;
        std::string_view type = next_token(rest);
        if (type == "list") {
          property.count = scalar(next_token(rest));
          type = next_token(rest);
        }
        property.type = scalar(type);
        property.name = next_token(rest);
        elements_.back().properties.push_back(std::move(property));
      } else if (token == "end_header") {
        if (!format) file_.fail(token, "found no format line, expected one");
        return;
      } else if (token != "comment" && token != "obj_info") {
        file_.fail(line, "found " + quoted_excerpt(line) + ", expected a line of a PLY header");
      }
    }
    file_.fail_at_end("found the end of the file, expected 'end_header'");
  }

  void read_format(std::string_view name, std::string_view line) {
    ascii_ = name == "ascii";
    const bool big_endian = name == "binary_big_endian";
    if (!ascii_ && !big_endian && name != "binary_little_endian")
      file_.fail(line, "found " + quoted_excerpt(line) +
                           ", expected ascii, binary_little_endian or " + "binary_big_endian");
    big_endian_ = big_endian;
  }

  Scalar scalar(std::string_view name) const {
    static const std::pair<std::string_view, Scalar> names[] = {
        {"char", Scalar::Int8},      {"int8", Scalar::Int8},       {"uchar", Scalar::UInt8},
        {"uint8", Scalar::UInt8},    {"short", Scalar::Int16},     {"int16", Scalar::Int16},
        {"ushort", Scalar::UInt16},  {"uint16", Scalar::UInt16},   {"int", Scalar::Int32},
        {"int32", Scalar::Int32},    {"uint", Scalar::UInt32},     {"uint32", Scalar::UInt32},
        {"float", Scalar::Float32},  {"float32", Scalar::Float32}, {"double", Scalar::Float64},
        {"float64", Scalar::Float64}};
    for (const auto& [known, type] : names)
      if (known == name) return type;
    file_.fail(name, "found " + quoted_excerpt(name) + ", expected a type such as float or uchar");
  }

  size_t at() const { return file_.position(); }

  template <class T>
  double load(size_t begin) const {
    char bytes[sizeof(T)];
    std::memcpy(bytes, file_.text().data() + begin, sizeof(T));
    if (big_endian_ != (std::endian::native == std::endian::big))
      std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return static_cast<double>(value);
  }

  /// Reads the next value and its location.
  double next(Scalar type, Field& field) {
    if (ascii_) {
      const std::string& text = file_.text();
      size_t begin = at();
      while (begin < text.size() && (is_blank(text[begin]) || text[begin] == '\n')) ++begin;
      size_t end = begin;
      while (end < text.size() && !is_blank(text[end]) && text[end] != '\n') ++end;
      if (begin == end) file_.fail_at_end("found the end of the file, expected a number");
      file_.seek(end);
      field = {begin, static_cast<std::uint32_t>(end - begin), FieldKind::Free, false, 0};
      return file_.real(std::string_view(text).substr(begin, end - begin));
    }
    const size_t begin = at(), size = size_of(type);
    if (file_.text().size() - begin < size)
      file_.fail_at_end("found the end of the file, expected " + std::to_string(size) +
                        " more bytes");
    file_.seek(begin + size);
    const FieldKind kind = type == Scalar::Float32
                               ? (big_endian_ ? FieldKind::Float32Swapped : FieldKind::Float32)
                               : (big_endian_ ? FieldKind::Float64Swapped : FieldKind::Float64);
    field = {begin, static_cast<std::uint32_t>(size), kind, false, 0};
    switch (type) {
      case Scalar::Int8:
        return load<std::int8_t>(begin);
      case Scalar::UInt8:
        return load<std::uint8_t>(begin);
      case Scalar::Int16:
        return load<std::int16_t>(begin);
      case Scalar::UInt16:
        return load<std::uint16_t>(begin);
      case Scalar::Int32:
        return load<std::int32_t>(begin);
      case Scalar::UInt32:
        return load<std::uint32_t>(begin);
      case Scalar::Float32:
        return load<float>(begin);
      default:
        return load<double>(begin);
    }
  }
  long next_integer(Scalar type, const std::string& what, long low, long high) {
    Field field;
    const double value = next(type, field);
    if (!(value >= static_cast<double>(low) && value <= static_cast<double>(high)) ||
        value != std::floor(value))
      file_.fail(field.begin, "found " + format_number(value) + " as " + what + ", expected " +
                                  std::to_string(low) + " to " + std::to_string(high));
    return static_cast<long>(value);
  }
  void skip(const Property& property) {
    Field field;
    const long count = property.count ? next_integer(*property.count, "a length", 0, 1L << 40) : 1;
    for (long i = 0; i < count; ++i) next(property.type, field);
  }

  void vertices(const Element& element) {
    std::array<int, 3> where{-1, -1, -1};
    bool normals = false;
    for (int p = 0; p < isize(element.properties); ++p) {
      const Property& property = element.properties[p];
      for (int c = 0; c < 3; ++c)
        if (property.name == std::string(1, "xyz"[c])) {
          if (property.count ||
              (property.type != Scalar::Float32 && property.type != Scalar::Float64))
            file_.fail(at(), "found another type of coordinate, expected float or double");
          where[c] = p;
        }
      normals |= property.name == "nx";
    }
    if (where[0] < 0 || where[1] < 0 || where[2] < 0)
      file_.fail(at(), "found nodes without x, y and z, expected them");
    std::vector<double> coordinates;
    for (long i = 0; i < element.count; ++i) {
      std::array<Field, 3> fields;
      std::array<double, 3> xyz{};
      for (int p = 0; p < isize(element.properties); ++p) {
        const Property& property = element.properties[p];
        const auto c = std::find(where.begin(), where.end(), p) - where.begin();
        if (c == 3) {
          skip(property);
          continue;
        }
        Field& field = fields[c];
        xyz[c] = next(property.type, field);
        if (!std::isfinite(xyz[c]))
          file_.fail(field.begin,
                     "found a coordinate of node " + std::to_string(i) + " that is not finite");
      }
      mesh_.fields.push_back(fields);
      coordinates.insert(coordinates.end(), xyz.begin(), xyz.end());
    }
    mesh_.shells.points =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
            coordinates.data(), element.count, 3);
    if (normals)
      mesh_.warnings.push_back(format_count(element.count, "normal") +
                               " (nx, ny, nz) of the file remain unchanged");
  }

  void polygons(const Element& element) {
    const auto is_list = [](const Property& p) {
      return p.count && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    if (std::none_of(element.properties.begin(), element.properties.end(), is_list))
      file_.fail(at(), "found faces without a list 'vertex_indices', expected one");
    std::vector<int> face;
    for (long i = 0; i < element.count; ++i)
      for (const Property& property : element.properties) {
        if (!is_list(property)) {
          skip(property);
          continue;
        }
        const long corners = next_integer(*property.count, "a number of nodes", 0, 1L << 31);
        if (corners < 3)
          file_.fail(at(),
                     "found a face of " + format_count(corners, "node") + ", expected 3 or more");
        face.clear();
        for (long k = 0; k < corners; ++k)
          face.push_back(static_cast<int>(
              next_integer(property.type, "a node number", 0, mesh_.shells.node_count() - 1L)));
        mesh_.shells.add_face(face);
      }
  }

  TextMeshContent& mesh_;
  MeshSourceText& file_;
  std::vector<Element> elements_;
  bool ascii_ = true, big_endian_ = false;
};

}  // namespace

std::unique_ptr<MeshContent> read_ply_mesh(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path, true));
  mesh->format = "Stanford PLY";
  mesh->extensions = {".ply"};
  PlyReader(*mesh).read();
  return mesh;
}

void write_ply_mesh(const MeshOutput& output) {
  const ShellMesh& mesh = output.mesh;
  std::string body;
  const auto put = [&](auto value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if (std::endian::native == std::endian::big) std::reverse(bytes, bytes + sizeof value);
    body.append(bytes, sizeof value);
  };
  for (int i = 0; i < mesh.node_count(); ++i)
    for (int c = 0; c < 3; ++c) put(mesh.points(i, c));
  const std::vector<int> set = set_of_faces(mesh, output.sets);
  std::vector<std::optional<std::array<int, 3>>> colours;
  for (const MeshSet& one : output.sets) colours.push_back(mesh_colour(one.colour));
  const bool coloured = std::any_of(colours.begin(), colours.end(),
                                    [](const auto& colour) { return colour.has_value(); });
  constexpr std::array without{204, 204, 204};
  for (int f = 0; f < mesh.face_count(); ++f) {
    const std::vector<int> nodes = outline_of(mesh, f);
    put(static_cast<std::uint32_t>(nodes.size()));
    for (const int node : nodes) put(static_cast<std::int32_t>(node));
    if (coloured)
      for (const int c : set[f] < 0 ? without : colours[set[f]].value_or(without))
        put(static_cast<std::uint8_t>(c));
  }
  write_file_atomically(output.path, [&](std::ostream& out) {
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.node_count()
        << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
        << mesh.face_count() << "\nproperty list uint int vertex_indices\n"
        << (coloured ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "")
        << "end_header\n"
        << body;
  });
}

}  // namespace batten
