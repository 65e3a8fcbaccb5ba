// SPDX-License-Identifier: MPL-2.0
// Reads and writes Wavefront OBJ files.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/command_files.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/text_mesh_content.h"

namespace batten {

// Tags of control cages, `t NAME INTEGERS/REALS/TEXTS …` as in OpenSubdiv: integers, reals, then
// texts.

/// Collects `t` records, and converts them to cage_tags or cage_problem once the mesh is read.
class ObjTags {
 public:
  /// Adds the tokens after the `t`. They are views and must stay valid.
  void add(std::vector<std::string_view> tokens) {
    if (!tokens.empty()) records_.push_back(std::move(tokens));
  }
  void finish(TextMeshContent& mesh) const;

 private:
  std::vector<std::vector<std::string_view>> records_;
};

namespace {

/// One record, split into its parts.
struct Tag {
  std::string_view name;
  std::vector<long> integers;
  std::vector<double> reals;
  std::vector<std::string_view> texts;
};

class TagReader {
 public:
  explicit TagReader(TextMeshContent& mesh) : mesh_(mesh), file_(mesh.file) {
    for (int f = 0; f < mesh.shells.face_count(); ++f) {
      const auto nodes = mesh.shells.corners(f);
      for (size_t i = 0; i < nodes.size(); ++i) {
        ++faces_at_[nodes[i]];
        ++faces_of_edge_[std::minmax(nodes[i], nodes[(i + 1) % nodes.size()])];
      }
    }
  }

  void read(const std::vector<std::string_view>& tokens) {
    const Tag tag = parts_of(tokens);
    if (tag.name == "crease") {
      crease(tokens, tag);
    } else if (tag.name == "corner") {
      corner(tokens, tag);
    } else if (tag.name == "interpolateboundary") {
      boundary(tokens, tag);
    } else if (tag.name == "creasemethod" || tag.name == "smoothtriangles") {
      if (tag.texts.size() != 1 || (tag.texts[0] != "normal" && tag.texts[0] != "catmark"))
        fail(tokens, "found " + all(tokens) + ", expected the default, 'normal' or 'catmark'");
    } else if (!tag.name.starts_with("facevarying")) {
      fail(tokens, "found the tag '" + std::string(tag.name) +
                       "', expected crease, corner or interpolateboundary");
    }
  }

 private:
  [[noreturn]] void fail(const std::vector<std::string_view>& tokens,
                         const std::string& why) const {
    file_.fail(tokens.front(), why);
  }
  static std::string all(const std::vector<std::string_view>& tokens) {
    std::string text = "'t";
    for (const std::string_view token : tokens) text += " " + std::string(token);
    return text + "'";
  }

