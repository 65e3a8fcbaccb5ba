// Wavefront OBJ.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <ostream>
#include <unordered_map>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/meshes/mesh_colour.h"
#include "batten/io/meshes/obj_tags.h"
#include "batten/io/meshes/text_mesh_content.h"

namespace batten {
namespace {

/// Words of a record, which goes on in the next line after a backslash.
class Tokens {
 public:
  Tokens(MeshSourceText& file, std::string_view line) : file_(file), rest_(without_comment(line)) {}
  /// Empty at the end of the record.
  std::string_view next() {
    for (;;) {
      std::string_view word = next_word(rest_);
      if (!word.ends_with('\\') || !trimmed(rest_).empty()) return word;
      std::string_view line;
      rest_ = file_.next(line) ? without_comment(line) : rest_.substr(rest_.size());
      word.remove_suffix(1);
      if (!word.empty()) return word;
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

/// Face sets by name, in the order of their first faces.
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
      Tokens words(file_, line);
      const std::string_view record = words.next();
      if (record == "v") {
        vertex(words, line);
      } else if (record == "f") {
        face(words, line);
      } else if (record == "g") {
        groups_.clear();
        for (auto name = words.next(); !name.empty(); name = words.next())
          groups_.emplace_back(name);
      } else if (record == "o") {
        object_ = words.rest();
      } else if (record == "usemtl") {
        material_ = words.rest();
      } else if (record == "mtllib") {
        libraries_.emplace_back(words.rest());
      } else if (record == "t") {
        std::vector<std::string_view> tag;
        for (auto word = words.next(); !word.empty(); word = words.next()) tag.push_back(word);
        tags_.add(std::move(tag));
      } else if (record == "vn") {
        ++normals_;
      } else if (record == "l" || record == "p" || record == "curv" || record == "surf") {
        ++others_;
      }
    }
    const int count = isize(mesh_.fields);
    if (count == 0) file_.fail_at_end("found no nodes, expected records 'v x y z'");
    if (highest_ > count) refuse(highest_word_, highest_);
    mesh_.shells.points =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
            coordinates_.data(), count, 3);
    mesh_.node_labels = Labels::counted_from(1, count);
    mesh_.face_labels = Labels::counted_from(1, mesh_.shells.face_count());
    for (const std::string& library : libraries_) read_colours(library);
    tags_.finish(mesh_);
    if (normals_ > 0)
      mesh_.warnings.push_back(format_count(normals_, "normal") +
                               " (vn) of the file stay as they are");
    if (others_ > 0)
      mesh_.warnings.push_back(format_count(others_, "line, point or curve record") +
                               " of the file are kept as text");
    if (const int unused = unused_nodes(mesh_.shells))
      mesh_.warnings.push_back(format_count(unused, "node") + " without a face");
    if (file_.ends_in_mid_line())
      mesh_.warnings.push_back("the file ends in mid-line: it may be cut short");
  }

 private:
  void vertex(Tokens& words, std::string_view line) {
    std::array<Field, 3> fields;
    for (int c = 0; c < 3; ++c) {
      const std::string_view word = words.next();
      if (word.empty())
        file_.fail(line.substr(line.size()),
                   "found " + format_count(c, "coordinate") + ", expected 3 (v x y z)");
      coordinates_.push_back(file_.real(word));
      fields[c].begin = file_.offset(word);
      fields[c].length = static_cast<std::uint32_t>(word.size());
    }
    mesh_.fields.push_back(fields);
  }

  void face(Tokens& words, std::string_view line) {
    nodes_.clear();
    const long count = static_cast<long>(mesh_.fields.size());
    for (auto word = words.next(); !word.empty(); word = words.next()) {
      // vertex/texture/normal: the first number is meant.
      long index = 0;
      if (!parse_integer(word.substr(0, word.find('/')), index))
        file_.fail(word, "found " + quoted_excerpt(word) + ", expected a node number");
      const long node = index < 0 ? count + index : index - 1;
      if (index == 0 || node < 0) refuse(word, index);
      if (node >= std::numeric_limits<int>::max()) refuse(word, index);
      // Nodes may follow later.
      if (index > highest_) {
        highest_ = index;
        highest_word_ = word;
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

  /// The colours of the materials, where their file is there. What else is in it does not matter,
  /// nor does damage.
  void read_colours(const std::string& library) {
    const std::filesystem::path path = path_.parent_path() / library;
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none)) return;
    std::ifstream in(path);
    MeshSet* material = nullptr;
    for (std::string line; std::getline(in, line);) {
      std::string_view rest = line;
      const std::string_view record = next_word(rest);
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
          sound = parse_real(next_word(rest), channel) && sound;
          c = static_cast<int>(std::lround(255 * std::clamp(channel, 0.0, 1.0)));
        }
        if (sound) material->colour = hex_of(colour);
      }
    }
  }

  [[noreturn]] void refuse(std::string_view word, long index) const {
    const std::string count = std::to_string(mesh_.fields.size());
    file_.fail(word, "found node number " + std::to_string(index) + ", expected " +
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
  std::string_view highest_word_;
};

/// A group's name is one word; "default" is the group of faces in none.
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

/// The colours of the sets, by the names of their materials; where there are any, also that of
/// faces without.
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
    // Readers take a blank for the end of the name.
    std::string name = path.stem().string() + ".mtl";
    std::replace(name.begin(), name.end(), ' ', '_');
    beside.emplace(path.parent_path() / name);
    write_file_atomically(beside->temporary(),
                          [&](std::ostream& out) { write_materials(out, materials); });
  }
  write_file_atomically(file.temporary(), [&](std::ostream& out) {
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
  beside->commit();
  file.commit();
  return {written};
}

}  // namespace batten
