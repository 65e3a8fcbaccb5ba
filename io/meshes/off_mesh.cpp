// SPDX-License-Identifier: MPL-2.0
// Reads and writes Geomview's Object File Format (OFF).
#include <algorithm>
#include <charconv>
#include <limits>
#include <ostream>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/meshes/text_mesh_content.h"

namespace batten {
namespace {

std::string_view without_comment(std::string_view line) {
  return trimmed(line.substr(0, line.find('#')));
}

/// Reads the next line that contains data; false at the end.
bool next_data(MeshSourceText& file, std::string_view& line) {
  while (file.next(line)) {
    line = without_comment(line);
    if (!line.empty()) return true;
  }
  return false;
}

/// Checks the header keyword, which states the kind of OFF; false if the file has none.
bool read_kind(const MeshSourceText& file, std::string_view token) {
  if (!token.ends_with("OFF")) return false;
  std::string_view rest = token.substr(0, token.size() - 3);
  if (rest.starts_with("ST")) rest.remove_prefix(2);
  if (rest.starts_with("C")) rest.remove_prefix(1);
  if (rest.starts_with("N")) rest.remove_prefix(1);
  if (!rest.empty())
    file.fail(token,
              "found " + quoted_excerpt(token) + ", expected OFF, COFF, NOFF, STOFF or CNOFF");
  return true;
}

struct Counts {
  long nodes = 0, faces = 0;
};

Counts read_counts(MeshSourceText& file) {
  std::string_view line;
  if (!next_data(file, line)) file.fail_at_end("found the end of the file, expected 'OFF'");
  std::string_view rest = line, token = next_token(rest);
  if (read_kind(file, token)) {
    if (trimmed(rest) == "BINARY")
      file.fail(trimmed(rest), "found a binary OFF file, expected text");
    if (trimmed(rest).empty()) {
      if (!next_data(file, line))
        file.fail_at_end("found the end of the file, expected the numbers of nodes and faces");
      rest = line;
    }
    token = next_token(rest);
  } else if (token.find_first_not_of("0123456789") != token.npos) {
    file.fail(token, "found " + quoted_excerpt(token) + ", expected 'OFF'");
  }
  Counts counts;
  counts.nodes = file.integer(token, "a number of nodes");
  const std::string_view faces = next_token(rest);
  counts.faces =
      file.integer(faces.empty() ? line.substr(line.size()) : faces, "a number of faces");
  const long most = std::numeric_limits<int>::max();
  if (counts.nodes < 0 || counts.faces < 0 || counts.nodes > most || counts.faces > most)
    file.fail(line, "found " + quoted_excerpt(line) + ", expected numbers of nodes and faces");
  return counts;
}

void read(TextMeshContent& mesh) {
  MeshSourceText& file = mesh.file;
  const Counts counts = read_counts(file);
  // The stated counts may be wrong, so the file size bounds what is reserved.
  const auto nodes = static_cast<size_t>(counts.nodes);
  mesh.fields.reserve(std::min(nodes, file.text().size() / 6 + 1));
  std::vector<double> coordinates;
  coordinates.reserve(3 * mesh.fields.capacity());
  std::string_view line;
  for (size_t i = 0; i < nodes; ++i) {
    if (!next_data(file, line))
      file.fail_at_end("found " + format_count(static_cast<long>(i), "node") + ", expected " +
                       std::to_string(nodes));
    std::array<Field, 3> fields;
    std::string_view rest = line;
    for (Field& field : fields) {
      const std::string_view token = next_token(rest);
      if (token.empty())
        file.fail(line, "found " + format_count(&field - fields.data(), "number") +
                            ", expected the 3 coordinates of node " + std::to_string(i));
      coordinates.push_back(file.real(token));
      field.begin = file.offset(token);
      field.length = static_cast<std::uint32_t>(token.size());
    }
    mesh.fields.push_back(fields);
  }
  mesh.shells.points = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      coordinates.data(), counts.nodes, 3);
  std::vector<int> face;
  for (long f = 0; f < counts.faces; ++f) {
    if (!next_data(file, line))
      file.fail_at_end("found " + format_count(f, "face") + ", expected " +
                       std::to_string(counts.faces));
    std::string_view rest = line;
    const std::string_view first = next_token(rest);
    const long corners = file.integer(first, "a number of nodes");
    if (corners < 3)
      file.fail(first, "found a face of " + format_count(corners, "node") + ", expected 3 or more");
    face.clear();
    for (long i = 0; i < corners; ++i) {
      const std::string_view token = next_token(rest);
      if (token.empty())
        file.fail(line, "found a face of " + format_count(i, "node") + ", expected " +
                            std::to_string(corners) + " as stated");
      const long node = file.integer(token, "a node number");
      if (node < 0 || node >= counts.nodes)
        file.fail(token, "found node number " + quoted_excerpt(token) + ", expected 0 to " +
                             std::to_string(counts.nodes - 1));
      face.push_back(static_cast<int>(node));
    }
    mesh.shells.add_face(face);
  }
  mesh.node_labels = Labels::counted_from(0, static_cast<int>(counts.nodes));
  mesh.face_labels = Labels::counted_from(0, static_cast<int>(counts.faces));
  if (const int unused = unused_nodes(mesh.shells))
    mesh.warnings.push_back(format_count(unused, "node") + " without a face");
}

}  // namespace

std::unique_ptr<MeshContent> read_off_mesh(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "OFF";
  mesh->extensions = {".off"};
  MeshSourceText& file = mesh->file;
  const size_t start = file.position();
  std::string_view line;
  next_data(file, line);
  const std::string_view kind = next_token(line);
  file.seek(start);
  read(*mesh);
  if (kind.ends_with("NOFF"))
    mesh->warnings.push_back(format_count(mesh->shells.node_count(), "normal") +
                             " of the file remain unchanged");
  return mesh;
}

void write_off_mesh(const MeshOutput& output) {
  const ShellMesh& mesh = output.mesh;
  write_file_atomically(output.path, [&](std::ostream& out) {
    char text[32];
    out << "OFF\n" << mesh.node_count() << ' ' << mesh.face_count() << " 0\n";
    for (int i = 0; i < mesh.node_count(); ++i)
      for (int c = 0; c < 3; ++c) {
        const auto end = std::to_chars(text, text + sizeof text, mesh.points(i, c));
        out << std::string_view(text, static_cast<size_t>(end.ptr - text)) << (c < 2 ? ' ' : '\n');
      }
    for (int f = 0; f < mesh.face_count(); ++f) {
      const std::vector<int> nodes = outline_of(mesh, f);
      out << nodes.size();
      for (const int node : nodes) out << ' ' << node;
      out << '\n';
    }
  });
}

}  // namespace batten