  Tag parts_of(const std::vector<std::string_view>& tokens) const {
    if (tokens.size() < 2)
      fail(tokens, "found a tag without counts, expected t NAME INTEGERS/REALS/TEXTS");
    std::array<long, 3> counts{};
    std::string_view rest = tokens[1];
    for (int part = 0; part < 3; ++part) {
      const size_t end = rest.find('/');
      counts[part] = file_.integer(rest.substr(0, end), "counts as 2/1/0");
      if ((end == std::string_view::npos) != (part == 2) || counts[part] < 0 ||
          counts[part] > static_cast<long>(tokens.size()))
        file_.fail(tokens[1], "found '" + std::string(tokens[1]) + "', expected counts as 2/1/0");
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (counts[0] + counts[1] + counts[2] != static_cast<long>(tokens.size()) - 2)
      file_.fail(tokens[1], "found " + std::to_string(tokens.size() - 2) + " words behind '" +
                                std::string(tokens[1]) + "', expected as many as stated");
    Tag tag{tokens[0], {}, {}, {}};
    for (size_t k = 2; k < tokens.size(); ++k) {
      const auto at = static_cast<long>(k) - 2;
      if (at < counts[0])
        tag.integers.push_back(file_.integer(tokens[k], "a whole number"));
      else if (at < counts[0] + counts[1])
        tag.reals.push_back(file_.real(tokens[k]));
      else
        tag.texts.push_back(tokens[k]);
    }
    return tag;
  }

  int node(const std::vector<std::string_view>& tokens, long number) const {
    const int count = mesh_.shells.node_count();
    if (number < 0 || number >= count)
      fail(tokens, "found the node " + std::to_string(number) + ", expected 0 to " +
                       std::to_string(count - 1) + ": nodes of tags count from 0");
    return static_cast<int>(number);
  }
  double sharpness(const std::vector<std::string_view>& tokens, double value) const {
    if (value < 0)
      fail(tokens, "found a sharpness of " + format_number(value) + ", expected 0 or more");
    return value;
  }

  void crease(const std::vector<std::string_view>& tokens, const Tag& tag) {
    if (tag.integers.size() != 2 || tag.reals.size() != 1)
      fail(tokens, "found " + all(tokens) + ", expected two nodes and a sharpness (2/1/0)");
    const int a = node(tokens, tag.integers[0]), b = node(tokens, tag.integers[1]);
    if (!faces_of_edge_.contains(std::minmax(a, b)))
      fail(tokens, "found a crease from node " + std::to_string(a) + " to " + std::to_string(b) +
                       ", expected an edge of a face: nodes of tags count from 0");
    mesh_.cage_tags.creases.push_back({a, b, sharpness(tokens, tag.reals[0])});
  }

  void corner(const std::vector<std::string_view>& tokens, const Tag& tag) {
    if (tag.integers.empty() || (tag.reals.size() != 1 && tag.reals.size() != tag.integers.size()))
      fail(tokens,
           "found " + all(tokens) + ", expected nodes, and a sharpness for each or for all");
    for (size_t k = 0; k < tag.integers.size(); ++k)
      mesh_.cage_tags.corners.push_back(
          {node(tokens, tag.integers[k]),
           sharpness(tokens, tag.reals.size() == 1 ? tag.reals[0] : tag.reals[k])});
  }

  /// Boundary interpolation rule. 0: boundary faces are removed; 1: boundary edges and corners are
  /// sharp, as in catmull_clark(); 2: boundary edges only.
  void boundary(const std::vector<std::string_view>& tokens, const Tag& tag) const {
    const long value = tag.integers.size() == 1 ? tag.integers[0] : -1;
    const bool rims = std::any_of(faces_of_edge_.begin(), faces_of_edge_.end(),
                                  [](const auto& edge) { return edge.second == 1; });
    const bool corners = std::any_of(faces_at_.begin(), faces_at_.end(),
                                     [](const auto& faces) { return faces.second == 1; });
    if (value == 1 || (value == 0 && !rims) || (value == 2 && !corners)) return;
    fail(tokens, "found " + all(tokens) +
                     ", expected 't interpolateboundary 1/0/0 1': boundary edges of a cage and "
                     "their corners "
                     "are sharp");
  }

  TextMeshContent& mesh_;
  const MeshSourceText& file_;
  std::map<std::pair<int, int>, int> faces_of_edge_;
  std::map<int, int> faces_at_;
};

}  // namespace

void ObjTags::finish(TextMeshContent& mesh) const {
  if (records_.empty()) return;
  try {
    TagReader reader(mesh);
    for (const auto& tokens : records_) reader.read(tokens);
  } catch (const InputError& problem) {
    // Not an error here: only callers that use the mesh as a cage need the tags.
    mesh.cage_problem = problem.what();
  }
}

namespace {

/// The tokens of a record; a backslash at the end of a line continues it on the next one.
class Tokens {
 public:
  Tokens(MeshSourceText& file, std::string_view line) : file_(file), rest_(without_comment(line)) {}
  /// The next token; empty at the end of the record.
  std::string_view next() {
    for (;;) {
      std::string_view token = next_token(rest_);
      if (!token.ends_with('\\') || !trimmed(rest_).empty()) return token;
      std::string_view line;
      rest_ = file_.next(line) ? without_comment(line) : rest_.substr(rest_.size());
      token.remove_suffix(1);
      if (!token.empty()) return token;
      if (line.data() == nullptr) return rest_;
    }
  }
  std::string_view rest() const { return trimmed(rest_); }

 private:
  static std::string_view without_comment(std::string_view line) {
    return line.substr(0, line.find('#'));
  }
  MeshSourceText& file_;
  std::string_view rest_;
};

/// Face sets by name, in the order of their first face.
class NamedFaces {
 public:
  explicit NamedFaces(std::vector<MeshSet>& sets) : sets_(sets) {}
  void add(const std::string& name, int face) {
    const auto [at, first] = index_.try_emplace(name, sets_.size());
    if (first) sets_.push_back({name, {}, {}, {}});
    auto& faces = sets_[at->second].faces;
    if (faces.empty() || faces.back() != face) faces.push_back(face);
  }

 private:
  std::vector<MeshSet>& sets_;
  std::unordered_map<std::string, size_t> index_;
};

class ObjReader {
 public:
  ObjReader(TextMeshContent& mesh, const std::filesystem::path& path)
      : mesh_(mesh), file_(mesh.file), path_(path) {}

  void read() {
    std::string_view line;
    while (file_.next(line)) {
      Tokens tokens(file_, line);
      const std::string_view record = tokens.next();
      if (record == "v") {
        vertex(tokens, line);
      } else if (record == "f") {
        face(tokens, line);
      } else if (record == "g") {
        groups_.clear();
        for (auto name = tokens.next(); !name.empty(); name = tokens.next())
          groups_.emplace_back(name);
      } else if (record == "o") {
        object_ = tokens.rest();
      } else if (record == "usemtl") {
        material_ = tokens.rest();
      } else if (record == "mtllib") {
        libraries_.emplace_back(tokens.rest());
      } else if (record == "t") {
        std::vector<std::string_view> tag;
        for (auto token = tokens.next(); !token.empty(); token = tokens.next())
          tag.push_back(token);
        tags_.add(std::move(tag));
      } else if (record == "vn") {
        ++normals_;
      } else if (record == "l" || record == "p" || record == "curv" || record == "surf") {
        ++others_;
      }
    }
    const int count = isize(mesh_.fields);
    if (count == 0) file_.fail_at_end("found no nodes, expected records 'v x y z'");
    if (highest_ > count) refuse(highest_token_, highest_);
    mesh_.shells.points =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
            coordinates_.data(), count, 3);
    mesh_.node_labels = Labels::counted_from(1, count);
    mesh_.face_labels = Labels::counted_from(1, mesh_.shells.face_count());
    for (const std::string& library : libraries_) read_colours(library);
    tags_.finish(mesh_);
    if (normals_ > 0)
      mesh_.warnings.push_back(format_count(normals_, "normal") +
                               " (vn) of the file remain unchanged");
    if (others_ > 0)
      mesh_.warnings.push_back(format_count(others_, "line, point or curve record") +
                               " of the file are kept as text");
    if (const int unused = unused_nodes(mesh_.shells))
      mesh_.warnings.push_back(format_count(unused, "node") + " without a face");
    if (file_.ends_in_mid_line())
      mesh_.warnings.push_back("the last line has no line end: the file may be truncated");
  }

 private:
  void vertex(Tokens& tokens, std::string_view line) {
    std::array<Field, 3> fields;
    for (int c = 0; c < 3; ++c) {
      const std::string_view token = tokens.next();
      if (token.empty())
        file_.fail(line.substr(line.size()),
                   "found " + format_count(c, "coordinate") + ", expected 3 (v x y z)");
      coordinates_.push_back(file_.real(token));
      fields[c].begin = file_.offset(token);
      fields[c].length = static_cast<std::uint32_t>(token.size());
    }
    mesh_.fields.push_back(fields);
  }

  void face(Tokens& tokens, std::string_view line) {
    nodes_.clear();
    const long count = static_cast<long>(mesh_.fields.size());
    for (auto token = tokens.next(); !token.empty(); token = tokens.next()) {
      // Of vertex/texture/normal only the vertex index is used.
      long index = 0;
      if (!parse_integer(token.substr(0, token.find('/')), index))
        file_.fail(token, "found " + quoted_excerpt(token) + ", expected a node number");
      const long node = index < 0 ? count + index : index - 1;
      if (index == 0 || node < 0) refuse(token, index);
      if (node >= std::numeric_limits<int>::max()) refuse(token, index);
      // Nodes may be defined after the faces that use them.
      if (index > highest_) {
        highest_ = index;
        highest_token_ = token;
      }
      nodes_.push_back(static_cast<int>(node));
    }
    if (nodes_.size() < 3)
      file_.fail(line, "found a face of " + format_count(static_cast<long>(nodes_.size()), "node") +
                           ", expected 3 or more");
    const int number = mesh_.shells.face_count();
    mesh_.shells.add_face(nodes_);
    for (const std::string& group : groups_) sets_.add(group, number);
    if (!object_.empty()) sets_.add(object_, number);
    if (!material_.empty()) materials_.add(material_, number);
  }

  /// Reads the material colours, if the material file exists. Everything else in that file is
  /// ignored, and errors in it are not reported.
  void read_colours(const std::string& library) {
    const std::filesystem::path path = path_.parent_path() / library;
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none)) return;
    record_input(path);
    std::ifstream in(path);
    MeshSet* material = nullptr;
    for (std::string line; std::getline(in, line);) {
      std::string_view rest = line;
      const std::string_view record = next_token(rest);
      if (record == "newmtl") {
        const auto named =
            std::find_if(mesh_.properties.begin(), mesh_.properties.end(),
                         [&](const MeshSet& set) { return set.name == trimmed(rest); });
        material = named == mesh_.properties.end() ? nullptr : &*named;
      } else if (record == "Kd" && material) {
        std::array<int, 3> colour{};
        bool sound = true;
        for (int& c : colour) {
          double channel = 0;
          sound = parse_real(next_token(rest), channel) && sound;
          c = static_cast<int>(std::lround(255 * std::clamp(channel, 0.0, 1.0)));
        }
        if (sound) material->colour = hex_of(colour);
      }
    }
  }

  [[noreturn]] void refuse(std::string_view token, long index) const {
    const std::string count = std::to_string(mesh_.fields.size());
    file_.fail(token, "found node number " + std::to_string(index) + ", expected " +
                          (count == "0" ? "nodes (v records) before it"
                                        : "1 to " + count + " or -1 to -" + count));
  }

  TextMeshContent& mesh_;
  MeshSourceText& file_;
  const std::filesystem::path& path_;
  NamedFaces sets_{mesh_.sets}, materials_{mesh_.properties};
  std::vector<double> coordinates_;
  std::vector<int> nodes_;
  std::vector<std::string> groups_, libraries_;
  std::string object_, material_;
  ObjTags tags_;
  long highest_ = 0, normals_ = 0, others_ = 0;
  std::string_view highest_token_;
};

/// Group name of a set as a single token; "default" for faces without a set.
std::string group_name(const std::vector<MeshSet>& sets, int set) {
  if (set < 0) return "default";
  std::string name = sets[static_cast<size_t>(set)].name;
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return c <= 32 || c == 127 || c == '#' || c == '\\'; }, '_');
  return name.empty() ? "_" : name;
}

}  // namespace

std::unique_ptr<MeshContent> read_obj_mesh(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "Wavefront OBJ";
  mesh->extensions = {".obj"};
  ObjReader(*mesh, path).read();
  return mesh;
}

namespace {

void append_number(std::ostream& out, double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  out << ' ' << std::string_view(text, static_cast<size_t>(end.ptr - text));
}

/// The colours of the sets by material name. If any set has a colour, "none" is added for faces
/// without one.
std::map<std::string, std::array<int, 3>> materials_of(const std::vector<MeshSet>& sets) {
  std::map<std::string, std::array<int, 3>> all;
  for (const MeshSet& set : sets)
    if (const auto colour = mesh_colour(set.colour)) all.emplace(set.colour.substr(1), *colour);
  if (!all.empty()) all.emplace("none", std::array{204, 204, 204});
  return all;
}

void write_materials(std::ostream& out,
                     const std::map<std::string, std::array<int, 3>>& materials) {
  for (const auto& [name, colour] : materials) {
    out << "newmtl " << name << "\nKd";
    for (const int c : colour) append_number(out, c / 255.0);
    out << "\n";
  }
}

}  // namespace

std::vector<std::filesystem::path> write_obj_mesh(const MeshOutput& output) {
  const std::filesystem::path& path = output.path;
  const ShellMesh& mesh = output.mesh;
  const std::vector<MeshSet>& sets = output.sets;
  const std::vector<int> set = set_of_faces(mesh, sets);
  const auto materials = materials_of(sets);
  std::optional<AtomicFile> beside;
  AtomicFile file(path);
  if (!materials.empty()) {
    // Readers end a file name at a blank.
    std::string name = path.stem().string() + ".mtl";
    std::replace(name.begin(), name.end(), ' ', '_');
    beside.emplace(path.parent_path() / name);
    beside->write([&](std::ostream& out) { write_materials(out, materials); });
  }
  file.write([&](std::ostream& out) {
    if (beside) out << "mtllib " << beside->path().filename().string() << '\n';
    for (int i = 0; i < mesh.node_count(); ++i) {
      out << 'v';
      for (int c = 0; c < 3; ++c) append_number(out, mesh.points(i, c));
      out << '\n';
    }
    int group = -1;
    std::string material;
    for (int f = 0; f < mesh.face_count(); ++f) {
      if (set[f] != group) out << "g " << group_name(sets, group = set[f]) << '\n';
      if (beside) {
        const std::string& colour = set[f] < 0 ? "" : sets[set[f]].colour;
        const std::string own = colour.empty() ? "none" : colour.substr(1);
        if (own != material) out << "usemtl " << (material = own) << '\n';
      }
      out << 'f';
      for (const int node : outline_of(mesh, f)) out << ' ' << node + 1;
      out << '\n';
    }
  });
  if (!beside) return file.commit(), std::vector<std::filesystem::path>{};
  const std::filesystem::path written = beside->path();
  commit_together({&*beside, &file});
  return {written};
}

}  // namespace batten
